// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/joints_by_four.h"
#include "time/inner_loads.h"
#include "time/inner_motion.h"
#include "time/inside.h"

namespace dttmm::plugin {

/// The forces of all joints of a network over a step, on the frames inside and on the ports.
class InnerForces {
public:
    /// Keeps the inside.
    explicit InnerForces(Inside& inside);

    /// What is known of the coming step: where rigid directions were at the two instants before its end.
    void look_at_joints();
    /// Those over the step that ends at the trial, as wrenches on all frames, and on massless frames at its end and half
    /// way. Notes in the motion those of the near joints, and the largest impulse.
    void find(InnerMotion& motion, InnerLoads& loads);
    /// Those over the step that is taken and ends at the trial, each a pair that balances exactly. The memory of the
    /// joints moves on. mechanism: that of the inside.
    void take_step(Mechanism& mechanism, const InnerMotion& motion);
    const JointsByFour& by_four() const { return by_four_; }

private:
    JointForce rigid_action(size_t joint, const JointPose& at_end, const Vector3& theta, const Vector6& q) const;
    JointForce over_step(size_t joint, const JointPose& at_end, const Joint::Strained& end) const;
    void find_settling(size_t joint, Ends trial, const JointPose& at_end, const Joint::Strained& end,
                       InnerLoads& loads) const;

    Inside& inside_;
    JointsByFour by_four_;               ///< joints that are neither near nor rigid nor settling
    std::vector<size_t> others_;         ///< all joints it does not take, ascending
    std::vector<RigidMap> rigid_known_;  ///< of the rigid joints: what the two instants before the end contribute
};

}  // namespace dttmm::plugin
