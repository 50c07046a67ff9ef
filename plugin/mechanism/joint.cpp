// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joint.h"

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
    springs.is_line = law->line.mixed != 0;
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

Joint::Joint(const JointSpec& spec, const Assembly& assembly, std::shared_ptr<JointKind> kind)
    : element_(spec.element), from_(spec.from), to_(spec.to), kind_(std::move(kind)) {
    const Pose& from = assembly.frames[as_size(from_)].pose;
    const Pose& to = assembly.frames[as_size(to_)].pose;
    seat_.from_axes = from.rotation.transpose() * spec.pose.rotation;
    seat_.to_axes = to.rotation.transpose() * spec.pose.rotation;
    seat_.rest = spec.pose.rotation.transpose() * (spec.pose.position - from.position);
    seat_.to_point = to.rotation.transpose() * (spec.pose.position - to.position);
    seat_.is_aligned = from.rotation == spec.pose.rotation;
    seat_.is_straight = to.rotation == spec.pose.rotation;
    seat_.has_lever = spec.pose.position != to.position;
    if (!is_axial()) return;
    const Vector3 start = spec.pose.position - law().axial->length * spec.pose.rotation.col(0);
    from_point_ = from.rotation.transpose() * (start - from.position);
}

void Joint::set_scheme(const Scheme& scheme) {
    try {
        kind_->set_scheme(scheme);
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element_);
    }
}

// ---- Kinematics ---------------------------------------------------------------------------------------------------------

/// Its x along the line; where the others point is of no account.
JointPose Joint::axial_pose(FrameView from, FrameView to) const {
    const Vector3 line = way(from, to);
    const double length = line.norm();
    if (!(length > 0)) throw Error(DTTMM_ERROR_NUMERIC, "its ends have met: its force has no direction there", element_);
    JointPose pose{Matrix3(), seat_.arm(from, to), seat_.lever(to)};
    pose.axes.col(0) = line / length;
    pose.axes.col(1) = pose.axes.col(0).unitOrthogonal();
    pose.axes.col(2) = pose.axes.col(0).cross(pose.axes.col(1));
    return pose;
}

Vector6 Joint::rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const {
    const Vector6 x = kind_->springs.is_line ? deformation(pose(from, to), from, to) : Vector6(Vector6::Zero());
    return rate(from, from_velocity, to, to_velocity, x);
}

Vector6 Joint::rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity,
                    const Vector6& x) const {
    // r = R_fromᵀ p,  p = p_to − p_from  =>  r' = R_fromᵀ (p' − ω_from × p)
    const auto& [R, arm, lever] = pose(from, to);
    Vector6 rate;
    rate << R.transpose() * (to_velocity.linear + to_velocity.angular.cross(lever) - from_velocity.linear -
                             from_velocity.angular.cross(arm)),
        R.transpose() * (to_velocity.angular - from_velocity.angular);
    if (kind_->springs.is_line) rate(0) = stretch(x).dot(rate);
    if (is_axial()) rate.tail<5>().setZero();
    return rate;
}

Vector6 Joint::acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
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
    if (kind_->springs.is_line) {  // of second degree: its second rate has twice its value for the rates
        const Vector3 slide = R.transpose() * (p_rate - w.cross(p)), turn = R.transpose() * (w_to - w);
        acceleration(0) = stretch(deformation(pose(from, to), from, to)).dot(acceleration) +
                          2 * kind_->springs.drawn(slide, turn).elongation;
    }
    return acceleration;
}

