// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "core/index.h"
#include "mechanism/joint_geometry.h"

namespace dttmm::plugin {

/// A massless joint at work between two frames: its geometry, and its law solved for the step size. The wrenches on its two
/// ends balance exactly, lever arms included. A rotational stiffness holds for relative rotations θ up to kLargestRotation.
/// A rotational damper may turn for ever.
///
/// The memory is the caller's: a JointState and, where rates count, a DamperState.
class Joint : public JointGeometry {
public:
    /// kind: of the law of `spec`.
    Joint(const JointSpec& spec, const Assembly& assembly, std::shared_ptr<JointKind> kind)
        : JointGeometry(spec, assembly, std::move(kind)) {}

    bool is_damped() const { return kind_->is_damped; }
    /// Laws of its translations (0) or rotations count with the mean of the two ends of a step, not with that along the
    /// path: as massless frames balance, at the ends.
    void take_ends(int half) { takes_ends_[half] = true; }
    /// Whether a spring is not linear, or acts along a line that turns: neither is for the lanes.
    bool has_laws() const { return kind_->has_laws; }

    /// Where to write the element's index while its law is asked; NULL: nowhere.
    void report_work(volatile int32_t* at_work, uint32_t element) {
        at_work_ = at_work;
        reported_ = as_whole<int32_t>(element);
    }

    /// Solves its kind for the step size. Throws Error naming the element.
    void set_scheme(const Scheme& scheme);

    /// Adds what a joint does to the wrenches on its frames, at their origins.
    static void add_wrench(const JointForce& force, double* on_from, double* on_to);

    /// What the law of a direction answers. Throws Error naming the element.
    LawOnPath ask(int direction, const LawPath& path) const;
    /// Forces along the strains of a deformation x (gradients by θ in rotations) as [force; moment] in the joint's axes, and
    /// as what they do to the frames.
    Vector6 spread(const Vector6& x, const Vector6& f) const { return kind_->springs.force(x, f, Vector6::Zero()); }
    JointForce act(const JointPose& pose, const Vector6& x, const Vector6& f) const;
    /// ∂(elastic force)/∂(deformation) of springs of the stiffness k along the deformations, joint axes, rotations in terms
    /// of the relative turn ε. Symmetric.
    Matrix6 along(const Vector6& x, const Vector6& k) const;

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
        const Vector3 s = kind_->springs.strains(d, theta);
        return 0.5 * s.dot(kind_->springs.halves[0].stiffness.cwiseProduct(s)) +
               0.5 * theta.dot(kind_->springs.halves[1].stiffness.cwiseProduct(theta));
    }
    /// The dampers' force of a rate [strains; relative turn] likewise.
    Vector6 damping(const Vector6& deformation, const Vector6& rate) const {
        return kind_->springs.force(deformation, Vector6::Zero(), rate);
    }
    /// The force law at one instant: f [force; moment] on the `from` end in the joint's axes; of its springs a share.
    [[gnu::always_inline]] Vector6 force(const Vector6& deformation, const Vector6& rate, const double* memory,
                                         double elastic_share = 1) const {
        return kind_->springs.force(deformation, elastic_share * spring_force(deformation, memory), rate);
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
    LawOnPath law_on_path(int direction, const LawPath& path) const;
    Beyond beyond(const Scheme& scheme, const Vector6& x, const Vector6& end, const double* memory) const;
    // Not inlined: links with laws are few
    [[gnu::noinline, gnu::cold]] void add_laws(const Scheme& scheme, const Strained& end, const JointPose& at_end,
                                               const JointState& state, const double* memory, JointForce& force) const;
    /// Of the springs along the deformations; translations as forces, rotations as the gradient by θ.
    Vector6 spring_force(const Vector6& x, const double* memory) const {
        Vector6 f = kind_->springs.along(x);
        if (kind_->has_laws) [[unlikely]]
            put_laws({x, memory, 0}, x, f);
        return f;
    }
    [[gnu::noinline, gnu::cold]] void put_laws(const LawsAt& from, const Vector6& x, Vector6& f) const;
    [[gnu::noinline, gnu::cold]] void strain_laws(Ends at, const JointPose& pose, const LawsAt& from,
                                                  Strained& strained) const;
    [[gnu::noinline, gnu::cold]] void advance_with_laws(const Scheme& scheme, Ends next, Ends now, JointState& state,
                                                        DamperState* damper, LawMemory memory, JointForce* force) const;
    [[gnu::noinline, gnu::cold]] double energy_of_laws(const Vector6& x, const double* memory) const;
    Vector6 spring_tangent(const LawsAt& from, const Vector6& x) const;
    Matrix6 of_translations(const Vector6& x, const Vector3& k) const;
    Vector3 motion_of_strains(const Vector6& x, const Vector6& change) const;

    int32_t reported_ = 0;
    volatile int32_t* at_work_ = nullptr;
    bool takes_ends_[2] = {false, false};
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
