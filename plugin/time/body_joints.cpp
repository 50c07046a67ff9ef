// SPDX-License-Identifier: BSD-3-Clause
#include "time/body_joints.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dttmm::plugin {

BodyJoints::BodyJoints(Mechanism& mechanism, const PortBodies& bodies, const PortBlocks& blocks)
    : mechanism_(mechanism), bodies_(bodies), blocks_(blocks) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        (mechanism.joints[j].has_laws() ? with_laws_ : linear_).push_back(j);
        for (int d = 0; d < 6; ++d)
            if (mechanism.joints[j].law().laws[as_size(d)]) law_looks_.push_back({j, d, 0, 0, 0});
    }
    by_four_ = {mechanism, linear_};
}

void BodyJoints::linearise(const dttmm_motion* motions, double* wrench, double* stiffness, double* damping) const {
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const auto [from, to] = bodies_.seen(joint, motions);
        const Twist v_from = bodies_.velocity(joint.from(), motions), v_to = bodies_.velocity(joint.to(), motions);
        const JointPose pose = joint.pose(from, to);
        const Vector6 deformation = joint.deformation(pose, from, to);
        const double* const memory = mechanism_.memory(j);
        const Vector6 force = joint.force(deformation, joint.rate(pose, v_from, v_to, deformation), memory);
        bodies_.add_wrench(joint, pose.act(force), wrench);
        if (stiffness) blocks_.add(j, joint.stiffness(pose, joint.stiffness_tangent(deformation, memory)), stiffness);
        if (damping) blocks_.add(j, joint.stiffness(pose, joint.damping_tangent(deformation)), damping);
    }
}

void BodyJoints::start(const dttmm_motion* motions, const double* accelerations) {
    for (int p = 0; p < bodies_.count(); ++p) mechanism_.frames[as_size(p)] = bodies_.seen(p, motions).copy();
    mechanism_.start_joints([&](int frame) { return bodies_.velocity(frame, motions); },
                            [&](int frame) { return bodies_.acceleration(frame, accelerations); });
}

double BodyJoints::find_worst_prediction(const dttmm_motion* motions) {
    double worst = 0;
    for (LawLook& last : law_looks_) {
        const Joint& joint = mechanism_.joints[last.joint];
        const Ends at = bodies_.seen(joint, motions);
        const double x = joint.deformation(joint.pose(at), at.from, at.to)(last.direction),
                     now = mechanism_.states[last.joint].deformation()(last.direction);
        const Joint::OnPath path = joint.on_path(mechanism_.scheme, last.direction, now, x, mechanism_.memory(last.joint));
        const double predicted = last.force + last.gain * (x - last.x),
                     largest = std::max(std::abs(path.force), std::abs(predicted));
        if (largest > 0) worst = std::max(worst, std::abs(path.force - predicted) / largest);
        last.x = x;
        last.force = path.force;
        last.gain = path.gain;
    }
    return worst;
}

void BodyJoints::evaluate(const dttmm_motion* motions, double* wrench, double* stiffness) const {
    if (mechanism_.scheme.is_implicit()) {
        by_four_.add_forces(bodies_, motions, wrench);
        evaluate_singles(motions, wrench);
        if (stiffness) add_stiffness_of_linear(motions, stiffness);
        evaluate_with_laws(motions, wrench, stiffness);
        return;
    }
    for (size_t j = 0; j < mechanism_.joints.size(); ++j)  // the trial is not looked at
        bodies_.add_wrench(mechanism_.joints[j], mechanism_.states[j].known, wrench);
}

[[gnu::always_inline]] inline void BodyJoints::add_stiffness(size_t j, Ends at, double* stiffness) const {
    const Joint& joint = mechanism_.joints[j];
    const JointState& state = mechanism_.states[j];
    const JointPose end = joint.pose(at);
    const Vector6 deformation = joint.deformation(end, at.from, at.to);
    blocks_.add(j,
                joint.stiffness(end, joint.gain(mechanism_.scheme, state.deformation(), deformation, mechanism_.memory(j))),
                stiffness);
    // The force that acts as at t_n: that of a trial far from the solution may be any
    const Vector3 acting = mechanism_.scheme.elastic_weight(0) * state.elastic.force;
    blocks_.add(j, joint.acting_stiffness(end, at.from, at.to, acting), stiffness);
}

DTTMM_WIDE void BodyJoints::evaluate_singles(const dttmm_motion* motions, double* wrench) const {
    for (size_t j : by_four_.others()) {
        const Joint& joint = mechanism_.joints[j];
        bodies_.add_wrench(
            joint,
            joint.over_step(mechanism_.scheme, bodies_.seen(joint, motions), mechanism_.states[j], mechanism_.damper(j)),
            wrench);
    }
}

/// One by one: stiffness is asked for when the matrix of the bodies is formed, which is seldom.
DTTMM_WIDE void BodyJoints::add_stiffness_of_linear(const dttmm_motion* motions, double* stiffness) const {
    for (size_t j : linear_) add_stiffness(j, bodies_.seen(mechanism_.joints[j], motions), stiffness);
}

/// Not wide: what throws must not pass a function that is compiled for several processors (g++ 12 ends the process then).
void BodyJoints::evaluate_with_laws(const dttmm_motion* motions, double* wrench, double* stiffness) const {
    for (size_t j : with_laws_) {
        const Joint& joint = mechanism_.joints[j];
        const Ends at = bodies_.seen(joint, motions);
        const JointPose at_end = joint.pose(at);
        const JointState& state = mechanism_.states[j];
        const double* const memory = mechanism_.memory(j);
        bodies_.add_wrench(joint,
                           joint.weigh(mechanism_.scheme, joint.strain(mechanism_.scheme, at, at_end, state, memory), at_end,
                                       state, mechanism_.damper(j), memory),
                           wrench);
        if (stiffness) add_stiffness(j, at, stiffness);
    }
}

void BodyJoints::commit(const dttmm_motion* motions, std::vector<Frame>& earlier) {
    for (const Joint& joint : mechanism_.joints) {
        const auto [from, to] = bodies_.seen(joint, motions);
        joint.refuse_large_rotation(from, to);
    }
    by_four_.advance(mechanism_, bodies_, motions);
    for (const std::vector<size_t>* list : {&by_four_.others(), &std::as_const(with_laws_)})
        for (size_t j : *list) {
            const Joint& joint = mechanism_.joints[j];
            joint.advance(mechanism_.scheme, bodies_.seen(joint, motions), mechanism_.ends(j), mechanism_.states[j],
                          mechanism_.damper(j), mechanism_.law_memory_of(j), nullptr);
        }
    earlier.swap(mechanism_.before);
    mechanism_.before.swap(mechanism_.frames);
    for (int p = 0; p < bodies_.count(); ++p) mechanism_.frames[as_size(p)] = bodies_.seen(p, motions).copy();
}

}  // namespace dttmm::plugin
