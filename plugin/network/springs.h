// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/rotation.h"
#include "network/joint_kinematics.h"
#include "network/scheme.h"

namespace dttmm::plugin {

// The force law of a joint. Real: double for one, Lanes for four at once.

/// Three translations or three rotations of a joint, its axes: the same formulas hold for both.
template <class Real>
struct JointHalfOf {
    Vector3Of<Real> stiffness;  ///< [N/m, N m/rad]
    Vector3Of<Real> damping;    ///< [N s/m, N m s/rad]
};
using JointHalf = JointHalfOf<double>;

/// What changes from step to step, in the joint's axes: deformations [m] and rotation vectors [rad], d and θ; plain numbers,
/// so that saving is copying.
template <class Real>
struct JointStateOf {
    static constexpr int kNumbers = 30;
    Vector3Of<Real> d, theta;                ///< at t_n; θ zero where the joint carries no moment
    Vector3Of<Real> d_before, theta_before;  ///< at t_{n−1}
    JointForceOf<Real> elastic;              ///< at t_n
    JointForceOf<Real> known;                ///< what of the force over the open step does not depend on its end
};
using JointState = JointStateOf<double>;

/// More of it where rates count: at dampers, and everywhere if the scheme has numerical damping.
template <class Real>
struct DamperStateOf {
    static constexpr int kNumbers = 29;
    struct Half {
        Vector3Of<Real> delta[3];  ///< increments of the deformation over the steps that ended at t_n, t_{n−1}, t_{n−2}
    };
    Half halves[2];
    Matrix3Of<Real> attitude;  ///< of the `to` end relative to the `from` end at t_n, joint axes; if it carries a moment
    Real dissipated;           ///< energy lost to damping up to t_{n−1} [J]
    Real last_loss;            ///< lost over the step from there to t_n [J]
};
using DamperState = DamperStateOf<double>;

/// A joint at an instant: its deformation and the elastic force that stems from it.
template <class Real>
struct StrainedOf {
    Vector3Of<Real> d, theta;
    Matrix3Of<Real> attitude;  ///< if it carries a moment
    JointForceOf<Real> elastic;
};

/// Springs and dampers of a joint at work. A rotational stiffness has the moment that is the gradient of ½ θᵀ k θ, so that
/// it conserves energy.
///
/// Over a step of the centred scheme the elastic forces at t_{n+1}, t_n and t_{n−1} are weighted, each with the axes and
/// lever arms of its own instant: Newmark's rule for the whole wrench, so that a lasting force turns with the parts
/// implicitly too. Dampers and numerical damping act by the increments of the deformation over the two steps around t_n, the
/// later with the axes and lever arms of t_{n+1}, the earlier with those of t_{n−1}: second order like those of t_n for
/// both, and the derivative by the end of the step is symmetric, as Newton's matrix is. (With those of t_n it is not: where
/// a damper is stiffer than what it is in series with, by more than the turn per step makes up for, passes then diverge.)
/// Increments of rotations are the rotation vectors that lead from one instant to the next.
template <class Real>
struct SpringsOf {
    using Force = JointForceOf<Real>;
    using Strained = StrainedOf<Real>;
    using State = JointStateOf<Real>;
    using Damper = DamperStateOf<Real>;

    JointHalfOf<Real> halves[2];  ///< translations, rotations
    Vector3Of<Real> rest;         ///< the point of the `to` end from the `from` origin at rest, joint axes
    bool turns = true;            ///< it carries a moment

