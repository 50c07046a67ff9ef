// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "solve/elimination.h"
#include "time/inside.h"

namespace dttmm::plugin {

/// What stands inside a network at t_n, the start of the step last committed: results are of that instant. Velocities first,
/// then the forces of the joints, then accelerations.
class InteriorInstant {
public:
    /// pattern: an elimination of what is inside. Keeps both.
    InteriorInstant(const Inside& inside, const Elimination& pattern);
    /// Room for the steps to come: nothing is allocated later.
    void make_room_for_steps();

    /// Velocities of frames with mass: Newmark's, those over the step less half of what its mean wrenches (of the joints, on
    /// all frames) add per step. The others have the mean of those over the two steps. With numerical damping all have it.
    void find_velocities(std::span<const Vector6> mean_wrenches);
    /// Velocities of massless frames where dampers act, and the forces of rigid directions on massless frames: by the
    /// balance of the instant. rate(j): of the joints' deformations, as known. At rest the velocities that would balance are
    /// what the equilibrium leaves by rounding, over dampers that may be next to nothing: there they stay zero.
    template <class Rate>
    void find_massless_velocities(const Rate& rate) {
        std::ranges::fill(corrections_, Twist{});
        if (!inside_.balances.exist()) return;
        const Mechanism& mechanism = inside_.mechanism;
        inside_.balances.find_instant(
            mechanism, inside_.step_size(), mechanism.before,
            [&](size_t j) {
                const JointState& state = mechanism.states[j];
                return InstantBalances::Acting{
                    state.deformation_before(), rate(j),
                    mechanism.joints[j].elastic(state.deformation_before(), mechanism.memory_before(j))};
            },
            [&](size_t i) { return inside_.frame_load(i).load[2]; }, velocities_, corrections_, rigid_);
        if (mechanism.steps > 1 || inside_.record.starts_at_rest == 0) return;
        for (auto* list : {&velocities_, &corrections_}) std::ranges::fill(*list, Twist{});
    }
    /// What that has added to the velocity of a frame's origin, world.
    Twist correction(int frame) const {
        return inside_.is_inner(frame) && !corrections_.empty() ? corrections_[inside_.at(frame)] : Twist{};
    }
    /// Of a port, linear and angular; at the start what the host knows there.
    void set_port_acceleration(int port, const Twist& a) { of_ports_[as_size(port)] = a; }

    /// Forces of rigid directions over a step say nothing exact of an instant. At the start of a run balance_rigid() finds
    /// those of the instant, with the accelerations of all masses inside at once:
    ///     M a + Jᵀ q = f,   J a = −C̈         C̈: second rates of the rigid directions at constant velocities
    /// The ports have the accelerations set. wrenches: of the joints, with the forces q known so far.
    bool is_to_balance_rigid() const { return inside_.mechanism.steps == 1 && first_balance_.has_value(); }
    template <class Velocity>
    void balance_rigid(std::span<const Vector6> wrenches, const Velocity& velocity) {
        find_accelerations(wrenches);
        for (size_t j : inside_.rigid_joints) {
            const Joint& joint = inside_.mechanism.joints[j];
            set_opening(j, velocity(joint.from()), velocity(joint.to()));
        }
        solve_first_balance();
    }
    /// Forms the matrix of that balance, if nothing is written yet and something is rigid. Allocates.
    void form_first_balance();
    void forget_first_balance() { first_balance_.reset(); }

    /// Accelerations: of frames with mass by the wrenches of the joints at that instant, of massless ones by the velocities
    /// over the steps around it. At the start there is one step only: there those that dampers or rigid directions act on
    /// have the accelerations that keep their forces in balance and rigid directions closed. velocity(frame), force(joint):
    /// at that instant, the force in the joint's axes.
    template <class Velocity, class Force>
    void find_accelerations(std::span<const Vector6> wrenches, const Velocity& velocity, const Force& force) {
        find_accelerations(wrenches);
        const Mechanism& mechanism = inside_.mechanism;
        if (mechanism.steps > 1 || !inside_.balances.exist()) return;
        take_load_rates();
        const auto ends = [&](size_t j) {
            return std::pair{velocity(mechanism.joints[j].from()), velocity(mechanism.joints[j].to())};
        };
        for (size_t j = 0; j < mechanism.joints.size(); ++j) {
            const auto [from, to] = ends(j);
            add_arm_rates(j, from, to, force(j));
        }
        inside_.balances.find_instant(
            mechanism, inside_.step_size(), mechanism.before,
            [&](size_t j) {
                const auto [from, to] = ends(j);
                return rate_of_force(j, from, to, force(j));
            },
            [&](size_t i) { return wrench_rates_[i]; }, accelerations_, corrections_, rigid_rates_);
    }

    /// Of a frame's origin, world.
    Twist velocity(int frame) const { return inside_.is_inner(frame) ? velocities_[inside_.at(frame)] : Twist{}; }
    /// A point of an inner frame in its axes.
    Twist velocity(int frame, const Vector3& offset) const;
    Twist acceleration(int frame, const Vector3& offset) const;
    double kinetic_energy() const;
    /// Force of a joint's rigid directions, its axes [force; moment]: over the step, and at the instant. The first step
    /// counts half of it, and twice that is the force, unless the run starts at rest.
    Vector6 rigid_force_over_step(size_t joint) const;
    Vector6 rigid_force(size_t joint) const;

    /// The accelerations of the ports change from step to step.
    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit) {
        visit(std::span(self.of_ports_));
    }

private:
    void find_accelerations(std::span<const Vector6> wrenches);
    void set_opening(size_t joint, const Twist& from, const Twist& to);
    void solve_first_balance();
    std::vector<Vector6> lend_masses() const;
    Matrix3 opening_of_turn_before(size_t joint) const;
    Vector6 acceleration_of_deformation(size_t joint, const Twist& from, const Twist& to) const;
    void take_load_rates();
    void add_arm_rates(size_t joint, const Twist& from, const Twist& to, const Vector6& f);
    InstantBalances::Acting rate_of_force(size_t joint, const Twist& from_velocity, const Twist& to_velocity,
                                          const Vector6& f) const;

    const Inside& inside_;
    const Elimination& pattern_;
    std::vector<Twist> velocities_, accelerations_;  ///< of the inner frames, world
    std::vector<Twist> corrections_;                 ///< empty where there is no massless frame; so is wrench_rates_
    std::vector<double> rigid_;                      ///< forces of the rigid directions then
    // For accelerations at the start of a run:
    std::vector<Twist> of_ports_;
    std::vector<Vector6> wrench_rates_;  ///< on the inner frames, known ones
    std::vector<double> rigid_rates_;    ///< of forces of rigid directions
    /// Masses and rigid directions at the start of a run.
    struct FirstBalance {
        Elimination matrix;
        std::vector<Vector6> lent;  ///< diagonal that stands for the inertia of massless halves, zero in the others
        std::vector<Vector6> a;     ///< accelerations
        std::vector<double> q;      ///< forces of rigid directions
    };
    std::optional<FirstBalance> first_balance_;  ///< up to the first row; none where nothing is rigid
};

}  // namespace dttmm::plugin