Vector3 Joint::turning(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const {
    const auto& [R, arm, lever] = pose(from, to);
    if (!is_axial()) return R.transpose() * from_velocity.angular;
    const Vector3 line = way(from, to);
    const Vector3 rate = to_velocity.linear + to_velocity.angular.cross(lever) - from_velocity.linear -
                         from_velocity.angular.cross(arm_of_line(from));
    return R.transpose() * line.cross(rate) / line.squaredNorm();
}

Matrix6 Joint::by_from(const JointPose& pose) const {
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = -pose.axes.transpose();
    G.topRightCorner<3, 3>() = pose.axes.transpose() * skew(pose.arm);
    return G;
}

Matrix6 Joint::by_to(const JointPose& pose) const {
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = pose.axes.transpose();
    if (seat_.has_lever) G.topRightCorner<3, 3>() = -pose.axes.transpose() * skew(pose.lever);
    return G;
}

// ---- The force law ------------------------------------------------------------------------------------------------------

Vector6 Joint::deformation(const JointPose& pose, FrameView from, FrameView to) const {
    Vector6 x;
    if (is_axial()) {
        x << way(from, to).norm() - kind_->law->axial->natural, 0, 0, 0, 0, 0;
        return x;
    }
    x << pose.axes.transpose() * pose.arm - seat_.rest, Vector3::Zero();
    if (turns()) x.tail<3>() = rotation_vector(Matrix3(pose.axes.transpose() * seat_.axes_at_to(to)));
    if (kind_->springs.is_line) x(0) += kind_->springs.drawn(x.head<3>(), x.tail<3>()).elongation;
    return x;
}

/// What the law of a direction answers; a fault names the element.
LawOnPath Joint::ask(int direction, const LawPath& path) const {
    if (at_work_) *at_work_ = reported_;
    try {
        const LawOnPath answer = kind_->law->along(direction, path);
        if (at_work_) *at_work_ = -1;
        return answer;
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element_);
    }
}

/// The forces of laws in place of those of linear springs.
void Joint::put_laws(const LawsAt& from, const Vector6& x, Vector6& f) const {
    for (int d = 0; d < 6; ++d) f(d) = ask(d, {from.x(d), x(d), from.time, from.memory}).force;
}

/// Its derivative by the deformations.
Vector6 Joint::spring_tangent(const LawsAt& from, const Vector6& x) const {
    if (!kind_->has_laws) return kind_->law->stiffness;
    Vector6 k;
    for (int d = 0; d < 6; ++d) k(d) = ask(d, {from.x(d), x(d), from.time, from.memory}).tangent;
    return k;
}

double Joint::energy_of_laws(const Vector6& x, const double* memory) const {
    double stored = 0;
    for (int d = 0; d < 6; ++d) stored += ask(d, {x(d), x(d), 0, memory}).stored;
    return stored;
}

LawOnPath Joint::law_on_path(int direction, const LawPath& path) const {
    LawOnPath on_path = ask(direction, path);
    if (takes_ends_[direction / 3]) {
        on_path.mean = 0.5 * (ask(direction, {path.from, path.from, 0, path.memory}).force + on_path.force);
        on_path.mean_tangent = 0.5 * on_path.tangent;
    }
    return on_path;
}

Joint::OnPath Joint::on_path(const Scheme& scheme, int direction, double now, double end, const double* memory) const {
    const double weight = scheme.elastic_weight(0), lag = scheme.lag(), k = kind_->law->stiffness(direction);
    const LawOnPath path = law_on_path(direction, {now, end, scheme.step_size(), memory});
    const double start = ask(direction, {now, now, 0, memory}).force;
    OnPath step;
    step.mean = path.mean - 0.5 * (start + path.force);
    step.rate = lag * (path.force - start - k * (end - now)) + 0.5 * step.mean;
    step.rate_gain = lag * (path.tangent - k) + 0.5 * (path.mean_tangent - 0.5 * path.tangent);
    step.force = weight * path.force + step.rate;
    step.gain = weight * path.tangent + step.rate_gain;
    return step;
}

Joint::Beyond Joint::beyond(const Scheme& scheme, const Vector6& x, const Vector6& end, const double* memory) const {
    Beyond beyond;
    for (int d = 0; d < 6; ++d) {
        if (!kind_->law->laws[as_size(d)]) continue;
        const OnPath step = on_path(scheme, d, x(d), end(d), memory);
        beyond.force(d) = step.force - scheme.elastic_weight(0) * kind_->law->stiffness(d) * end(d);
        beyond.mean(d) = step.mean;
        beyond.rate(d) = step.rate;
        beyond.gain(d) = step.rate_gain;
    }
    return beyond;
}

