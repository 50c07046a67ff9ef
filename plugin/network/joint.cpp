// SPDX-License-Identifier: BSD-3-Clause
#include "network/joint.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "core/driven_ends.h"
#include "core/error.h"
#include "core/rotation.h"

namespace dttmm::plugin {

Joint::Joint(const JointSpec& spec, const Assembly& assembly)
    : element_(spec.element), from_(spec.from), to_(spec.to), rigid_(spec.law.rigid), law_(spec.law) {
    for (int half : {0, 1}) {
        springs_.halves[half].stiffness = spec.law.stiffness.segment<3>(3 * half);
        springs_.halves[half].damping = spec.law.damping.segment<3>(3 * half);
    }
    springs_.turns = (spec.law.carried() >> 3).any();
    is_damped_ = !spec.law.damping.isZero(0);
    const Pose& from = assembly.frames[static_cast<size_t>(from_)].pose;
    const Pose& to = assembly.frames[static_cast<size_t>(to_)].pose;
    seat_.from_axes = from.rotation.transpose() * spec.pose.rotation;
    seat_.to_axes = to.rotation.transpose() * spec.pose.rotation;
    springs_.rest = spec.pose.rotation.transpose() * (spec.pose.position - from.position);
    seat_.to_point = to.rotation.transpose() * (spec.pose.position - to.position);
    seat_.is_aligned = from.rotation == spec.pose.rotation;
    seat_.is_straight = to.rotation == spec.pose.rotation;
    seat_.has_lever = spec.pose.position != to.position;
}

void Joint::set_scheme(const Scheme& scheme) {
    // The unknown of the transfer equations is the increment over the open step, or, explicit, the one that ends at t_n.
    const StepCoefficients step =
        scheme.is_implicit() ? StepCoefficients{scheme.weight(0), scheme.rate(0)} : StepCoefficients{1, scheme.rate(1)};
    try {
        // f = [−q; m] of the input end against d = x_O − x_I: −∂q/∂x_O for forces, ∂m/∂θ_O for moments
        const EndForces ends = solve_driven_ends(law_.transfer(step, Vector6::Zero()), law_.elastic());
        for (int i = 0; i < 3; ++i) {
            solved_[0](i) = -ends.S(i, 6 + i);
            solved_[1](i) = ends.S(3 + i, 9 + i);
        }
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element_);
    }
}

// ---- Kinematics ---------------------------------------------------------------------------------------------------------

Vector6 Joint::rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const {
    // r = R_fromᵀ p,  p = p_to − p_from  =>  r' = R_fromᵀ (p' − ω_from × p)
    const Matrix3 R = axes(from);
    Vector6 rate;
    rate << R.transpose() * (to_velocity.linear + to_velocity.angular.cross(lever(to)) - from_velocity.linear -
                             from_velocity.angular.cross(arm(from, to))),
        R.transpose() * (to_velocity.angular - from_velocity.angular);
    return rate;
}

