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
/// scheme; the ports' motion comes from the host. Rotations are large, deformations small: an element measures its
/// deformation in the axes of its `from` end, and the wrenches on its two ends balance exactly, lever arm included, at the
/// poses of t_n, so that the host's momentum and angular momentum are kept to rounding.
///
/// The phases, units and frames are those of dttmm_plugin.h; errors are thrown as Error, with the element's index.
class Network {
public:
    explicit Network(const dttmm_network& description);

    int port_count() const { return port_count_; }
    bool is_implicit() const { return scheme_ == DTTMM_SCHEME_CENTRED; }
    void load_weights(double weights[3]) const;

    void linearise(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const;
    void start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations);
    void begin_step(const dttmm_step& step);
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
        Vector3 law;        ///< k̂: −∂f/∂d of the solved transfer equations [N/m, N m/rad]
        Vector3 recall[4];  ///< the known part of the force is Σ recall[i] ∘ d[i]
    };
    static constexpr int kTranslation = 0, kRotation = 1;

    /// An element at work: its data, its rest configuration and its solved force law at the current step size.
    struct Joint {
        End from, to;
        Half halves[2];
        int half_count;           ///< 1 when it carries no rotation: then the relative rotation is not worked out
        Vector3 rest_position;    ///< of the `to` end seen from the `from` end, in its axes
        Matrix3 rest_rotation;    ///< R_fromᵀ R_to
        std::unique_ptr<const Element> element;
    };

    /// What changes from step to step, joint by joint; plain numbers, so that saving is copying.
    struct HalfState {
        Vector3 d[4];   ///< deformation at t_n, t_{n−1}, t_{n−2}, t_{n−3}
        Vector3 known;  ///< part of the force over the open step that does not depend on its end
    };
    struct JointState {
        HalfState halves[2];
        double dissipated;  ///< energy lost to damping up to t_{n−1} [J]
        double power;       ///< at t_{n−1} [W]
    };
    struct Clock {
        double step_size = 0;
        uint64_t steps = 0;  ///< committed since the start
    };

    FrameView committed(const End& end) const;
    static FrameView trial(const End& end, const dttmm_motion* ports);
    static Vector3 arm(FrameView from, FrameView to);
    static Vector3 translation(const Joint& joint, FrameView from, const Vector3& arm);
    static Vector3 rotation(const Joint& joint, FrameView from, FrameView to);
    static Vector6 deformation(const Joint& joint, FrameView from, FrameView to);
    static Vector6 deformation_rate(const Joint& joint, const dttmm_motion* ports);
    static Vector6 deformation_acceleration(const Joint& joint, const dttmm_motion* ports, const double* accelerations);

    /// Adds the wrenches of a joint's force and moment (axes of `from`) to its ports; `arm` leads from `from` to `to`.
    static void add_wrench(const Joint& joint, FrameView from, const Vector3& arm, const Vector3* force, double* wrench);
    /// Adds −∂(wrench)/∂(pose), or by velocity, of a joint whose force changes by `gain` ∘ δd. The force acts in the axes
    /// of `from_now` over the lever `arm_now`; the deformation changes with the frames from and to.
    void add_stiffness(const Joint& joint, const Vector6& gain, FrameView from, FrameView to, FrameView from_now,
                       const Vector3& arm_now, double* stiffness) const;

    std::vector<End> place_ends(const dttmm_network& description);
    void build_joint(const dttmm_network& description, const std::vector<End>& ends, uint32_t index);
    void set_step_size(double h);
    /// How a scheme weights d at t_n, t_{n−1}, t_{n−2}, t_{n−3} in the known part of elastic force and rate.
    struct PastWeights {
        std::array<double, 4> elastic, rate;
    };
    PastWeights past_weights(double h) const;
    void solve_law(Joint& joint, const StepCoefficients& step) const;
    void start_half(const Half& half, const Vector3& d, const Vector3& rate, const Vector3& acceleration, HalfState& state) const;
    void recall(const Half& half, HalfState& state) const;

    uint32_t scheme_;
    Centred centred_;
    int port_count_ = 0;
    std::vector<Joint> joints_;
    std::vector<dttmm_channel> channels_;

    int recalled_ = 0;  ///< how many past deformations the scheme looks at

    std::vector<JointState> joint_states_;
    std::vector<Frame> ports_;  ///< at t_n
    Clock clock_;
    bool started_ = false, open_ = false;
};

}  // namespace dttmm
