// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/step_convergence.h"
#include "coupling/step_equations.h"
#include "coupling/step_report.h"
#include "coupling/step_stops.h"
#include "model/model.h"
#include "world/joint_system.h"
#include "world/singular_position.h"
#include "world/world.h"

namespace dttmm::host {

/// Finds the motion at the end of a step that agrees with the wrench the networks answer to it, for all coupled bodies at
/// once: Newton's iteration on the StepEquations. Their matrix is factored once and kept while it converges fast (with
/// joints formed anew for every solve, as J turns). For explicit schemes S is zero and u follows at once: one path for both.
///
/// The iteration closes the joints just as ODE and the closing of its joints will: only f and the impulses of stops are
/// handed to ODE, whose joints then find the rest of q by themselves.
///
/// Stops act as far as they push, by the sign of q, so that a stop lets go in the step in which it would pull.
///
/// A step is accepted when every group of connected bodies and every part of the plugins has converged (StepConvergence).
/// The rate of the steps before may be used, so that a linear model takes one pass, with joints two (their multipliers do
/// not show in the correction).
class EndOfStep {
public:
    /// have_rigid_loop: elements with rigid directions form a closed loop. It only selects the advice in a message.
    EndOfStep(const Model& model, const Networks& networks, bool have_rigid_loop = false);

    /// Initial conditions: from the motion at t0 with the velocities and accelerations of that instant, returns the motion
    /// with the velocities half a step of size h back, as a leap-frog host wants them.
    std::vector<BodyState> start(double h, const std::vector<BodyState>& at, const BodyVectors& accelerations);

    /// What motors ask for over the coming step, one per joint.
    void drive(const std::vector<Drive>& drives) { equations_.joint_system().drive(drives); }
    /// Opens a step. `now`: poses at t_n, velocities over the step before. Networks and loads have begun the step.
    void begin_step(const dttmm_step& step, const std::vector<BodyState>& now, const Loads& loads);

    /// The wrenches for ODE, 6 per body, the forces of stops among them. Throws Error(numerical_failure) naming the worst
    /// body when it does not converge.
    const BodyVectors& solve(const std::vector<BodyState>& now, Networks& networks);
    /// The bodies at the end of the step last solved.
    const std::vector<BodyState>& predicted() const { return trial_; }
    /// The same. Also without joints it includes the last correction, which predicted() lacks there.
    void write_end(const std::vector<BodyState>& now, std::vector<BodyState>& end) const {
        equations_.move(now, equations_.h(), end);
    }
    /// The equations of the step last solved, at its end.
    const StepEquations& equations() const { return equations_; }
    /// Which equations of joints that step does without.
    const SingularPosition& singular_position() const { return singular_; }

    /// Throws Error(numerical_failure) naming body and joint unless ODE has moved the bodies as solve() predicted, to
    /// kAgreement of their speeds.
    void confirm(const std::vector<BodyState>& after) const;

    const StepStops& stops() const { return stops_; }

    /// How the end of the open step was found, or of the last one.
    StepReport report() const;
    /// The first of the steps with the most passes.
    const StepReport& worst() const { return worst_; }
    /// What its last pass but one was not enough for: `body "plate" on element "bolt1"`, `element "beam" (plugin ..)`; or
    /// nothing.
    std::string waited_for(const StepReport& report, const Networks& networks) const;

    /// Evaluations of the networks over all steps so far, and matrix factorisations.
    long passes() const { return passes_; }
    long factorisations() const { return factorisations_; }

private:
    bool find_end(const std::vector<BodyState>& now, Networks& networks);
    void linearise_joints(const std::vector<BodyState>& now);
    void evaluate(const std::vector<BodyState>& now, Networks& networks);
    void see_singular_position(const std::vector<BodyState>& now, Networks& networks);
    bool go_back(const std::vector<BodyState>& now);
    bool judge(int pass, const Networks& networks);
    const char* cure(const char* otherwise) const;
    [[noreturn]] void refuse_matrix(const std::vector<BodyState>& now) const;
    [[noreturn]] void refuse(const Networks& networks) const;
    [[noreturn]] void fail() const;

    StepEquations equations_;
    StepConvergence convergence_;
    std::vector<Joint> joints_;
    bool have_loop_, have_rigid_loop_;
    SingularPosition singular_;
    StepStops stops_;
    std::vector<BodyState> trial_, half_;  ///< at the end of the step, and half way
    std::vector<double> wrenches_;         ///< 6 per body
    BodyVectors previous_u_;               ///< over the step before
    BodyVectors base_u_;                   ///< before the correction last made
    double base_residual_ = 0;             ///< there [J]
    BodyVectors feedback_;
    bool stiffness_wanted_ = true;  ///< by the next evaluation, which then factors the matrix anew
    long passes_ = 0, factorisations_ = 0;
    StepReport open_, worst_;  ///< of the open step its counts only
};

}  // namespace dttmm::host
