// SPDX-License-Identifier: BSD-3-Clause
#include "time/instant.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/rotation.h"

namespace dttmm::plugin {

Instant::Instant(const PortBodies& bodies, Interior* interior, const JointsByFour& by_four)
    : bodies_(bodies),
      mechanism_(bodies.mechanism),
      interior_(interior),
      by_four_(by_four),
      others_(by_four.not_taken(mechanism_.joints.size())),
      has_rates_by_increments_(interior && interior->has_rigid_directions()),
      port_velocities_(bodies.bodies.size()),
      forces_(mechanism_.joints.size(), Vector6::Zero()),
      wrenches_(mechanism_.frames.size(), Vector6::Zero()) {
    for (size_t j = 0; j < mechanism_.joints.size(); ++j)
        if (mechanism_.damper(j) && !std::ranges::binary_search(others_, j)) damped_by_four_.push_back(j);
}

JointPose Instant::pose(size_t j) const {
    const Joint& joint = mechanism_.joints[j];
    return joint.pose(mechanism_.frame_before(joint.from()), mechanism_.frame_before(joint.to()));
}

void Instant::add_wrench(size_t j, const JointForce& force) {
    const Joint& joint = mechanism_.joints[j];
    Joint::add_wrench(force, wrenches_[as_size(joint.from())].data(), wrenches_[as_size(joint.to())].data());
}

Twist Instant::velocity(int frame) const {
    if (frame < bodies_.count()) return port_velocities_[as_size(frame)];
    return interior_ ? interior_->instant().velocity(frame) : Twist{};
}

/// Of a joint's deformation. The forces of rigid directions are known over a step only. Velocities at the instant lack what
/// these forces change within it, and a stiff damper would make large forces of that. It would do the same with the
/// difference between Newmark's velocities inside and mean ones of bodies. In both cases rates are therefore those of the
/// increments.
Vector6 Instant::deformation_rate(size_t j, const JointPose& at) const {
    const Joint& joint = mechanism_.joints[j];
    const auto rate_of = [&](const Twist& v_from, const Twist& v_to) {
        return joint.rate(at, v_from, v_to, mechanism_.states[j].deformation_before());
    };
    if (!(by_increments_ || has_rates_by_increments_) || mechanism_.steps == 1)
        return rate_of(velocity(joint.from()), velocity(joint.to()));
    const auto correction = [&](int frame) { return interior_ ? interior_->instant().correction(frame) : Twist{}; };
    Vector6 total = rate_of(correction(joint.from()), correction(joint.to()));
    const double per_step = 0.5 / mechanism_.scheme.step_size();
    if (const DamperState* damper = mechanism_.damper(j))
        for (int half : {0, 1})
            total.segment<3>(3 * half) += per_step * (damper->halves[half].delta[0] + damper->halves[half].delta[1]);
    return total;
}

/// Newmark's rule has (a_n + a_{n+1})/2 as the acceleration over a step, so elastic forces are means of its two ends and
/// dampers have the mean rate.
/// Mean rate of its deformation over the step last committed, of its dampers; else zero.
Vector6 Instant::rate_over_step(size_t j) const {
    Vector6 rate = Vector6::Zero();
    if (const DamperState* damper = mechanism_.damper(j)) {
        rate << damper->halves[0].delta[0], damper->halves[1].delta[0];
        rate /= mechanism_.scheme.step_size();
    }
    return rate;
}

void Instant::find_mean_wrenches() {
    std::ranges::fill(wrenches_, Vector6::Zero());
    by_four_.add_mean_forces(mechanism_, wrenches_);
    for (size_t j : others_) {
        const Joint& joint = mechanism_.joints[j];
        const JointState& state = mechanism_.states[j];  // d_before is that at t_n
        const Vector6 x = state.deformation_before();
        Vector6 f = joint.force(x, rate_over_step(j), mechanism_.memory_before(j), 0.5);
        if (joint.has_laws()) f += joint.beyond_mean(mechanism_.scheme, x, state.deformation(), mechanism_.memory_before(j));
        if (joint.rigid().any()) f += interior_->instant().rigid_force_over_step(j);
        JointForce force = pose(j).act(f);
        force.add(0.5, state.elastic);
        add_wrench(j, force);
    }
    if (interior_) interior_->instant().find_velocities(wrenches_);
}

/// Forces of the joints and wrenches on the frames, as velocities and rigid directions are known.
void Instant::find_forces() {
    std::ranges::fill(wrenches_, Vector6::Zero());
    for (size_t j : damped_by_four_) forces_[j] = deformation_rate(j, pose(j));
    by_four_.add_forces_before(mechanism_, forces_, wrenches_);
    for (size_t j : others_) {
        const Joint& joint = mechanism_.joints[j];
        const JointPose at = pose(j);
        Vector6& f = forces_[j] = joint.force(mechanism_.states[j].deformation_before(),
                                              mechanism_.damper(j) ? deformation_rate(j, at) : Vector6(Vector6::Zero()),
                                              mechanism_.memory_before(j));
        if (joint.rigid().any()) f += interior_->instant().rigid_force(j);
        add_wrench(j, at.act(f));
    }
}

void Instant::find_by_port_velocities() {
    const auto velocity_of = [&](int frame) { return velocity(frame); };
    if (interior_) interior_->instant().find_massless_velocities([&](size_t j) { return deformation_rate(j, pose(j)); });
    find_forces();
    if (interior_ && interior_->instant().is_to_balance_rigid()) {
        interior_->instant().balance_rigid(wrenches_, velocity_of);
        find_forces();
    }
    if (interior_)
        interior_->instant().find_accelerations(wrenches_, velocity_of,
                                                [&](size_t j) -> const Vector6& { return forces_[j]; });
    is_known_ = true;
}

void Instant::find(const dttmm_motion* motions, const double* accelerations) {
    for (int p = 0; p < bodies_.count(); ++p) port_velocities_[as_size(p)] = bodies_.velocity(p, motions);
    if (accelerations && interior_)
        for (int p = 0; p < bodies_.count(); ++p)
            interior_->instant().set_port_acceleration(p, bodies_.acceleration(p, accelerations));
    find_by_port_velocities();
}

void Instant::find_by_centred_velocities(const std::vector<Frame>& earlier_frames, const std::vector<Twist>& start) {
    find_mean_wrenches();
    const double per_step = 0.5 / mechanism_.scheme.step_size();
    for (size_t p = 0; p < port_velocities_.size(); ++p) {
        if (mechanism_.steps == 1) {
            port_velocities_[p] = start[p];
            continue;
        }
        const FrameView earlier = earlier_frames[p], at = mechanism_.before[p], later = mechanism_.frames[p];
        port_velocities_[p] = {per_step * (later.origin() - earlier.origin()),
                               per_step * (rotation_vector(later.axes() * at.axes().transpose()) +
                                           rotation_vector(at.axes() * earlier.axes().transpose()))};
    }
    by_increments_ = true;
    find_by_port_velocities();
    by_increments_ = false;
}

void Instant::add_wrenches(double* wrench) const {
    for (int p = 0; p < bodies_.count(); ++p) bodies_.add_wrench(p, wrenches_[as_size(p)], wrench);
}

void Instant::add_rigid_wrenches(double* wrench) const {
    if (!interior_ || !interior_->has_rigid_directions()) return;
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        if (joint.rigid().none() || std::min(joint.from(), joint.to()) >= bodies_.count()) continue;
        bodies_.add_wrench(joint, pose(j).act(interior_->instant().rigid_force_over_step(j)), wrench);
    }
}

void Instant::add_turned_dampers(double* wrench) const {
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        if (!mechanism_.damper(j) || std::min(joint.from(), joint.to()) >= bodies_.count()) continue;
        const JointState& state = mechanism_.states[j];
        const FrameView from = mechanism_.frames[as_size(joint.from())], to = mechanism_.frames[as_size(joint.to())];
        const auto damping = [&](const Vector6& x) {
            return joint.force(x, rate_over_step(j), mechanism_.memory_before(j), 0);
        };
        JointForce half;
        half.add(0.5, joint.pose(from, to).act(damping(state.deformation())));
        half.add(-0.5, pose(j).act(damping(state.deformation_before())));
        bodies_.add_wrench(joint, half, wrench);
    }
}

}  // namespace dttmm::plugin
