// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/index.h"
#include "mechanism/mechanism.h"
#include "mechanism/momentum.h"
#include "statics/frame_links.h"

namespace dttmm::plugin {

// What the parts of Interior share.

inline Vector3 head(const Vector6& v) { return v.head<3>(); }
inline Vector3 tail(const Vector6& v) { return v.tail<3>(); }
inline Vector6 joined(const Twist& twist) {
    Vector6 v;
    v << twist.linear, twist.angular;
    return v;
}
/// A motion or wrench, world axes, in those of a frame.
inline Vector6 in_axes(FrameView frame, const Vector6& v) {
    Vector6 local;
    local << frame.axes().transpose() * v.head<3>(), frame.axes().transpose() * v.tail<3>();
    return local;
}
/// The other way round.
inline Vector6 in_world(FrameView frame, const Vector6& v) {
    Vector6 world;
    world << frame.axes() * v.head<3>(), frame.axes() * v.tail<3>();
    return world;
}
/// The frames of a joint where they are in `at`.
inline Ends ends(const Joint& joint, const std::vector<Frame>& at) {
    return {at[as_size(joint.from())], at[as_size(joint.to())]};
}
/// By the motion of its frame, frame axes.
Matrix6 mass_matrix(const Inertia& inertia);

/// Columns of [d; relative turn] of a joint at t_n by the motion of its `from` (0) or `to` (1) frame, in that frame's axes.
Matrix6 local_columns(const Mechanism& mechanism, size_t joint, int end);
/// The same of a joint in a pose, by the motion of a frame where it is.
Matrix6 local_columns(const Joint& joint, const JointPose& pose, int end, FrameView frame);
/// From these those of [d; θ] that rigid directions hold: δθ = J⁻¹ ε.
Matrix6 rigid_rows(const Mechanism& mechanism, size_t joint, const Matrix6& columns);

/// Sets the rows of a joint's rigid directions in a pose, turned by theta; in the axes that its frames have at t_n.
void set_rigid_rows(const Mechanism& mechanism, size_t joint, const JointPose& pose, const Vector3& theta,
                    Elimination& matrix);
/// The same in the axes of the frames where they are in `at`.
void set_rigid_rows(const Mechanism& mechanism, size_t joint, const std::vector<Frame>& at, Elimination& matrix);

/// Factors it. Throws Error(status) naming what makes it singular.
void factor_or_refuse(const Mechanism& mechanism, Elimination& matrix, dttmm_status status);

}  // namespace dttmm::plugin
