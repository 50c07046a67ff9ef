// SPDX-License-Identifier: BSD-3-Clause
#include "time/interior_instant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/index.h"
#include "core/rotation.h"
#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

InteriorInstant::InteriorInstant(const Inside& inside, const Elimination& pattern)
    : inside_(inside), pattern_(pattern), rigid_(inside.rigid), of_ports_(as_size(inside.ports)), rigid_rates_(rigid_) {}

void InteriorInstant::make_room_for_steps() {
    for (auto* list : {&velocities_, &accelerations_}) list->resize(inside_.inertias.size());
    if (!inside_.balances.exist()) return;
    corrections_.resize(inside_.inertias.size());
    wrench_rates_.resize(inside_.inertias.size());
}

// ---- Velocities ---------------------------------------------------------------------------------------------------------

void InteriorInstant::find_velocities(std::span<const Vector6> mean_wrenches) {
    const double half_step = 0.5 * inside_.step_size();
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        const size_t f = inside_.frame_of(i);
        Vector6 wrench = mean_wrenches[f];
        if (inside_.load_of[i] >= 0) wrench += 0.5 * (inside_.frame_load(i).load[1] + inside_.frame_load(i).load[2]);
        Twist& v = velocities_[i] = inside_.past.mean(i);  // at the start the initial velocities
        if (inside_.mechanism.steps == 1 || !inside_.mechanism.scheme.is_trapezoidal()) continue;
        if (!inside_.massless.is_massless(i, 0))
            v.linear =
                inside_.past.velocity[i].linear - half_step * (head(wrench) / inside_.inertias[i].mass + inside_.gravity);
        if (inside_.massless.is_massless(i, 1)) continue;
        // L_n = L_{n+1/2} - h/2 T, ω = (R J Rᵀ)⁻¹ L
        const RowMajor3 R = FrameView(inside_.mechanism.before[f]).axes();
        v.angular =
            R * (inside_.inverse_moments[i] * (R.transpose() * (tail(inside_.momenta[i]) - half_step * tail(wrench))));
    }
    rigid_ = inside_.rigid;
}

// ---- Rigid directions at the start of a run -----------------------------------------------------------------------------

void InteriorInstant::form_first_balance() {
    first_balance_.reset();
    if (inside_.mechanism.steps > 1 || inside_.rigid.empty()) return;
    FirstBalance& balance = first_balance_.emplace(FirstBalance{
        pattern_, lend_masses(), std::vector<Vector6>(inside_.inertias.size()), std::vector<double>(inside_.rigid.size())});
    balance.matrix.set_zero();
    for (size_t i = 0; i < balance.lent.size(); ++i)
        balance.matrix.add_diagonal(as_int(i), mass_matrix(inside_.inertias[i]) + Matrix6(balance.lent[i].asDiagonal()));
    for (size_t j : inside_.rigid_joints) set_rigid_rows(inside_.mechanism, j, inside_.mechanism.before, balance.matrix);
    factor_or_refuse(inside_.mechanism, balance.matrix, DTTMM_ERROR_SINGULAR);
}

/// For massless halves: so that every frame has something. A share of the lightest mass that rigid directions join them to.
/// Where they join none, of the lightest in the network: rounding of what is lent acts on the bodies, and a kilogram moved
/// those of milligrams. Where the network has no mass, of a kilogram: bodies of 1e-12 kg feel 1e-11 of their acceleration.
std::vector<Vector6> InteriorInstant::lend_masses() const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<double> nearby(inside_.inertias.size(), kNone);
    for (size_t i = 0; i < nearby.size(); ++i)
        if (!inside_.massless.is_massless(i, 0)) nearby[i] = inside_.inertias[i].mass;
    const double least = nearby.empty() ? kNone : *std::ranges::min_element(nearby), lightest = least < kNone ? least : 1;
    for (bool spreads = true; spreads;) {
        spreads = false;
        for (size_t j : inside_.rigid_joints) {
            const int frames[2] = {inside_.mechanism.joints[j].from(), inside_.mechanism.joints[j].to()};
            if (!inside_.is_inner(frames[0]) || !inside_.is_inner(frames[1])) continue;
            for (int end : {0, 1}) {
                const size_t i = inside_.at(frames[end]), other = inside_.at(frames[1 - end]);
                if (!inside_.massless.is_massless(i, 0) || !(nearby[other] < nearby[i])) continue;
                nearby[i] = nearby[other];
                spreads = true;
            }
        }
    }
    std::vector<Vector6> lent(nearby.size(), Vector6::Zero());
    for (size_t i : inside_.massless.frames()) {
        // solve_first_balance() takes it out again; 1e-2 to 1e-8 give the same digits
        const double mass = kNextToNothing * (nearby[i] < kNone ? nearby[i] : lightest);
        const double arm = inside_.reach[i] > 0 ? inside_.reach[i] : 1;
        for (int half : {0, 1})
            if (inside_.massless.is_massless(i, half))
                lent[i].segment<3>(3 * half).setConstant(half == 0 ? mass : mass * arm * arm);
    }
    return lent;
}

