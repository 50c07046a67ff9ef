// SPDX-License-Identifier: BSD-3-Clause
#include "time/inside.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/rounding.h"
#include "statics/frame_links.h"

namespace dttmm::plugin {

namespace {

/// Of moments of inertia; 0 about a principal axis that has none, as a rod has none about itself: there a moment says
/// nothing about the motion.
Matrix3 inverse_of(const Matrix3& moments) {
    constexpr double kNone = kRoundingOfSums;  // of the largest; a real part has a millionth or more
    const Eigen::SelfAdjointEigenSolver<Matrix3> principal(moments);
    const Vector3& values = principal.eigenvalues();
    if (values(0) > kNone * values(2)) return moments.inverse();
    const Vector3 inverse = (values.array() > kNone * values(2)).select(values.cwiseInverse(), 0.0);
    return principal.eigenvectors() * inverse.asDiagonal() * principal.eigenvectors().transpose();
}

/// Translation and rotation of every inner frame: whether it has no mass, no inertia but rounding of that which the mass has
/// at a lever of a metre.
std::vector<std::array<bool, 2>> massless_halves(const Mechanism& mechanism) {
    std::vector<std::array<bool, 2>> halves;
    for (auto f = as_size(mechanism.assembly.driven_count); f < mechanism.assembly.frames.size(); ++f) {
        const FrameSpec& frame = mechanism.assembly.frames[f];
        halves.push_back({frame.mass == 0, frame.inertia.trace() <= kRoundingOfSums * frame.mass});
    }
    return halves;
}

}  // namespace

Inside::Inside(const Mechanism& whole, const dttmm_network& description, Loading all_loads)
    : mechanism(whole),
      massless(whole, massless_halves(whole)),
      balances(whole, massless),
      loading(std::move(all_loads)),
      gravity(Eigen::Map<const Vector3>(description.gravity)) {
    ports = whole.assembly.port_count;
    driven = whole.assembly.driven_count;
    count = whole.assembly.inner_count();
    read_nodes(description);
    inertias.reserve(as_size(count));
    inverse_moments.reserve(as_size(count));
    for (size_t i = 0; i < as_size(count); ++i) {
        const FrameSpec& frame = mechanism.assembly.frames[frame_of(i)];
        inertias.push_back({frame.mass, frame.inertia});
        inverse_moments.push_back(massless.is_massless(i, 1) ? Matrix3(Matrix3::Zero()) : inverse_of(frame.inertia));
    }
    set_reaches();
    massless.set_reach(reach);
    choose_receivers();
    choose_near();
    choose_loaded();
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (joint.from() < ports || joint.to() < ports) port_joints.push_back(j);
        rigid_index.push_back(joint.rigid().any() ? as_int(rigid_joints.size()) : -1);
        if (joint.rigid().any()) rigid_joints.push_back(j);
        if (massless.is_settling(j)) settling_joints.push_back(j);
    }
    make_room();
}

/// Of what is kept from step to step, and of what is small.
void Inside::make_room() {
    for (auto* list : {&past.u, &past.u_before, &momenta}) list->assign(as_size(count), Vector6::Zero());
    for (auto* list : {&past.velocity, &past.velocity_before}) list->resize(as_size(count));
    frame_loads.resize(loaded.size());
    const auto rows_of = [](const Joint& joint) { return joint.rigid().count(); };
    for (auto* list : {&rigid, &trial_q, &motion_q})
        list->assign(
            std::transform_reduce(mechanism.joints.begin(), mechanism.joints.end(), size_t{0}, std::plus(), rows_of), 0.0);
    for (auto* list : {&port_u, &port_u_before}) list->assign(as_size(ports), Vector6::Zero());
}

/// Of all frames: not before the start, as statics and slow motions take much memory for a while.
void Inside::make_room_for_steps() {
    motion.assign(as_size(count), Vector6::Zero());
    wrench.assign(mechanism.frames.size(), Vector6::Zero());
    trial = mechanism.frames;
}

Vector6 Inside::rigid_values(size_t j, const std::vector<double>& q) const {
    Vector6 f = Vector6::Zero();
    for_each_rigid(mechanism.joints[j], [&](int i, int d) { f(d) = q[rigid_row(j, i)]; });
    return f;
}

void Inside::place(std::span<const Vector6> u) { move_frames(step_size(), inner(mechanism.frames), u, inner(trial)); }

void Inside::place(size_t i, const Vector6& u) {
    const size_t f = frame_of(i);
    move_frames(step_size(), {&mechanism.frames[f], 1}, {&u, 1}, {&trial[f], 1});
}

int Inside::fastest_element(std::span<const Vector6> u) const {
    const auto size = [&](size_t i) { return u[i].head<3>().squaredNorm() + turn_weight[i] * u[i].tail<3>().squaredNorm(); };
    size_t worst = 0;
    for (size_t i = 1; i < inertias.size(); ++i)
        if (!(size(i) <= size(worst))) worst = i;
    return mechanism.assembly.frames[frame_of(worst)].element;
}

void Inside::read_nodes(const dttmm_network& description) {
    for (uint32_t i = 0; i < description.node_count; ++i) {
        const dttmm_node& node = description.nodes[i];
        if (node.kind != DTTMM_NODE_INNER) continue;
        inner_nodes.push_back(as_int(i));
        given.push_back(
            {node.moves != 0, {Eigen::Map<const Vector3>(node.velocity), Eigen::Map<const Vector3>(node.angular_velocity)}});
    }
}

void Inside::set_reaches() {
    port_reach.assign(as_size(ports), 0);
    for (const Inertia& inertia : inertias)
        reach.push_back(inertia.mass > 0 ? std::sqrt(inertia.moment.trace() / inertia.mass) : 0);
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const auto reach_out = [&](int frame, double length) {
            if (length < kSamePoint || (frame >= ports && !is_inner(frame))) return;
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

void Inside::choose_loaded() {
    load_of.assign(inertias.size(), -1);
    for (size_t i = 0; i < inertias.size(); ++i) {
        if (!loading.is_on(driven + as_int(i)) && massless.index_of(i) < 0) continue;
        load_of[i] = as_int(loaded.size());
        loaded.push_back(i);
    }
}

/// The nearest frame over joints that has mass and inertia, or a body of the host.
void Inside::choose_receivers() {
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
void Inside::choose_near() {
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
