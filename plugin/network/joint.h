// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "dttmm_plugin.h"
#include "network/assembly.h"
#include "network/scheme.h"

namespace dttmm {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// A frame in the world as plain numbers: origin [m] and axes, row-major as in dttmm_motion.
struct Frame {
    double position[3];
    double rotation[9];
};
/// The same somewhere else in memory.
struct FrameView {
    FrameView(const Frame& frame) : position(frame.position), rotation(frame.rotation) {}
    FrameView(const dttmm_motion& motion) : position(motion.position), rotation(motion.rotation) {}
    const double* position;
    const double* rotation;
    Eigen::Map<const Vector3> origin() const { return Eigen::Map<const Vector3>(position); }
    Eigen::Map<const RowMajor3> axes() const { return Eigen::Map<const RowMajor3>(rotation); }
};

/// Velocities [m/s, rad/s] or accelerations of a frame, world axes.
struct Twist {
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
};

/// Three translations or three rotations of a joint: the same formulas hold for both.
struct JointHalf {
    Vector3 stiffness, damping;
    Vector3 law = Vector3::Zero();  ///< k̂ = ∂f/∂d of the solved transfer equations [N/m, N m/rad]
};

/// What changes from step to step; plain numbers, so that saving is copying.
struct HalfState {
    Vector3 d, d_before;  ///< deformation at t_n and t_{n−1}
    Vector3 delta[3];     ///< its increments over the steps that ended at t_n, t_{n−1}, t_{n−2}
    Vector3 rate;         ///< of the deformation at t_{n−1}: centred, at the start the initial one
    Vector3 known;        ///< part of the force over the open step that does not depend on its end
};
struct JointState {
    HalfState translation;
    double dissipated;  ///< energy lost to damping up to t_{n−1} [J]
    double power;       ///< at t_{n−1} [W]
};
struct TurnState {
    HalfState rotation;
    Matrix3 attitude;   ///< of the `to` end relative to the `from` end at t_n, in the joint's axes; identity at rest
    Matrix3 conjugate;  ///< J⁻ᵀ(θ) at t_n: makes of k ∘ θ the moment that does its work
};

/// A massless joint at work between two frames: its rest configuration, its law solved for the step size, its kinematics. It
/// measures its deformation in its axes, which go with the `from` frame; the wrenches on its two ends balance exactly, lever
/// arms included. A rotational stiffness holds for relative rotations θ up to kLargestRotation; its moment is the gradient
/// of ½ θᵀ k θ, so that it conserves energy. A rotational damper may turn for ever.
///
/// Motion over a step enters as increments δ of the deformation from t_n, rotations as the rotation vector that leads from
/// t_n to t_{n+1}. The memory is the caller's: a JointState and, if turns(), a TurnState.
class Joint {
public:
    static constexpr double kLargestRotation = 2.5;  ///< rad

    Joint(const JointSpec& spec, const Assembly& assembly);

    int element() const { return element_; }
    int from() const { return from_; }
    int to() const { return to_; }
    /// Whether it carries a moment: otherwise rotations are not worked out.
    bool turns() const { return turns_; }
    Directions rigid() const { return rigid_; }
    const JointHalf& translation_half() const { return halves_[0]; }
    const JointHalf& rotation_half() const { return halves_[1]; }
    bool is_damped() const { return !halves_[0].damping.isZero(0) || !halves_[1].damping.isZero(0); }

    /// Solves the transfer equations for the law at the scheme's step size. Throws Error naming the element.
    void set_scheme(const Scheme& scheme);

    /// Kinematics at given frames: from the `from` origin to the point of the `to` end, world axes; from the `to` origin to
    /// that point; the joint's axes; its deformation; its attitude.
    Vector3 arm(FrameView from, FrameView to) const;
    Vector3 lever(FrameView to) const { return has_lever_ ? Vector3(to.axes() * to_point_) : Vector3(Vector3::Zero()); }
    Matrix3 axes(FrameView from) const { return is_aligned_ ? Matrix3(from.axes()) : Matrix3(from.axes() * from_axes_); }
    Vector3 translation(FrameView from, const Vector3& arm) const;
    Matrix3 attitude(FrameView from, FrameView to) const;
    /// Rates and second rates of the deformation, [d; θ].
    Vector6 rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const;
    Vector6 acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
                         const Twist& to_velocity, const Twist& to_acceleration) const;

    /// Columns of [d; θ], joint axes, by the pose of the `from` or the `to` frame, world axes; for small relative rotations.
    Matrix6 by_from(FrameView from, FrameView to) const;
    Matrix6 by_to(FrameView from, FrameView to) const;

    /// The wrench of the force F and the moment M (world axes) on the `to` and the `from` frame, at their origins.
    void add_wrench(const Vector3& arm, const Vector3& lever, const Vector3& F, const Vector3& M, double* on_from,
                    double* on_to) const;

