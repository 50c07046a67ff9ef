// SPDX-License-Identifier: BSD-3-Clause
#include "time/interior_layout.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace dttmm::plugin {

namespace {

/// Of moments of inertia; 0 about a principal axis that has none, as a rod has none about itself: there a moment says
/// nothing about the motion.
Matrix3 inverse_of(const Matrix3& moments) {
    constexpr double kNone = 1e-12;  // of the largest; a real part has a millionth or more
    const Eigen::SelfAdjointEigenSolver<Matrix3> principal(moments);
    const Vector3& values = principal.eigenvalues();
    if (values(0) > kNone * values(2)) return moments.inverse();
    const Vector3 inverse = (values.array() > kNone * values(2)).select(values.cwiseInverse(), 0.0);
    return principal.eigenvectors() * inverse.asDiagonal() * principal.eigenvectors().transpose();
}

}  // namespace

InteriorLayout::InteriorLayout(const Mechanism& mechanism, const dttmm_network& description, const MasslessFrames& massless,
                               const Loading& loading)
    : ports(mechanism.assembly.port_count),
      driven(mechanism.assembly.driven_count),
      count(mechanism.assembly.inner_count()),
      gravity(Eigen::Map<const Vector3>(description.gravity)) {
    read_nodes(description);
    inertias.reserve(as_size(count));
    inverse_moments.reserve(as_size(count));
    for (int f = 0; f < count; ++f) {
        const FrameSpec& frame = mechanism.assembly.frames[as_size(driven + f)];
        inertias.push_back({frame.mass, frame.inertia});
        inverse_moments.push_back(massless.is_massless(as_size(f), 1) ? Matrix3(Matrix3::Zero())
                                                                      : inverse_of(frame.inertia));
    }
    set_reaches(mechanism);
    choose_receivers(mechanism, massless);
    choose_near(mechanism);
    choose_loaded(loading, massless);
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (joint.from() < ports || joint.to() < ports) port_joints.push_back(j);
        rigid_index.push_back(joint.rigid().any() ? as_int(rigid_joints.size()) : -1);
        if (joint.rigid().any()) rigid_joints.push_back(j);
        if (massless.is_settling(j)) settling_joints.push_back(j);
    }
}

void InteriorLayout::read_nodes(const dttmm_network& description) {
    for (uint32_t i = 0; i < description.node_count; ++i) {
        const dttmm_node& node = description.nodes[i];
        if (node.kind != DTTMM_NODE_INNER) continue;
        inner_nodes.push_back(as_int(i));
        given.push_back(
            {node.moves != 0, {Eigen::Map<const Vector3>(node.velocity), Eigen::Map<const Vector3>(node.angular_velocity)}});
    }
}

void InteriorLayout::set_reaches(const Mechanism& mechanism) {
    port_reach.assign(as_size(ports), 0);
    for (const Inertia& inertia : inertias)
        reach.push_back(inertia.mass > 0 ? std::sqrt(inertia.moment.trace() / inertia.mass) : 0);
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const auto reach_out = [&](int frame, double length) {
            if (frame >= ports && !is_inner(frame)) return;
            double& longest = is_inner(frame) ? reach[at(frame)] : port_reach[as_size(frame)];
            longest = std::max(longest, length);
        };
        reach_out(joint.from(), joint.arm(0, from, to).norm());
        reach_out(joint.to(), joint.arm(1, from, to).norm());
    }
    for (double length : reach) {
        turn_weight.push_back(length * length);
        spin_weight.push_back(length > 0 ? 1 / (length * length) : 0);
    }
}

void InteriorLayout::choose_loaded(const Loading& loading, const MasslessFrames& massless) {
    load_of.assign(inertias.size(), -1);
    for (size_t i = 0; i < inertias.size(); ++i) {
        if (!loading.is_on(driven + as_int(i)) && massless.index_of(i) < 0) continue;
        load_of[i] = as_int(loaded.size());
        loaded.push_back(i);
    }
}

/// The nearest frame over joints that has mass and inertia, or a body of the host.
void InteriorLayout::choose_receivers(const Mechanism& mechanism, const MasslessFrames& massless) {
    const auto receives = [&](int frame) {
        if (!is_inner(frame)) return frame < ports;
        return massless.index_of(at(frame)) < 0;
    };
    std::vector<int> receiver(mechanism.frames.size(), -1);
    for (size_t f = 0; f < receiver.size(); ++f)
        if (receives(as_int(f))) receiver[f] = as_int(f);
    for (bool grows = true; grows;) {
        grows = false;
        for (const Joint& joint : mechanism.joints) {
            int &a = receiver[as_size(joint.from())], &b = receiver[as_size(joint.to())];
            if ((a < 0) == (b < 0) || !is_inner(a < 0 ? joint.from() : joint.to())) continue;  // not across the ground
            (a < 0 ? a : b) = std::max(a, b);
            grows = true;
        }
    }
    for (int f = driven; f < driven + count; ++f) receivers.push_back(receives(f) ? -1 : receiver[as_size(f)]);
}

/// What the ports feel: their own joints, and those of the frames whose receivers they are.
void InteriorLayout::choose_near(const Mechanism& mechanism) {
    std::vector<bool> at_port(mechanism.frames.size(), false);
    for (int f = 0; f < as_int(at_port.size()); ++f) {
        const bool is_received = is_inner(f) && receivers[at(f)] >= 0 && receivers[at(f)] < ports;
        if (f >= ports && !is_received) continue;
        at_port[as_size(f)] = true;
        port_frames.push_back(f);
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const bool is_near = at_port[as_size(mechanism.joints[j].from())] || at_port[as_size(mechanism.joints[j].to())];
        near_index.push_back(is_near ? as_int(near_joints.size()) : -1);
        if (is_near) near_joints.push_back(j);
    }
}

}  // namespace dttmm::plugin
