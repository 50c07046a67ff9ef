// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/rotation.h"
#include "element/joint_law.h"
#include "mechanism/joint_kinematics.h"
#include "mechanism/scheme.h"

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
    Eigen::Matrix<Real, 6, 1> deformation() const { return (Eigen::Matrix<Real, 6, 1>() << d, theta).finished(); }
    Eigen::Matrix<Real, 6, 1> deformation_before() const {
        return (Eigen::Matrix<Real, 6, 1>() << d_before, theta_before).finished();
    }
};
using JointState = JointStateOf<double>;

/// More of it where rates count: at dampers, and everywhere if the scheme has numerical damping.
template <class Real>
struct DamperStateOf {
    static constexpr int kNumbers = 29;
    struct Half {
        Vector3Of<Real> delta[3];  ///< increments of strains or turns over the steps that ended at t_n, t_{n−1}, t_{n−2}
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
    Vector3Of<Real> strains;   ///< of an elastic line; of others d
    Matrix3Of<Real> attitude;  ///< if it carries a moment
    JointForceOf<Real> elastic;
    Eigen::Matrix<Real, 6, 1> deformation() const { return (Eigen::Matrix<Real, 6, 1>() << d, theta).finished(); }
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
    bool turns = true;            ///< it carries a moment
    bool is_line = false;         ///< of four: one is
    LineStrainsOf<Real> line;

    /// Along which it acts: those of an elastic line, of others d.
    Vector3Of<Real> strains(const Vector3Of<Real>& d, const Vector3Of<Real>& theta) const;
    /// Forces along the strains, as forces in the joint's axes and the gradient by θ.
    void spread(const Vector3Of<Real>& d, const Vector3Of<Real>& theta, Vector3Of<Real>& force,
                Vector3Of<Real>& by_theta) const;
    /// What forces along the strains, a gradient by θ and a moment (joint axes) do to the frames.
    Force act(const JointPoseOf<Real>& pose, const Vector3Of<Real>& d, const Vector3Of<Real>& theta, Vector3Of<Real> force,
              Vector3Of<Real> by_theta, Vector3Of<Real> moment) const;

    /// Forces of linear springs along the strains of a deformation x, gradients by θ.
    Eigen::Matrix<Real, 6, 1> along(const Eigen::Matrix<Real, 6, 1>& x) const {
        const Vector3Of<Real> theta = x.template tail<3>();
        Eigen::Matrix<Real, 6, 1> f;
        f << halves[0].stiffness.cwiseProduct(strains(x.template head<3>(), theta)), halves[1].stiffness.cwiseProduct(theta);
        return f;
    }
    /// The force law at one instant, [force; moment] on the `from` end in the joint's axes: of springs with the forces
    /// `along` the strains of x (gradients by θ), and of dampers with the rates [strains; relative turn].
    Eigen::Matrix<Real, 6, 1> force(const Eigen::Matrix<Real, 6, 1>& x, const Eigen::Matrix<Real, 6, 1>& along,
                                    const Eigen::Matrix<Real, 6, 1>& rate) const;

