// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/rotation.h"
#include "mechanism/frame.h"

namespace dttmm::plugin {

// Where a joint is, and what its forces are on its frames. Real: double for one, Lanes for four at once.

/// What a joint does to its frames [N, N m], world axes: force and moment on the `from` end, the opposite on the `to` end
/// (on_to counts as on_from does, Joint::add_wrench turns its sign); the moments about the origins of the frames, each at
/// the instant of the force.
template <class Real>
struct JointForceOf {
    static constexpr int kNumbers = 9;
    Vector3Of<Real> force = Vector3Of<Real>::Zero(), on_from = Vector3Of<Real>::Zero(), on_to = Vector3Of<Real>::Zero();
    void add(const Real& weight, const JointForceOf& other) {
        force += weight * other.force;
        on_from += weight * other.on_from;
        on_to += weight * other.on_to;
    }
};
using JointForce = JointForceOf<double>;

/// A joint at an instant, world: its axes, and the point of its `to` end from the origins of its frames [m].
template <class Real>
struct JointPoseOf {
    Matrix3Of<Real> axes;
    Vector3Of<Real> arm, lever;  ///< from the origin of the `from` frame, of the `to` frame
    /// A force and a moment at the point.
    JointForceOf<Real> act(const Vector3Of<Real>& force, const Vector3Of<Real>& moment) const {
        return {force, moment + cross<Real>(arm, force), moment + cross<Real>(lever, force)};
    }
    /// The same of [force; moment] in the joint's axes.
    JointForceOf<Real> act(const Eigen::Matrix<Real, 6, 1>& f) const {
        return act(axes * f.template head<3>(), axes * f.template tail<3>());
    }
};
using JointPose = JointPoseOf<double>;

// from, to: FrameView, or FrameOf

/// The axes of a joint.
template <class Real>
struct JointAxesOf {
    bool is_aligned = false;    ///< from_axes = I
    bool is_straight = false;   ///< to_axes = I
    Matrix3Of<Real> from_axes;  ///< of the joint in the axes of the `from` frame
    Matrix3Of<Real> to_axes;    ///< the same at rest in those of the `to` frame
    bool operator==(const JointAxesOf&) const = default;

    /// The joint's axes, which go with the `from` frame; those that are the same at rest and go with the `to` frame.
    Matrix3Of<Real> axes(const auto& from) const { return in_world(from, is_aligned, from_axes); }
    Matrix3Of<Real> axes_at_to(const auto& to) const { return in_world(to, is_straight, to_axes); }

private:
    Matrix3Of<Real> in_world(const auto& frame, bool is_one, const Matrix3Of<Real>& own) const {
        if (is_one) return frame.axes();
        return frame.axes() * own;
    }
};

/// The point where its ends meet at rest.
template <class Real>
struct JointPointOf {
    Vector3Of<Real> to_point;  ///< from the `to` origin, axes of the `to` frame [m]
    Vector3Of<Real> rest;      ///< from the `from` origin at rest, joint axes [m]
    bool has_lever = true;     ///< to_point ≠ 0

    /// It from the origins of its frames, where it goes with the `to` frame.
    Vector3Of<Real> arm(const auto& from, const auto& to) const {
        if (!has_lever) return to.origin() - from.origin();
        return to.origin() + to.axes() * to_point - from.origin();
    }
    Vector3Of<Real> lever(const auto& to) const {
        if (!has_lever) return Vector3Of<Real>::Zero();
        return to.axes() * to_point;
    }
    JointPoseOf<Real> pose(const JointAxesOf<Real>& own, const auto& from, const auto& to) const {
        return {own.axes(from), arm(from, to), lever(to)};
    }
};

/// How a joint sits between its frames. Joints that are alike share their axes.
struct JointSeat : JointPointOf<double> {
    std::shared_ptr<const JointAxesOf<double>> own;
    Matrix3 axes(const auto& from) const { return own->axes(from); }
    Matrix3 axes_at_to(const auto& to) const { return own->axes_at_to(to); }
    JointPose pose(const auto& from, const auto& to) const { return JointPointOf::pose(*own, from, to); }
};

}  // namespace dttmm::plugin
