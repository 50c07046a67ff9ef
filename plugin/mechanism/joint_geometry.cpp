// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joint_geometry.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "core/driven_ends.h"
#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

JointKind::JointKind(std::shared_ptr<const JointLaw> of)
    : law(std::move(of)),
      is_damped(!law->damping.isZero(0)),
      is_axial(law->axial.has_value()),
      has_laws(law->has_laws() || is_axial) {
    for (int half : {0, 1}) {
        springs.halves[half].stiffness = law->stiffness.segment<3>(3 * half);
        springs.halves[half].damping = law->damping.segment<3>(3 * half);
    }
    springs.turns = (law->carried() >> 3).any();
    springs.line = law->line;
    springs.is_line = law->line.half != 0;
    if (const Directions rotations = law->rigid >> 3; rotations.count() == 2)
        for (int axis = 0; axis < 3; ++axis)
            if (!rotations[as_size(axis)]) hinge_axis = axis;
}

void JointKind::set_scheme(const Scheme& scheme) {
    if (step_size == scheme.step_size()) return;
    // The unknown of the transfer equations is the increment over the open step, or, explicit, the one that ends at t_n.
    const StepCoefficients step =
        scheme.is_implicit() ? StepCoefficients{scheme.weight(0), scheme.rate(0)} : StepCoefficients{1, scheme.rate(1)};
    // f = [−q; m] of the input end against d = x_O − x_I: −∂q/∂x_O for forces, ∂m/∂θ_O for moments
    const EndForces ends = solve_driven_ends(law->transfer(step, Vector6::Zero()), law->resisting());
    for (int i = 0; i < 3; ++i) {
        solved[0](i) = -ends.S(i, 6 + i);
        solved[1](i) = ends.S(3 + i, 9 + i);
    }
    step_size = scheme.step_size();
}

JointGeometry::JointGeometry(const JointSpec& spec, const Assembly& assembly, std::shared_ptr<JointKind> kind)
    : kind_(std::move(kind)), element_(spec.element), from_(spec.from), to_(spec.to) {
    const Pose& from = assembly.frames[as_size(from_)].pose;
    const Pose& to = assembly.frames[as_size(to_)].pose;
    const JointAxesOf<double> axes{from.rotation == spec.pose.rotation, to.rotation == spec.pose.rotation,
                                   from.rotation.transpose() * spec.pose.rotation,
                                   to.rotation.transpose() * spec.pose.rotation};
    std::shared_ptr<const JointAxesOf<double>>& last = kind_->last_axes;
    if (!last || !(*last == axes)) last = std::make_shared<JointAxesOf<double>>(axes);
    seat_.own = last;
    seat_.rest = spec.pose.rotation.transpose() * (spec.pose.position - from.position);
    seat_.to_point = to.rotation.transpose() * (spec.pose.position - to.position);
    seat_.has_lever = spec.pose.position != to.position;
}

// ---- Kinematics ---------------------------------------------------------------------------------------------------------

/// Its x along the line; where the others point is of no account.
JointPose JointGeometry::axial_pose(FrameView from, FrameView to) const {
    const Vector3 line = way(from, to);
    const double length = line.norm();
    if (!(length > 0)) throw Error(DTTMM_ERROR_NUMERIC, "its ends have met: its force has no direction there", element_);
    JointPose pose{Matrix3(), seat_.arm(from, to), seat_.lever(to)};
    pose.axes.col(0) = line / length;
    pose.axes.col(1) = pose.axes.col(0).unitOrthogonal();
    pose.axes.col(2) = pose.axes.col(0).cross(pose.axes.col(1));
    return pose;
}

Vector6 JointGeometry::rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const {
    const JointPose at = pose(from, to);
    const Vector6 x = kind_->springs.is_line ? deformation(at, from, to) : Vector6(Vector6::Zero());
    return rate(at, from_velocity, to_velocity, x);
}

Vector6 JointGeometry::rate(const JointPose& pose, const Twist& from_velocity, const Twist& to_velocity,
                            const Vector6& x) const {
    // r = R_fromᵀ p,  p = p_to − p_from  =>  r' = R_fromᵀ (p' − ω_from × p)
    const auto& [R, arm, lever] = pose;
    Vector6 rate;
    rate << R.transpose() * (to_velocity.linear + to_velocity.angular.cross(lever) - from_velocity.linear -
                             from_velocity.angular.cross(arm)),
        R.transpose() * (to_velocity.angular - from_velocity.angular);
    if (is_line()) rate.head<3>() = (strain_columns(x) * rate).eval();
    if (is_axial()) rate.tail<5>().setZero();
    return rate;
}