    /// rest: of the joint's point; to_axes: those that are the joint's at rest and go with the `to` frame. The elastic force
    /// is needed by `advance`, and by `weigh` where rates do not count.
    Strained strain(const Vector3Of<Real>& rest, const JointPoseOf<Real>& pose, const Matrix3Of<Real>& to_axes,
                    bool with_elastic = true) const;
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
[[gnu::always_inline]] inline Vector3Of<Real> SpringsOf<Real>::strains(const Vector3Of<Real>& d,
                                                                       const Vector3Of<Real>& theta) const {
    if (!is_line) return d;
    Vector3Of<Real> s = d - line.half * cross<Real>(theta, d);
    s.x() += line.sway_y * d.y() * d.y() + line.sway_z * d.z() * d.z() -
             line.bow * (theta.y() * theta.y() + theta.z() * theta.z()) +
             Real(0.5) * line.half * theta.x() * (theta.y() * d.y() + theta.z() * d.z());
    return s;
}

template <class Real>
[[gnu::always_inline]] inline void SpringsOf<Real>::spread(const Vector3Of<Real>& d, const Vector3Of<Real>& theta,
                                                           Vector3Of<Real>& force, Vector3Of<Real>& by_theta) const {
    if (!is_line) return;
    const Vector3Of<Real> f = force, half_f = line.half * f;
    const Real twice = 2 * f.x();
    force += cross<Real>(theta, half_f);
    by_theta -= cross<Real>(d, half_f);
    force.y() += twice * line.sway_y * d.y();
    force.z() += twice * line.sway_z * d.z();
    by_theta.y() -= twice * line.bow * theta.y();
    by_theta.z() -= twice * line.bow * theta.z();
    const Real twisted = Real(0.5) * half_f.x();
    force.y() += twisted * theta.x() * theta.y();
    force.z() += twisted * theta.x() * theta.z();
    by_theta += twisted * Vector3Of<Real>(theta.y() * d.y() + theta.z() * d.z(), theta.x() * d.y(), theta.x() * d.z());
}

template <class Real>
[[gnu::always_inline]] inline JointForceOf<Real> SpringsOf<Real>::act(const JointPoseOf<Real>& pose,
                                                                      const Vector3Of<Real>& d, const Vector3Of<Real>& theta,
                                                                      Vector3Of<Real> force, Vector3Of<Real> by_theta,
                                                                      Vector3Of<Real> moment) const {
    spread(d, theta, force, by_theta);
    // Of a gradient m = J⁻ᵀ(θ) ∂U/∂θ, for δθ = J⁻¹ ε
    if (turns) moment = (pose.axes * (moment + moment_of_gradient<Real>(theta, by_theta))).eval();
    return pose.act(pose.axes * force, moment);
}

template <class Real>
[[gnu::always_inline]] inline Eigen::Matrix<Real, 6, 1> SpringsOf<Real>::force(const Eigen::Matrix<Real, 6, 1>& x,
                                                                               const Eigen::Matrix<Real, 6, 1>& along,
                                                                               const Eigen::Matrix<Real, 6, 1>& rate) const {
    const Vector3Of<Real> theta = x.template tail<3>();
    Vector3Of<Real> force = along.template head<3>() + halves[0].damping.cwiseProduct(rate.template head<3>()),
                    by_theta = along.template tail<3>(), moment = Vector3Of<Real>::Zero();
    spread(x.template head<3>(), theta, force, by_theta);
    if (turns) moment = moment_of_gradient<Real>(theta, by_theta) + halves[1].damping.cwiseProduct(rate.template tail<3>());
    Eigen::Matrix<Real, 6, 1> f;
    f << force, moment;
    return f;
}

template <class Real>
[[gnu::always_inline]] inline StrainedOf<Real> SpringsOf<Real>::strain(const Vector3Of<Real>& rest,
                                                                       const JointPoseOf<Real>& pose,
                                                                       const Matrix3Of<Real>& to_axes,
                                                                       bool with_elastic) const {
    Strained strained;
    strained.d = pose.axes.transpose() * pose.arm - rest;
    strained.theta.setZero();
    if (turns) {
        strained.attitude.noalias() = pose.axes.transpose() * to_axes;
        strained.theta = rotation_vector<Real>(strained.attitude);
    }
    strained.strains = strains(strained.d, strained.theta);
    if (with_elastic)
        strained.elastic = act(pose, strained.d, strained.theta, halves[0].stiffness.cwiseProduct(strained.strains),
                               halves[1].stiffness.cwiseProduct(strained.theta), Vector3Of<Real>::Zero());
    return strained;
}

template <class Real>
[[gnu::always_inline]] inline JointForceOf<Real> SpringsOf<Real>::weigh(const Scheme& scheme, const Strained& end,
                                                                        const JointPoseOf<Real>& at_end, const State& state,
                                                                        const Damper* damper) const {
    Force force = state.known;
    if (!scheme.is_implicit()) return force;
    const Real weight = scheme.elastic_weight(0);
    if (!damper) {
        force.add(weight, end.elastic);
        return force;
    }
    const Real rate = scheme.rate(0), lag = scheme.lag();
    const auto along = [&](const JointHalfOf<Real>& half, const Vector3Of<Real>& delta) {
        return Vector3Of<Real>((rate * half.damping + lag * half.stiffness).cwiseProduct(delta));
    };
    Vector3Of<Real> moment = Vector3Of<Real>::Zero();
    if (turns) moment = along(halves[1], rotation_vector<Real>(end.attitude * damper->attitude.transpose()));
    force.add(1, act(at_end, end.d, end.theta,
                     weight * halves[0].stiffness.cwiseProduct(end.strains) +
                         along(halves[0], end.strains - strains(state.d, state.theta)),
                     weight * halves[1].stiffness.cwiseProduct(end.theta), moment));
    return force;
}

template <class Real>
[[gnu::always_inline]] inline void SpringsOf<Real>::recall(const Scheme& scheme, const JointPoseOf<Real>& at,
                                                           const Force& before, State& state, const Damper* damper) const {
    state.known = {};
    state.known.add(scheme.elastic_weight(1), state.elastic);
    state.known.add(scheme.elastic_weight(2), before);
    if (!damper) return;
    const auto along = [&](int i) {
        const JointHalfOf<Real>& half = halves[i];
        const typename Damper::Half& s = damper->halves[i];
        const Real r1 = scheme.rate(1), r2 = scheme.rate(2), r3 = scheme.rate(3), lag = scheme.lag();
        return Vector3Of<Real>(half.damping.cwiseProduct(r1 * s.delta[0] + r2 * s.delta[1] + r3 * s.delta[2]) +
                               lag * half.stiffness.cwiseProduct(s.delta[0]));
    };
    Vector3Of<Real> moment = Vector3Of<Real>::Zero();
    if (turns) moment = along(1);
    const Vector3Of<Real>&d = scheme.is_implicit() ? state.d_before : state.d,
          &theta = scheme.is_implicit() ? state.theta_before : state.theta;
    state.known.add(1, act(at, d, theta, along(0), Vector3Of<Real>::Zero(), moment));
}

template <class Real>
[[gnu::always_inline]] inline void SpringsOf<Real>::advance(const Scheme& scheme, const Strained& end,
                                                            const JointPoseOf<Real>& next, const auto& pose_now,
                                                            State& state, Damper* damper) const {
    if (damper) {
        const Vector3Of<Real> slide = end.strains - strains(state.d, state.theta);
        Vector3Of<Real> turn = Vector3Of<Real>::Zero();
        if (turns) {
            turn = rotation_vector<Real>(end.attitude * damper->attitude.transpose());
            damper->attitude = end.attitude;
        }
        damper->dissipated += damper->last_loss;
        damper->last_loss = 0;
        for (int i = 0; i < (turns ? 2 : 1); ++i) {
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
