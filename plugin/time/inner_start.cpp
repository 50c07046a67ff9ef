// SPDX-License-Identifier: BSD-3-Clause
#include "time/inner_start.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// Of the largest speed [m/s or rad/s], in start velocities: rounding of the numbers of a model.
constexpr double kTolerated = 1e-7;

/// A velocity for messages, without what is too small to count.
std::string text_of(Vector3 velocity, double least) {
    for (double& x : velocity)
        if (std::abs(x) <= least) x = 0;
    return fmt::format("({:.8g}, {:.8g}, {:.8g})", velocity.x(), velocity.y(), velocity.z());
}

}  // namespace

InnerStart::InnerStart(const Inside& inside, const std::vector<Frame>& frames)
    : inside_(inside), frames_(frames), velocities_(frames.size()) {}

InnerStart::InnerStart(const Inside& inside, const Elimination& pattern, Ports ports)
    : InnerStart(inside, described_frames(inside.mechanism)) {
    bool moves = std::ranges::any_of(inside.given, &Inside::Given::moves);
    for (int p = 0; p < inside.ports; ++p) {
        const auto port = as_size(p);
        frames_[port] = ports[port].copy();
        velocities_[port] = ports.twist(p);
        moves = moves || !velocities_[port].linear.isZero(0) || !velocities_[port].angular.isZero(0);
    }
    if (!moves) return;
    std::vector<Vector6> motion(frames_.size(), Vector6::Zero());
    for (size_t p = 0; p < as_size(inside.ports); ++p) motion[p] = in_axes(frames_[p], joined(velocities_[p]));
    const SlowMotion slow(inside, pattern, frames_, given_velocities());
    std::vector<double> q(inside.rigid.size());
    slow.follow(motion, q);
    for (auto f = as_size(inside.driven); f < motion.size(); ++f) {
        const Vector6 v = in_world(frames_[f], motion[f]);
        velocities_[f] = {head(v), tail(v)};
    }
}

std::vector<GivenVelocity> InnerStart::given_velocities() const {
    std::vector<GivenVelocity> all;
    for (size_t i = 0; i < inside_.given.size(); ++i) {
        const NodeSpec& spec = inside_.mechanism.assembly.nodes[as_size(inside_.inner_nodes[i])];
        if (inside_.given[i].moves && inside_.is_inner(spec.frame))
            all.push_back({inside_.at(spec.frame), spec.offset,
                           in_axes(frames_[as_size(spec.frame)], joined(inside_.given[i].velocity))});
    }
    return all;
}

void InnerStart::refuse_forbidden_velocities() const {
    double largest = 0;
    const auto look_at = [&](const Twist& v) { largest = std::max({largest, v.linear.norm(), v.angular.norm()}); };
    for (const Twist& velocity : velocities_) look_at(velocity);
    for (const Inside::Given& given : inside_.given)
        if (given.moves) look_at(given.velocity);
    const double least = kTolerated * largest;
    for (size_t i = 0; i < inside_.given.size(); ++i) {
        const NodeSpec& spec = inside_.mechanism.assembly.nodes[as_size(inside_.inner_nodes[i])];
        if (!inside_.given[i].moves || !inside_.is_inner(spec.frame)) continue;
        const Twist& given = inside_.given[i].velocity;
        Twist left = velocities_[as_size(spec.frame)];
        const FrameView frame = frames_[as_size(spec.frame)];
        left.linear += left.angular.cross(frame.axes() * spec.offset);
        if ((left.linear - given.linear).norm() <= least && (left.angular - given.angular).norm() <= least) continue;
        throw Error(DTTMM_ERROR_MODEL,
                    fmt::format("{}: it is to start with velocity {} m/s and angular velocity {} rad/s, but rigid or fixed "
                                "directions, or other nodes on its rigid body, leave it {} m/s and {} rad/s; give nodes and "
                                "bodies velocities that these allow",
                                spec.name, text_of(given.linear, least), text_of(given.angular, least),
                                text_of(left.linear, least), text_of(left.angular, least)),
                    spec.element);
    }
}

void InnerStart::balance(double h) {
    if (!inside_.balances.exist()) return;
    const Mechanism& mechanism = inside_.mechanism;
    const std::span<Twist> inner = inside_.inner(velocities_);
    const std::vector<Twist> before(inner.begin(), inner.end());
    std::vector<Twist> velocities = before, corrections(before.size());
    std::vector<double> rigid(inside_.rigid.size());
    inside_.balances.find_instant(
        mechanism, h, frames_,
        [&](size_t j) {
            const Joint& joint = mechanism.joints[j];
            const auto [from, to] = ends(joint, frames_);
            const auto now = [&](int frame) {
                return inside_.is_inner(frame) ? velocities[inside_.at(frame)] : velocity(frame);
            };
            const JointPose pose = joint.pose(from, to);
            const Vector6 deformation = joint.deformation(pose, from, to);
            return InstantBalances::Acting{deformation, joint.rate(pose, now(joint.from()), now(joint.to()), deformation),
                                           joint.elastic(deformation, mechanism.memory(j))};
        },
        [&](size_t i) { return inside_.frame_load(i).load[1]; }, velocities, corrections, rigid);
    for (size_t i = 0; i < inside_.given.size(); ++i) {
        const int frame = mechanism.assembly.nodes[as_size(inside_.inner_nodes[i])].frame;
        if (inside_.given[i].moves && inside_.is_inner(frame)) velocities[inside_.at(frame)] = before[inside_.at(frame)];
    }
    std::ranges::copy(velocities, inner.begin());
}

JointForce InnerStart::force(size_t j) const {
    const Joint& joint = inside_.mechanism.joints[j];
    const auto [from, to] = ends(joint, frames_);
    const JointPose pose = joint.pose(from, to);
    const Vector6 x = joint.deformation(pose, from, to);
    return pose.act(
        joint.force(x, joint.rate(pose, velocity(joint.from()), velocity(joint.to()), x), inside_.mechanism.memory(j)));
}

std::vector<Twist> InnerStart::set_inertias(Inside& inside, std::span<const Vector6> wrenches) const {
    const double h = inside.step_size();
    const std::span<const Twist> velocities = inner_velocities();
    inside.past.velocity.assign(velocities.begin(), velocities.end());
    std::vector<Twist> acceleration(velocities.size());
    for (size_t i = 0; i < velocities.size(); ++i) {
        const Twist& velocity = velocities[i];
        const Inertia& inertia = inside.inertias[i];
        const RowMajor3 R = FrameView(frames_[inside.frame_of(i)]).axes();
        Vector6 force = wrenches[inside.frame_of(i)];
        if (inside.load_of[i] >= 0) force += inside.frame_load(i).load[1];
        force.head<3>() += inertia.mass * inside.gravity;
        const Vector3 spin = R.transpose() * velocity.angular;
        inside.momenta[i] << inertia.mass * velocity.linear, R * (inertia.moment * spin);
        inside.momenta[i] -= 0.5 * h * force;
        inside.past.u[i] << R.transpose() * velocity.linear, spin;
        if (inertia.mass > 0) acceleration[i].linear = head(force) / inertia.mass;
        const Vector3 moment = R.transpose() * tail(force) - spin.cross(inertia.moment * spin);
        if (!inside.massless.is_massless(i, 1)) acceleration[i].angular = R * inertia.moment.fullPivLu().solve(moment);
    }
    inside.past.u_before = inside.past.u;
    inside.past.velocity_before = inside.past.velocity;
    return acceleration;
}

}  // namespace dttmm::plugin
