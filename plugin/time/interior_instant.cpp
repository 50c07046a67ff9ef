// SPDX-License-Identifier: BSD-3-Clause
//
// What stands inside a network at t_n, the start of the step last committed: results are of that instant.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/index.h"
#include "core/rotation.h"
#include "time/interior.h"
#include "time/interior_parts.h"

namespace dttmm::plugin {

void Interior::find_velocities(const Mechanism& mechanism, std::span<const Vector6> mean_wrenches) {
    const double half_step = 0.5 * mechanism.scheme.step_size();
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const size_t f = as_size(layout_.driven) + i;
        Vector6 wrench = mean_wrenches[f];
        if (layout_.load_of[i] >= 0) wrench += 0.5 * (frame_load(i).load[1] + frame_load(i).load[2]);
        Twist& v = instant_.velocities[i] = past_.mean(i);  // at the start the initial velocities
        if (mechanism.steps == 1) continue;
        if (!massless_.is_massless(i, 0))
            v.linear = past_.velocity[i].linear - half_step * (head(wrench) / layout_.inertias[i].mass + layout_.gravity);
        if (massless_.is_massless(i, 1)) continue;
        // L_n = L_{n+1/2} - h/2 T, ω = (R J Rᵀ)⁻¹ L
        const RowMajor3 R = FrameView(mechanism.before[f]).axes();
        v.angular = R * (layout_.inverse_moments[i] * (R.transpose() * (tail(momenta_[i]) - half_step * tail(wrench))));
    }
    instant_.rigid = rigid_;
}

// ---- Rigid directions at the start of a run -----------------------------------------------------------------------------

void Interior::form_first_balance(const Mechanism& mechanism) {
    first_balance_.reset();
    if (mechanism.steps > 1 || !has_rigid_directions()) return;
    FirstBalance& balance = first_balance_.emplace(FirstBalance{matrix_.factor, lend_masses(mechanism)});
    balance.matrix.set_zero();
    for (size_t i = 0; i < balance.lent.size(); ++i)
        balance.matrix.add_diagonal(as_int(i), mass_matrix(i) + Matrix6(balance.lent[i].asDiagonal()));
    for (size_t j : layout_.rigid_joints) set_rigid_rows(mechanism, j, mechanism.before, balance.matrix);
    factor(mechanism, balance.matrix, DTTMM_ERROR_SINGULAR);
}

/// For massless halves: so that every frame has something. A share of the lightest mass that rigid directions join them to.
std::vector<Vector6> Interior::lend_masses(const Mechanism& mechanism) const {
    constexpr double kShare = 1e-6;  // solve_first_balance() takes it out again; 1e-2 to 1e-8 give the same digits
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<double> nearby(layout_.inertias.size(), kNone);
    for (size_t i = 0; i < nearby.size(); ++i)
        if (!massless_.is_massless(i, 0)) nearby[i] = layout_.inertias[i].mass;
    for (bool spreads = true; spreads;) {
        spreads = false;
        for (size_t j : layout_.rigid_joints) {
            const int frames[2] = {mechanism.joints[j].from(), mechanism.joints[j].to()};
            if (!is_inner(frames[0]) || !is_inner(frames[1])) continue;
            for (int end : {0, 1}) {
                const size_t i = at(frames[end]), other = at(frames[1 - end]);
                if (!massless_.is_massless(i, 0) || !(nearby[other] < nearby[i])) continue;
                nearby[i] = nearby[other];
                spreads = true;
            }
        }
    }
    std::vector<Vector6> lent(nearby.size(), Vector6::Zero());
    for (size_t i : massless_.frames()) {
        const double mass = nearby[i] < kNone ? kShare * nearby[i] : 1;
        const double arm = layout_.reach[i] > 0 ? layout_.reach[i] : 1;
        for (int half : {0, 1})
            if (massless_.is_massless(i, half))
                lent[i].segment<3>(3 * half).setConstant(half == 0 ? mass : mass * arm * arm);
    }
    return lent;
}

