// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mechanism/frame.h"

namespace dttmm::plugin {

/// What of a frame resists motion; plain numbers. Real: double, or Lanes for four.
template <class Real>
struct InertiaOf {
    static constexpr int kNumbers = 10;
    Real mass;               ///< [kg]
    Matrix3Of<Real> moment;  ///< of inertia, axes of the frame [kg m²]
};
using Inertia = InertiaOf<double>;

/// How frames moved over the two steps before t_n, the later and the earlier one.
struct PastMotion {
    std::vector<Vector6> u, u_before;              ///< each in the axes at its start [m/s, rad/s]
    std::vector<Twist> velocity, velocity_before;  ///< the same, world
    /// Velocity at the start of the later one.
    Twist mean(size_t frame) const {
        const Twist &later = velocity[frame], &earlier = velocity_before[frame];
        return {0.5 * (later.linear + earlier.linear), 0.5 * (later.angular + earlier.angular)};
    }
};

// Of all frames inside a network at once; the lists have one length.

/// What momenta P− (world, over the step before) and wrenches W over a step of h (world) leave over of the momenta that a
/// motion u has over it, in the frames' axes at its start [N s, N m s]:
///     r = Rᵀ (P− + h (W + m g)) − [m v; L(ω)],   L(ω) = exp(h ω~/2) J ω, as it is half way through the step
void find_imbalance(double h, const Vector3& gravity, std::span<const Inertia> inertias, std::span<const Vector6> momenta,
                    std::span<const Frame> now, std::span<const Vector6> wrenches, std::span<const Vector6> u,
                    std::span<Vector6> r);

/// The largest √(|head|² + w |tail|²) of vectors of six, each with a weight w of its own; NaN or infinite if one of the
/// numbers is.
double largest_size(std::span<const Vector6> vectors, std::span<const double> weights);

/// The motions u over a step (`sum` may be the same) and what is to be added to them: their corrections, and their responses
/// to a change of the ports, each a matrix of 6 rows and a column for every number in `change`, one after the other; an
/// empty `change`: none.
void add_changes(std::span<const Vector6> u, std::span<const Vector6> corrections, std::span<const double> responses,
                 std::span<const double> change, std::span<Vector6> sum);

/// Takes a step with the motions u: the momenta about the frames' origins move on by the wrenches W over it and by weight,
/// the angular ones also by what the origins move meanwhile. velocities: takes the motions in world axes.
void take_step(double h, const Vector3& gravity, std::span<const Inertia> inertias, std::span<const Frame> now,
               std::span<const Vector6> wrenches, std::span<const Vector6> u, std::span<Vector6> momenta,
               std::span<Twist> velocities);

}  // namespace dttmm::plugin
