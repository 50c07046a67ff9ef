// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/index.h"
#include "core/types.h"
#include "element/element.h"

namespace dttmm::plugin {

/// Displacements at points of a line, and their derivatives by its length, by the motion of its ends.
struct LineShapes {
    static constexpr std::array kPoints = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281, 0.9305681557970263};
    static constexpr std::array kWeights = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731, 0.1739274225687269};
    struct Shape {
        Eigen::Matrix<double, 6, 12> d, slope;
    };
    std::array<Shape, kPoints.size()> at;  ///< at Gauss' points, as shares of the length
};

/// The section forces of a line at rest that is nearly straight, local axes, [f; m] on the positive face: f is linear
/// between its stations, and m' = −e_x × f makes m a cubic there. Its axis lies beside the straight line between its ends.
class LineForces {
public:
    /// forces: in the joints of a line of equal segments, joint k where k segments end; the first and the last joint lie a
    /// quarter of a segment inside the ends. turning: of the loads that turn with it, their force per length at its start
    /// and at its end, between which they are linear. section: what bends by these forces; NULL: its axis counts as
    /// straight.
    LineForces(std::vector<Vector6> forces, double length, const Vector6& turning, const Section* section = nullptr);

    double length() const { return length_; }
    int segments() const { return as_int(stations_.size()) - 1; }
    const Vector6& first() const { return stations_.front(); }
    const Vector6& last() const { return stations_.back(); }
    Vector6 at(double s) const;
    Vector3 mean_force() const;
    Vector3 turning_load(double s) const;
    /// Into how many pieces the line is to be cut, its segments at most, so that what its forces add to the stiffness is
    /// known to a share of 1e-7 of it. 1: only the mean axial force counts, what the others add is below a share of 1e-5,
    /// and the axis is straight to that share of the radius of gyration.
    int pieces(const Section& section) const;

    /// What these forces, without a uniform axial one, add to the stiffness from `start` over a piece as they turn with it:
    /// the second derivative of ∫ f·(−θ × u' + ½ θ × (θ × e_x)) − ½ m·(θ × θ') ds, θ the rotation vector. Loads q that turn
    /// with the line have no potential: the symmetric part of what they do, of −∫ (θ × q)·δu ds, is added.
    /// The shape between the ends is that without them, but for the torsion: it follows them with a parabola, held by GJ.
    /// Without it the load at which a deep beam tips over would err by 0.25 % at ten segments, not by 2e-5.
    Matrix12 stiffness(double start, double length, double axial, double GJ, const LineShapes& shapes) const;
    /// What the axis adds from `start` over a piece because these forces bend it: where it lies beside the line by w and
    /// bends by u it grows longer by ∫ w'·u' ds, and ½ EA/length ((Δu_x + ∫ w'·u' ds)² − Δu_x²) is its energy. To first
    /// order in w that couples bending and tension.
    Matrix12 stiffness_of_axis(double start, double length, double EA, const LineShapes& shapes) const;

private:
    Eigen::Vector2d bend(double s) const;
    Eigen::Vector2d turn(double s) const;
    Eigen::Vector2d slope(double s) const;

    std::vector<Vector6> stations_;
    double length_;
    Vector6 turning_;
    /// Of the bent axis, local y and z: 1/EI, 1/GA, and its turn from the first station to each; none where it is straight.
    Eigen::Vector2d bends_ = Eigen::Vector2d::Zero(), shears_ = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> turns_;
    Eigen::Vector2d mean_slope_ = Eigen::Vector2d::Zero();
};

}  // namespace dttmm::plugin