Vector6 JointGeometry::acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
                                    const Twist& to_velocity, const Twist& to_acceleration) const {
    // r'' = R_fromᵀ (p'' − α × p − ω × (ω × p) − 2 ω × (p' − ω × p)),   ω and α of the `from` end
    const auto& [R, p, l] = pose(from, to);
    const Vector3 &w = from_velocity.angular, &w_to = to_velocity.angular;
    const Vector3 p_rate = to_velocity.linear + w_to.cross(l) - from_velocity.linear;
    const Vector3 a = to_acceleration.linear + to_acceleration.angular.cross(l) + w_to.cross(w_to.cross(l)) -
                      (from_acceleration.linear + from_acceleration.angular.cross(p) + w.cross(w.cross(p)) +
                       2 * w.cross(p_rate - w.cross(p)));
    const Vector3 alpha = to_acceleration.angular - (from_acceleration.angular + w.cross(w_to));
    Vector6 acceleration;
    if (is_axial()) {  // L'' = n · r'' + |r' across the line|²/L,   r from point to point
        const Vector3 o = arm_of_line(from), r_rate = p_rate - w.cross(o);
        const Vector3 across = r_rate - R.col(0) * R.col(0).dot(r_rate);
        const Vector3 r_second = to_acceleration.linear + to_acceleration.angular.cross(l) + w_to.cross(w_to.cross(l)) -
                                 (from_acceleration.linear + from_acceleration.angular.cross(o) + w.cross(w.cross(o)));
        acceleration << R.col(0).dot(r_second) + across.squaredNorm() / way(from, to).norm(), 0, 0, 0, 0, 0;
        return acceleration;
    }
    acceleration << R.transpose() * a, R.transpose() * alpha;
    if (is_line()) {  // the second difference is the second derivative of what is of third degree at most
        const Vector3 slide = R.transpose() * (p_rate - w.cross(p)), turn = R.transpose() * (w_to - w);
        const Vector6 x = deformation(pose(from, to), from, to);
        const Vector3 d = x.head<3>(), theta = x.tail<3>();
        const auto& springs = kind_->springs;
        acceleration.head<3>() = (strain_columns(x) * acceleration).eval() + springs.strains(d + slide, theta + turn) +
                                 springs.strains(d - slide, theta - turn) - 2 * springs.strains(d, theta);
    }
    return acceleration;
}

