// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/model.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/body_state.h"
#include "world/inertia.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// ODE's joints hold the velocities at t_n, J u = 0, so that over a step a joint opens by h² |C̈|/2: on a turning machine a
/// steady gap, and energy that drifts. This closes them: the motion over the step changes along M⁻¹ Jᵀ, the direction in
/// which the joints' forces act, until joints move as predicted, C = 0 at the end of the step. ODE and this together are the
/// SHAKE form of the leap-frog scheme. Whether bodies then move as predicted is up to ODE: nothing is changed in directions
/// that joints leave free.
class JointClosure {
public:
    JointClosure(const std::vector<Body>& bodies, const std::vector<Joint>& joints);

    /// now: poses at t_n, joints closed. let_go: equations of joints that do not hold over the step. predicted: velocities
    /// over the step that close the joints. after: ODE's velocities over the step; poses and velocities are set. Throws
    /// Error(numerical_failure) naming the joint that does not follow.
    void close(const std::vector<BodyState>& now, double h, const LetGo& let_go, const std::vector<BodyState>& predicted,
               std::vector<BodyState>& after);

private:
    double correct(std::vector<BodyState>& after);
    void factor(const std::vector<BodyState>& now);
    [[noreturn]] void fail() const;

    std::vector<Inertia> inertias_;
    std::vector<double> reaches_;  ///< of the anchors and of the mass from the centre of mass [m]
    std::vector<std::string> names_;
    JointSystem system_;
    std::vector<Stop> no_stops_;  ///< none acts
    BlockMatrix matrix_;
    BlockFactor factor_;
    Eigen::VectorXd right_hand_side_, solution_;
};

}  // namespace dttmm::host
