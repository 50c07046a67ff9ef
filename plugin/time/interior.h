// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/index.h"
#include "mechanism/joints_by_four.h"
#include "mechanism/loading.h"
#include "mechanism/mechanism.h"
#include "mechanism/momentum.h"
#include "solve/elimination.h"
#include "time/interior_layout.h"
#include "time/law_rows.h"
#include "time/massless.h"

namespace dttmm::plugin {

/// What moves inside a network between its ports: lumps, rigid masses and massless nodes, on the joints between them. For a
/// given motion of the ports over a step it finds its own,
///     P(u) = P− + h (f(x + h u) + weight + loads),     massless: 0 = f + loads,     rigid directions: d(x + h u) = 0,
/// u = [v; ω] of every frame over the step in the frame's own axes at t_n, P = [m v; L(ω)] its momentum, L half way through
/// the step as the host has it. f is the centred force of the joints: the same recursion as the host's, DT-TMM with
/// A = 1/h², C = γ/h. A rigid direction has one force over the whole step, in the weighted mean of its axes at the three
/// instants.
///
/// Newton's iteration with the matrix M + h² S, in the frames' axes, in which it changes with the deformations only, not
/// with the motion of the whole: it is factored once per step size and kept until it converges slowly, or joints at ports
/// or rigid directions have turned. Elastic directions enter it where the step ends if all goes on, for only their forces
/// there hang on the motion: by those of t_n, k h²/m times what a hinge turns in a step would be missing across it, and k
/// h²/m is in the thousands where it is stiff. Rigid directions enter it where they are at t_n, in the middle of the three
/// instants.
///
/// The iteration goes on with the host's: an iteration per trial of the ports, from where the last one leads to and with the
/// linear answer to the ports' way since then. The first of a step starts from the extrapolated motion. The host says when
/// it is enough: when what remains of the correction is a small share of the first one and of the motion, and what remains
/// of the momentum of the largest impulse of a joint: a stiff joint makes much of a small motion, and would feed its own
/// vibration with what is left, step after step. The forces where it ends then move the momentum, in pairs that balance
/// exactly, so that it is kept however few iterations were made; what the motion lacks to it is made up for in the next
/// step. The ports are answered linearly from where the forces were worked out.
///
/// What a massless frame leaves unbalanced over a step by its own rule (MasslessFrames) its receiver takes over, a frame
/// nearby with a mass, so that no momentum is lost: force and moment about where the frame is at t_n, in the equations of
/// the motion and in the momentum alike. (Once the momentum had, in place of that, the elastic force on the frame with the
/// lever arms l of its own instants. Under a lasting load P on a node at the end of a beam that force is −P at every
/// instant, so the moment on the last lump was l_n × P in the momentum and (l_{n+1} + 2 l_n + l_{n−1})/4 × P in the motion.
/// With θ the turn of the lump and g = P l its stiffness by the load that is
///     J (θ_{n+1} − 2θ_n + θ_{n−1})/h² = −g (θ_{n+1} + θ_n + 3θ_{n−1} − θ_{n−2})/4
/// in place of (θ_{n+1} + 2θ_n + θ_{n−1})/4: not symmetric in time, a negative damping in proportion to P, and a bar at rest
/// under a pull began to swing.)
class Interior {
public:
    /// Throws Error(DTTMM_ERROR_MODEL) naming what cannot move as described: a massless node that nothing holds in some
    /// direction, a rigid direction that is driven from both its ends; or a scheme that is explicit.
    Interior(const Mechanism& mechanism, const dttmm_network& description, Loading loading);

    /// The force law at one instant with the inside at its start: wrenches on the ports, and −∂(wrench)/∂(pose of the ports)
    /// when the inside follows without inertia.
    /// Wrenches are added, 6 per body; stiffness: 6P × 6P row-major.
    void linearise(const Mechanism& mechanism, Ports ports, double* wrench, double* stiffness) const;
    /// Adds to the small motions of the ports from the start, 6 per frame, world axes, those of the inside, which follows
    /// without inertia.
    void follow(const Mechanism& mechanism, std::span<Vector6> motion) const;