JointForce Joint::act(const JointPose& pose, const Vector6& x, const Vector6& f) const {
    return kind_->springs.act(pose, kind_->springs.drawn(x.head<3>(), x.tail<3>()), x.tail<3>(), f.head<3>(), f.tail<3>(),
                              Vector3::Zero());
}

void Joint::strain_laws(Ends at, const JointPose& pose, const LawsAt& from, Strained& strained) const {
    if (is_axial()) strained.d = deformation(pose, at.from, at.to).head<3>();
    const Vector6 x = strained.deformation();
    Vector6 f;
    put_laws(from, x, f);
    strained.elastic = act(pose, x, f);
}

/// Laws come to where the joint is at the start on the straight way.
void Joint::start_laws(Ends at, const JointPose& pose, LawMemory memory, Strained& strained) const {
    const Vector6 x = deformation(pose, at.from, at.to);
    if (is_axial()) strained.d = x.head<3>();
    const size_t size = kind_->law->memory_before(6);
    std::fill_n(memory.before, size, 0.0);
    std::fill_n(memory.now, size, 0.0);
    for (int d = 0; d < 6; ++d) ask(d, {0, x(d), 0, memory.before, memory.now});
    std::copy_n(memory.now, size, memory.before);
    strained.elastic = act(pose, x, spring_force(x, memory.now));
}

/// Adds to the force over the step what laws do otherwise than linear springs.
void Joint::add_laws(const Scheme& scheme, const Strained& end, const JointPose& at_end, const JointState& state,
                     const double* memory, JointForce& force) const {
    if (!scheme.is_implicit()) return;
    const Beyond more = beyond(scheme, state.deformation(), end.deformation(), memory);
    force.add(1, act(at_end, end.deformation(), more.force));
}

Vector6 Joint::stretch(const Vector6& x) const {
    Vector6 columns = Vector6::UnitX();
    if (!kind_->springs.is_line) return columns;
    const SpringsOf<double>::Drawn e = kind_->springs.drawn(x.head<3>(), x.tail<3>());
    columns << 1, e.by_y, e.by_z, moment_of_gradient(x.tail<3>(), Vector3(0, e.by_turn_y, e.by_turn_z));
    return columns;
}

Vector6 Joint::damping(const Vector6& x, const Vector6& rate) const {
    Vector6 f;
    f << kind_->springs.halves[0].damping.cwiseProduct(rate.head<3>()),
        kind_->springs.halves[1].damping.cwiseProduct(rate.tail<3>());
    if (kind_->springs.is_line) f += f(0) * (stretch(x) - Vector6::UnitX());
    return f;
}

Matrix6 Joint::stiffness_tangent(const Vector6& x, const double* memory) const {
    return along(x, spring_tangent({x, memory, 0}, x));
}

/// Of springs of the stiffness k along the deformations.
Matrix6 Joint::along(const Vector6& x, const Vector6& k) const {
    Matrix6 K = Matrix6::Zero();
    const Vector6 e = stretch(x);
    K.diagonal().segment<2>(1) = k.segment<2>(1);
    K += k(0) * e * e.transpose();
    if (!turns()) return K;
    const Matrix3 inverse_J = rotation_vector_rate(x.tail<3>());
    K.bottomRightCorner<3, 3>() += inverse_J.transpose() * k.tail<3>().asDiagonal() * inverse_J;
    return K;
}

Matrix6 Joint::damping_tangent(const Vector6& x) const {
    Vector6 c;
    c << kind_->springs.halves[0].damping, kind_->springs.halves[1].damping;
    const Vector6 e = stretch(x);
    Matrix6 C = c(0) * e * e.transpose();
    C.diagonal().tail<5>() += c.tail<5>();
    return C;
}

