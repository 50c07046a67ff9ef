// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "network/elimination.h"
#include "network/mechanism.h"

namespace dttmm {

/// What moves inside a network between its ports: lumps, rigid masses and massless nodes, on the joints between them. For a
/// given motion of the ports over a step it finds its own,
///     P(u) = P− + h (f(x + h u) + weight + loads),     massless: 0 = f + loads,     rigid directions: d(x + h u) = 0,
/// u = [v; ω] of every frame over the step in the frame's own axes at t_n, P = [m v; L(ω)] its momentum, L half way through
/// the step as the host has it, so that momentum and angular momentum are kept to rounding. f is the centred force of the
/// joints: the same recursion as the host's, DT-TMM with A = 1/h², C = γ/h.
///
/// Newton's iteration with the matrix M + h² S of a configuration of before, in the frames' axes, in which it changes with
/// the deformations only, not with the motion of the whole: it is factored once per step size and kept until it converges
/// slowly. Passes start from the extrapolated motion; the solution is accepted when θ/(1 − θ) × (last correction), θ the
/// rate of convergence, is below kShare of the first one, which measures what the step itself leaves out, and below
/// kTolerance of the motion. The forces of the last pass with their linear change then move the momentum, in pairs that
/// balance exactly, so that it is kept however few passes were taken; what the motion lacks to it is made up for in the next
/// step.
///
/// A step is solved once, for ports that go on as they have; the answer to another motion of the ports is the linear one
/// from there, as long as that is good enough by a like measure. A step of small vibrations takes one pass or two.
///
/// A massless frame would ring under weights of three instants, for (z + 1)² makes a double root at −1: where no damper and
/// no rigid direction acts on it, its force balances at the end of every step; otherwise, without numerical damping, half
/// way through every step, which leaves a single root.
class Interior {
public:
    static constexpr double kTolerance = 1e-7;
    static constexpr double kShare = 1e-4;
    static constexpr int kMostPasses = 30;

    /// Throws Error(DTTMM_ERROR_MODEL) naming what cannot move as described: a massless node that nothing holds in some
    /// direction, a rigid direction that is driven from both its ends; or a scheme that is explicit.
    Interior(const Mechanism& mechanism, const dttmm_network& description);

    int node_count() const { return static_cast<int>(inner_nodes_.size()); }

    /// The force law at one instant with the inside at its start: wrenches on the ports, and −∂(wrench)/∂(pose of the ports)
    /// when the inside follows without inertia.
    void linearise(const Mechanism& mechanism, const dttmm_motion* ports, double* wrench, double* stiffness,
                   double* damping) const;

    void start(Mechanism& mechanism, const dttmm_motion* ports, const double* accelerations, const double* loads);
    void begin_step(const Mechanism& mechanism, const double* loads);
    /// Wrenches on the ports over the open step, at a trial end of it.
    void evaluate(const Mechanism& mechanism, const dttmm_motion* trial, double* wrench) const;
    /// −∂(wrench)/∂(pose), 6P × 6P row-major.
    void write_stiffness(const Mechanism& mechanism, double* stiffness) const;
    void commit(Mechanism& mechanism, const dttmm_motion* accepted);

    /// At t_n, the start of the step last committed; a point of a frame in its axes.
    Twist velocity(const Mechanism& mechanism, int frame, const Vector3& offset) const;
    Twist acceleration(const Mechanism& mechanism, int frame, const Vector3& offset) const;
    double kinetic_energy(const Mechanism& mechanism) const;
    double work(const Mechanism& mechanism) const;  ///< of gravity and loads since the start
    /// Force of a joint's rigid directions, joint axes.
    Vector6 rigid_force(const Mechanism& mechanism, size_t joint) const;

    /// Momentum and angular momentum about the world's origin over the step before t_n, of all that is inside.
    Twist momentum(const Mechanism& mechanism) const;

