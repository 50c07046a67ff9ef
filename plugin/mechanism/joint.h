// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/rotation.h"
#include "mechanism/assembly.h"
#include "mechanism/joint_kinematics.h"
#include "mechanism/scheme.h"
#include "mechanism/springs.h"

namespace dttmm::plugin {

/// The frames of a joint at an instant.
struct Ends {
    FrameView from, to;
};

/// What unit forces in the rigid directions of a joint do over a step.
struct RigidMap {
    Matrix3 force = Matrix3::Zero(), arm = Matrix3::Zero(), lever = Matrix3::Zero(), moment = Matrix3::Zero();
    /// Adds an instant: the joint and its rotation θ then.
    void add(double weight, const JointPose& pose, const Vector3& theta) {
        force += weight * pose.axes;
        arm += weight * (skew(pose.arm) * pose.axes);
        lever += weight * (skew(pose.lever) * pose.axes);
        moment += weight * (pose.axes * rotation_vector_rate(theta).transpose());
    }
    JointForce of(const Vector6& q) const {
        const Vector3 slide = q.head<3>(), turn = moment * q.tail<3>();
        return {force * slide, arm * slide + turn, lever * slide + turn};
    }
};

/// −∂(wrench)/∂(pose) of the two ends of a joint, [row][column], `from` first; world axes, at the frames' origins.
struct EndBlocks {
    Matrix6 at[2][2];
};

/// What the laws of a joint remember at t_n, and at t_{n−1}; NULL where none has a memory.
struct LawMemory {
    double *now = nullptr, *before = nullptr;
};

/// What all joints of one law have alike, as those along a beam.
struct JointKind {
    explicit JointKind(std::shared_ptr<const JointLaw> law);
    /// Solves the transfer equations for the law at the scheme's step size.
    void set_scheme(const Scheme& scheme);

    std::shared_ptr<const JointLaw> law;
    SpringsOf<double> springs;
    bool is_damped, is_axial, has_laws;
    double step_size = 0;  ///< `solved` is for [s]
    Vector3 solved[2];     ///< k̂ = ∂f/∂d of the solved transfer equations, translations, rotations [N/m, N m/rad]
};

/// A massless joint at work between two frames: its rest configuration, its law solved for the step size, its kinematics. It
/// measures its deformation in its axes, which go with the `from` frame; the wrenches on its two ends balance exactly, lever
/// arms included. A rotational stiffness holds for relative rotations θ up to kLargestRotation. A rotational damper may turn
/// for ever.
///
/// The memory is the caller's: a JointState and, where rates count, a DamperState.
class Joint {
public:
    static constexpr double kLargestRotation = 2.5;  ///< rad

    /// kind: of the law of `spec`.
    Joint(const JointSpec& spec, const Assembly& assembly, std::shared_ptr<JointKind> kind);

    int element() const { return element_; }
    int from() const { return from_; }
    int to() const { return to_; }
    int frame(int end) const { return end == 0 ? from_ : to_; }
    /// Whether it carries a moment: otherwise rotations are not worked out.
    bool turns() const { return kind_->springs.turns; }
    Directions rigid() const { return kind_->law->rigid; }
    const JointLaw& law() const { return *kind_->law; }
    const JointHalf& translation_half() const { return kind_->springs.halves[0]; }
    const JointHalf& rotation_half() const { return kind_->springs.halves[1]; }
    const JointSeat& seat() const { return seat_; }
    bool is_line() const { return kind_->springs.is_line; }
    const SpringsOf<double>& springs() const { return kind_->springs; }
    const JointKind& kind() const { return *kind_; }
    bool is_damped() const { return kind_->is_damped; }
    /// Laws of its translations (0) or rotations count with the mean of the two ends of a step, not with that along the
    /// path: as massless frames balance, at the ends.
    void take_ends(int half) { takes_ends_[half] = true; }
    /// Whether a spring is not linear, or acts along a line that turns: neither is for the lanes.
    bool has_laws() const { return kind_->has_laws; }
    bool is_axial() const { return kind_->is_axial; }

    /// Where to write the element's index while its law is asked; NULL: nowhere.
    void report_work(volatile int32_t* at_work, uint32_t element) {
        at_work_ = at_work;
        reported_ = static_cast<int32_t>(element);
    }

    /// Solves its kind for the step size. Throws Error naming the element.
    void set_scheme(const Scheme& scheme);

