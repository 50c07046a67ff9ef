// SPDX-License-Identifier: BSD-3-Clause
#include "network/joint.h"

#include <fmt/format.h>

#include "core/driven_ends.h"
#include "core/error.h"
#include "core/rotation.h"

namespace dttmm {

Joint::Joint(const JointSpec& spec, const Assembly& assembly)
    : element_(spec.element), from_(spec.from), to_(spec.to), rigid_(spec.law.rigid), law_(spec.law) {
    for (int half : {0, 1}) {
        halves_[half].stiffness = spec.law.stiffness.segment<3>(3 * half);
        halves_[half].damping = spec.law.damping.segment<3>(3 * half);
    }
    turns_ = (spec.law.carried() >> 3).any();
    is_damped_ = !spec.law.damping.isZero(0);
    const Pose& from = assembly.frames[static_cast<size_t>(from_)].pose;
    const Pose& to = assembly.frames[static_cast<size_t>(to_)].pose;
    from_axes_ = from.rotation.transpose() * spec.pose.rotation;
    to_axes_ = to.rotation.transpose() * spec.pose.rotation;
    rest_ = spec.pose.rotation.transpose() * (spec.pose.position - from.position);
    to_point_ = to.rotation.transpose() * (spec.pose.position - to.position);
    is_aligned_ = from.rotation == spec.pose.rotation;
    is_straight_ = is_aligned_ && to.rotation == spec.pose.rotation;
    has_lever_ = spec.pose.position != to.position;
}

void Joint::set_scheme(const Scheme& scheme) {
    // The unknown of the transfer equations is the increment over the open step, or, explicit, the one that ends at t_n.
    const StepCoefficients step =
        scheme.is_implicit() ? StepCoefficients{scheme.weight(0), scheme.rate(0)} : StepCoefficients{1, scheme.rate(1)};
    try {
        // f = [−q; m] of the input end against d = x_O − x_I: −∂q/∂x_O for forces, ∂m/∂θ_O for moments
        const EndForces ends = solve_driven_ends(law_.transfer(step, Vector6::Zero()), law_.elastic());
        for (int i = 0; i < 3; ++i) {
            halves_[0].law(i) = -ends.S(i, 6 + i);
            halves_[1].law(i) = ends.S(3 + i, 9 + i);
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
    if (has_lever_) G.topRightCorner<3, 3>() = -pose.axes.transpose() * skew(pose.lever);
    return G;
}

// ---- The force law ------------------------------------------------------------------------------------------------------

Vector6 Joint::force(FrameView from, FrameView to, const Vector6& rate) const {
    const Vector3 theta = rotation(from, to);
    Vector6 f;
    f << halves_[0].stiffness.cwiseProduct(translation(from, arm(from, to))) +
             halves_[0].damping.cwiseProduct(rate.head<3>()),
        moment_of_gradient(theta, halves_[1].stiffness.cwiseProduct(theta)) +
            halves_[1].damping.cwiseProduct(rate.tail<3>());
    return f;
}

Matrix3 Joint::turn_stiffness(const Vector3& theta) const {
    const Matrix3 inverse_J = rotation_vector_rate(theta);
    return inverse_J.transpose() * halves_[1].stiffness.asDiagonal() * inverse_J;
}

Matrix6 Joint::gain(const Scheme& scheme, const Vector3& theta) const {
    Matrix6 gain = Matrix6::Zero();
    gain.topLeftCorner<3, 3>() = halves_[0].law.asDiagonal();
    if (!turns_) return gain;
    const double weight = scheme.elastic_weight(0);
    gain.bottomRightCorner<3, 3>() = weight * turn_stiffness(theta);
    gain.bottomRightCorner<3, 3>().diagonal() += halves_[1].law - weight * halves_[1].stiffness;
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

/// What of the force over the coming step is known before its end is: for an explicit scheme all of it. before: the elastic
/// force at t_{n−1}.
void Joint::recall(const Scheme& scheme, const JointPose& now, const JointForce& before, JointState& state,
                   const TurnState* turn) const {
    state.known = {};
    state.known.add(scheme.elastic_weight(1), state.elastic);
    state.known.add(scheme.elastic_weight(2), before);
    if (!is_damped_ && scheme.lag() == 0) return;
    const auto damper = [&](const JointHalf& half, const HalfState& s) {
        return Vector3(now.axes * (half.damping.cwiseProduct(scheme.rate(1) * s.delta[0] + scheme.rate(2) * s.delta[1] +
                                                             scheme.rate(3) * s.delta[2]) +
                                   scheme.lag() * half.stiffness.cwiseProduct(s.delta[0])));
    };
    state.known.add(1, now.act(damper(halves_[0], state.translation),
                               turn ? damper(halves_[1], turn->rotation) : Vector3(Vector3::Zero())));
}

void Joint::start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
                  JointState& state, TurnState* turn) const {
    const JointPose now = pose(from, to);
    const Strained strained = strain({from, to}, now);
    state.dissipated = 0;
    state.power = 0;
    state.elastic = strained.elastic;
    start_half(scheme, strained.d, rate.head<3>(), acceleration.head<3>(), state.translation);
    if (turn) {
        turn->attitude = strained.attitude;
        start_half(scheme, strained.theta, rate.tail<3>(), acceleration.tail<3>(), turn->rotation);
    }
    if (!scheme.is_implicit()) return recall(scheme, now, state.elastic, state, turn);
    // The rate of the first step is Newmark's from d, d', d'': γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''
    const double gamma = scheme.centred().gamma;
    const Vector6 known = (1 - gamma) * rate + (scheme.centred().beta - 0.5 * gamma) * scheme.step_size() * acceleration;
    state.known = {};
    state.known.add(1 - scheme.elastic_weight(0), state.elastic);
    state.known.add(1, now.act(now.axes * halves_[0].damping.cwiseProduct(known.head<3>()),
                               now.axes * halves_[1].damping.cwiseProduct(known.tail<3>())));
}

/// The past before the start is the parabola through it, which suits every explicit scheme; for the centred one the elastic
/// force before the start counts as that at the start.
void Joint::start_half(const Scheme& scheme, const Vector3& d, const Vector3& rate, const Vector3& acceleration,
                       HalfState& state) const {
    const double h = scheme.step_size();
    state.d = d;
    state.rate = rate;
    for (int back = 0; back < 3; ++back) state.delta[back] = h * rate - (back + 0.5) * h * h * acceleration;
    state.d_before = d - state.delta[0];
}

JointForce Joint::damping_half_way(Ends trial, Ends now, double h, const JointState& state, const TurnState* turn) const {
    const JointPose at = pose(now);
    const Matrix3 mean = 0.5 / h * (axes(trial.from) + at.axes);
    const Vector3 slide = translation(trial.from, arm(trial.from, trial.to)) - state.translation.d;
    Vector3 moment = Vector3::Zero();
    if (turn)
        moment = mean * halves_[1].damping.cwiseProduct(
                            rotation_vector(attitude(trial.from, trial.to) * turn->attitude.transpose()));
    return at.act(mean * halves_[0].damping.cwiseProduct(slide), moment);
}

/// Moves one half of a joint on by the increment `delta` to `d`; returns the power of its damper at the start of the step.
double Joint::advance_half(const Scheme& scheme, uint64_t steps, const JointHalf& half, const Vector3& d,
                           const Vector3& delta, HalfState& state) const {
    state.delta[2] = state.delta[1];
    state.delta[1] = state.delta[0];
    state.delta[0] = delta;
    state.d_before = state.d;
    state.d = d;
    if (steps > 0) state.rate = 0.5 / scheme.step_size() * (state.delta[0] + state.delta[1]);
    return state.rate.dot(half.damping.cwiseProduct(state.rate));
}

void Joint::advance(const Scheme& scheme, uint64_t steps, Ends next, Ends now, JointState& state, TurnState* turn,
                    JointForce* force) const {
    const JointPose at_end = pose(next);
    const Strained end = strain(next, at_end);
    if (force) *force = weigh(scheme, end, now, state, turn);
    const JointForce before = state.elastic;
    state.elastic = end.elastic;
    double power = advance_half(scheme, steps, halves_[0], end.d, end.d - state.translation.d, state.translation);
    if (turn) {
        const Vector3 delta =
            is_damped_ ? rotation_vector(end.attitude * turn->attitude.transpose()) : Vector3(end.theta - turn->rotation.d);
        power += advance_half(scheme, steps, halves_[1], end.theta, delta, turn->rotation);
        turn->attitude = end.attitude;
    }
    recall(scheme, at_end, before, state, turn);
    if (steps > 0) state.dissipated += 0.5 * scheme.step_size() * (state.power + power);
    state.power = power;
}

void Joint::refuse_large_rotation(FrameView from, FrameView to) const {
    if (turns_ && !halves_[1].stiffness.isZero(0)) refuse_rotation(rotation(from, to).norm());
}

void Joint::refuse_rotation(double angle) const {
    if (angle <= kLargestRotation || halves_[1].stiffness.isZero(0)) return;
    throw Error(
        DTTMM_ERROR_NUMERIC,
        fmt::format("its ends have turned {:.3g} rad against each other; a rotational stiffness holds up to {:g} rad", angle,
                    kLargestRotation),
        element_);
}

}  // namespace dttmm
