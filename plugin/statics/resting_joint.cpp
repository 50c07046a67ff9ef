// SPDX-License-Identifier: BSD-3-Clause
#include "statics/resting_joint.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {

RestingForce resting_force(const Joint& joint, const Vector6& x) {
    RestingForce rest{joint.springs().along(x), joint.law().stiffness};
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

namespace {

Vector6 small_motion(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to) {
    return placed.joint.by_from(placed.pose) * of_from + placed.joint.by_to(placed.pose) * of_to;
}

void take_turn(const PlacedJoint& placed, Vector6& change) {
    if (placed.joint.turns()) change.tail<3>() = (rotation_vector_rate(placed.x.tail<3>()) * change.tail<3>()).eval();
}

}  // namespace

Vector6 change_of_motion(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to) {
    Vector6 change = small_motion(placed, of_from, of_to);
    take_turn(placed, change);
    return change;
}

Vector6 change_of_deformation(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to) {
    Vector6 change = small_motion(placed, of_from, of_to);
    if (placed.joint.is_line()) change.head<3>() = (placed.joint.strain_columns(placed.x) * change).eval();
    take_turn(placed, change);
    return change;
}

JointForce carried_force(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid) {
    const Joint& joint = placed.joint;
    JointForce all = joint.act(placed.pose, placed.x, force);
    if (joint.law().rigid.none()) return all;
    Vector6 held = rigid;
    if (joint.turns()) held.tail<3>() = joint.opening_of_turn(placed.x.tail<3>()).transpose() * rigid.tail<3>();
    all.add(1, placed.pose.act(held));
    return all;
}

/// Of forces f along the strains of a line, by [d; θ]: the curvature of f·s. Of a gradient g by θ the moment is J⁻ᵀ g.
Matrix6 spread_tangent(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid) {
    const Joint& joint = placed.joint;
    Matrix6 tangent = Matrix6::Zero();
    if (!joint.turns()) return tangent;
    const Vector3 theta = placed.x.tail<3>();
    Vector6 gradient = force;
    if (!joint.is_hinge()) gradient += rigid;
    if (joint.is_line()) {
        tangent = curvature_of(joint.springs().line, force.head<3>(), placed.x);
        Vector3 f = force.head<3>(), by_theta = Vector3::Zero();
        joint.springs().spread(placed.x.head<3>(), theta, f, by_theta);
        gradient.tail<3>() += by_theta;
    }
    const Matrix3 inverse_J = rotation_vector_rate(theta);
    tangent.bottomRows<3>() = (inverse_J.transpose() * tangent.bottomRows<3>()).eval();
    tangent.bottomRightCorner<3, 3>() += moment_of_gradient_rate(theta, gradient.tail<3>());
    tangent.rightCols<3>() = (tangent.rightCols<3>() * inverse_J).eval();
    return tangent;
}

namespace {

/// R X Rᵀ, each half of X turned.
Matrix6 rotated(const Matrix3& R, const Matrix6& X) {
    Matrix6 out;
    for (const int i : {0, 3})
        for (const int j : {0, 3}) out.block<3, 3>(i, j).noalias() = R * X.block<3, 3>(i, j) * R.transpose();
    return out;
}

/// How the force and the moment of a joint at its point change with the pose of an end, world axes. spread: by the relative
/// motion there, world axes too.
Matrix6 force_by_end(const PlacedJoint& placed, int end, const Vector3& arm, const Vector3& force, const Vector3& moment,
                     const Matrix6& spread) {
    const double sign = end == 0 ? -1 : 1;
    Matrix6 change = Matrix6::Zero();
    if (placed.joint.is_axial()) {  // F = n f, δF = f/L (δr − n (n·δr)), r from the first point of its line to the second
        const Vector3 line = placed.joint.way(placed.at.from, placed.at.to), n = placed.pose.axes.col(0);
        const Matrix3 across = sign * force.dot(n) / line.norm() * (Matrix3::Identity() - n * n.transpose());
        change.topRows<3>() << across, -across * skew(arm);
        return change;
    }
    if (!spread.isZero(0)) {
        change = sign * spread;
        change.rightCols<3>() -= change.leftCols<3>() * skew(arm);
    }
    if (end == 0) {  // its axes go with the `from` frame
        change.topRightCorner<3, 3>() -= skew(force);
        change.bottomRightCorner<3, 3>() -= skew(moment);
    }
    return change;
}

}  // namespace

EndBlocks turning_stiffness(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid, const Matrix6& spread) {
    const JointForce now = carried_force(placed, force, rigid);
    const Vector3 arms[2] = {placed.joint.arm(0, placed.at.from, placed.at.to), placed.pose.lever};
    Vector3 moment = Vector3::Zero();
    if (placed.joint.turns()) moment = now.on_to - arms[1].cross(now.force);
    const Matrix6 by_motion = spread.isZero(0) ? spread : rotated(placed.pose.axes, spread);
    EndBlocks K;
    for (int end : {0, 1}) {
        const Matrix6 change = force_by_end(placed, end, arms[end], now.force, moment, by_motion);
        K.at[0][end] = -change;
        K.at[0][end].bottomRows<3>() -= skew(arms[0]) * change.topRows<3>();
        K.at[1][end] = change;
        K.at[1][end].bottomRows<3>() += skew(arms[1]) * change.topRows<3>();
    }
    // The lever arms change too. The first arm of an axial joint turns with `from`, that of others follows the point.
    const Matrix3 F = skew(now.force), by_lever = F * skew(arms[1]);
    K.at[1][1].bottomRightCorner<3, 3>() += by_lever;
    if (placed.joint.is_axial()) {
        K.at[0][0].bottomRightCorner<3, 3>() -= F * skew(arms[0]);
    } else {
        K.at[0][0].bottomLeftCorner<3, 3>() -= F;
        K.at[0][1].bottomLeftCorner<3, 3>() += F;
        K.at[0][1].bottomRightCorner<3, 3>() -= by_lever;
    }
    return K;
}

}  // namespace dttmm::plugin