    /// Throws Error(DTTMM_ERROR_MODEL) naming a node whose given velocity rigid directions, or other nodes on its rigid
    /// body, forbid.
    void start(Mechanism& mechanism, Ports ports, const double* accelerations, const double* loads,
               const std::vector<Frame>* at_rest = nullptr);
    /// loads: NULL: none. Forms the matrix anew where the last step has left it stale; throws Error, nothing being changed,
    /// if that is singular or a rotational spring has turned too far.
    void begin_step(const Mechanism& mechanism, const double* loads);
    /// One iteration for ports that end the open step where they are given. Throws Error(DTTMM_ERROR_NUMERIC) where the
    /// motion is no number; then it is where begin_step has left it.
    void iterate(const Mechanism& mechanism, Ports ports, dttmm_progress& progress);
    /// Finds the wrenches on the ports over the open step, at a trial end of it near the last of iterate(). Throws
    /// Error(DTTMM_ERROR_PHASE) if there was none.
    void evaluate(const Mechanism& mechanism, Ports ports) const;
    const Vector6& wrench(int port) const { return work_.wrench[as_size(port)]; }
    /// −∂(wrench)/∂(pose), 6P × 6P row-major.
    void write_stiffness(const Mechanism& mechanism, double* stiffness) const;
    /// Throws Error(DTTMM_ERROR_NUMERIC), nothing being changed, naming what is farther or faster than the host has its
    /// bodies, or turns more than half a turn over the step.
    void commit(Mechanism& mechanism, Ports ports);

