// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/newton_convergence.h"
#include "coupling/step_report.h"
#include "model/model.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/inertia.h"
#include "world/joint_system.h"
#include "world/world.h"

namespace dttmm::host {

/// What acts on the bodies over a step, for ODE: [force; moment about the centre of mass] per body, world axes.
using Feedback = std::vector<Eigen::Matrix<double, 6, 1>>;

/// The bodies at t_n: what a row of results tells of them. Mass times acceleration is the sum of the forces recorded there.
struct Instant {
    std::vector<BodyState> at;                               ///< poses and velocities
    std::vector<Eigen::Matrix<double, 6, 1>> accelerations;  ///< of the centres of mass, linear and angular [m/s², rad/s²]
};

/// Finds the motion at the end of a step that agrees with the wrench the networks answer to it, for all coupled bodies at
/// once.
///
/// ODE moves a free body by  v+ = v + h M⁻¹ f,  x+ = x + h v+. Its momentum over the step, P = [m v; L(ω)], therefore obeys
///     P(u) = P− + h (f_loads + f_networks(x + h u)),     u = [v; ω] over the step, 6 per body,
/// where L(ω) = R_{n+1/2} J R_{n+1/2}ᵀ ω is the angular momentum half way through the step: the centred gyroscopic moment,
/// which keeps the angular momentum of a free body to rounding. Simplified Newton iteration with the matrix
///     K = M + h² S,     S: stiffness of the networks seen from the centres of mass,
/// symmetric (the gyroscopic part of ∂P/∂u and the little asymmetry of S away from rest are left to the iteration), sparse,
/// factored once and kept while it converges fast (with joints formed anew for every solve, as J turns). For explicit
/// schemes S is zero and u follows at once: one path for both.
///
/// Bodies on ideal joints also obey, with the multipliers q and the directions J of t_n (see JointSystem),
///     P(u) + Jᵀ q = P− + h f,   C(x + h u) = 0,      matrix | K   Jᵀ |
///                                                           | J  −E  |
/// just as ODE and the closing of its joints will: only f is handed to ODE, whose joints then find q by themselves. ODE is
/// asked whether it agrees; it has the last word on which stops act.
///
/// A step is accepted when every group of connected bodies and every part of the plugins has converged (NewtonConvergence).
/// The rate of the steps before may be used, so that a linear model takes one pass, with joints two (their multipliers do
/// not show in the correction).
class EndOfStep {
public:
    static constexpr int kMostPasses = 50;
    static constexpr double kAgreement = 1e-8;

    EndOfStep(const Model& model, const Networks& networks);

    /// Initial conditions: from the motion at t0 = step.time with the velocities of that instant, starts loads and networks,
    /// and returns the motion with the velocities half a step back, as a leap-frog host wants them.
    std::vector<BodyState> start(const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks, Loads& loads);

    /// Opens a step. `now`: poses at t_n, velocities over the step before. Networks and loads have begun the step.
    void begin_step(const dttmm_step& step, const std::vector<BodyState>& now, const Loads& loads);

    /// The wrenches for ODE if `stops` act over the step, one per joint; those that the step would run through are added
    /// here, their forces among the wrenches. May be called again with others. Throws Error(numerical_failure) naming the
    /// worst body when it does not converge.
    const Feedback& solve(const std::vector<BodyState>& now, Networks& networks, const std::vector<Stop>& stops);

    /// Equations of joints that the step last solved does without; empty: ODE's joints hold.
    const LetGo& let_go() const { return singular_.let_go; }
    /// Steps so far that went without equations of joints, near singular positions; the first: its time [s], and a joint.
    struct Passed {
        long steps = 0;
        double time = 0;
        size_t joint = 0;
    };
    const Passed& singular_positions() const { return passed_; }
    /// The bodies at the end of the step last solved.
    const std::vector<BodyState>& foretold() const { return trial_; }

    /// Throws Error(numerical_failure) naming body and joints unless ODE has moved the bodies as solve() foretold, to
    /// kAgreement of their speeds.
    void confirm(const std::vector<BodyState>& after) const;

    /// What stands at t_n, the start of the step last committed: velocities as Newmark's rule has them,
    ///     v_n = v_{n+1/2} − h/2 M⁻¹ (mean wrench over the step),   J v_n = 0,
    /// accelerations and joint forces by the balance of that instant, M a + Jᵀ q = f, J a = −C̈. Then the networks stand
    /// there too. now: poses at t_n, velocities over the step before; after: those over the step. Velocities are the means
    /// of those over the two steps where joints turn (J at t_n would share the turning over half a step between a heavy body
    /// and one that is stiffly held), in the row of an impact on a stop, with an explicit scheme, and where a plugin does
    /// not tell what stands; in the row of an impact, and for such a plugin, accelerations and joint forces are the means
    /// over these steps too, the impulse of the impact among them.
    const Instant& find_instant(const std::vector<BodyState>& now, const std::vector<BodyState>& after, Networks& networks,
                                const Loads& loads);

