// SPDX-License-Identifier: BSD-3-Clause
#include "statics/resting_joint.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {

RestingForce resting_force(const Joint& joint, const Vector6& x) {
    RestingForce rest{joint.law().stiffness.cwiseProduct(x), joint.law().stiffness};
    if (!joint.has_laws()) return rest;
    const std::vector<double> undeformed(joint.law().memory_before(6), 0.0);
    for (int d = 0; d < 6; ++d) {
        const LawOnPath path = joint.ask(d, {0, x(d), 0, undeformed.data()});
        rest.force(d) = path.force;
        rest.tangent(d) = path.tangent;
    }
    return rest;
}

Vector6 unloading_tangent(const Joint& joint, const Vector6& x) {
    Vector6 tangent = joint.law().stiffness;
    if (!joint.has_laws()) return tangent;
    const size_t size = joint.law().memory_before(6);
    const std::vector<double> undeformed(size, 0.0);
    std::vector<double> memory(size, 0.0);
    for (int d = 0; d < 6; ++d) joint.ask(d, {0, x(d), 0, undeformed.data(), memory.data()});
    for (int d = 0; d < 6; ++d) tangent(d) = joint.ask(d, {x(d), x(d), 0, memory.data()}).tangent;
    return tangent;
}

Vector6 change_of_deformation(const Joint& joint, const JointPose& pose, const Vector6& x, const Vector6& of_from,
                              const Vector6& of_to) {
    Vector6 change = joint.by_from(pose) * of_from + joint.by_to(pose) * of_to;
    change(0) = joint.stretch(x).dot(change);
    if (joint.turns()) change.tail<3>() = (rotation_vector_rate(x.tail<3>()) * change.tail<3>()).eval();
    return change;
}

JointForce carried_force(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid) {
    const JointPose pose = joint.pose(at);
    const Vector6 x = joint.deformation(pose, at.from, at.to);
    JointForce all = joint.act(pose, x, force);
    if (joint.law().rigid.none()) return all;
    const Vector3 moment =
        joint.turns() ? moment_of_gradient(x.tail<3>(), Vector3(rigid.tail<3>())) : Vector3(rigid.tail<3>());
    Vector6 held;
    held << rigid.head<3>(), moment;
    all.add(1, pose.act(held));
    return all;
}

/// By central differences: with 1e-5 rad what is neglected and rounding are 1e-10 of the forces.
Matrix6 spread_tangent(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid) {
    constexpr double kStep = 1e-5;
    Matrix6 tangent = Matrix6::Zero();
    if (!joint.turns() && !joint.is_line()) return tangent;
    const JointPose pose = joint.pose(at);
    const Vector6 x = joint.deformation(pose, at.from, at.to);
    const double size = std::max({pose.arm.norm(), pose.lever.norm(), kStep});
    for (int c = 0; c < 6; ++c) {
        Vector6 change = (c < 3 ? kStep * size : kStep) * Vector6::Unit(c);
        const double step = change(c);
        change(0) = joint.stretch(x).dot(change);
        if (joint.turns()) change.tail<3>() = (rotation_vector_rate(x.tail<3>()) * change.tail<3>()).eval();
        for (const double sign : {1.0, -1.0}) {
            const Vector6 end = x + sign * change;
            Vector6 all = joint.spread(end, force) + rigid;
            if (joint.turns())
                all.tail<3>() += moment_of_gradient(Vector3(end.tail<3>()), Vector3(rigid.tail<3>())) - rigid.tail<3>();
            tangent.col(c) += sign / (2 * step) * all;
        }
    }
    return tangent;
}

/// By the motion of the `to` end by central differences. The forces are linear in the shifts of frames and smooth in their
/// turns: with 1e-5 rad both the neglected third derivative and rounding are 1e-10 of the forces. What the `from` end does
/// follows: forces go with a motion of both ends as a whole.
EndBlocks turning_stiffness(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid) {
    constexpr double kTurn = 1e-5;
    EndBlocks K;
    for (auto& row : K.at)
        for (Matrix6& block : row) block.setZero();
    if (force.isZero(0) && rigid.isZero(0)) return K;
    const JointPose pose = joint.pose(at);
    double size = std::max(pose.arm.norm(), pose.lever.norm());
    if (joint.is_axial()) size = joint.way(at.from, at.to).norm();
    if (!(size > 0)) size = 1;
    for (int c = 0; c < 6; ++c) {
        const double step = c < 3 ? kTurn * size : kTurn;
        JointForce difference;
        for (const double sign : {1.0, -1.0}) {
            Frame moved = at.to.copy();
            if (c < 3) {
                moved.position[c] += sign * step;
            } else {
                Eigen::Map<RowMajor3> axes(moved.rotation);
                axes = (rotation_from_vector(Vector3(sign * step * Vector3::Unit(c - 3))) * axes).eval();
            }
            difference.add(sign / (2 * step), carried_force(joint, {at.from, FrameView(moved)}, force, rigid));
        }
        K.at[0][1].col(c) << -difference.force, -difference.on_from;
        K.at[1][1].col(c) << difference.force, difference.on_to;
    }
    const JointForce now = carried_force(joint, at, force, rigid);
    const Matrix3 between = skew(at.to.origin() - at.from.origin());
    for (int row : {0, 1}) {
        K.at[row][0].leftCols<3>() = -K.at[row][1].leftCols<3>();
        K.at[row][0].rightCols<3>() = K.at[row][1].leftCols<3>() * between - K.at[row][1].rightCols<3>();
        const double sign = row == 0 ? 1 : -1;
        K.at[row][0].topRightCorner<3, 3>() += sign * skew(now.force);
        K.at[row][0].bottomRightCorner<3, 3>() += sign * skew(row == 0 ? now.on_from : now.on_to);
    }
    return K;
}

}  // namespace dttmm::plugin