Matrix6 Joint::gain(const Scheme& scheme, const Vector6& now, const Vector6& x, const double* memory) const {
    // Beside the elastic force over the step there are its dampers, and the scheme's own
    const double weight = scheme.elastic_weight(0);
    Matrix6 gain = weight * along(x, spring_tangent({now, memory, scheme.step_size()}, x));
    if (kind_->has_laws) gain += along(x, beyond(scheme, now, x, memory).gain);
    Vector6 other;
    other << kind_->solved[0] - weight * kind_->springs.halves[0].stiffness,
        kind_->solved[1] - weight * kind_->springs.halves[1].stiffness;
    const Vector6 e = stretch(x);
    gain += other(0) * e * e.transpose();
    gain.diagonal().segment<2>(1) += other.segment<2>(1);
    if (turns()) gain.diagonal().tail<3>() += other.tail<3>();
    return gain;
}

EndBlocks Joint::stiffness(const JointPose& pose, const Matrix6& answer) const {
    const Matrix6 G[2] = {by_from(pose), by_to(pose)};
    EndBlocks K;
    for (int i : {0, 1})
        for (int j : {0, 1}) K.at[i][j].noalias() = G[i].transpose() * answer * G[j];
    return K;
}

/// A force of a line turns with it, and its points with the frames: F = n f, δF = f/L (δr − n (n·δr)).
EndBlocks Joint::axial_stiffness(FrameView from, FrameView to, const Vector3& force) const {
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

EndBlocks Joint::acting_stiffness(const JointPose& pose, FrameView from, FrameView to, const Vector3& force) const {
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
    if (!kind_->springs.is_line) return K;
    // A pull along a line stretches it as it bends and shears
    const Foreshortening& line = kind_->springs.line;
    Matrix6 curvature = Matrix6::Zero();  // of the elongation, by d and θ
    curvature.diagonal() << 0, 2 * line.sway_y, 2 * line.sway_z, 0, -2 * line.bow, -2 * line.bow;
    curvature(1, 5) = curvature(5, 1) = line.mixed;
    curvature(2, 4) = curvature(4, 2) = -line.mixed;
    const EndBlocks stretched = stiffness(pose, pose.axes.col(0).dot(force) * curvature);
    for (int i : {0, 1})
        for (int j : {0, 1}) K.at[i][j] += stretched.at[i][j];
    return K;
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

Joint::AtRest Joint::at_rest(const Vector6& x) const {
    AtRest rest{kind_->law->stiffness.cwiseProduct(x), kind_->law->stiffness};
    if (!kind_->has_laws) return rest;
    const std::vector<double> undeformed(kind_->law->memory_before(6), 0.0);
    for (int d = 0; d < 6; ++d) {
        const LawOnPath path = ask(d, {0, x(d), 0, undeformed.data()});
        rest.force(d) = path.force;
        rest.tangent(d) = path.tangent;
    }
    return rest;
}

Vector6 Joint::unloading(const Vector6& x) const {
    Vector6 tangent = kind_->law->stiffness;
    if (!kind_->has_laws) return tangent;
    const size_t size = kind_->law->memory_before(6);
    const std::vector<double> undeformed(size, 0.0);
    std::vector<double> memory(size, 0.0);
    for (int d = 0; d < 6; ++d) ask(d, {0, x(d), 0, undeformed.data(), memory.data()});
    for (int d = 0; d < 6; ++d) tangent(d) = ask(d, {x(d), x(d), 0, memory.data()}).tangent;
    return tangent;
}

Vector6 Joint::change(const JointPose& pose, const Vector6& x, const Vector6& of_from, const Vector6& of_to) const {
    Vector6 change = by_from(pose) * of_from + by_to(pose) * of_to;
    change(0) = stretch(x).dot(change);
    if (turns()) change.tail<3>() = (rotation_vector_rate(x.tail<3>()) * change.tail<3>()).eval();
    return change;
}

JointForce Joint::carry(Ends at, const Vector6& force, const Vector6& rigid) const {
    const JointPose pose = this->pose(at);
    const Vector6 x = deformation(pose, at.from, at.to);
    JointForce all = act(pose, x, force);
    if (law().rigid.none()) return all;
    const Vector3 moment = turns() ? moment_of_gradient(x.tail<3>(), Vector3(rigid.tail<3>())) : Vector3(rigid.tail<3>());
    Vector6 held;
    held << rigid.head<3>(), moment;
    all.add(1, pose.act(held));
    return all;
}

/// By central differences: with 1e-5 rad what is neglected and rounding are 1e-10 of the forces.
Matrix6 Joint::spread_tangent(Ends at, const Vector6& force, const Vector6& rigid) const {
    constexpr double kStep = 1e-5;
    Matrix6 tangent = Matrix6::Zero();
    if (!turns() && !kind_->springs.is_line) return tangent;
    const JointPose pose = this->pose(at);
    const Vector6 x = deformation(pose, at.from, at.to);
    const double size = std::max({pose.arm.norm(), pose.lever.norm(), kStep});
    for (int c = 0; c < 6; ++c) {
        Vector6 change = (c < 3 ? kStep * size : kStep) * Vector6::Unit(c);
        const double step = change(c);
        change(0) = stretch(x).dot(change);
        if (turns()) change.tail<3>() = (rotation_vector_rate(x.tail<3>()) * change.tail<3>()).eval();
        for (const double sign : {1.0, -1.0}) {
            const Vector6 end = x + sign * change;
            Vector6 all = spread(end, force) + rigid;
            if (turns())
                all.tail<3>() += moment_of_gradient(Vector3(end.tail<3>()), Vector3(rigid.tail<3>())) - rigid.tail<3>();
            tangent.col(c) += sign / (2 * step) * all;
        }
    }
    return tangent;
}

/// By the motion of the `to` end by central differences. The forces are linear in the shifts of frames and smooth in their
/// turns: with 1e-5 rad both the neglected third derivative and rounding are 1e-10 of the forces. What the `from` end does
/// follows: forces go with a motion of both ends as a whole.
EndBlocks Joint::turning_stiffness(Ends at, const Vector6& force, const Vector6& rigid) const {
    constexpr double kTurn = 1e-5;
    EndBlocks K;
    for (auto& row : K.at)
        for (Matrix6& block : row) block.setZero();
    if (force.isZero(0) && rigid.isZero(0)) return K;
    const JointPose pose = this->pose(at);
    double size = std::max(pose.arm.norm(), pose.lever.norm());
    if (is_axial()) size = way(at.from, at.to).norm();
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
            difference.add(sign / (2 * step), carry({at.from, FrameView(moved)}, force, rigid));
        }
        K.at[0][1].col(c) << -difference.force, -difference.on_from;
        K.at[1][1].col(c) << difference.force, difference.on_to;
    }
    const JointForce now = carry(at, force, rigid);
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

// ---- Time steps ---------------------------------------------------------------------------------------------------------

/// The past before the start is the parabola through it, which suits every explicit scheme; for the centred one the elastic
/// force before the start counts as that at the start.
void Joint::start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
                  JointState& state, DamperState* damper, LawMemory memory) const {
    const double h = scheme.step_size();
    const JointPose now = pose(from, to);
    Strained strained = kind_->springs.strain(seat_.rest, now, seat_.axes_at_to(to));
    if (kind_->has_laws) start_laws({from, to}, now, memory, strained);
    state.elastic = strained.elastic;
    state.d = strained.d;
    state.theta = strained.theta;
    const auto increment = [&](int back) -> Vector6 { return h * rate - (back + 0.5) * h * h * acceleration; };
    state.d_before = state.d - increment(0).head<3>();
    state.theta_before = turns() ? Vector3(state.theta - increment(0).tail<3>()) : Vector3(Vector3::Zero());
    if (damper) {
        for (int half : {0, 1}) {
            for (int back = 0; back < 3; ++back) damper->halves[half].delta[back] = increment(back).segment<3>(3 * half);
        }
        damper->attitude = turns() ? strained.attitude : Matrix3(Matrix3::Identity());
        damper->dissipated = 0;
        damper->last_loss = 0;
    }
    if (!scheme.is_implicit()) return kind_->springs.recall(scheme, now, state.elastic, state, damper);
    // The rate of the first step is Newmark's from d, d', d'': γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''
    const double gamma = scheme.centred().gamma;
    const Vector6 known = (1 - gamma) * rate + (scheme.centred().beta - 0.5 * gamma) * h * acceleration;
    state.known = {};
    state.known.add(1 - scheme.elastic_weight(0), state.elastic);
    state.known.add(1, kind_->springs.act(now, strained.drawn, state.theta,
                                          kind_->springs.halves[0].damping.cwiseProduct(known.head<3>()), Vector3::Zero(),
                                          kind_->springs.halves[1].damping.cwiseProduct(known.tail<3>())));
}