    /// Kinematics at given frames: its pose; its attitude; its rotation θ.
    JointPose pose(FrameView from, FrameView to) const {
        if (is_axial()) [[unlikely]]
            return axial_pose(from, to);
        return seat_.pose(from, to);
    }
    JointPose pose(Ends at) const { return pose(at.from, at.to); }
    /// From the origin of its `from` frame (0) or `to` frame (1) to the point where its force acts on that [m], world axes.
    Vector3 arm(int end, FrameView from, FrameView to) const {
        return end == 1 ? seat_.lever(to) : is_axial() ? arm_of_line(from) : seat_.arm(from, to);
    }
    Matrix3 attitude(FrameView from, FrameView to) const { return seat_.axes(from).transpose() * seat_.axes_at_to(to); }
    Vector3 rotation(FrameView from, FrameView to) const {
        return turns() ? rotation_vector(attitude(from, to)) : Vector3(Vector3::Zero());
    }
    /// Its deformation [d; θ] in a pose between its frames.
    Vector6 deformation(const JointPose& pose, FrameView from, FrameView to) const;
    /// Rates and second rates of the deformation, [d; relative turn], joint axes.
    Vector6 rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const;
    /// The same where its deformation there is known already.
    Vector6 rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity,
                 const Vector6& deformation) const;
    Vector6 acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
                         const Twist& to_velocity, const Twist& to_acceleration) const;
    /// Angular velocity of its axes, in these.
    Vector3 turning(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const;

    /// Columns of [d; θ], joint axes, by the pose of the `from` or the `to` frame, world axes; for small relative rotations.
    Matrix6 by_from(const JointPose& pose) const;
    Matrix6 by_to(const JointPose& pose) const;

    /// Adds what a joint does to the wrenches on its frames, at their origins.
    static void add_wrench(const JointForce& force, double* on_from, double* on_to);

    /// The elastic force of a deformation, [force; moment] on the `from` end in the joint's axes.
    Vector6 elastic(const Vector6& deformation, const double* memory) const {
        return spread(deformation, spring_force(deformation, memory));
    }
    /// Its mean over the step from the deformation x to `end` less the mean of the two: zero where springs are linear.
    Vector6 beyond_mean(const Scheme& scheme, const Vector6& x, const Vector6& end, const double* memory) const {
        return spread(x, beyond(scheme, x, end, memory).mean);
    }
    /// What a direction with a law does over a step that takes its deformation from `now` to `end` [N, N m], but for what a
    /// linear spring would have of numerical damping; derivatives are those by `end` [N/m, N m/rad].
    struct OnPath {
        double force, gain;      ///< in all, and its derivative
        double rate, rate_gain;  ///< of it all but the scheme's weight of the force at the end
        double mean;             ///< of the force along the path, less the mean of its two ends
    };
    OnPath on_path(const Scheme& scheme, int direction, double now, double end, const double* memory) const;
    /// Its energy [J].
    double strain_energy(const Vector3& d, const Vector3& theta, const double* memory) const {
        if (kind_->has_laws) [[unlikely]]
            return energy_of_laws((Vector6() << d, theta).finished(), memory);
        return 0.5 * d.dot(kind_->springs.halves[0].stiffness.cwiseProduct(d)) +
               0.5 * theta.dot(kind_->springs.halves[1].stiffness.cwiseProduct(theta));
    }
    /// The dampers' force of a rate [d; relative turn] likewise.
    Vector6 damping(const Vector6& deformation, const Vector6& rate) const;
    /// The force law at one instant: f [force; moment] on the `from` end in the joint's axes; of its springs a share.
    [[gnu::always_inline]] Vector6 force(const Vector6& deformation, const Vector6& rate, const double* memory,
                                         double elastic_share = 1) const {
        Vector6 f = elastic_share * spring_force(deformation, memory);
        f.head<3>() += kind_->springs.halves[0].damping.cwiseProduct(rate.head<3>());
        f = spread(deformation, f);
        if (turns()) f.tail<3>() += kind_->springs.halves[1].damping.cwiseProduct(rate.tail<3>());
        return f;
    }
    using Strained = StrainedOf<double>;
    /// Its elastic part with the deformation it stems from.
    Strained strain(const Scheme& scheme, Ends at, const JointPose& pose, const JointState& state,
                    const double* memory) const {
        Strained strained = kind_->springs.strain(seat_.rest, pose, seat_.axes_at_to(at.to));
        if (kind_->has_laws) [[unlikely]]
            strain_laws(at, pose, {state.deformation(), memory, scheme.step_size()}, strained);
        return strained;
    }

    /// ∂(elastic force)/∂(deformation) and ∂(damping force)/∂(its rate) at one instant, joint axes, rotations in terms of
    /// the relative turn ε: what does not hang on a force that acts already. Symmetric.
    Matrix6 stiffness_tangent(const Vector6& deformation, const double* memory) const;
    Matrix6 damping_tangent(const Vector6& deformation) const;
    /// ∂f/∂(deformation at its end) over a step from the deformation `now` likewise.
    Matrix6 gain(const Scheme& scheme, const Vector6& now, const Vector6& deformation, const double* memory) const;
    /// Of forces that grow with the deformation by `answer` (joint axes).
    EndBlocks stiffness(const JointPose& pose, const Matrix6& answer) const;
    /// Of a force already acting (world axes), which turns with the joint; symmetric part.
    EndBlocks acting_stiffness(const JointPose& pose, FrameView from, FrameView to, const Vector3& force) const;

    // At rest: laws go the straight way from the undeformed state to a deformation x.

    /// The elastic forces along the deformations there (gradients by θ in rotations), and their derivatives.
    struct AtRest {
        Vector6 force, tangent;
    };
    AtRest at_rest(const Vector6& x) const;
    /// The derivatives where the laws have come to rest there: those of small vibrations, with which sliders stick.
    Vector6 unloading(const Vector6& x) const;
    /// ∂(elastic force)/∂(deformation) of that, joint axes, rotations in terms of the relative turn.
    Matrix6 rest_tangent(const Vector6& x, const Vector6& tangent) const { return along(x, tangent); }
    /// How small motions of its frames (shifts and turns, world axes) change a deformation x.
    Vector6 change(const JointPose& pose, const Vector6& x, const Vector6& of_from, const Vector6& of_to) const;
    /// What forces along the deformations do to the frames; `rigid` are those of rigid directions.
    JointForce carry(Ends at, const Vector6& force, const Vector6& rigid) const;
    /// How such forces change as [force; moment] in the joint's axes while they keep their size, by a small relative motion
    /// [d; ε] of the `to` end.
    Matrix6 spread_tangent(Ends at, const Vector6& force, const Vector6& rigid) const;
    /// −∂(wrench)/∂(pose) of such forces while they keep their size: all that stems from their directions and lever arms.
    EndBlocks turning_stiffness(Ends at, const Vector6& force, const Vector6& rigid) const;

    /// Takes laws to where the joint is at the start on the straight way from the undeformed state; `strained` takes where
    /// that is, and the elastic force there.
    void start_laws(Ends at, const JointPose& pose, LawMemory memory, Strained& strained) const;
    void start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
               JointState& state, DamperState* damper, LawMemory memory) const;
    /// The force over the open step at a trial end of it, where the joint is at `at_end`; without rigid directions.
    JointForce weigh(const Scheme& scheme, const Strained& end, const JointPose& at_end, const JointState& state,
                     const DamperState* damper, const double* memory) const {
        JointForce force = kind_->springs.weigh(scheme, end, at_end, state, damper);
        if (kind_->has_laws) [[unlikely]]
            add_laws(scheme, end, at_end, state, memory, force);
        return force;
    }
    /// The same of a joint without laws: what every step does for most joints.
    JointForce over_step(const Scheme& scheme, Ends trial, const JointState& state, const DamperState* damper) const {
        const JointPose at_end = seat_.pose(trial.from, trial.to);
        return kind_->springs.weigh(scheme, kind_->springs.strain(seat_.rest, at_end, seat_.axes_at_to(trial.to)), at_end,
                                    state, damper);
    }
    /// The damping force from the start of the open step to a trial end of it: the mean rate in the mean of the axes.
    JointForce damping_half_way(Ends trial, Ends now, double h, const JointState& state, const DamperState& damper) const;
    /// Moves the memory on to the accepted end of the step. force: if given, takes the force over the step as over_step
    /// finds it.
    void advance(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper, LawMemory memory,
                 JointForce* force) const;

    /// Throws Error(DTTMM_ERROR_NUMERIC) when a rotational stiffness has turned too far.
    void refuse_large_rotation(FrameView from, FrameView to) const;
    void refuse_large_rotation(const JointState& state) const {
        if (!(state.theta.squaredNorm() <= kLargestRotation * kLargestRotation)) [[unlikely]]
            refuse_rotation(state.theta.norm());
    }

