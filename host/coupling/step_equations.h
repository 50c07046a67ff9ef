// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "coupling/networks.h"
#include "model/model.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/body_state.h"
#include "world/inertia.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// The equations of motion of all bodies over a step, and one Newton iterate of their solution. ODE moves a free body by
/// v+ = v + h M⁻¹ f,  x+ = x + h v+. Its momentum over the step, P = [m v; L(ω)], therefore obeys
///     P(u) = P− + h (f_loads + f_networks(x + h u)),     u = [v; ω] over the step, 6 per body,
/// where L(ω) = R_{n+1/2} J R_{n+1/2}ᵀ ω is the angular momentum half way through the step: the centred gyroscopic moment,
/// which keeps the angular momentum of a free body to rounding. Simplified Newton iteration with the matrix
///     K = M + h² S,     S: stiffness of the networks seen from the centres of mass,
/// symmetric (the gyroscopic part of ∂P/∂u and the little asymmetry of S away from rest are left to the iteration), sparse.
/// It is kept. For a body that is coupled with no other, and as stiff in all directions of translation, it turns with the
/// body: Q K Qᵀ, Q the rotation since it was formed. Inertia and springs to the ground that are equally stiff in all
/// directions turn in the same way.
/// Bodies on ideal joints also obey, with the multipliers q and the directions J of t_n (see JointSystem),
///     P(u) + Jᵀ q = P− + h f,   C(x + h u) = 0,      matrix | K   Jᵀ |
///                                                           | J  −E  |
/// `now`: poses at t_n, velocities over the step before. Wrenches: 6 per body, those of the networks over the step.
class StepEquations {
public:
    StepEquations(const Model& model, const Networks& networks);

    void start(double h) { h_ = h; }
    /// Opens a step with the wrenches of the loads over it.
    void begin_step(const std::vector<BodyState>& now, const std::vector<double>& loads);

    /// After begin_step(), where a stop was reached within the step before: what its impulses lack there. before: u over the
    /// step before that, stops: those of the step before.
    void follow_impact(const std::vector<BodyState>& now, const BodyVectors& before, const std::vector<Stop>& stops);

    /// The iterate: u, its last correction, and the impulses q [N s, N m s] in the joints' rows of matrix().
    BodyVectors& u() { return u_; }
    const BodyVectors& u() const { return u_; }
    const BodyVectors& correction() const { return correction_; }
    Eigen::VectorXd& impulses() { return impulses_; }
    const Eigen::VectorXd& impulses() const { return impulses_; }
    double h() const { return h_; }
    /// The largest linear momentum of a body that lacked before the last correction [N s].
    double lack() const { return std::sqrt(lack_); }
    JointSystem& joint_system() { return joints_; }
    const JointSystem& joint_system() const { return joints_; }
    const BlockMatrix& matrix() const { return matrix_; }
    const BlockFactor& factor() const { return factor_; }

    /// The bodies after a part t [s] of the step with the velocities u.
    void move(const std::vector<BodyState>& now, double t, std::vector<BodyState>& to) const;
    /// Forms the matrix anew: h² S, block by block, then inertia and joints. False when it is singular.
    void set_zero() { matrix_.set_zero(); }
    void add_stiffness(int row_body, int column_body, const BlockMatrix::Block& S);
    bool factor_with_inertia(const std::vector<BodyState>& now);
    /// Of the last matrix: what stiffness has of it in a direction of the body, h² S/(h² S + M), at most; 1 before the
    /// first.
    double stiffness_share(size_t body) const { return stiffness_shares_[body]; }
    /// The body whose stiffness takes most from its inertia.
    size_t least_held(const std::vector<BodyState>& now) const;

    /// One correction K⁻¹ (P− + h f − P(u)) of u; with joints, likewise of u and q. end: the bodies at the end of the step.
    void correct(const std::vector<BodyState>& now, const std::vector<BodyState>& end, const std::vector<double>& wrenches);
    /// Residual r of the equations of motion at u with the present impulses q, as ½ rᵀ M⁻¹ r [J]. Call it for the old u
    /// after correct(): q then belongs to the whole correction.
    double residual(const std::vector<BodyState>& now, const BodyVectors& u, const std::vector<double>& wrenches);
    /// What makes ODE move the bodies by u; its joints add their own impulses, which have no stops.
    void write_feedback(const std::vector<BodyState>& now, BodyVectors& feedback);

    // Stops over the step whose motion has been found; end: poses at its end, velocities over it.
    /// Where coordinates were a step before the start, at the speeds of the start: `start` of the stops.
    void place_before_start(const std::vector<BodyState>& at, std::vector<Stop>& stops) const;
    /// Lets go the stops that pull; true if there are any.
    bool release_pulling_stops(std::vector<Stop>& stops) const {
        return joints_.release_pulling_stops(matrix_, impulses_, stops);
    }
    // before: those of the step before. A stop takes the speed at the instant at which it is reached. From then on the
    // forces act, and the machine leaves with the speed that they have made.
    /// Adds the first stop that the motion runs through, of those `reached` at t_n or within the step, so that it ends
    /// there; true if there is one.
    bool add_first_stop(const std::vector<BodyState>& end, const std::vector<Stop>& reached, const std::vector<Stop>& before,
                        std::vector<Stop>& stops) const;
    /// Has the machine leave, over two steps, stops that were reached within the step before, do not act yet, and from which
    /// it is drawn off; true if there are any.
    bool leave_stops(const std::vector<BodyState>& end, const std::vector<Stop>& before, std::vector<Stop>& stops) const;
    /// Whether a stop changes the speed of its coordinate over the step: it has not been at rest on it.
    bool has_impact() const;
    /// Work of the stops at t_n on the bodies [J]: a stop takes speed and gives none back. Positive by round-off, and by
    /// order h² where a stop that was just reached is left.
    double stop_work(const std::vector<BodyState>& now, const std::vector<BodyState>& end) const {
        return coordinate_work(now, end, &JointEquations::has_stops);
    }
    /// Work of the motors at t_n on the bodies [J].
    double drive_work(const std::vector<BodyState>& now, const std::vector<BodyState>& end) const {
        return coordinate_work(now, end, &JointEquations::is_driven);
    }

private:
    /// Rotation of a body since the matrix was formed.
    struct Turn {
        bool is_alone = true;                                 ///< coupled with no other body
        bool is_followed = true;                              ///< by the matrix
        Eigen::Matrix3d then = Eigen::Matrix3d::Identity();   ///< rotation of the body when it was formed
        Eigen::Matrix3d since = Eigen::Matrix3d::Identity();  ///< Q; the identity of a body that is not followed
    };
    int stop_index(size_t joint) const;  ///< of the equation of its stop or motor
    double coordinate_work(const std::vector<BodyState>& now, const std::vector<BodyState>& end,
                           bool (JointEquations::*counts)() const) const;
    using Momentum = Eigen::Matrix<double, 6, 1>;
    Momentum residual_of(size_t body, const BodyState& now, const Momentum& u, const std::vector<double>& wrenches) const;

    double h_ = 0, lack_ = 0;  ///< lack_: squared
    std::vector<Inertia> inertias_;
    BodyVectors free_momentum_;  ///< P− + h f_loads
    BodyVectors u_, correction_;
    JointSystem joints_;
    BlockMatrix matrix_;
    BlockFactor factor_;
    std::vector<BodyState> struck_at_;      ///< of follow_impact()
    std::vector<double> stiffness_shares_;  ///< per body
    std::vector<Turn> turns_;               ///< per body
    Eigen::VectorXd impulses_, right_hand_side_, solution_;
};

}  // namespace dttmm::host