Vector3 JointGeometry::turning(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const {
    const auto& [R, arm, lever] = pose(from, to);
    if (!is_axial()) return R.transpose() * from_velocity.angular;
    const Vector3 line = way(from, to);
    const Vector3 rate = to_velocity.linear + to_velocity.angular.cross(lever) - from_velocity.linear -
                         from_velocity.angular.cross(arm_of_line(from));
    return R.transpose() * line.cross(rate) / line.squaredNorm();
}

Matrix6 JointGeometry::by_from(const JointPose& pose) const {
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = -pose.axes.transpose();
    G.topRightCorner<3, 3>() = pose.axes.transpose() * skew(pose.arm);
    return G;
}

Matrix3 JointGeometry::lever_rows(const JointPose& pose) const {
    return seat_.has_lever ? Matrix3(pose.axes.transpose() * skew(pose.lever)) : Matrix3(Matrix3::Zero());
}

Matrix6 JointGeometry::by_to(const JointPose& pose) const {
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = pose.axes.transpose();
    G.topRightCorner<3, 3>() = -lever_rows(pose);
    return G;
}

Vector6 JointGeometry::deformation(const JointPose& pose, FrameView from, FrameView to) const {
    Vector6 x;
    if (is_axial()) {
        x << way(from, to).norm() - kind_->law->axial->natural, 0, 0, 0, 0, 0;
        return x;
    }
    x << pose.axes.transpose() * pose.arm - seat_.rest, Vector3::Zero();
    if (turns()) x.tail<3>() = rotation_vector(Matrix3(pose.axes.transpose() * seat_.axes_at_to(to)));
    return x;
}

Vector6 JointGeometry::opening(const JointPose& pose, FrameView from, FrameView to) const {
    Vector6 x = deformation(pose, from, to);
    if (!is_hinge()) return x;
    const Vector3 axis = Vector3::Unit(kind_->hinge_axis);
    x.tail<3>() = axis.cross(attitude(from, to) * axis);
    return x;
}

Matrix36 JointGeometry::strain_columns(const Vector6& x) const {
    Matrix36 columns;
    columns << Matrix3::Identity(), Matrix3::Zero();
    if (!is_line()) return columns;
    const LineStrains& line = kind_->springs.line;
    const Vector3 d = x.head<3>(), theta = x.tail<3>();
    Matrix3 by_theta = line.half * skew(d);
    by_theta.row(0) -= 2 * line.bow * RowVector3(0, theta.y(), theta.z());
    const double twisted = 0.5 * line.half;
    by_theta.row(0) += twisted * RowVector3(theta.y() * d.y() + theta.z() * d.z(), theta.x() * d.y(), theta.x() * d.z());
    columns.leftCols<3>() -= line.half * skew(theta);
    columns.row(0).head<3>() += 2 * RowVector3(0, line.sway_y * d.y(), line.sway_z * d.z()) +
                                twisted * theta.x() * RowVector3(0, theta.y(), theta.z());
    columns.rightCols<3>() = by_theta * rotation_vector_rate(theta);
    return columns;
}

// ---- What forces do to the frames ---------------------------------------------------------------------------------------

/// G stays in the joint's axes. In world axes, round-off would give a spring through the origin of a frame a small moment.
/// Each block is worked out by itself. A transposed copy of the other one has other round-off, which a stiff rod multiplies.
EndBlocks JointGeometry::stiffness(const JointPose& pose, const Matrix6& answer) const {
    // G = ∓ [Rᵀ −P; 0 Rᵀ], block by block
    const Matrix3 &R = pose.axes, Rt = R.transpose(), P[2] = {Rt * skew(pose.arm), lever_rows(pose)};
    Matrix6 answered;  // without its sign
    answered.leftCols<3>().noalias() = answer.leftCols<3>() * Rt;
    EndBlocks K;
    for (int end : {0, 1}) {
        answered.rightCols<3>().noalias() = answer.rightCols<3>() * Rt;
        answered.rightCols<3>().noalias() -= answer.leftCols<3>() * P[end];
        Matrix6 turned;
        turned.topRows<3>().noalias() = R * answered.topRows<3>();
        turned.bottomRows<3>().noalias() = R * answered.bottomRows<3>();
        for (int at : {0, 1}) {
            Matrix6& block = K.at[at][end] = turned;
            block.bottomRows<3>().noalias() -= P[at].transpose() * answered.topRows<3>();
            if (at != end) block = -block;
        }
    }
    return K;
}

/// A force of a line turns with it, and its points with the frames: F = n f, δF = f/L (δr − n (n·δr)).
EndBlocks JointGeometry::axial_stiffness(FrameView from, FrameView to, const Vector3& force) const {
    const Vector3 line = way(from, to), n = line.normalized();
    const Vector3 arms[2] = {arm_of_line(from), seat_.lever(to)};
    const Matrix3 across = force.dot(line) / line.squaredNorm() * (Matrix3::Identity() - n * n.transpose());
    Eigen::Matrix<double, 3, 6> G[2];
    for (int end : {0, 1}) {
        const double sign = end == 0 ? -1 : 1;
        G[end] << sign * Matrix3::Identity(), -sign * skew(arms[end]);
    }
    EndBlocks K;
    for (int i : {0, 1}) {
        for (int j : {0, 1}) K.at[i][j] = G[i].transpose() * across * G[j];
        const Matrix3 aF = skew(arms[i]) * skew(force);
        K.at[i][i].bottomRightCorner<3, 3>() += (i == 0 ? -0.5 : 0.5) * (aF + aF.transpose());
    }
    return K;
}

EndBlocks JointGeometry::acting_stiffness(const JointPose& pose, FrameView from, FrameView to, const Vector3& force) const {
    if (is_axial()) return axial_stiffness(from, to, force);
    // F goes with the axes of `from`, its point with `to`: δF = δθ_from × F, δp = δx_to + δθ_to × l
    const Matrix3 F = skew(force), aF = skew(pose.arm) * F, lF = skew(pose.lever) * F;
    EndBlocks K;
    for (auto& row : K.at)
        for (Matrix6& block : row) block.setZero();
    K.at[0][0].topRightCorner<3, 3>() = F;
    K.at[0][0].bottomLeftCorner<3, 3>() = -F;
    K.at[0][0].bottomRightCorner<3, 3>() = 0.5 * (aF + aF.transpose());
    K.at[0][1].bottomLeftCorner<3, 3>() = F;
    K.at[0][1].bottomRightCorner<3, 3>() = -lF.transpose();
    K.at[1][0].topRightCorner<3, 3>() = -F;
    K.at[1][0].bottomRightCorner<3, 3>() = -lF;
    K.at[1][1].bottomRightCorner<3, 3>() = 0.5 * (lF + lF.transpose());
    if (!is_line()) return K;
    // The strains of a line are not linear
    const EndBlocks stretched =
        stiffness(pose, curvature_of(kind_->springs.line, pose.axes.transpose() * force, deformation(pose, from, to)));
    for (int i : {0, 1})
        for (int j : {0, 1}) K.at[i][j] += stretched.at[i][j];
    return K;
}

void JointGeometry::refuse_large_rotation(FrameView from, FrameView to) const {
    if (turns() && !kind_->springs.halves[1].stiffness.isZero(0)) refuse_rotation(rotation(from, to).norm());
}

void JointGeometry::refuse_rotation(double angle) const {
    if (angle <= kLargestRotation || kind_->springs.halves[1].stiffness.isZero(0)) return;
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("{} have turned {:.3g} rad against each other; a rotational stiffness holds up to {:g} rad{}",
                            is_line() ? "the ends of one of its segments" : "its ends", angle, kLargestRotation,
                            is_line() ? ": give it more segments" : ""),
                element_);
}

}  // namespace dttmm::plugin
