// SPDX-License-Identifier: BSD-3-Clause
#include "time/inner_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/rotation.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

InnerForces::InnerForces(Inside& inside) : inside_(inside), rigid_known_(inside.rigid_joints.size()) {
    const Mechanism& mechanism = inside.mechanism;
    std::vector<size_t> plain;
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const bool is_plain = inside.near_index[j] < 0 && inside.rigid_index[j] < 0 && !inside.massless.is_settling(j) &&
                              !mechanism.joints[j].has_laws();
        if (is_plain) plain.push_back(j);
    }
    by_four_ = {mechanism, plain};
    others_ = by_four_.not_taken(mechanism.joints.size());
}

void InnerForces::look_at_joints() {
    const Mechanism& mechanism = inside_.mechanism;
    const Scheme& scheme = mechanism.scheme;
    for (size_t k = 0; k < inside_.rigid_joints.size(); ++k) {
        const size_t j = inside_.rigid_joints[k];
        const Joint& joint = mechanism.joints[j];
        const JointPose before = joint.pose(ends(joint, mechanism.before));
        const Vector3 theta = mechanism.theta(j);
        RigidMap& known = rigid_known_[k] = {};
        known.add(scheme.elastic_weight(1), mechanism.pose(j), joint.opening_of_turn(theta));
        // Three instants, one force: of one branch of θ
        known.add(scheme.elastic_weight(2), before,
                  joint.opening_of_turn(nearest_turn(mechanism.states[j].theta_before, theta)));
    }
    inside_.massless.look(mechanism);
}

/// Of a joint's rigid directions over the step, with forces q.
JointForce InnerForces::rigid_action(size_t j, const JointPose& at_end, const Vector3& theta, const Vector6& q) const {
    RigidMap map = rigid_known_[as_size(inside_.rigid_index[j])];
    map.add(inside_.mechanism.scheme.elastic_weight(0), at_end,
            inside_.mechanism.joints[j].opening_of_turn(nearest_turn(theta, inside_.mechanism.theta(j))));
    return map.of(q);
}

/// Of a joint, its rigid directions carrying the forces of the trial.
JointForce InnerForces::over_step(size_t j, const JointPose& at_end, const Joint::Strained& end) const {
    const Mechanism& mechanism = inside_.mechanism;
    const Joint& joint = mechanism.joints[j];
    JointForce force =
        joint.weigh(mechanism.scheme, end, at_end, mechanism.states[j], mechanism.damper(j), mechanism.memory(j));
    if (joint.rigid().any()) force.add(1, rigid_action(j, at_end, end.theta, inside_.rigid_values(j, inside_.trial_q)));
    return force;
}

void InnerForces::find(InnerMotion& motion, InnerLoads& loads) {
    const Mechanism& mechanism = inside_.mechanism;
    std::ranges::fill(inside_.wrench, Vector6::Zero());
    loads.forget_wrenches();
    inside_.trial_q = motion.q;
    double largest = by_four_.add_forces(mechanism, inside_.trial, inside_.wrench);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends trial = {inside_.trial[a], inside_.trial[b]};
        const JointPose at_end = joint.pose(trial);
        const Joint::Strained end = joint.strain(mechanism.scheme, trial, at_end, mechanism.states[j], mechanism.memory(j));
        const JointForce force = over_step(j, at_end, end);
        largest = std::max(largest, force.force.squaredNorm());
        Joint::add_wrench(force, inside_.wrench[a].data(), inside_.wrench[b].data());
        if (inside_.near_index[j] >= 0) motion.near[as_size(inside_.near_index[j])] = force;
        if (inside_.massless.is_settling(j)) find_settling(j, trial, at_end, end, loads);
    }
    motion.impulse = inside_.step_size() * std::sqrt(largest);
}

/// What a joint of massless frames does at the end of the step; its damper half way.
void InnerForces::find_settling(size_t j, Ends trial, const JointPose& at_end, const Joint::Strained& end,
                                InnerLoads& loads) const {
    const Mechanism& mechanism = inside_.mechanism;
    const Joint& joint = mechanism.joints[j];
    JointForce then = end.elastic;
    if (joint.rigid().any()) {
        const Vector6 q = inside_.rigid_values(j, inside_.trial_q);
        then.add(1,
                 at_end.act(at_end.axes * head(q), at_end.axes * (joint.opening_of_turn(end.theta).transpose() * tail(q))));
    }
    Joint::add_wrench(then, loads.end_wrench(joint.from()), loads.end_wrench(joint.to()));
    if (inside_.massless.is_half_way(j))
        Joint::add_wrench(
            joint.damping_half_way(trial, mechanism.ends(j), inside_.step_size(), mechanism.states[j], *mechanism.damper(j)),
            loads.damping_wrench(joint.from()), loads.damping_wrench(joint.to()));
}

void InnerForces::take_step(Mechanism& mechanism, const InnerMotion& motion) {
    std::ranges::fill(inside_.wrench, Vector6::Zero());
    by_four_.advance(mechanism, inside_.trial, inside_.wrench);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends next = {inside_.trial[a], inside_.trial[b]};
        const int near = inside_.near_index[j];
        JointForce rigid, force;
        if (near < 0 && joint.rigid().any())
            rigid = rigid_action(j, joint.pose(next), joint.rotation(next.from, next.to),
                                 inside_.rigid_values(j, inside_.rigid));
        joint.advance(mechanism.scheme, next, mechanism.ends(j), mechanism.states[j], mechanism.damper(j),
                      mechanism.law_memory_of(j), near < 0 ? &force : nullptr);
        if (near >= 0)
            force = motion.near_force(as_size(near));
        else if (joint.rigid().any())
            force.add(1, rigid);
        Joint::add_wrench(force, inside_.wrench[a].data(), inside_.wrench[b].data());
    }
}

}  // namespace dttmm::plugin
