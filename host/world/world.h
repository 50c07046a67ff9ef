// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "model/index.h"
#include "model/model.h"
#include "world/body_state.h"
#include "world/joint_closure.h"

namespace dttmm::host {

/// ODE behind one owner: rigid bodies on ideal joints, without geometry, no gravity, no damping, no gyroscopic term of its
/// own (the coupling supplies a centred one), finite rotations. Its step is  v+ = v + h M⁻¹ (f + joints),  x+ = x + h v+, R+
/// = exp(h ω+) R; what ODE's joints open over it is closed at once (JointClosure). Stops are ODE's own: one that is reached
/// at t_n acts over the step, without rebound, and lets go when the bodies part. ODE aborts the process on bad numbers, so
/// all that enters is checked here. One thread at a time.
class World {
public:
    /// No force [N] or moment [N m] beyond this reaches ODE, which aborts on overflow; no machine needs more.
    static constexpr double kLargestWrench = 1e15;

    /// Of the ODE this was built with, e.g. "0.16.2".
    static const char* engine_version();

    /// Bodies at their model positions with their model velocities.
    explicit World(const std::vector<Body>& bodies, const std::vector<Joint>& joints = {});
    ~World();

    int body_count() const { return as_int(bodies_.size()); }

    /// states: one per body, in the model's order.
    void read_states(std::vector<BodyState>& states) const;
    /// Throws Error(numerical_failure) unless every number is finite. Rotations must be orthonormal to rounding.
    void set_states(const std::vector<BodyState>& states);

    /// What acts over the next step, per body: [force at the centre of mass; moment about it], N and N m; replaces what was
    /// applied before. Throws Error(numerical_failure) before a number reaches ODE that is not finite or beyond
    /// kLargestWrench.
    void apply(const std::vector<Eigen::Matrix<double, 6, 1>>& wrenches);

    /// What motors do over the next steps, one per joint in the model's order. Speeds must be finite.
    void drive(const std::vector<Drive>& drives);

    /// One step of size h [s]. predicted: the bodies at its end, by which joints are closed; not looked at without joints.
    /// Where equations of joints are let go, all joints are left to JointClosure. Throws Error(resource_limit) if ODE ran
    /// out of memory, Error(numerical_failure) if it complained or a joint does not close.
    void advance(double h, const std::vector<BodyState>& predicted = {}, const LetGo& let_go = {});

private:
    void set_state(size_t body, const BodyState& state);
    void create_joint(const Joint& joint);
    int step(double h, bool with_joints);
    class Library;
    class Owner;
    /// ODE's handle of a body, and where ODE keeps its numbers.
    struct Handle {
        void* id;
        const double *position, *rotation, *velocity, *angular_velocity;
    };
    std::unique_ptr<Owner> world_;
    std::vector<Handle> bodies_;

    /// A joint of ODE's, without its stops.
    struct JointHandle {
        void* id;
        bool turns, is_driven;
    };
    std::vector<JointHandle> joints_;
    double largest_mobility_ = 0;  ///< of a body with joints [1/kg, 1/(kg m²)], at least 1
    std::vector<BodyState> before_, after_;
    std::unique_ptr<JointClosure> closure_;  ///< none without joints
};

}  // namespace dttmm::host