    /// to_axes: those that are the joint's at rest and go with the `to` frame.
    Strained strain(const JointPoseOf<Real>& pose, const Matrix3Of<Real>& to_axes) const;
    /// The force over the open step at a trial end of it, when the joint is at `at_end`; damper: NULL where rates do not
    /// count.
    Force weigh(const Scheme& scheme, const Strained& end, const JointPoseOf<Real>& at_end, const State& state,
                const Damper* damper) const;
    /// Moves the memory on to the accepted end of the step, when the joint is at `next`. pose_now(): the joint at t_n, asked
    /// for only where rates count.
    void advance(const Scheme& scheme, const Strained& end, const JointPoseOf<Real>& next, const auto& pose_now,
                 State& state, Damper* damper) const;
    /// What of the force over the coming step is known before its end is: for an explicit scheme all of it. before: the
    /// elastic force at t_{n−1}; at: the joint when the forces of rates act, t_{n−1}, or t_n of an explicit scheme.
    void recall(const Scheme& scheme, const JointPoseOf<Real>& at, const Force& before, State& state,
                const Damper* damper) const;
};

// ---- What every step does for every joint -------------------------------------------------------------------------------

template <class Real>
[[gnu::always_inline]] inline StrainedOf<Real> SpringsOf<Real>::strain(const JointPoseOf<Real>& pose,
                                                                       const Matrix3Of<Real>& to_axes) const {
    Strained strained;
    strained.d = pose.axes.transpose() * pose.arm - rest;
    strained.theta.setZero();
    Vector3Of<Real> moment = Vector3Of<Real>::Zero();
    if (turns) {
        strained.attitude.noalias() = pose.axes.transpose() * to_axes;
        strained.theta = rotation_vector<Real>(strained.attitude);
        // m = J⁻ᵀ(θ) (k ∘ θ): the gradient of ½ θᵀ k θ, for δθ = J⁻¹ ε
        moment.noalias() =
            pose.axes * moment_of_gradient<Real>(strained.theta, halves[1].stiffness.cwiseProduct(strained.theta));
    }
    strained.elastic = pose.act(pose.axes * halves[0].stiffness.cwiseProduct(strained.d), moment);
    return strained;
}

template <class Real>
[[gnu::always_inline]] inline JointForceOf<Real> SpringsOf<Real>::weigh(const Scheme& scheme, const Strained& end,
                                                                        const JointPoseOf<Real>& at_end, const State& state,
                                                                        const Damper* damper) const {
    Force force = state.known;
    if (!scheme.is_implicit()) return force;
    force.add(scheme.elastic_weight(0), end.elastic);
    if (!damper) return force;
    const auto act = [&](const JointHalfOf<Real>& half, const Vector3Of<Real>& delta) {
        const Real rate = scheme.rate(0), lag = scheme.lag();
        return Vector3Of<Real>(at_end.axes * (rate * half.damping + lag * half.stiffness).cwiseProduct(delta));
    };
    const Vector3Of<Real> slide = act(halves[0], end.d - state.d);
    Vector3Of<Real> moment = Vector3Of<Real>::Zero();
    if (turns) moment = act(halves[1], rotation_vector<Real>(end.attitude * damper->attitude.transpose()));
    force.add(1, at_end.act(slide, moment));
    return force;
}

template <class Real>
[[gnu::always_inline]] inline void SpringsOf<Real>::recall(const Scheme& scheme, const JointPoseOf<Real>& at,
                                                           const Force& before, State& state, const Damper* damper) const {
    state.known = {};
    state.known.add(scheme.elastic_weight(1), state.elastic);
    state.known.add(scheme.elastic_weight(2), before);
    if (!damper) return;
    const auto act = [&](int i) {
        const JointHalfOf<Real>& half = halves[i];
        const typename Damper::Half& s = damper->halves[i];
        const Real r1 = scheme.rate(1), r2 = scheme.rate(2), r3 = scheme.rate(3), lag = scheme.lag();
        return Vector3Of<Real>(at.axes * (half.damping.cwiseProduct(r1 * s.delta[0] + r2 * s.delta[1] + r3 * s.delta[2]) +
                                          lag * half.stiffness.cwiseProduct(s.delta[0])));
    };
    Vector3Of<Real> moment = Vector3Of<Real>::Zero();
    if (turns) moment = act(1);
    state.known.add(1, at.act(act(0), moment));
}

template <class Real>
[[gnu::always_inline]] inline void SpringsOf<Real>::advance(const Scheme& scheme, const Strained& end,
                                                            const JointPoseOf<Real>& next, const auto& pose_now,
                                                            State& state, Damper* damper) const {
    if (damper) {
        const Vector3Of<Real> slide = end.d - state.d;
        Vector3Of<Real> turn = Vector3Of<Real>::Zero();
        if (turns) {
            turn = rotation_vector<Real>(end.attitude * damper->attitude.transpose());
            damper->attitude = end.attitude;
        }
        damper->dissipated += damper->last_loss;
        damper->last_loss = 0;
        for (int i : {0, 1}) {
            typename Damper::Half& half = damper->halves[i];
            half.delta[2] = half.delta[1];
            half.delta[1] = half.delta[0];
            half.delta[0] = i == 0 ? slide : turn;
            // The mean force c δ/h times the displacement δ: exact for Newmark's rule
            damper->last_loss +=
                Real(1 / scheme.step_size()) * half.delta[0].dot(halves[i].damping.cwiseProduct(half.delta[0]));
        }
    }
    const Force before = state.elastic;
    state.elastic = end.elastic;
    state.d_before = state.d;
    state.d = end.d;
    state.theta_before = state.theta;
    state.theta = end.theta;
    recall(scheme, damper && scheme.is_implicit() ? pose_now() : next, before, state, damper);
}

}  // namespace dttmm::plugin