    // At t_n, the start of the step last committed, in this order:
    /// Velocities of frames with mass: Newmark's, those over the step less half of what its mean wrenches (of the joints, on
    /// all frames) add per step. The others have the mean of those over the two steps.
    void find_velocities(const Mechanism& mechanism, std::span<const Vector6> mean_wrenches);
    /// Velocities of massless frames where dampers act, and the forces of rigid directions on massless frames: by the
    /// balance of the instant. rate(j): of the joints' deformations, as known.
    template <class Rate>
    void find_massless_velocities(const Mechanism& mechanism, const Rate& rate) {
        std::fill(instant_.corrections.begin(), instant_.corrections.end(), Twist{});
        if (!massless_.has_balances()) return;
        massless_.find_instant(
            mechanism, mechanism.scheme.step_size(), mechanism.before,
            [&](size_t j) {
                const JointState& state = mechanism.states[j];
                return MasslessFrames::Acting{
                    state.deformation_before(), rate(j),
                    mechanism.joints[j].elastic(state.deformation_before(), mechanism.memory_before(j))};
            },
            [&](size_t i) { return frame_load(i).load[2]; }, instant_.velocities, instant_.corrections, instant_.rigid);
    }
    /// What that has added to the velocity of a frame's origin, world.
    Twist correction(int frame) const {
        return is_inner(frame) && !instant_.corrections.empty() ? instant_.corrections[at(frame)] : Twist{};
    }
    /// Whether nothing of mass (half 0) or inertia (1) is in a frame.
    bool is_massless(int frame, int half) const { return is_inner(frame) && massless_.is_massless(at(frame), half); }
    /// Of a port at that instant, linear and angular; at the start what the host knows there.
    void set_port_acceleration(int port, const double* a) {
        instant_.of_ports[as_size(port)] = {Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    }
    bool has_rigid_directions() const { return matrix_.factor.rigid_count() > 0; }
    /// Forces of rigid directions over a step say nothing exact of an instant. At the start of a run balance_rigid() finds
    /// those of the instant, with the accelerations of all masses inside at once:
    ///     M a + Jᵀ q = f,   J a = −C̈         C̈: second rates of the rigid directions at constant velocities
    /// The ports have the accelerations set. wrenches: of the joints, with the forces q known so far.
    bool is_to_balance_rigid(const Mechanism& mechanism) const { return mechanism.steps == 1 && first_balance_.has_value(); }
    template <class Velocity>
    void balance_rigid(const Mechanism& mechanism, std::span<const Vector6> wrenches, const Velocity& velocity) {
        find_accelerations(mechanism, wrenches);
        for (size_t j : layout_.rigid_joints)
            set_opening(mechanism, j, velocity(mechanism.joints[j].from()), velocity(mechanism.joints[j].to()));
        solve_first_balance();
    }
    /// Forms the matrix of that balance. Allocates.
    void form_first_balance(const Mechanism& mechanism);
    /// Accelerations: of frames with mass by the wrenches of the joints at that instant, of massless ones by the velocities
    /// over the steps around it. At the start there is one step only: there those that dampers or rigid directions act on
    /// have the accelerations that keep their forces in balance and rigid directions closed. velocity(frame), force(joint):
    /// at that instant, the force in the joint's axes.
    template <class Velocity, class Force>
    void find_accelerations(const Mechanism& mechanism, std::span<const Vector6> wrenches, const Velocity& velocity,
                            const Force& force) {
        find_accelerations(mechanism, wrenches);
        if (mechanism.steps > 1 || !massless_.has_balances()) return;
        take_load_rates(mechanism);
        const auto ends = [&](size_t j) {
            return std::pair{velocity(mechanism.joints[j].from()), velocity(mechanism.joints[j].to())};
        };
        for (size_t j = 0; j < mechanism.joints.size(); ++j) {
            const auto [from, to] = ends(j);
            add_arm_rates(mechanism, j, from, to, force(j));
        }
        massless_.find_instant(
            mechanism, mechanism.scheme.step_size(), mechanism.before,
            [&](size_t j) {
                const auto [from, to] = ends(j);
                return rate_of_force(mechanism, j, from, to, force(j));
            },
            [&](size_t i) { return instant_.wrench_rates[i]; }, instant_.accelerations, instant_.corrections,
            instant_.rigid_rates);
    }
    /// Force of a joint's rigid directions at that instant, its axes.
    Vector6 rigid_force_at_start(const Mechanism& mechanism, size_t joint) const;
    /// Of a frame's origin, world.
    Twist velocity(int frame) const { return is_inner(frame) ? instant_.velocities[at(frame)] : Twist{}; }
    /// A point of a frame in its axes.
    Twist velocity(const Mechanism& mechanism, int frame, const Vector3& offset) const;
    Twist acceleration(const Mechanism& mechanism, int frame, const Vector3& offset) const;
    double kinetic_energy(const Mechanism& mechanism) const;
    double work(const Mechanism& mechanism) const;  ///< of gravity and loads since the start
    /// Force of a joint's rigid directions over the step last committed, its axes [force; moment].
    Vector6 rigid_force(const Mechanism& mechanism, size_t joint) const;

    /// Momentum and angular momentum about the world's origin of all that is inside, over the step before t_n.
    Twist momentum(const Mechanism& mechanism) const;
    /// The same as Newmark's rule keeps it: at t_n, of y = x − β h² F/m in place of x (Kane et al. 2000, Int. J. Numer.
    /// Meth. Eng. 49, 1295–1325). It differs by a part of order h² that does not grow. For networks without dampers.
    Twist newmark_momentum(const Mechanism& mechanism) const;

    /// Solutions of the linear equations over all steps so far, and factorisations.
    long passes() const { return work_.passes; }
    long factorisations() const { return work_.factorisations; }

    /// Shows the memory of what changes from step to step, piece by piece, as spans; self: an Interior, constant or not. The
    /// factor goes with it by refactor(), for the step to come.
    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit) {
        visit(std::span(self.past_.u));
        visit(std::span(self.past_.u_before));
        visit(std::span(self.past_.velocity));
        visit(std::span(self.past_.velocity_before));
        visit(std::span(self.momenta_));
        visit(std::span(self.frame_loads_));
        visit(std::span(self.rigid_));
        visit(std::span(self.port_u_));
        visit(std::span(self.port_u_before_));
        visit(std::span(self.instant_.of_ports));
        visit(std::span(&self.record_, 1));
    }
    void refactor(const Mechanism& mechanism);

private:
    void find_accelerations(const Mechanism& mechanism, std::span<const Vector6> wrenches);
    void set_opening(const Mechanism& mechanism, size_t joint, const Twist& from, const Twist& to);
    void solve_first_balance();
    std::vector<Vector6> lend_masses(const Mechanism& mechanism) const;
    Vector6 acceleration_of_deformation(const Mechanism& mechanism, size_t joint, const Twist& from, const Twist& to) const;
    void take_load_rates(const Mechanism& mechanism);
    void add_arm_rates(const Mechanism& mechanism, size_t joint, const Twist& from, const Twist& to, const Vector6& f);
    MasslessFrames::Acting rate_of_force(const Mechanism& mechanism, size_t joint, const Twist& from_velocity,
                                         const Twist& to_velocity, const Vector6& f) const;
    /// What changes from step to step for a frame that a load may act on, or with a massless half: the others take no load.
    struct FrameLoad {
        Vector6 load[3];     ///< at the frame's origin, world, at t_{n+1} once the step is taken, t_n, t_{n−1}
        Vector6 elastic[3];  ///< elastic forces on a massless frame, the same
        Vector6 settled;     ///< ψ of MasslessFrames at t_n, axes of the frame
        FrameLoad() {
            for (Vector6* list : {load, elastic}) std::fill_n(list, 3, Vector6::Zero());
            settled.setZero();
        }
    };
    struct Record {
        static constexpr bool kStaysOwn = true;  ///< see centring.h
        double port_turn = 0;  ///< of joints at ports in the last step, since the matrix was formed, as share of their arms
        double scale = 0;      ///< size of the motion, slowly forgetting [m/s]
        double load_work = 0;  ///< of the loads up to t_{n−1} [J]
        double last_work = 0;  ///< over the step from there to t_n [J]
        double is_slow = 0;    ///< 1: some step was slow; laws are found together from then on
    };
    /// The motion inside for one motion of the ports, linear about the last pass: u + change.
    struct Solution {
        std::vector<Frame> ports;      ///< at the end of the step
        std::vector<Vector6> u;        ///< of the inner frames, at which the forces were worked out [m/s, rad/s]
        std::vector<Vector6> change;   ///< last correction of it
        std::vector<double> q;         ///< forces of the rigid directions, before the correction [N, N m]
        std::vector<double> q_change;  ///< correction of them, times h
        std::vector<double> laws;      ///< ψ of the last correction
        std::vector<JointForce> near;  ///< forces of layout_.near_joints over the step, before the correction
        double scale = 0;              ///< as in Record
        double correction = 0;         ///< size of the last one [m/s]; 0: there was none
        double rate = 0;               ///< of the last two
        double impulse = 0;            ///< of a joint over the step [N s]
        double floor = 0;              ///< corrections below are rounding [m/s]
    };