/// What accelerations of now lack to keep the rigid directions of a joint closed.
void InteriorInstant::set_opening(size_t j, const Twist& from, const Twist& to) {
    Vector6 opening = acceleration_of_deformation(j, from, to);
    opening.tail<3>() = (opening_of_turn_before(j) * opening.tail<3>()).eval();
    for_each_rigid(inside_.mechanism.joints[j],
                   [&](int i, int d) { first_balance_->q[inside_.rigid_row(j, i)] = -opening(d); });
}

/// Adds to the forces of rigid directions what closes these. Forces that accelerate lent masses are taken off again, pass
/// by pass, 4 as a rule, more where levers are short beside the reach of a frame: with B the lent masses,  (M + B) a₁ + Jᵀ
/// q₁ = 0,  J a₁ = g,   (M + B) a₂ + Jᵀ q₂ = B a₁,  J a₂ = 0, ...
void InteriorInstant::solve_first_balance() {
    std::vector<Vector6>& a = first_balance_->a;
    std::vector<double>& q = first_balance_->q;
    std::ranges::fill(a, Vector6::Zero());
    double first = 0, before = 0;
    for (int pass = 0; pass < kMostPassesOfStep; ++pass) {
        first_balance_->matrix.solve(a, q);
        for (size_t i = 0; i < q.size(); ++i) rigid_[i] += q[i];
        const double size = largest_size(a, inside_.turn_weight);
        if (pass == 0) first = size;
        const bool shrinks = pass < 2 || size < before;
        if (!(size > std::numeric_limits<double>::epsilon() * first) || !shrinks) return;
        before = size;
        for (size_t i = 0; i < a.size(); ++i) a[i] = first_balance_->lent[i].cwiseProduct(a[i]).eval();
        std::ranges::fill(q, 0.0);
    }
}

// ---- Accelerations ------------------------------------------------------------------------------------------------------

void InteriorInstant::find_accelerations(std::span<const Vector6> wrenches) {
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        const size_t f = inside_.frame_of(i);
        Vector6 wrench = wrenches[f];
        if (inside_.load_of[i] >= 0) wrench += inside_.frame_load(i).load[2];
        const Twist &later = inside_.past.velocity[i], &earlier = inside_.past.velocity_before[i];
        Twist& a = accelerations_[i];
        const double h = inside_.step_size();
        a.linear = inside_.massless.is_massless(i, 0) ? Vector3((later.linear - earlier.linear) / h)
                                                      : Vector3(head(wrench) / inside_.inertias[i].mass + inside_.gravity);
        if (inside_.massless.is_massless(i, 1)) {
            a.angular = (later.angular - earlier.angular) / h;
            continue;
        }
        const RowMajor3 R = FrameView(inside_.mechanism.before[f]).axes();
        const Vector3 spin = R.transpose() * velocities_[i].angular;
        a.angular = R * (inside_.inverse_moments[i] *
                         (R.transpose() * tail(wrench) - spin.cross(inside_.inertias[i].moment * spin)));
    }
}

/// Of a joint, as its frames accelerate.
Vector6 InteriorInstant::acceleration_of_deformation(size_t j, const Twist& from_velocity, const Twist& to_velocity) const {
    const Joint& joint = inside_.mechanism.joints[j];
    const auto acceleration_of = [&](int frame) {
        if (inside_.is_inner(frame)) return accelerations_[inside_.at(frame)];
        return frame < inside_.ports ? of_ports_[as_size(frame)] : Twist{};
    };
    return joint.acceleration(inside_.mechanism.frame_before(joint.from()), from_velocity, acceleration_of(joint.from()),
                              inside_.mechanism.frame_before(joint.to()), to_velocity, acceleration_of(joint.to()));
}