/// What accelerations of now lack to keep the rigid directions of a joint closed.
void Interior::set_opening(const Mechanism& mechanism, size_t j, const Twist& from, const Twist& to) {
    Vector6 opening = acceleration_of_deformation(mechanism, j, from, to);
    opening.tail<3>() = (rotation_vector_rate(mechanism.states[j].theta_before) * opening.tail<3>()).eval();
    for_each_rigid(mechanism.joints[j], [&](int i, int d) { work_.column_q[rigid_row(j, i)] = -opening(d); });
}

/// Adds to the forces of rigid directions what closes these. Forces that accelerate lent masses are taken off again, pass
/// by pass: with B the lent masses,  (M + B) a₁ + Jᵀ q₁ = 0,  J a₁ = g,   (M + B) a₂ + Jᵀ q₂ = B a₁,  J a₂ = 0, ...
void Interior::solve_first_balance() {
    constexpr int kMostPasses = 100;  // 4 are the rule; more where levers are short beside the reach of a frame
    std::vector<Vector6>& a = work_.motion;
    std::vector<double>& q = work_.column_q;
    std::ranges::fill(a, Vector6::Zero());
    double first = 0, before = 0;
    for (int pass = 0; pass < kMostPasses; ++pass) {
        first_balance_->matrix.solve(a, q);
        for (size_t i = 0; i < q.size(); ++i) instant_.rigid[i] += q[i];
        const double size = largest_size(a, layout_.turn_weight);
        if (pass == 0) first = size;
        const bool shrinks = pass < 2 || size < before;
        if (!(size > std::numeric_limits<double>::epsilon() * first) || !shrinks) return;
        before = size;
        for (size_t i = 0; i < a.size(); ++i) a[i] = first_balance_->lent[i].cwiseProduct(a[i]).eval();
        std::ranges::fill(q, 0.0);
    }
}

// ---- Accelerations ------------------------------------------------------------------------------------------------------

void Interior::find_accelerations(const Mechanism& mechanism, std::span<const Vector6> wrenches) {
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const size_t f = as_size(layout_.driven) + i;
        Vector6 wrench = wrenches[f];
        if (layout_.load_of[i] >= 0) wrench += frame_load(i).load[2];
        const Twist &later = past_.velocity[i], &earlier = past_.velocity_before[i];
        Twist& a = instant_.accelerations[i];
        const double h = mechanism.scheme.step_size();
        a.linear = massless_.is_massless(i, 0) ? Vector3((later.linear - earlier.linear) / h)
                                               : Vector3(head(wrench) / layout_.inertias[i].mass + layout_.gravity);
        if (massless_.is_massless(i, 1)) {
            a.angular = (later.angular - earlier.angular) / h;
            continue;
        }
        const RowMajor3 R = FrameView(mechanism.before[f]).axes();
        const Vector3 spin = R.transpose() * instant_.velocities[i].angular;
        a.angular = R * (layout_.inverse_moments[i] *
                         (R.transpose() * tail(wrench) - spin.cross(layout_.inertias[i].moment * spin)));
    }
}

/// Of a joint, as its frames accelerate.
Vector6 Interior::acceleration_of_deformation(const Mechanism& mechanism, size_t j, const Twist& from_velocity,
                                              const Twist& to_velocity) const {
    const Joint& joint = mechanism.joints[j];
    const auto acceleration_of = [&](int frame) {
        if (is_inner(frame)) return instant_.accelerations[at(frame)];
        return frame < layout_.ports ? instant_.of_ports[as_size(frame)] : Twist{};
    };
    return joint.acceleration(mechanism.frame_before(joint.from()), from_velocity, acceleration_of(joint.from()),
                              mechanism.frame_before(joint.to()), to_velocity, acceleration_of(joint.to()));
}