    size_t at(int frame) const { return layout_.at(frame); }
    bool is_inner(int frame) const { return layout_.is_inner(frame); }

    void choose_lanes(const Mechanism& mechanism);
    void make_room();
    void make_room_for_steps(const Mechanism& mechanism);
    FrameLoad& frame_load(size_t frame) { return frame_loads_[as_size(layout_.load_of[frame])]; }
    const FrameLoad& frame_load(size_t frame) const { return frame_loads_[as_size(layout_.load_of[frame])]; }
    void assemble(const Mechanism& mechanism, const std::vector<Frame>& at);
    void make_heavier(Elimination& matrix) const;
    void factor(const Mechanism& mechanism, Elimination& matrix, dttmm_status status) const;
    void find_responses(const Mechanism& mechanism);
    /// How a network begins: where all frames are, and their velocities.
    struct Start {
        std::vector<Frame> frames;
        std::vector<Twist> velocities;
    };
    /// Springs, dampers and masses under slow motions of the ports, factored; and what couples the ports to the inside.
    struct Slow {
        const std::vector<Frame>& frames;
        Elimination matrix;
        std::vector<EndBlocks> at_ports;  ///< of layout_.port_joints
    };
    void form_dynamic_stiffness(const Mechanism& mechanism, const std::vector<Frame>& at, double rate,
                                Elimination& matrix) const;
    EndBlocks dynamic_stiffness(const Mechanism& mechanism, size_t joint, const std::vector<Frame>& at, double rate) const;
    static Ends ends(const Joint& joint, const std::vector<Frame>& at) {
        return {at[as_size(joint.from())], at[as_size(joint.to())]};
    }
    template <class Hold>
    Slow form_slow(const Mechanism& mechanism, const std::vector<Frame>& frames, const Hold& hold) const;
    void follow(const Mechanism& mechanism, const Slow& slow, std::span<Vector6> motion, std::span<double> q) const;
    JointForce start_force(const Mechanism& mechanism, size_t joint, const Start& start) const;
    Start place_at_start(const Mechanism& mechanism, Ports ports) const;
    static std::vector<Frame> frames_at_start(const Mechanism& mechanism);
    std::vector<Twist> start_inertias(const Mechanism& mechanism, std::span<const Vector6> wrench);
    void balance_at_start(const Mechanism& mechanism, double h, Start& start) const;
    void refuse_forbidden_velocities(const Mechanism& mechanism, const Start& start) const;
    void read_loads(const double* loads);
    void set_elastic(const Mechanism& mechanism);