    /// Solutions of the linear equations over all steps so far, and factorisations.
    long passes() const { return passes_; }
    long factorisations() const { return factorisations_; }

    /// Everything that changes from step to step, as pieces of memory; the factor goes with them by refactor().
    void add_state_parts(std::vector<std::pair<void*, size_t>>& parts);
    void refactor(const Mechanism& mechanism);

private:
    /// How the equation of a half of a frame (translation, rotation) stands in time.
    enum class Balance : unsigned char { momentum, end_of_step, half_step, centred };

    struct Inertia {
        double mass;
        Matrix3 moment;  ///< of inertia, frame axes
        double reach;    ///< of its joints from its origin [m], at least its radius of gyration
        Balance balance[2];
        int heir = -1;  ///< frame nearby that takes over what a massless one leaves unbalanced; −1: none
    };
    /// What changes from step to step.
    struct State {
        Vector6 momentum;                 ///< over the step before t_n, world
        Vector6 u, u_before;              ///< over that step and the one before, each in the axes at its start
        Twist velocity, velocity_before;  ///< the same, world
    };
    /// The same of a frame with a node on it, or without a mass: the others take no load.
    struct Burden {
        Vector6 load[3];       ///< at the frame's origin, world, at t_{n+1}, t_n, t_{n−1}
        Vector6 imbalance[2];  ///< of a massless frame, at t_n and t_{n−1}
    };
    struct Books {
        double contraction = 1, scale = 0;  ///< θ/(1 − θ) last measured; size of the motion, slowly forgetting [m/s]
        double port_way = 0;                ///< of the ports from the anchor to where they went in the last step [m/s]
        double load_work = 0, load_power = 0;
    };
    /// A joint at t_n, world axes: what every pass of a step looks at.
    struct JointNow {
        Matrix3 axes;
        Vector3 arm, lever;
    };
    /// The motion inside for one motion of the ports, linear about the last pass: u + change.
    struct Solution {
        std::vector<Frame> ports;      ///< at the end of the step
        std::vector<Vector6> u;        ///< at which the forces were worked out
        std::vector<Vector6> change;   ///< last correction
        std::vector<double> q;         ///< forces of the rigid directions, before the correction
        std::vector<double> q_change;  ///< correction of them, times h
        std::vector<Vector6> wrench;   ///< over the step at u, on every frame at its origin, world
        std::vector<Vector6> left;     ///< what massless frames have passed on to their heirs
        double contraction = 1, scale = 0, rate = 0;
        double tolerance = 0;  ///< of what remains to be corrected [m/s]
    };

    size_t at(int frame) const { return static_cast<size_t>(frame - driven_); }
    bool is_inner(int frame) const { return frame >= driven_; }

    void set_reaches(const Mechanism& mechanism);
    void set_balances(const Mechanism& mechanism);
    void choose_heirs(const Mechanism& mechanism);
    void choose_burdened(const Mechanism& mechanism);
    Burden& burden(size_t frame) { return burdens_[static_cast<size_t>(burden_of_[frame])]; }
    const Burden& burden(size_t frame) const { return burdens_[static_cast<size_t>(burden_of_[frame])]; }
    void assemble(const Mechanism& mechanism);
    void factor(const Mechanism& mechanism, dttmm_status status);
    [[noreturn]] void refuse(const Mechanism& mechanism, const Elimination::Fault& fault, dttmm_status status) const;
    void find_responses(const Mechanism& mechanism);
    Twist start_velocity(int frame, const dttmm_motion* ports) const;
    void settle_at_start(Mechanism& mechanism, const dttmm_motion* ports);
    void find_start_velocities(const Mechanism& mechanism, const dttmm_motion* ports);
    void read_loads(const Mechanism& mechanism, const double* loads);
    void find_imbalances(const Mechanism& mechanism);