Vector6 Joint::acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
                            const Twist& to_velocity, const Twist& to_acceleration) const {
    // r'' = R_fromᵀ (p'' − α × p − ω × (ω × p) − 2 ω × (p' − ω × p)),   ω and α of the `from` end
    const Vector3 p = arm(from, to), l = lever(to);
    const Vector3 &w = from_velocity.angular, &w_to = to_velocity.angular;
    const Vector3 p_rate = to_velocity.linear + w_to.cross(l) - from_velocity.linear;
    const Vector3 a = to_acceleration.linear + to_acceleration.angular.cross(l) + w_to.cross(w_to.cross(l)) -
                      (from_acceleration.linear + from_acceleration.angular.cross(p) + w.cross(w.cross(p)) +
                       2 * w.cross(p_rate - w.cross(p)));
    const Vector3 alpha = to_acceleration.angular - (from_acceleration.angular + w.cross(w_to));
    const Matrix3 R = axes(from);
    Vector6 acceleration;
    acceleration << R.transpose() * a, R.transpose() * alpha;
    return acceleration;
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

Vector6 Joint::force(FrameView from, FrameView to, const Vector6& rate) const {
    return elastic(translation(from, arm(from, to)), rotation(from, to)) + damping(rate);
}

Matrix3 Joint::turn_stiffness(const Vector3& theta) const {
    const Matrix3 inverse_J = rotation_vector_rate(theta);
    return inverse_J.transpose() * springs_.halves[1].stiffness.asDiagonal() * inverse_J;
}

Matrix6 Joint::gain(const Scheme& scheme, const Vector3& theta) const {
    Matrix6 gain = Matrix6::Zero();
    gain.topLeftCorner<3, 3>() = solved_[0].asDiagonal();
    if (!turns()) return gain;
    const double weight = scheme.elastic_weight(0);
    gain.bottomRightCorner<3, 3>() = weight * turn_stiffness(theta);
    gain.bottomRightCorner<3, 3>().diagonal() += solved_[1] - weight * springs_.halves[1].stiffness;
    return gain;
}

EndBlocks Joint::stiffness(const JointPose& pose, const Matrix6& answer) const {
    const Matrix6 G[2] = {by_from(pose), by_to(pose)};
    EndBlocks K;
    for (int i : {0, 1})
        for (int j : {0, 1}) K.at[i][j].noalias() = G[i].transpose() * answer * G[j];
    return K;
}

EndBlocks Joint::acting_stiffness(const JointPose& pose, const Vector3& force) {
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
    return K;
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

/// The past before the start is the parabola through it, which suits every explicit scheme; for the centred one the elastic
/// force before the start counts as that at the start.
void Joint::start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
                  JointState& state, DamperState* damper) const {
    const double h = scheme.step_size();
    const JointPose now = pose(from, to);
    const Strained strained = strain({from, to}, now);
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
    if (!scheme.is_implicit()) return springs_.recall(scheme, now, state.elastic, state, damper);
    // The rate of the first step is Newmark's from d, d', d'': γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''
    const double gamma = scheme.centred().gamma;
    const Vector6 known = (1 - gamma) * rate + (scheme.centred().beta - 0.5 * gamma) * h * acceleration;
    state.known = {};
    state.known.add(1 - scheme.elastic_weight(0), state.elastic);
    state.known.add(1, now.act(now.axes * springs_.halves[0].damping.cwiseProduct(known.head<3>()),
                               now.axes * springs_.halves[1].damping.cwiseProduct(known.tail<3>())));
}

JointForce Joint::damping_half_way(Ends trial, Ends now, double h, const JointState& state,
                                   const DamperState& damper) const {
    const JointPose at = pose(now);
    const Matrix3 mean = 0.5 / h * (axes(trial.from) + at.axes);
    const Vector3 slide = translation(trial.from, arm(trial.from, trial.to)) - state.d;
    Vector3 moment = Vector3::Zero();
    if (turns())
        moment = mean * springs_.halves[1].damping.cwiseProduct(
                            rotation_vector(attitude(trial.from, trial.to) * damper.attitude.transpose()));
    return at.act(mean * springs_.halves[0].damping.cwiseProduct(slide), moment);
}

[[gnu::flatten]] void Joint::advance(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper,
                                     JointForce* force) const {
    const JointPose at_end = pose(next);
    const Strained end = strain(next, at_end);
    if (force) *force = weigh(scheme, end, at_end, state, damper);
    springs_.advance(
        scheme, end, at_end, [&] { return pose(now); }, state, damper);
}

void Joint::refuse_large_rotation(FrameView from, FrameView to) const {
    if (turns() && !springs_.halves[1].stiffness.isZero(0)) refuse_rotation(rotation(from, to).norm());
}

void Joint::refuse_rotation(double angle) const {
    if (angle <= kLargestRotation || springs_.halves[1].stiffness.isZero(0)) return;
    throw Error(
        DTTMM_ERROR_NUMERIC,
        fmt::format("its ends have turned {:.3g} rad against each other; a rotational stiffness holds up to {:g} rad", angle,
                    kLargestRotation),
        element_);
}

}  // namespace dttmm::plugin