    void place(const Mechanism& mechanism, std::span<const Vector6> u) const;
    void place(const Mechanism& mechanism, size_t frame, const Vector6& u) const;
    JointForce rigid_action(const Mechanism& mechanism, size_t joint, const JointPose& at_end, const Vector3& theta,
                            const Vector6& q) const;
    JointForce force_over_step(const Mechanism& mechanism, size_t joint, const JointPose& at_end,
                               const Joint::Strained& end) const;
    void find_forces(const Mechanism& mechanism, Solution& solution) const;
    Vector6 load_at_end(size_t loaded, FrameView frame) const;
    Vector6 load_over_step(const Scheme& scheme, size_t loaded, FrameView frame) const;
    void form_residuals(const Mechanism& mechanism, Solution& solution) const;
    void balance_massless(const Mechanism& mechanism, Solution& solution) const;
    Vector6 settled(const Mechanism& mechanism, size_t massless, const Vector6& load) const;
    Vector6 passed_on(const std::vector<Frame>& frames, size_t frame, const Vector6& left) const;
    double correct(const Mechanism& mechanism, Solution& solution) const;
    double speed_of_port_change() const;
    Vector3 mean_velocity(const Mechanism& mechanism, const Solution& solution) const;
    void take_measures(const Mechanism& mechanism, Solution& solution) const;
    void pass(const Mechanism& mechanism, dttmm_progress& progress);
    int fastest_element(const Mechanism& mechanism, std::span<const Vector6> u) const;
    void refuse_unstarted() const;
    void look_at_joints(const Mechanism& mechanism);
    void form_matrix(const Mechanism& mechanism, const std::vector<Frame>& at);
    void find_stiffest();
    void take_factor(const Mechanism& mechanism, const std::vector<Frame>& at);
    void hold_given(const Mechanism& mechanism, const Start& start, Elimination& matrix, std::vector<Vector6>& load) const;
    void predict(const Mechanism& mechanism);
    void open_solution(const Mechanism& mechanism);
    void take_port_change(const Mechanism& mechanism, Ports ports) const;
    void go_on(const Mechanism& mechanism, Ports ports);
    /// The motion of all inner frames over the step, with the linear answer to the ports.
    void find_motion(const Solution& solution, std::span<Vector6> motion) const;
    Vector6 motion_of(size_t frame, const Solution& solution) const;
    Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic>> response(size_t frame) const {
        return {&matrix_.responses[frame * 36 * as_size(layout_.ports)], 6, 6 * layout_.ports};
    }
    Vector6 change_of(int frame, const Solution& solution) const;
    JointForce near_force(const Mechanism& mechanism, size_t near, const Solution& solution) const;
    void find_rigid_forces(const Mechanism& mechanism, const Solution& solution) const;
    Vector6 massless_part(size_t frame, Vector6 wrench) const;
    Vector6 estate(const Mechanism& mechanism, size_t frame, FrameView end) const;
    bool rigid_directions_have_turned(const Mechanism& mechanism) const;
    double turn_at_ports(const Mechanism& mechanism) const;
    void find_end(const Mechanism& mechanism, const Solution& solution) const;
    [[noreturn]] void refuse_divergence(const Mechanism& mechanism, size_t frame) const;
    void take_forces(Mechanism& mechanism, const Solution& solution);
    void take_momenta(const Mechanism& mechanism);
    void take_loads(const Mechanism& mechanism);
    void take_motion(Mechanism& mechanism);

    Matrix6 mass_matrix(size_t frame) const;
    /// Index of rigid direction number i of a joint among those of all.
    size_t rigid_row(size_t joint, int i) const { return as_size(matrix_.factor.rigid_begin(as_int(joint)) + i); }
    Vector6 rigid_values(const Mechanism& mechanism, size_t joint, const std::vector<double>& q) const;
    struct Blocks {
        EndBlocks own, acting;
        Matrix6 between(int row, int column) const { return own.at[row][column] + acting.at[row][column]; }
    };
    Blocks blocks(const Mechanism& mechanism, size_t joint, const std::vector<Frame>& at) const;
    Blocks blocks(const Mechanism& mechanism, size_t joint, Ends at, const JointPose& pose, const Vector6& deformation,
                  Vector3 acting, const std::vector<double>& q) const;
    void add_joint(const Mechanism& mechanism, size_t index, const Blocks& blocks);
    void set_rigid_rows(const Mechanism& mechanism, size_t joint, const JointPose& pose, const Vector3& theta,
                        Elimination& matrix) const;
    void set_rigid_rows(const Mechanism& mechanism, size_t joint, const std::vector<Frame>& at, Elimination& matrix) const;
    void form_at_trial(const Mechanism& mechanism);