JointForce Joint::damping_half_way(Ends trial, Ends now, double h, const JointState& state,
                                   const DamperState& damper) const {
    const JointPose at = pose(now), end = pose(trial);
    const Vector6 x = deformation(end, trial.from, trial.to);
    const Vector3 slide = (kind_->springs.halves[0].damping / h).cwiseProduct(x.head<3>() - state.d);
    Vector3 turn = Vector3::Zero();
    if (turns())
        turn = (kind_->springs.halves[1].damping / h)
                   .cwiseProduct(rotation_vector(attitude(trial.from, trial.to) * damper.attitude.transpose()));
    const Vector3 d = 0.5 * (x.head<3>() + state.d), theta = 0.5 * (x.tail<3>() + state.theta);
    return kind_->springs.act({0.5 * (end.axes + at.axes), at.arm, at.lever}, kind_->springs.drawn(d, theta), theta, slide,
                              Vector3::Zero(), turn);
}

[[gnu::flatten]] void Joint::advance(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper,
                                     LawMemory memory, JointForce* force) const {
    if (kind_->has_laws) [[unlikely]]
        return advance_with_laws(scheme, next, now, state, damper, memory, force);
    const JointPose at_end = seat_.pose(next.from, next.to);
    const Strained end = kind_->springs.strain(seat_.rest, at_end, seat_.axes_at_to(next.to));
    if (force) *force = kind_->springs.weigh(scheme, end, at_end, state, damper);
    kind_->springs.advance(
        scheme, end, at_end, [&] { return seat_.pose(now.from, now.to); }, state, damper);
}