    void place(const Mechanism& mechanism, const Solution& solution) const;
    void find_forces(const Mechanism& mechanism, Solution& solution) const;
    void pass_on_imbalances(const Mechanism& mechanism, Solution& solution) const;
    void bequeath(const Mechanism& mechanism, size_t frame, const Vector6& left, Vector6& to_heir) const;
    void settle_estate(const Mechanism& mechanism, size_t frame, const Solution& solution) const;
    void form_residuals(const Mechanism& mechanism, Solution& solution) const;
    static Vector6 load_over_step(const Scheme& scheme, const Burden& burden);
    Vector3 balanced(const Scheme& scheme, size_t frame, int half, const Vector3& momentum, const Solution& solution) const;
    double correct(Solution& solution) const;
    static bool is_good_enough(double correction, const Solution& solution);
    void solve(const Mechanism& mechanism, Solution& solution) const;
    void look_at_joints(const Mechanism& mechanism);
    void drop_anchor(const Mechanism& mechanism);
    const Solution& respond(const Mechanism& mechanism, const dttmm_motion* ports) const;
    Vector6 change_of(int frame, const Solution& solution) const;
    Vector6 force_change(const Mechanism& mechanism, size_t joint, const Twist& from, const Twist& to,
                         const Solution& solution) const;
    void take_momentum(const Mechanism& mechanism, const Solution& solution);
    void take_motion(Mechanism& mechanism, const Solution& solution, const dttmm_motion* accepted);

    Matrix6 mass_matrix(size_t frame) const;
    Matrix6 local_by_from(const Mechanism& mechanism, size_t joint) const;
    Matrix6 local_by_to(const Mechanism& mechanism, size_t joint) const;
    Matrix6 rigid_rows(const Mechanism& mechanism, size_t joint, const Matrix6& G) const;
    Matrix6 gain(const Mechanism& mechanism, size_t joint) const;

    int ports_ = 0, driven_ = 0, count_ = 0;
    Vector3 gravity_;
    std::vector<Inertia> inertias_;
    std::vector<int> inner_nodes_;  ///< nodes of the description that loads and motions go by
    std::vector<dttmm_node> node_data_;
    std::vector<size_t> port_joints_;       ///< of the ports
    std::vector<size_t> port_side_joints_;  ///< whose forces the ports feel
    std::vector<int> port_frames_;          ///< the ports, and massless frames whose heirs they are
    std::vector<bool> half_wanted_;         ///< of each joint: an end of it balances half way
    Elimination elimination_;
    std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> responses_;  ///< ∂u/∂(u of the ports) per inner frame
    Eigen::MatrixXd rigid_responses_;  ///< the same of the forces of rigid directions, times h
    bool halves_wanted_ = false;       ///< some frame balances half way
    bool settles_ = false;             ///< some frame balances at the end of every step

    std::vector<State> state_;
    std::vector<Burden> burdens_;
    std::vector<size_t> burdened_;              ///< the frame of each
    std::vector<int> burden_of_;                ///< and the other way round; −1: none
    std::vector<double> rigid_, rigid_before_;  ///< forces of the rigid directions over the two steps before t_n
    Books books_;

    // Of the open step
    std::vector<JointNow> now_;
    std::vector<Vector6> port_u_, port_u_before_;  ///< of the ports over the two steps before, each in the axes at its start
    std::vector<double> port_reach_;
    Solution anchor_;  ///< where the ports go on as they have

    // Working memory
    mutable Solution other_;
    mutable Eigen::VectorXd port_change_;   ///< from the solution in use to the end of the step asked for, 6 per port, local
    mutable Eigen::VectorXd rigid_change_;  ///< what it changes in the forces of rigid directions, times h
    mutable double port_way_ = 0;           ///< size of it: the largest speed of a point
    mutable std::vector<Frame> trial_;
    mutable std::vector<Vector6> half_wrench_;
    mutable std::vector<Vector6> wrench_;
    std::vector<Twist> world_change_;
    mutable long passes_ = 0;
    long factorisations_ = 0;
};

}  // namespace dttmm