/// Rates of the loads on massless frames.
void Interior::take_load_rates(const Mechanism& mechanism) {
    std::fill(instant_.wrench_rates.begin(), instant_.wrench_rates.end(), Vector6::Zero());
    for (size_t i : massless_.frames())
        instant_.wrench_rates[i] = (frame_load(i).load[1] - frame_load(i).load[2]) / mechanism.scheme.step_size();
    std::fill(instant_.rigid_rates.begin(), instant_.rigid_rates.end(), 0.0);
}

/// Adds the rates of the moments that a joint's force has on its frames, as far as its lever arms make them.
void Interior::add_arm_rates(const Mechanism& mechanism, size_t j, const Twist& from, const Twist& to, const Vector6& f) {
    const Joint& joint = mechanism.joints[j];
    const JointPose pose = joint.pose(mechanism.frame_before(joint.from()), mechanism.frame_before(joint.to()));
    const Vector3 force = pose.axes * head(f), lever_rate = to.angular.cross(pose.lever);
    const Vector3 arm_rate = to.linear + lever_rate - from.linear;
    const auto on = [&](int frame) { return is_inner(frame) ? instant_.wrench_rates[at(frame)].data() : nullptr; };
    Joint::add_wrench({Vector3::Zero(), arm_rate.cross(force), lever_rate.cross(force)}, on(joint.from()), on(joint.to()));
}

/// Rate of a joint's force at the start, where it is at rest but for its rate: f' + ω × f in its axes, and what makes it.
MasslessFrames::Acting Interior::rate_of_force(const Mechanism& mechanism, size_t j, const Twist& from_velocity,
                                               const Twist& to_velocity, const Vector6& f) const {
    const Joint& joint = mechanism.joints[j];
    const FrameView from = mechanism.frame_before(joint.from()), to = mechanism.frame_before(joint.to());
    const Vector6 rate = joint.rate(from, from_velocity, to, to_velocity);
    const Vector3 w = joint.turning(from, from_velocity, to, to_velocity);
    Vector6 other;
    other << w.cross(head(f)), w.cross(tail(f));
    other += joint.stiffness_tangent(mechanism.states[j].deformation_before(), mechanism.memory_before(j)) * rate;
    return {mechanism.states[j].deformation_before(), acceleration_of_deformation(mechanism, j, from_velocity, to_velocity),
            other};
}

Vector6 Interior::rigid_force(const Mechanism& mechanism, size_t j) const {
    Vector6 q = rigid_values(mechanism, j, rigid_);
    if (mechanism.steps == 1) q *= 2;
    q.tail<3>() = moment_of_gradient(mechanism.states[j].theta_before, q.tail<3>()).eval();
    return q;
}

Vector6 Interior::rigid_force_at_start(const Mechanism& mechanism, size_t j) const {
    Vector6 q = rigid_values(mechanism, j, instant_.rigid);
    q.tail<3>() = moment_of_gradient(mechanism.states[j].theta_before, q.tail<3>()).eval();
    return q;
}

Twist Interior::velocity(const Mechanism& mechanism, int frame, const Vector3& offset) const {
    const Twist v = velocity(frame);
    return {v.linear + v.angular.cross(mechanism.frame_before(frame).axes() * offset), v.angular};
}

Twist Interior::acceleration(const Mechanism& mechanism, int frame, const Vector3& offset) const {
    const Twist &a = instant_.accelerations[at(frame)], &v = instant_.velocities[at(frame)];
    const Vector3 arm = mechanism.frame_before(frame).axes() * offset;
    return {a.linear + a.angular.cross(arm) + v.angular.cross(v.angular.cross(arm)), a.angular};
}

double Interior::kinetic_energy(const Mechanism& mechanism) const {
    double twice = 0;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const Twist& v = instant_.velocities[i];
        const Vector3 w = mechanism.frame_before(layout_.driven + as_int(i)).axes().transpose() * v.angular;
        twice += layout_.inertias[i].mass * v.linear.squaredNorm() + w.dot(layout_.inertias[i].moment * w);
    }
    return 0.5 * twice;
}

}  // namespace dttmm::plugin
