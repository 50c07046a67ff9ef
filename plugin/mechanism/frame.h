// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/lanes.h"
#include "core/pose.h"
#include "core/types.h"
#include "dttmm_plugin.h"

namespace dttmm::plugin {

template <class Real>
using RowMajor3Of = Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>;
using RowMajor3 = RowMajor3Of<double>;

/// A frame in the world as plain numbers: origin [m] and axes, row-major as in dttmm_motion. Real: double, or Lanes for
/// four.
template <class Real>
struct FrameOf {
    static constexpr int kNumbers = 12;
    Real position[3];
    Real rotation[9];
    bool operator==(const FrameOf&) const = default;
    Eigen::Map<const Vector3Of<Real>> origin() const { return Eigen::Map<const Vector3Of<Real>>(position); }
    Eigen::Map<const RowMajor3Of<Real>> axes() const { return Eigen::Map<const RowMajor3Of<Real>>(rotation); }
};
using Frame = FrameOf<double>;

/// The same somewhere else in memory.
struct FrameView {
    FrameView(const Frame& frame) : position(frame.position), rotation(frame.rotation) {}
    FrameView(const dttmm_motion& motion) : position(motion.position), rotation(motion.rotation) {}
    FrameView(const double* origin, const double* axes) : position(origin), rotation(axes) {}
    Frame copy() const {
        Frame frame;
        for (int i = 0; i < 3; ++i) frame.position[i] = position[i];
        for (int i = 0; i < 9; ++i) frame.rotation[i] = rotation[i];
        return frame;
    }
    const double* position;
    const double* rotation;
    Eigen::Map<const Vector3> origin() const { return Eigen::Map<const Vector3>(position); }
    Eigen::Map<const RowMajor3> axes() const { return Eigen::Map<const RowMajor3>(rotation); }
};

/// Velocities [m/s, rad/s] or accelerations of a frame, world axes.
struct Twist {
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
};
static_assert(sizeof(Twist) == 6 * sizeof(double));

/// The bodies that a network hangs on, in the arrays of the host: port p is body bodies[p].
struct Ports {
    const dttmm_motion* motions;
    const uint32_t* bodies;
    const dttmm_motion& motion(int port) const { return motions[bodies[port]]; }
    FrameView operator[](size_t port) const { return motions[bodies[port]]; }
    Twist twist(int port) const {
        return {Eigen::Map<const Vector3>(motion(port).velocity), Eigen::Map<const Vector3>(motion(port).angular_velocity)};
    }
};

/// The frame of a pose.
Frame make_frame(const Pose& pose);

/// Moves frames on by u over a step h [s], u = [v; ω] [m/s, rad/s] in the axes at its start. from, u and to have one length;
/// `to` does not overlap `from`.
void move_frames(double h, std::span<const Frame> from, std::span<const Vector6> u, std::span<Frame> to);

}  // namespace dttmm::plugin
