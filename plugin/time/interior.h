// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "time/inner_forces.h"
#include "time/inner_loads.h"
#include "time/inner_motion.h"
#include "time/inside.h"
#include "time/interior_instant.h"
#include "time/interior_matrix.h"

namespace dttmm::plugin {

class InnerStart;

/// What moves inside a network between its ports: lumps, rigid masses and massless nodes, on the joints between them. For a
/// given motion of the ports over a step it finds its own,
///     P(u) = P− + h (f(x + h u) + weight + loads),     massless: 0 = f + loads,     rigid directions: d(x + h u) = 0,
/// u = [v; ω] of every frame over the step in the frame's own axes at t_n, P = [m v; L(ω)] its momentum, L half way through
/// the step as the host has it. f is the centred force of the joints: the same recursion as the host's, DT-TMM with
/// A = 1/h², C = γ/h. A rigid direction has one force over the whole step, in the weighted mean of its axes at the three
/// instants.
///
/// Newton's iteration with the InteriorMatrix goes on with the host's: an iteration per trial of the ports, from where the
/// last one leads to and with the linear answer to the ports' way since then. The first of a step starts from the
/// extrapolated motion. The host says when it is enough: when what remains of the correction is a small share of the first
/// one and of the motion, and what remains of the momentum of the largest impulse of a joint: a stiff joint makes much of a
/// small motion, and would feed its own vibration with what is left, step after step. The forces where it ends then move the
/// momentum, in pairs that balance exactly, so that it is kept however few iterations were made; what the motion lacks to it
/// is made up for in the next step. The ports are answered linearly from where the forces were worked out.
class Interior {
public:
    /// Throws Error(DTTMM_ERROR_MODEL) naming what cannot move as described: a rigid direction that is driven from both its
    /// ends; or a scheme that is explicit. A massless node that nothing holds in some direction is named here or at the
    /// start. Keeps the mechanism.
    Interior(Mechanism& mechanism, const dttmm_network& description, Loading loading);
    Interior(const Interior&) = delete;
    Interior& operator=(const Interior&) = delete;

    /// The force law at one instant with the inside at its start: wrenches on the ports, and −∂(wrench)/∂(pose of the ports)
    /// when the inside follows without inertia.
    /// Wrenches are added, 6 per body; stiffness: 6P × 6P row-major, or null.
    void linearise(Ports ports, double* wrench, double* stiffness) const;
    /// Adds to the small motions of the ports from the start, 6 per frame, world axes, those of the inside, which follows
    /// without inertia.
    void follow(std::span<Vector6> motion) const;

    /// Throws Error(DTTMM_ERROR_MODEL) naming a node whose given velocity rigid directions, or other nodes on its rigid
    /// body, forbid. at_rest: the frames, if it starts at rest and in balance.
    void start(Ports ports, const double* accelerations, const double* loads, const std::vector<Frame>* at_rest = nullptr);
    /// loads: NULL: none. Forms the matrix anew where the last step has left it stale; throws Error, nothing being changed,
    /// if that is singular or a rotational spring has turned too far.
    void begin_step(const double* loads);
    /// One iteration for ports that end the open step where they are given. Throws Error(DTTMM_ERROR_NUMERIC) where the
    /// motion is no number; then it is where begin_step has left it.
    void iterate(Ports ports, dttmm_progress& progress);
    /// Finds the wrenches on the ports over the open step, at a trial end of it near the last of iterate(). Throws
    /// Error(DTTMM_ERROR_PHASE) if there was none. To the host it changes nothing.
    void evaluate(Ports ports);
    const Vector6& wrench(int port) const { return inside_.wrench[as_size(port)]; }
    /// −∂(wrench)/∂(pose), 6P × 6P row-major.
    void write_stiffness(double* stiffness) const { matrix_.write_stiffness(stiffness); }
    /// Throws Error(DTTMM_ERROR_NUMERIC), nothing being changed, naming what is farther or faster than the host has its
    /// bodies, or turns more than half a turn over the step.
    void commit(Ports ports);

    /// Joints inside that are worked out four at a time.
    const JointsByFour& by_four() const { return forces_.by_four(); }
    /// At t_n, the start of the step last committed.
    InteriorInstant& instant() { return instant_; }
    const InteriorInstant& instant() const { return instant_; }
    double work() const;  ///< of gravity and loads since the start, up to then

    /// Whether nothing of mass (half 0) or inertia (1) is in a frame.
    bool is_massless(int frame, int half) const {
        return inside_.is_inner(frame) && inside_.massless.is_massless(inside_.at(frame), half);
    }
    bool has_rigid_directions() const { return !inside_.rigid.empty(); }

    /// Momentum and angular momentum about the world's origin of all that is inside, over the step before t_n.
    Twist momentum() const;
    /// The same as Newmark's rule keeps it: at t_n, of y = x − β h² F/m in place of x (Kane et al. 2000, Int. J. Numer.
    /// Meth. Eng. 49, 1295–1325). It differs by a part of order h² that does not grow. For networks without dampers.
    Twist newmark_momentum() const;

    /// Shows the memory of what changes from step to step, piece by piece, as spans; self: an Interior, constant or not. The
    /// factor goes with it by refactor(), for the step to come.
    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit) {
        InnerMemory::for_each_state(self.inside_, visit);
        InteriorInstant::for_each_state(self.instant_, visit);
    }
    void refactor();

    /// To work in before start().
    Elimination& lend_matrix() { return matrix_.lend(); }

private:
    void begin(InnerStart start, Ports ports, const double* accelerations, const double* loads);
    void balance_at_start(const InnerStart& start, Ports ports, const double* accelerations);
    void pass(dttmm_progress& progress);
    double find_correction(double previous);
    void find_lack();
    void report(double residual, dttmm_progress& progress) const;
    void refuse_unstarted() const;
    void find_end();
    [[noreturn]] void refuse_divergence(size_t inner) const;
    void take_momenta();
    void take_motion();

    Mechanism& mechanism_;
    Inside inside_;
    InteriorMatrix matrix_;
    InnerForces forces_;
    InnerLoads loads_;
    InnerMotion motion_;  ///< of the last iteration; before that where everything goes on as it has
    InteriorInstant instant_;
};

}  // namespace dttmm::plugin