/// Rates of the loads on massless frames.
void InteriorInstant::take_load_rates() {
    std::fill(wrench_rates_.begin(), wrench_rates_.end(), Vector6::Zero());
    for (size_t i : inside_.massless.frames())
        wrench_rates_[i] = (inside_.frame_load(i).load[1] - inside_.frame_load(i).load[2]) / inside_.step_size();
    std::fill(rigid_rates_.begin(), rigid_rates_.end(), 0.0);
}

/// Adds the rates of the moments that a joint's force has on its frames, as far as its lever arms make them.
void InteriorInstant::add_arm_rates(size_t j, const Twist& from, const Twist& to, const Vector6& f) {
    const Joint& joint = inside_.mechanism.joints[j];
    const JointPose pose =
        joint.pose(inside_.mechanism.frame_before(joint.from()), inside_.mechanism.frame_before(joint.to()));
    const Vector3 force = pose.axes * head(f), lever_rate = to.angular.cross(pose.lever);
    const Vector3 arm_rate = to.linear + lever_rate - from.linear;
    const auto on = [&](int frame) { return inside_.is_inner(frame) ? wrench_rates_[inside_.at(frame)].data() : nullptr; };
    Joint::add_wrench({Vector3::Zero(), arm_rate.cross(force), lever_rate.cross(force)}, on(joint.from()), on(joint.to()));
}

/// Rate of a joint's force at the start, where it is at rest but for its rate: f' + ω × f in its axes, and what makes it.
InstantBalances::Acting InteriorInstant::rate_of_force(size_t j, const Twist& from_velocity, const Twist& to_velocity,
                                                       const Vector6& f) const {
    const Joint& joint = inside_.mechanism.joints[j];
    const FrameView from = inside_.mechanism.frame_before(joint.from()), to = inside_.mechanism.frame_before(joint.to());
    const Vector6 rate = joint.rate(from, from_velocity, to, to_velocity);
    const Vector3 w = joint.turning(from, from_velocity, to, to_velocity);
    Vector6 other;
    other << w.cross(head(f)), w.cross(tail(f));
    other +=
        joint.stiffness_tangent(inside_.mechanism.states[j].deformation_before(), inside_.mechanism.memory_before(j)) * rate;
    return {inside_.mechanism.states[j].deformation_before(), acceleration_of_deformation(j, from_velocity, to_velocity),
            other};
}

Matrix3 InteriorInstant::opening_of_turn_before(size_t j) const {
    return inside_.mechanism.joints[j].opening_of_turn(inside_.mechanism.states[j].theta_before);
}

Vector6 InteriorInstant::rigid_force_over_step(size_t j) const {
    Vector6 q = inside_.rigid_values(j, inside_.rigid);
    if (inside_.mechanism.steps == 1 && inside_.record.starts_at_rest == 0) q *= 2;
    q.tail<3>() = (opening_of_turn_before(j).transpose() * q.tail<3>()).eval();
    return q;
}

Vector6 InteriorInstant::rigid_force(size_t j) const {
    Vector6 q = inside_.rigid_values(j, rigid_);
    q.tail<3>() = (opening_of_turn_before(j).transpose() * q.tail<3>()).eval();
    return q;
}

Twist InteriorInstant::velocity(int frame, const Vector3& offset) const {
    const Twist v = velocity(frame);
    return {v.linear + v.angular.cross(inside_.mechanism.frame_before(frame).axes() * offset), v.angular};
}

Twist InteriorInstant::acceleration(int frame, const Vector3& offset) const {
    const Twist &a = accelerations_[inside_.at(frame)], &v = velocities_[inside_.at(frame)];
    const Vector3 arm = inside_.mechanism.frame_before(frame).axes() * offset;
    return {a.linear + a.angular.cross(arm) + v.angular.cross(v.angular.cross(arm)), a.angular};
}

double InteriorInstant::kinetic_energy() const {
    double twice = 0;
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        const Twist& v = velocities_[i];
        const Vector3 w = inside_.mechanism.frame_before(inside_.driven + as_int(i)).axes().transpose() * v.angular;
        twice += inside_.inertias[i].mass * v.linear.squaredNorm() + w.dot(inside_.inertias[i].moment * w);
    }
    return 0.5 * twice;
}

}  // namespace dttmm::plugin
