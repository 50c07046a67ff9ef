// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "coupling/drives.h"
#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/step_equations.h"
#include "model/model.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/inertia.h"
#include "world/joint_system.h"
#include "world/world.h"

namespace dttmm::host {

/// The machine at t_n: what a row of results tells of it. Mass times acceleration is the sum of the forces recorded there.
struct Instant {
    std::vector<BodyState> at;   ///< poses and velocities
    BodyVectors accelerations;   ///< of the centres of mass, linear and angular [m/s², rad/s²]
    BodyVectors joint_wrenches;  ///< of each joint on its first body, [force; moment about the anchor], world axes
};

/// Whether velocities at instants are means over two steps, in all rows or in those of impacts: see InstantSolver::solve.
bool has_mean_velocities(const Model& model);

/// Finds what stands at an instant: velocities as Newmark's rule has them,
///     v_n = v_{n+1/2} − h/2 M⁻¹ (mean wrench over the step),   J v_n = 0,
/// accelerations and joint forces by the balance of that instant, M a + Jᵀ q = f, J a = −C̈.
class InstantSolver {
public:
    explicit InstantSolver(const Model& model);

    /// Initial conditions: starts loads and networks at t0 = step.time with the motion of that instant. Throws ModelError
    /// for velocities that open a joint, Error(numerical_failure) where the joints' equations are singular.
    const Instant& start(const Model& model, const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks,
                         Loads& loads);

    /// The same of a machine at rest where the networks have come to.
    const Instant& start_at_rest(const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks,
                                 const Loads& loads);

    /// What stands at t_n, the start of the step last committed, `step`; then the networks stand there too. now: poses at
    /// t_n, velocities over the step before; after: those over the step. Velocities are the means of those over the two
    /// steps
    ///   - of bodies that joints tie to one that turns: J at t_n would share the turning over half a step between a heavy
    ///     body and one that is stiffly held,
    ///   - with numerical damping: v_n = v_{n+1/2} − h [(1/2 − β) a_n + β a_{n+1}], and a_n depends on v_n by the dampers,
    ///   - in the row of an impact on a stop, with an explicit scheme, and where a plugin does not tell what stands.
    /// In the row of an impact, and for such a plugin, accelerations and joint forces are the means over these steps too,
    /// the impulse of the impact among them. time: t_n [s]. Throws Error(numerical_failure) where the joints' equations are
    /// singular.
    const Instant& solve(double time, const StepEquations& step, const std::vector<BodyState>& now,
                         const std::vector<BodyState>& after, Networks& networks, const Loads& loads);

private:
    void factor(const JointSystem& joints, double time);
    void solve_balance(const JointSystem& joints);
    void find_means(const std::vector<BodyState>& now, const std::vector<BodyState>& after);
    void find_velocities(const std::vector<BodyState>& after, const JointSystem& joints);
    void find_accelerations(const JointSystem& joints);
    void settle_accelerations(const JointSystem& joints, const std::vector<BodyState>& now, Networks& networks,
                              const Loads& loads);
    double norm(const BodyVectors& a) const;
    double norm_of_wrenches() const;
    void find_joint_wrenches(const JointSystem& joints, const BlockMatrix& matrix, const Eigen::VectorXd& impulses);

    std::vector<Inertia> inertias_;
    std::vector<Eigen::Matrix3d> inverse_moments_;  ///< of inertia, body axes
    std::vector<bool> have_means_;                  ///< of velocities in all rows, of every body
    double h_ = 0, start_time_ = 0;
    std::vector<BodyState> start_;  ///< as given
    Instant instant_;
    std::vector<double> wrenches_;              ///< 6 per body
    BodyVectors trial_, residual_, direction_;  ///< of settle_accelerations() [m/s², rad/s²]
    std::vector<double> trial_wrenches_;        ///< at the trial
    BlockMatrix matrix_;                        ///< M and the joints; of a machine without joints none
    BlockFactor factor_;
    Eigen::VectorXd right_hand_side_, proximal_, solution_, impulses_;  ///< impulses_: h q
};

}  // namespace dttmm::host
