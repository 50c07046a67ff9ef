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
/// which the joints' forces act, until C = 0 at its end. ODE and this together are the SHAKE form of the leap-frog scheme.
class JointClosure {
public:
    JointClosure(const std::vector<Body>& bodies, const std::vector<Joint>& joints);

    /// now: poses at t_n, joints closed. stops: those reached at t_n; on return those that ODE has made act and that let the
    /// joints close. after: ODE's
    /// velocities over the step; poses and velocities are set. Throws Error(numerical_failure) naming the joint that does
    /// not close.
    void close(const std::vector<BodyState>& now, double h, std::vector<Stop>& stops, std::vector<BodyState>& after);

private:
    static constexpr int kMostPasses = 60;
    bool find_closed(const std::vector<BodyState>& now, double h, std::vector<BodyState>& after);
    void factor(const std::vector<BodyState>& now);
    bool judge(std::vector<Stop>& stops, double h, const std::vector<BodyState>& after) const;
    [[noreturn]] void fail() const;

    std::vector<Inertia> inertias_;
    std::vector<double> reaches_;  ///< of the anchors and of the mass from the centre of mass [m]
    std::vector<std::string> names_;
    std::vector<BodyState> engine_;  ///< the motion as ODE left it
    JointSystem system_;
    BlockMatrix matrix_;
    BlockFactor factor_;
    Eigen::VectorXd right_hand_side_, solution_;
};

}  // namespace dttmm::host