/// The same; what laws did over the step is known of the coming one too.
void Joint::advance_with_laws(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper,
                              LawMemory memory, JointForce* force) const {
    const JointPose at_end = pose(next), at_now = pose(now);
    const Strained end = strain(scheme, next, at_end, state, memory.now);
    if (force) *force = weigh(scheme, end, at_end, state, damper, memory.now);
    kind_->springs.advance(
        scheme, end, at_end, [&] { return at_now; }, state, damper);
    const Vector6 start = state.deformation_before(), x = state.deformation();
    if (scheme.is_implicit()) state.known.add(1, act(at_now, start, beyond(scheme, start, x, memory.now).rate));
    std::copy_n(memory.now, kind_->law->memory_before(6), memory.before);
    for (int d = 0; d < 6; ++d)
        damper->last_loss += ask(d, {start(d), x(d), scheme.step_size(), memory.before, memory.now}).dissipated;
}

void Joint::refuse_large_rotation(FrameView from, FrameView to) const {
    if (turns() && !kind_->springs.halves[1].stiffness.isZero(0)) refuse_rotation(rotation(from, to).norm());
}

void Joint::refuse_rotation(double angle) const {
    if (angle <= kLargestRotation || kind_->springs.halves[1].stiffness.isZero(0)) return;
    throw Error(
        DTTMM_ERROR_NUMERIC,
        fmt::format("its ends have turned {:.3g} rad against each other; a rotational stiffness holds up to {:g} rad", angle,
                    kLargestRotation),
        element_);
}

}  // namespace dttmm::plugin
