// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "model/model.h"
#include "world/block_matrix.h"
#include "world/body_state.h"
#include "world/joint_equations.h"

namespace dttmm::host {

/// The stop of a hinge or slider over a step. Within kPlay of it, more than rounding, the stop counts as reached. While it
/// acts it keeps the coordinate there. It pushes in one direction only.
struct Stop {
    static constexpr double kPlay = 1e-12;  ///< [rad, m]
    double before = 0, start = 0;           ///< the coordinate at t_{n−1} and at t_n [rad, m]
    bool acts = false;
    double end = 0;            ///< where one that acts brings the coordinate by t_{n+1} [rad, m]
    int side = 0;              ///< 1: the lower stop, which pushes the coordinate up; −1: the upper
    bool is_foreseen = false;  ///< reached within the step, or left in it
    double share = 0;          ///< of the step after which a foreseen one is reached
    double arrival = 0;        ///< how far the coordinate would have gone over the step in which it came [rad, m]
    double gain = 0;           ///< and how much farther than over the step before
    int leaving_step = 0;      ///< the machine leaves it, as many steps after that in which it was reached; 0: it does not

    /// Reached within this step.
    bool is_struck() const { return acts && is_foreseen && leaving_step == 0; }
    void let_go() { *this = {before, start}; }
};

/// What a motor asks of the coordinate of its joint [rad, m] around a step from t_n to t_{n+1}.
struct Drive {
    double end = 0;           ///< at t_{n+1}
    double speed = 0;         ///< mean over the step
    double rate = 0;          ///< speed at t_n
    double acceleration = 0;  ///< at t_n
};

/// Equations of joints that do not hold over a step, a bit each, one number per joint; empty: all hold.
using LetGo = std::vector<unsigned>;

/// All ideal joints of a model, linearised at t_n, as rows of a BlockMatrix. Over the step they act by impulses −Jᵀ q along
/// the directions of t_n, such that the joints are closed at its end:
///     P(u) + Jᵀ q = (momentum without joints),     C(x_n + h u) = 0,     coordinate = that of its stop, where one acts.
/// This is the SHAKE form of the leap-frog scheme: second order, reversible in time, no drift of the joints.
/// Source: Ryckaert, Ciccotti and Berendsen (1977), J. Comput. Phys. 23, 327–341.
///
/// Joints may be redundant (the four of a plane linkage are): what they share is then settled by a small E in the matrix,
/// which is proximal, i.e. multiplies the change of q only, so that it costs passes but no accuracy.
class JointSystem {
public:
    /// E of an equation over its mobility J K⁻¹ Jᵀ: a pass leaves this part of an error, and rounding feigns forces in
    /// redundant joints as its inverse.
    static constexpr double kProximal = 1e-7;
    /// Share that tighten() leaves of E, twice at most; a step later it is as much larger again.
    static constexpr double kTighter = 1e-3;

    /// E of an equation over its mobility now.
    double proximal() const { return proximal_; }
    /// Makes E smaller from now on, where passes gain too little: very unequal masses in one chain.
    void tighten() { proximal_ = std::max(kTighter * proximal_, kTighter * kTighter * kProximal); }

    JointSystem(const std::vector<Body>& bodies, const std::vector<Joint>& joints);

    bool empty() const { return joints_.empty(); }
    const std::vector<JointEquations>& joints() const { return joints_; }
    bool has_stops() const { return std::ranges::any_of(joints_, &JointEquations::has_stops); }
    /// What motors ask for from now on, one per joint; all zero before.
    void drive(const std::vector<Drive>& drives) { drives_ = drives; }
    const std::vector<Drive>& drives() const { return drives_; }
    /// As last linearised, one per joint.
    const std::vector<Stop>& stops() const { return stops_; }
    /// From the centre of mass of a body to the farthest of its anchors [m]; 0 without joints.
    double longest_arm(int body) const;
    /// For the pattern of a BlockMatrix.
    std::vector<BlockMatrix::JointNode> nodes() const;

    /// Takes J at t_n, for impulses, and at `by`, for the matrix. `stops`: one per joint; `let_go`: equations that do not
    /// hold over the step. What tighten() has done wears off from step to step.
    void linearise(const std::vector<BodyState>& now, const std::vector<BodyState>& by, const std::vector<Stop>& stops,
                   const LetGo& let_go = {});
    /// Writes J of the matrix and E; E is measured by the bodies' own blocks K, which are to be complete.
    void write_to(BlockMatrix& matrix) const { write(matrix_jacobians_, matrix); }
    /// The same with J at t_n.
    void write_start_to(BlockMatrix& matrix) const { write(jacobians_, matrix); }

    /// Rate at which a joint's coordinate moves with the velocities of `end` [rad/s, m/s]; of one that a stop or a motor
    /// keeps.
    double coordinate_speed(size_t joint, const std::vector<BodyState>& end) const;

    /// Writes −C(end)/h [m/s, rad/s], likewise of stops, into the joints' rows of a right-hand side. `end`: poses at the end
    /// of the step.
    void write_openings(const BlockMatrix& matrix, const std::vector<BodyState>& end, double h, Eigen::VectorXd& rows) const;
    /// Writes J (u' − u) for velocities u' of `wanted` and u of `end`.
    void write_speeds(const BlockMatrix& matrix, const std::vector<BodyState>& end, const std::vector<BodyState>& wanted,
                      Eigen::VectorXd& rows) const;
    /// Writes −C̈ of bodies that keep their velocities, motors included: the right-hand side for accelerations.
    void write_curvatures(const BlockMatrix& matrix, const std::vector<BodyState>& at, Eigen::VectorXd& rows) const;
    /// Adds −Jᵀ q to the bodies' rows; q: the joints' rows of `multipliers`.
    void add_impulses(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers, Eigen::VectorXd& rows) const;
    /// The impulse −Jᵀ q of one joint on its body on that side.
    Eigen::Matrix<double, 6, 1> impulse(size_t joint, JointEquations::Side side, const double* q) const;

    // Of stops, one per joint:
    /// Those reached at t_n. before: those of the step before.
    void find_stops(const std::vector<BodyState>& now, const std::vector<Stop>& before, std::vector<Stop>& stops) const;
    /// Lets go those whose multipliers pull, the joints' rows of `multipliers`; true if there are any.
    bool release_pulling_stops(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers,
                               std::vector<Stop>& stops) const;

    /// Largest speed at which a joint opens at the instant `at` [m/s, rad/s].
    double opening_speed(size_t joint, const std::vector<BodyState>& at) const;

private:
    bool is_idle(size_t joint, int row) const;
    void write(const std::vector<JointEquations::Jacobian>& jacobians, BlockMatrix& matrix) const;

    double proximal_ = kProximal;
    std::vector<JointEquations> joints_;
    std::vector<JointEquations::Jacobian> jacobians_, matrix_jacobians_;
    std::vector<Stop> stops_;
    std::vector<Drive> drives_;
    LetGo let_go_;
};

}  // namespace dttmm::host
