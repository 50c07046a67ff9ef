// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "model/model.h"

namespace dttmm {

/// A rigid body as ODE keeps it: pose of the centre of mass at t_n, velocities over the step that ended there (half a step
/// back). World axes; R turns body axes into world axes. Before the first step, in the arguments named `at`, the velocities
/// are those of the instant.
struct BodyState {
    Eigen::Vector3d position;  ///< [m]
    Eigen::Matrix3d rotation;
    Eigen::Vector3d velocity;          ///< [m/s]
    Eigen::Vector3d angular_velocity;  ///< [rad/s]
};

/// ODE behind one owner: rigid bodies without geometry, no gravity, no damping, no gyroscopic term of its own (the coupling
/// supplies a centred one), finite rotations. Its step is  v+ = v + h M⁻¹ f,  x+ = x + h v+,  R+ = exp(h ω+) R.
/// ODE aborts the process on bad numbers, so all that enters is checked here. One thread at a time.
class World {
public:
    /// No force [N] or moment [N m] beyond this reaches ODE, which aborts on overflow; no machine needs more.
    static constexpr double kLargestWrench = 1e15;

    /// Of the ODE this was built with, e.g. "0.16.2".
    static const char* engine_version();

    /// Bodies at their model positions with their model velocities.
    explicit World(const std::vector<Body>& bodies);
    ~World();

    int body_count() const { return static_cast<int>(bodies_.size()); }

    /// states: one per body, in the model's order.
    void read_states(std::vector<BodyState>& states) const;
    /// Throws Error(numerical_failure) unless every number is finite. Rotations must be orthonormal to rounding.
    void set_states(const std::vector<BodyState>& states);

    /// What acts over the next step, per body: [force at the centre of mass; moment about it], N and N m; replaces what was
    /// applied before. Throws Error(numerical_failure) before a number reaches ODE that is not finite or beyond
    /// kLargestWrench.
    void apply(const std::vector<Eigen::Matrix<double, 6, 1>>& wrenches);

    /// One step of size h [s]. Throws Error(resource_limit) if ODE ran out of memory, Error(numerical_failure) if it
    /// complained.
    void advance(double h);

private:
    void set_state(size_t body, const BodyState& state);
    class Library;
    class Owner;
    /// ODE's handle of a body, and where ODE keeps its numbers.
    struct Handle {
        void* id;
        const double *position, *rotation, *velocity, *angular_velocity;
    };
    std::unique_ptr<Owner> world_;
    std::vector<Handle> bodies_;
};

}  // namespace dttmm