    /// The force law at one instant: f [force; moment] in the joint's axes.
    Vector6 force(FrameView from, FrameView to, const Vector6& rate) const;
    /// −∂f/∂(deformation) there: translations diagonal, rotations a 3×3 in terms of the relative turn ε.
    Matrix3 turn_stiffness(FrameView from, FrameView to) const;

    void start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
               JointState& state, TurnState* turn) const;
    /// The force over the open step at a trial end of it; its rigid directions not counted.
    Vector3 trial_force(FrameView from, const Vector3& arm, const JointState& state) const {
        return state.translation.known + halves_[0].law.cwiseProduct(translation(from, arm) - state.translation.d);
    }
    Vector3 trial_moment(const Vector3& delta, const TurnState& turn) const {
        return turn.rotation.known + moment_change(delta, turn);
    }
    /// Of the moment when δ₊ grows by `delta`.
    Vector3 moment_change(const Vector3& delta, const TurnState& turn) const {
        const Vector3 elastic = elastic_weight_ * halves_[1].stiffness.cwiseProduct(delta);
        return halves_[1].law.cwiseProduct(delta) + turn.conjugate * elastic - elastic;
    }
    Vector3 trial_turn(FrameView from, FrameView to, const TurnState& turn) const;
    /// ∂(moment)/∂δ₊ of the open step.
    Matrix3 turn_gain(const TurnState& state) const;
    /// Moves the memory on to the accepted end of the step. steps: committed before it since the start.
    void advance(const Scheme& scheme, uint64_t steps, FrameView from, FrameView to, JointState& state,
                 TurnState* turn) const;

    /// Throws Error(DTTMM_ERROR_NUMERIC) when a rotational stiffness has turned too far.
    void refuse_large_rotation(FrameView from, FrameView to) const;
    void refuse_large_rotation(const TurnState& turn) const {
        if (!(turn.rotation.d.squaredNorm() <= kLargestRotation * kLargestRotation)) [[unlikely]]
            refuse_rotation(turn.rotation.d.norm());
    }

private:
    void refuse_rotation(double angle) const;
    void recall(const Scheme& scheme, const JointHalf& half, HalfState& state) const;
    void settle_turn(const Scheme& scheme, TurnState& state) const;
    void start_half(const Scheme& scheme, const JointHalf& half, const Vector3& d, const Vector3& rate,
                    const Vector3& acceleration, HalfState& state) const;
    double advance_half(const Scheme& scheme, uint64_t steps, const JointHalf& half, const Vector3& d, const Vector3& delta,
                        HalfState& state) const;

    int element_, from_, to_;
    bool turns_, is_aligned_, has_lever_, is_straight_;
    Directions rigid_;
    JointLaw law_;
    JointHalf halves_[2];
    double elastic_weight_ = 0;
    Matrix3 from_axes_;  ///< of the joint in the axes of the `from` frame
    Matrix3 to_axes_;    ///< the same at rest in those of the `to` frame
    Vector3 rest_;       ///< the point of the `to` end from the `from` origin at rest, joint axes
    Vector3 to_point_;   ///< the point from the `to` origin, axes of the `to` frame
};

// ---- What every step does for every joint -------------------------------------------------------------------------------

inline Vector3 Joint::arm(FrameView from, FrameView to) const {
    if (!has_lever_) return to.origin() - from.origin();
    return to.origin() + to.axes() * to_point_ - from.origin();
}

inline Vector3 Joint::translation(FrameView from, const Vector3& arm) const {
    if (is_aligned_) return from.axes().transpose() * arm - rest_;
    return from_axes_.transpose() * (from.axes().transpose() * arm) - rest_;
}

inline Matrix3 Joint::attitude(FrameView from, FrameView to) const {
    if (is_straight_) return from.axes().transpose() * to.axes();
    return (from.axes() * from_axes_).transpose() * (to.axes() * to_axes_);
}

inline void Joint::add_wrench(const Vector3& arm, const Vector3& lever, const Vector3& F, const Vector3& M, double* on_from,
                              double* on_to) const {
    // to: (−F, −M − lever × F); from: (F, M + arm × F): forces and moments of the two ends balance about any point
    using Map = Eigen::Map<Vector3>;
    if (on_to) {
        Map{on_to} -= F;
        if (has_lever_)
            Map{on_to + 3} -= M + lever.cross(F);
        else
            Map{on_to + 3} -= M;
    }
    if (on_from) {
        Map{on_from} += F;
        Map{on_from + 3} += M + arm.cross(F);
    }
}

/// ∂m/∂δ₊ of the open step, the same addition in it.
inline Matrix3 Joint::turn_gain(const TurnState& state) const {
    Matrix3 gain = halves_[1].law.asDiagonal();
    const Vector3 elastic = elastic_weight_ * halves_[1].stiffness;
    gain += (state.conjugate - Matrix3::Identity()) * elastic.asDiagonal();
    return gain;
}

}  // namespace dttmm