private:
    /// What laws do over a step beyond linear springs, by direction as in OnPath; gradients by θ in rotations.
    struct Beyond {
        Vector6 force = Vector6::Zero(), mean = Vector6::Zero(), rate = Vector6::Zero(), gain = Vector6::Zero();
    };
    /// Where laws stand, and the time of the path that begins there.
    struct LawsAt {
        Vector6 x;
        const double* memory;
        double time;
    };
    LawOnPath ask(int direction, const LawPath& path) const;
    LawOnPath law_on_path(int direction, const LawPath& path) const;
    Beyond beyond(const Scheme& scheme, const Vector6& x, const Vector6& end, const double* memory) const;
    // Not inlined: links with laws are few
    [[gnu::noinline, gnu::cold]] void add_laws(const Scheme& scheme, const Strained& end, const JointPose& at_end,
                                               const JointState& state, const double* memory, JointForce& force) const;
    /// Of the springs along the deformations; translations as forces, rotations as the gradient by θ.
    Vector6 spring_force(const Vector6& x, const double* memory) const {
        Vector6 f;
        f << kind_->springs.halves[0].stiffness.cwiseProduct(x.head<3>()),
            kind_->springs.halves[1].stiffness.cwiseProduct(x.tail<3>());
        if (kind_->has_laws) [[unlikely]]
            put_laws({x, memory, 0}, x, f);
        return f;
    }
    [[gnu::noinline, gnu::cold]] void put_laws(const LawsAt& from, const Vector6& x, Vector6& f) const;
    [[gnu::noinline, gnu::cold]] void strain_laws(Ends at, const JointPose& pose, const LawsAt& from,
                                                  Strained& strained) const;
    [[gnu::noinline, gnu::cold]] JointPose axial_pose(FrameView from, FrameView to) const;
    /// From the first point of its line to the second, world axes; from the `from` origin to the first.
    Vector3 way(FrameView from, FrameView to) const { return seat_.arm(from, to) - arm_of_line(from); }
    Vector3 arm_of_line(FrameView from) const { return from.axes() * from_point_; }
    EndBlocks axial_stiffness(FrameView from, FrameView to, const Vector3& force) const;
    [[gnu::noinline, gnu::cold]] void advance_with_laws(const Scheme& scheme, Ends next, Ends now, JointState& state,
                                                        DamperState* damper, LawMemory memory, JointForce* force) const;
    [[gnu::noinline, gnu::cold]] double energy_of_laws(const Vector6& x, const double* memory) const;
    Vector6 spring_tangent(const LawsAt& from, const Vector6& x) const;
    Matrix6 along(const Vector6& x, const Vector6& k) const;
    /// Forces along the deformations as [force; moment] in the joint's axes, and as what they do to the frames.
    Vector6 spread(const Vector6& x, Vector6 f) const {
        Vector3 force = f.head<3>(), by_theta = f.tail<3>();
        f.tail<3>().setZero();
        if (turns()) {
            kind_->springs.spread(kind_->springs.drawn(x.head<3>(), x.tail<3>()), force, by_theta);
            f.tail<3>() = moment_of_gradient(Vector3(x.tail<3>()), by_theta);
        }
        f.head<3>() = force;
        return f;
    }
    JointForce act(const JointPose& pose, const Vector6& x, const Vector6& f) const;
    void refuse_rotation(double angle) const;
    /// Columns of the elongation of a line by d and ε.
    Vector6 stretch(const Vector6& deformation) const;

    int element_, from_, to_;
    int32_t reported_ = 0;
    volatile int32_t* at_work_ = nullptr;
    std::shared_ptr<JointKind> kind_;
    bool takes_ends_[2] = {false, false};
    JointSeat seat_;
    Vector3 from_point_ = Vector3::Zero();  ///< of a line: its first point in the axes of the `from` frame [m]
};

// ---- What every step does for every joint -------------------------------------------------------------------------------

inline void Joint::add_wrench(const JointForce& force, double* on_from, double* on_to) {
    using Map = Eigen::Map<Vector3>;
    if (on_to) {
        Map{on_to} -= force.force;
        Map{on_to + 3} -= force.on_to;
    }
    if (on_from) {
        Map{on_from} += force.force;
        Map{on_from + 3} += force.on_from;
    }
}

}  // namespace dttmm::plugin
