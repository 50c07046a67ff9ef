// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/index.h"
#include "mechanism/mechanism.h"
#include "statics/frame_links.h"

namespace dttmm::plugin {

/// What the sources of Interior share.

using Map3 = Eigen::Map<Vector3>;
using MapR = Eigen::Map<RowMajor3>;

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

/// Columns of [d; relative turn] of a joint at t_n by the motion of its `from` (0) or `to` (1) frame, in that frame's axes.
Matrix6 local_columns(const Mechanism& mechanism, size_t joint, int end);
/// The same with the joint elsewhere.
Matrix6 local_columns(const Mechanism& mechanism, size_t joint, const JointPose& pose, int end);
/// The same of a joint in a pose, by the motion of a frame where it is.
Matrix6 local_columns(const Joint& joint, const JointPose& pose, int end, FrameView frame);
/// From these those of [d; θ] that rigid directions hold: δθ = J⁻¹ ε.
Matrix6 rigid_rows(const Mechanism& mechanism, size_t joint, const Matrix6& columns);

}  // namespace dttmm::plugin
