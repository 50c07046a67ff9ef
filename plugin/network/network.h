// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/discretisation.h"
#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm {

/// A connected set of elements between ports and the ground, solved together at every step. It owns the memory of the time
/// scheme; the ports' motion comes from the host. Bodies may turn as they like: an element measures its deformation in the
/// axes of its `from` end, and the wrenches on its two ends balance exactly, lever arm included, at the poses of t_n, so
/// that the host's momentum and angular momentum are kept to rounding. A rotational stiffness holds for relative rotations θ
/// up to kLargestRotation; its moment is the gradient of ½ θᵀ k θ, so that it conserves energy. A rotational damper may turn
/// for ever.
///
/// Motion over a step enters as increments δ of the deformation from t_n, rotations as the rotation vector that leads from
/// t_n to t_{n+1}; the linearised transfer equations are solved for the force at the increment.
///
/// The phases, units and frames are those of dttmm_plugin.h; errors are thrown as Error, with the element's index.
class Network {
public:
    static constexpr double kLargestRotation = 2.5;  ///< rad

    explicit Network(const dttmm_network& description);

    int port_count() const { return port_count_; }
    bool is_implicit() const { return scheme_ == DTTMM_SCHEME_CENTRED; }
    void load_weights(double weights[3]) const;

    void linearise(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const;
    void start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations, const double* loads);
    void begin_step(const dttmm_step& step, const double* loads);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();

    size_t state_size() const;
    void save_state(void* buffer, size_t size) const;
    void restore_state(const void* buffer, size_t size);

    const std::vector<dttmm_channel>& channels() const { return channels_; }
    void outputs(double* values) const;

private:
    /// A frame in the world: origin [m] and axes, row-major as in dttmm_motion.
    struct Frame {
        double position[3];
        double rotation[9];
    };
    /// The same somewhere else in memory: a port's trial motion, the committed one, or a point of the ground.
    struct FrameView {
        const double* position;
        const double* rotation;
    };

    /// One end of a joint: a port, or (port −1) a point of the ground, which stays where it was at the start.
    struct End {
        int port;
        Frame start;
    };

    /// Three translations or three rotations of a joint: the same formulas hold for both.
    struct Half {
        Vector3 stiffness, damping;
        Vector3 law;  ///< k̂ = ∂f/∂d of the solved transfer equations [N/m, N m/rad]
    };
    enum { kTranslation, kRotation };

    /// An element at work: its data, its rest configuration and its solved force law at the current step size.
    struct Joint {
        End from, to;
        Half halves[2];
        int turn;               ///< index of its TurnState; −1 when it carries no rotation: then none is worked out
        Vector3 rest_position;  ///< of the `to` end seen from the `from` end, in its axes
        Matrix3 rest_rotation;  ///< R_fromᵀ R_to
        std::unique_ptr<const Element> element;
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
        Matrix3 attitude;   ///< of the `to` end relative to the `from` end at t_n, in the axes of `from`; identity at rest
        Matrix3 conjugate;  ///< J⁻ᵀ(θ) at t_n: makes of k ∘ θ the moment that does its work
    };
    struct Clock {
        double step_size = 0;
        uint64_t steps = 0;  ///< committed since the start
    };

    FrameView committed(const End& end) const;
    static FrameView trial(const End& end, const dttmm_motion* ports);
    static Vector3 arm(FrameView from, FrameView to);
    static Vector3 translation(const Joint& joint, FrameView from, const Vector3& arm);
    static Matrix3 attitude(const Joint& joint, FrameView from, FrameView to);
    static Vector6 deformation_rate(const Joint& joint, const dttmm_motion* ports);
    static Vector6 deformation_acceleration(const Joint& joint, const dttmm_motion* ports, const double* accelerations);

    /// Adds the wrenches of a joint's force F and moment M (world axes) to its ports; `arm` leads from `from` to `to`.
    static void add_wrench(const Joint& joint, const Vector3& arm, const Vector3& F, const Vector3& M, double* wrench);
    /// How a joint's force answers a small motion of its ends: δf = gain δd and δm = turn_gain δε, ε the relative turn, in
    /// the axes of `from`; they act in the axes R_now of the `from` end over the lever `arm_now`.
    struct Answer {
        Vector3 gain;
        Matrix3 turn_gain;
        Matrix3 R_now;
        Vector3 arm_now;
    };
    /// Adds −∂(wrench)/∂(pose), or by velocity; the deformation changes with the frames `from` and `to`.
    void add_stiffness(const Joint& joint, const Answer& answer, FrameView from, FrameView to, double* stiffness) const;

    /// How the scheme weighs increments δ of the deformation in the force over a step,
    ///     f = k ∘ (d + elastic[0] δ₊ + elastic[1] δ) + c ∘ (rate[0] δ₊ + rate[1] δ + rate[2] δ₋ + rate[3] δ₋₋),
    /// δ₊ over the open step (implicit schemes only), δ, δ₋, δ₋₋ over the three before.
    struct Weights {
        double elastic[2];
        double rate[4];  ///< [1/s]
    };
    Weights weights_of(double h) const;

    std::vector<End> place_ends(const dttmm_network& description);
    void build_joint(const dttmm_network& description, const std::vector<End>& ends, uint32_t index);
    void set_step_size(double h);
    void solve_law(Joint& joint, const StepCoefficients& step) const;
    void start_joint(size_t index, const dttmm_motion* ports, const double* accelerations);
    void start_half(const Half& half, const Vector3& d, const Vector3& rate, const Vector3& acceleration,
                    HalfState& state) const;
    void recall(const Half& half, HalfState& state) const;
    void settle_turn(const Joint& joint, TurnState& state) const;
    Matrix3 turn_gain(const Half& half, const TurnState& state) const;
    void refuse_large_rotation(const dttmm_motion* ports) const;
    double advance_half(const Half& half, const Vector3& d, const Vector3& delta, HalfState& state) const;
    std::vector<std::pair<void*, size_t>> state_parts();

    uint32_t scheme_;
    Centred centred_;
    int port_count_ = 0;
    std::vector<Joint> joints_;
    std::vector<dttmm_channel> channels_;

    Weights weights_{};
    std::vector<JointState> joint_states_;
    std::vector<TurnState> turn_states_;
    std::vector<Frame> ports_;  ///< at t_n
    Clock clock_;
    bool started_ = false, open_ = false;
};

}  // namespace dttmm
