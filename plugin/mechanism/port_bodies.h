// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/index.h"
#include "dttmm_plugin.h"
#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// The ports of a network among the bodies of the host, whose arrays have 6 numbers per body. The first frames of its
/// mechanism are the ports.
struct PortBodies {
    const Mechanism& mechanism;
    const std::vector<uint32_t>& bodies;  ///< of every port

    int count() const { return mechanism.assembly.port_count; }
    Ports ports(const dttmm_motion* motions) const { return {motions, bodies.data()}; }
    /// A frame where the host has it; where it is no port, at t_n.
    FrameView seen(int frame, const dttmm_motion* motions) const {
        if (frame < count()) return motions[bodies[as_size(frame)]];
        return mechanism.frame(frame);
    }
    Ends seen(const Joint& joint, const dttmm_motion* motions) const {
        return {seen(joint.from(), motions), seen(joint.to(), motions)};
    }
    Twist velocity(int frame, const dttmm_motion* motions) const {
        return frame < count() ? ports(motions).twist(frame) : Twist{};
    }
    Twist acceleration(int frame, const double* accelerations) const {
        if (frame >= count()) return {};
        const double* a = accelerations + 6 * bodies[as_size(frame)];
        return {Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    }
    /// The numbers of a frame's body; NULL: it is no port.
    double* on_body(int frame, double* wrenches) const {
        return frame < count() ? wrenches + 6 * bodies[as_size(frame)] : nullptr;
    }
    void add_wrench(int port, const Vector6& wrench, double* wrenches) const {
        Eigen::Map<Vector6>{on_body(port, wrenches)} += wrench;
    }
    void add_wrench(const Joint& joint, const JointForce& force, double* wrenches) const {
        Joint::add_wrench(force, on_body(joint.from(), wrenches), on_body(joint.to(), wrenches));
    }
    /// One port after the other, out of the numbers of the bodies.
    std::vector<Vector6> gather(const double* numbers) const {
        std::vector<Vector6> own;
        for (uint32_t body : bodies) own.emplace_back(Eigen::Map<const Vector6>(numbers + 6 * body));
        return own;
    }
};

}  // namespace dttmm::plugin
