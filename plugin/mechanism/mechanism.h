// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/index.h"
#include "mechanism/assembly.h"
#include "mechanism/joint.h"
#include "mechanism/scheme.h"

namespace dttmm::plugin {

/// The frames and joints of a network with their memory: what its phases work on.
struct Mechanism {
    /// supported_by: as assemble() has it.
    explicit Mechanism(const dttmm_network& description, std::span<const int> supported_by = {});

    Assembly assembly;
    Scheme scheme;
    std::vector<Joint> joints;
    std::vector<JointState> states;
    std::vector<int> damper_of;  ///< index of each joint's DamperState; −1: it has none
    std::vector<DamperState> dampers;
    std::vector<Frame> frames;  ///< all at t_n
    std::vector<Frame> before;  ///< all at t_{n−1}
    uint64_t steps = 0;         ///< committed since the start

    std::vector<double> law_memory, law_memory_before;  ///< of the laws of all joints, at t_n and at t_{n−1}
    std::vector<int> memory_of;                         ///< where each joint's begins in them; −1: its laws keep none

    /// What the laws of a joint remember at t_n, at t_{n−1}; NULL: nothing.
    const double* memory(size_t joint) const { return at_memory(law_memory, joint); }
    const double* memory_before(size_t joint) const { return at_memory(law_memory_before, joint); }
    LawMemory law_memory_of(size_t joint) { return {at_memory(law_memory, joint), at_memory(law_memory_before, joint)}; }
    template <class List>
    auto at_memory(List& all, size_t joint) const -> decltype(all.data()) {
        return memory_of[joint] < 0 ? nullptr : &all[as_size(memory_of[joint])];
    }
    DamperState* damper(size_t joint) { return damper_of[joint] < 0 ? nullptr : &dampers[as_size(damper_of[joint])]; }
    const DamperState* damper(size_t joint) const {
        return damper_of[joint] < 0 ? nullptr : &dampers[as_size(damper_of[joint])];
    }
    /// Rotation θ of a joint at t_n [rad], its axes; zero where it carries no moment.
    const Vector3& theta(size_t joint) const { return states[joint].theta; }
    /// Sets the memory of all joints by what velocity(frame) and acceleration(frame) say of their frames at the start.
    template <class Velocity, class Acceleration>
    void start_joints(const Velocity& velocity, const Acceleration& acceleration) {
        for (size_t j = 0; j < joints.size(); ++j) {
            const Joint& joint = joints[j];
            const auto [from, to] = ends(j);
            const Twist v_from = velocity(joint.from()), v_to = velocity(joint.to());
            joint.start(scheme, from, to, joint.rate(from, v_from, to, v_to),
                        joint.acceleration(from, v_from, acceleration(joint.from()), to, v_to, acceleration(joint.to())),
                        states[j], damper(j), law_memory_of(j));
        }
    }
    /// A joint at t_n.
    JointPose pose(size_t joint) const { return joints[joint].pose(ends(joint)); }
    Ends ends(size_t joint) const { return {frame(joints[joint].from()), frame(joints[joint].to())}; }
    FrameView frame(int index) const { return frames[as_size(index)]; }
    FrameView frame_before(int index) const { return before[as_size(index)]; }
};

/// All frames as the network is described.
std::vector<Frame> described_frames(const Mechanism& mechanism);

}  // namespace dttmm::plugin