    struct Columns {
        Matrix6 at[2];
    };
    /// The matrix M + h² S and what follows from it.
    struct Matrix {
        explicit Matrix(Elimination elimination) : factor(std::move(elimination)) {}
        Elimination factor;
        std::vector<double> responses;       ///< ∂u/∂(u of the ports) of every inner frame
        Eigen::MatrixXd rigid_responses;     ///< the same of the forces of rigid directions, times h
        std::vector<EndBlocks> near_blocks;  ///< stiffness of the near joints as in the matrix, frames' axes
        std::vector<Columns> near_columns;   ///< of their deformation by either frame, when it was formed
        double stiffest = 0;                 ///< what it has most of against the shift of a frame [kg]
        bool is_stale = false;               ///< it no longer serves
        bool is_fresh = false;               ///< it was formed for the open step
        bool is_own = false;                 ///< it was formed within the open step
    };
    /// At the start of the step last committed, world.
    struct Instant {
        std::vector<Twist> velocities, accelerations;
        std::vector<Twist> corrections;  ///< empty where there is no massless frame; so is wrench_rates
        std::vector<double> rigid;       ///< forces of the rigid directions then
        // For accelerations at the start of a run:
        std::vector<Twist> of_ports;        ///< their accelerations
        std::vector<Vector6> wrench_rates;  ///< on the inner frames, known ones
        std::vector<double> rigid_rates;    ///< of forces of rigid directions
    };
    /// Masses and rigid directions at the start of a run.
    struct FirstBalance {
        Elimination matrix;
        std::vector<Vector6> lent;  ///< diagonal that stands for the inertia of massless halves, zero in the others
    };
    struct OpenStep {
        std::vector<RigidMap> rigid_known;  ///< of the rigid joints: what the two instants before the end contribute
        std::vector<double> loads;          ///< their values at the end of the step
        double size = 0;                    ///< of the network and its way from the world's origin, at t_n [m]
        Solution solution;                  ///< of the last iteration; before that where everything goes on as it has
        bool is_begun = false;              ///< there was an iteration
    };
    /// Working memory.
    struct Work {
        explicit Work(LawRows law_rows) : laws(std::move(law_rows)) {}
        LawRows laws;
        std::vector<double> column_q;  ///< of a unit load or motion
        Eigen::VectorXd port_change;   ///< from the solution in use to the end of the step asked for, 6 per port, local
        Eigen::VectorXd rigid_change;  ///< what it changes in the forces of rigid directions, times h
        std::vector<Frame> trial;
        /// Of the inner frames: over the step that is committed, each in its axes at t_n. Before that of a unit load or
        /// motion.
        std::vector<Vector6> motion;
        std::vector<Vector6> wrench;                      ///< over the step, on every frame at its origin at t_n, world
        std::vector<Vector6> end_wrench, damping_wrench;  ///< on the massless frames at the end, and half way
        std::vector<MasslessFrames::Residual> massless_residuals;
        std::vector<double> q;
        long passes = 0;
        long factorisations = 0;
    };

    MasslessFrames massless_;
    Loading loading_;
    InteriorLayout layout_;
    JointsByFour by_four_;        ///< joints that are neither near nor rigid nor settling
    std::vector<size_t> others_;  ///< all joints it does not take, ascending
    Matrix matrix_;

    // From step to step
    PastMotion past_;
    std::vector<Vector6> momenta_;  ///< over the step before t_n, world
    std::vector<FrameLoad> frame_loads_;
    std::vector<double> rigid_;                    ///< forces of the rigid directions over the step before t_n
    std::vector<Vector6> port_u_, port_u_before_;  ///< of the ports over the two steps before, world [m/s, rad/s]
    Record record_;

    Instant instant_;
    std::optional<FirstBalance> first_balance_;  ///< up to the first row; none where nothing is rigid
    OpenStep open_;
    mutable Work work_;  ///< mutable: to the host evaluate() changes nothing, and it does not allocate
};

}  // namespace dttmm::plugin
