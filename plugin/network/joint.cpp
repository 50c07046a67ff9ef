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
        scheme.is_implicit() ? StepCoefficients{scheme.elastic[0], scheme.rate[0]} : StepCoefficients{1, scheme.rate[1]};
    elastic_weight_ = scheme.elastic[0];
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

Matrix6 Joint::by_from(FrameView from, FrameView to) const {
    const Matrix3 to_joint = axes(from).transpose();
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = -to_joint;
    G.topRightCorner<3, 3>() = to_joint * skew(arm(from, to));
    return G;
}

Matrix6 Joint::by_to(FrameView from, FrameView to) const {
    const Matrix3 to_joint = axes(from).transpose();
    Matrix6 G = Matrix6::Zero();
    G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = to_joint;
    if (has_lever_) G.topRightCorner<3, 3>() = -to_joint * skew(lever(to));
    return G;
}

// ---- The force law ------------------------------------------------------------------------------------------------------

Vector6 Joint::force(FrameView from, FrameView to, const Vector6& rate) const {
    // m = J⁻ᵀ(θ) (k ∘ θ) + c ∘ ω: the gradient of ½ θᵀ k θ, for δθ = J⁻¹ ε
    const Vector3 theta = turns_ ? rotation_vector(attitude(from, to)) : Vector3(Vector3::Zero());
    Vector6 f;
    f << halves_[0].stiffness.cwiseProduct(translation(from, arm(from, to))) +
             halves_[0].damping.cwiseProduct(rate.head<3>()),
        rotation_vector_rate(theta).transpose() * halves_[1].stiffness.cwiseProduct(theta) +
            halves_[1].damping.cwiseProduct(rate.tail<3>());
    return f;
}

Matrix3 Joint::turn_stiffness(FrameView from, FrameView to) const {
    const Matrix3 inverse_J = rotation_vector_rate(turns_ ? rotation_vector(attitude(from, to)) : Vector3(Vector3::Zero()));
    return inverse_J.transpose() * halves_[1].stiffness.asDiagonal() * inverse_J;
}

/// What of the force over the coming step is known before its end is: for an explicit scheme all of it.
void Joint::recall(const Scheme& scheme, const JointHalf& half, HalfState& state) const {
    if (scheme.is_implicit()) {
        state.known = half.stiffness.cwiseProduct(state.d + scheme.elastic[1] * state.delta[0]) +
                      half.damping.cwiseProduct(scheme.rate[1] * state.delta[0]);
    } else {
        // k d + c Σ rate δ = k̂ δ + k (d − δ) + c (…),   k̂ = k + c rate[1]
        state.known = half.law.cwiseProduct(state.delta[0]) + half.stiffness.cwiseProduct(state.d - state.delta[0]) +
                      half.damping.cwiseProduct(scheme.rate[2] * state.delta[1] + scheme.rate[3] * state.delta[2]);
    }
}

/// What a finite rotation adds to the linear law: k ∘ θ becomes J⁻ᵀ (k ∘ θ).
void Joint::settle_turn(const Scheme& scheme, TurnState& state) const {
    const JointHalf& half = halves_[1];
    state.conjugate = rotation_vector_rate(state.rotation.d).transpose();
    const Vector3 elastic = half.stiffness.cwiseProduct(state.rotation.d + scheme.elastic[1] * state.rotation.delta[0]);
    state.rotation.known += state.conjugate * elastic - elastic;
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

void Joint::start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
                  JointState& state, TurnState* turn) const {
    state.dissipated = 0;
    state.power = 0;
    start_half(scheme, halves_[0], translation(from, arm(from, to)), rate.head<3>(), acceleration.head<3>(),
               state.translation);
    if (!turns_) return;
    turn->attitude = attitude(from, to);
    start_half(scheme, halves_[1], rotation_vector(turn->attitude), rate.tail<3>(), acceleration.tail<3>(), turn->rotation);
    settle_turn(scheme, *turn);
}

/// The past before the start is the parabola through it, which suits every explicit scheme. The first step of the centred
/// scheme is Newmark's from d, d', d'': the elastic force before the start counts as that at the start, and the rate is
/// γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''.
void Joint::start_half(const Scheme& scheme, const JointHalf& half, const Vector3& d, const Vector3& rate,
                       const Vector3& acceleration, HalfState& state) const {
    const double h = scheme.step_size(), beta = scheme.centred().beta, gamma = scheme.centred().gamma;
    state.d = d;
    state.rate = rate;
    for (int back = 0; back < 3; ++back) state.delta[back] = h * rate - (back + 0.5) * h * h * acceleration;
    state.d_before = d - state.delta[0];
    if (scheme.is_implicit())
        state.known = half.stiffness.cwiseProduct(d) +
                      half.damping.cwiseProduct((1 - gamma) * rate + (beta - 0.5 * gamma) * h * acceleration);
    else
        recall(scheme, half, state);
}

Vector3 Joint::trial_turn(FrameView from, FrameView to, const TurnState& turn) const {
    return rotation_vector(attitude(from, to) * turn.attitude.transpose());
}

/// Moves one half of a joint on by the increment `delta` to `d`; returns the power of its damper at the start of the step.
double Joint::advance_half(const Scheme& scheme, uint64_t steps, const JointHalf& half, const Vector3& d,
                           const Vector3& delta, HalfState& state) const {
    state.delta[2] = state.delta[1];
    state.delta[1] = state.delta[0];
    state.delta[0] = delta;
    state.d_before = state.d;
    state.d = d;
    recall(scheme, half, state);
    if (steps > 0) state.rate = 0.5 / scheme.step_size() * (state.delta[0] + state.delta[1]);
    return state.rate.dot(half.damping.cwiseProduct(state.rate));
}

void Joint::advance(const Scheme& scheme, uint64_t steps, FrameView from, FrameView to, JointState& state,
                    TurnState* turn) const {
    const Vector3 d = translation(from, arm(from, to));
    double power = advance_half(scheme, steps, halves_[0], d, d - state.translation.d, state.translation);
    if (turns_) {
        const Matrix3 next = attitude(from, to);
        power += advance_half(scheme, steps, halves_[1], rotation_vector(next),
                              rotation_vector(next * turn->attitude.transpose()), turn->rotation);
        turn->attitude = next;
        settle_turn(scheme, *turn);
    }
    if (steps > 0) state.dissipated += 0.5 * scheme.step_size() * (state.power + power);
    state.power = power;
}

void Joint::refuse_large_rotation(FrameView from, FrameView to) const {
    if (turns_ && !halves_[1].stiffness.isZero(0)) refuse_rotation(rotation_vector(attitude(from, to)).norm());
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