    /// The wrench of a joint at the instant last found on its first body, [force; moment about the anchor], world axes.
    Eigen::Matrix<double, 6, 1> joint_wrench(size_t joint, const std::vector<BodyState>& now) const;
    const std::vector<JointEquations>& joints() const { return system_.joints(); }
    /// Work of the stops at t_n on the bodies [J], never positive but for rounding: a stop takes speed and gives none back.
    /// now: velocities over the step before; after: those over this one.
    double stop_work(const std::vector<BodyState>& now, const std::vector<BodyState>& after) const;

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
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    /// A body as the coupling sees it.
    struct Coupled {
        Inertia inertia;
        std::string name;
        std::string holder;  ///< an element or a joint that it hangs on; empty if none
        double least;        ///< principal moment [kg m²]
        double reach;        ///< of its markers and of its mass from the centre of mass [m]
        size_t group;        ///< of connected bodies
    };
    /// Connected bodies. Speeds are the largest of a point of theirs [m/s].
    struct Group {
        double scale = 0;  ///< of the motion found before, slowly forgetting
        double speed = 0;  ///< of the last pass: what a pass overshoots is no motion
        double floor = 0;  ///< apparent corrections from rounding of the held bodies' positions and of the joints' impulses
        dttmm_progress progress{};  ///< by the pass at hand
        NewtonConvergence convergence{NewtonConvergence::kBodies};
        double size() const { return std::max(scale, speed); }
    };

    void predict(const std::vector<BodyState>& now);
    void move(const std::vector<BodyState>& now, double t, std::vector<BodyState>& to) const;
    void evaluate(const std::vector<BodyState>& now, Networks& networks);
    void factor(const std::vector<BodyState>& now);
    size_t least_held(const std::vector<BodyState>& now) const;
    void factor_instant(const std::vector<BodyState>& at);
    void solve_instant(Eigen::VectorXd& rows, Eigen::VectorXd& x) const;
    void find_velocities(const std::vector<BodyState>& after);
    void find_accelerations(const std::vector<BodyState>& at);
    bool has_impact(const std::vector<BodyState>& now, const std::vector<BodyState>& after) const;
    void refuse_opening_joints(const std::vector<BodyState>& at) const;
    void correct(const std::vector<BodyState>& now);
    double lack(const std::vector<BodyState>& now) const;
    void remember(const std::vector<BodyState>& now);
    bool go_back(const std::vector<BodyState>& now);
    void open_groups(const std::vector<BodyState>& now);
    void raise_floors();
    bool judge(int pass);
    bool judge_parts(const Networks& networks);
    size_t farthest_off(size_t group) const;
    std::string name_of(size_t body) const;
    [[noreturn]] void refuse(const Networks& networks) const;
    bool revise_stops(const std::vector<BodyState>& now);
    bool find_end(const std::vector<BodyState>& now, Networks& networks);
    void remember_let_go();
    void linearise_joints(const std::vector<BodyState>& now);
    void see_singular_position(const std::vector<BodyState>& now, Networks& networks,
                               const JointSystem::SingularPosition& before);
    Eigen::Vector3d momentum_over_step(size_t body, const Eigen::Matrix3d& R, const Eigen::Vector3d& w) const;
    void form_feedback(const std::vector<BodyState>& now);
    [[noreturn]] void fail(int passes) const;

    /// The largest speed of a point of the body, at most.
    double speed_of(size_t body, const Vector6& u) const {
        const double reach = bodies_[body].reach;
        return std::sqrt(2 * (u.head<3>().squaredNorm() + reach * reach * u.tail<3>().squaredNorm()));
    }

    double h_ = 0, time_ = 0;
    long steps_ = 0;                   ///< begun since the start
    std::vector<Joint> descriptions_;  ///< of the joints
    std::vector<Coupled> bodies_;
    std::vector<Vector6> base_u_;                       ///< before the correction last made
    double base_lack_ = 0;                              ///< there
    std::vector<Vector6> u_, previous_u_, correction_;  ///< motion over the step, over the one before, last change of it
    std::vector<Vector6> free_momentum_;                ///< P− + h f_loads
    std::vector<double> wrenches_;
    std::vector<BodyState> trial_, half_;  ///< at the end of the step, and half way
    Feedback feedback_;

    JointSystem system_;
    BlockMatrix matrix_;
    BlockFactor factor_;
    Eigen::VectorXd right_hand_side_, solution_;
    std::vector<Stop> stops_;
    JointSystem::SingularPosition singular_;  ///< of the open step
    Passed passed_;
    BlockMatrix instant_matrix_;  ///< M and the joints, of an instant
    BlockFactor instant_factor_;
    bool joints_turn_ = false;  ///< some leave a rotation free
    Instant instant_;
    std::vector<BodyState> start_;  ///< as given
    Eigen::VectorXd instant_rows_, instant_solution_;
    mutable Eigen::VectorXd proximal_rows_;
    Eigen::VectorXd instant_multipliers_;           ///< h q of the instant last found
    std::vector<Eigen::Matrix3d> inverse_moments_;  ///< of inertia, body axes
    std::vector<bool> foreseen_;                    ///< stops that ODE does not see yet
    Eigen::VectorXd multipliers_;                   ///< q in the joints' rows; the others are not looked at
    bool stiffness_wanted_ = true;                  ///< by the next evaluation, which then factors the matrix anew
    std::vector<Group> groups_;
    std::vector<NewtonConvergence> parts_;  ///< of the plugins
    long passes_ = 0, factorisations_ = 0;
    StepReport open_, worst_;  ///< of the open step its counts only
};

}  // namespace dttmm::host
