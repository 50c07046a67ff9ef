// SPDX-License-Identifier: BSD-3-Clause
//
// Where the inside of a network stands and how it moves at the start.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "time/interior.h"
#include "time/interior_parts.h"

namespace dttmm::plugin {

namespace {

/// A step so long that nothing has inertia in it and no damper resists: its matrix is β h² times the static stiffness.
constexpr double kLongStep = 1e4;
/// Of the largest speed [m/s or rad/s], in start velocities: rounding, and what the stiff hold of those given gives way.
constexpr double kTolerated = 1e-7;

/// A velocity for messages, without what is too small to count.
std::string text_of(Vector3 velocity, double least) {
    for (double& x : velocity)
        if (std::abs(x) <= least) x = 0;
    return fmt::format("({:.8g}, {:.8g}, {:.8g})", velocity.x(), velocity.y(), velocity.z());
}

}  // namespace

void Interior::linearise(const Mechanism& mechanism, Ports ports, double* wrench, double* stiffness) const {
    Mechanism sample = mechanism;
    sample.scheme.set_step_size(kLongStep);
    Interior scratch = *this;
    scratch.settle_at_start(sample, ports);
    scratch.balance_at_start(sample, 0, ports);
    const auto on = [&](int frame) { return frame < ports_ ? wrench + 6 * ports.bodies[frame] : nullptr; };
    for (size_t j : port_joints_) {
        const Joint& joint = sample.joints[j];
        Joint::add_wrench(scratch.start_force(sample, j, ports), on(joint.from()), on(joint.to()));
    }
    if (!stiffness) return;
    const Mechanism slow = at_rest(sample, kLongStep);
    scratch.factor_static(slow, [] {});
    scratch.find_responses(slow);
    scratch.write_stiffness(slow, stiffness);
    const Eigen::Index size = 6 * ports_;
    Eigen::Map<Eigen::VectorXd>(stiffness, size * size) /= mechanism.scheme.weight(0);
}

void Interior::follow(const Mechanism& mechanism, std::span<Vector6> motion) const {
    Mechanism sample = mechanism;
    for (size_t f = 0; f < sample.frames.size(); ++f) sample.frames[f] = make_frame(sample.assembly.frames[f].pose);
    Interior scratch = *this;
    const Mechanism slow = at_rest(sample, kLongStep);
    scratch.factor_static(slow, [] {});
    scratch.find_responses(slow);
    Eigen::VectorXd u(6 * ports_);
    for (int p = 0; p < ports_; ++p) u.segment<6>(6 * p) = in_axes(slow.frame(p), motion[static_cast<size_t>(p)]);
    for (int f = driven_; f < driven_ + count_; ++f) {
        const Vector6 v = scratch.response(at(f)) * u;
        const RowMajor3 R = slow.frame(f).axes();
        motion[static_cast<size_t>(f)] << R * head(v), R * tail(v);
    }
}

Twist Interior::start_velocity(int frame, Ports ports) const {
    if (is_inner(frame)) return past_.velocity[at(frame)];
    return frame < ports_ ? ports.twist(frame) : Twist{};
}

/// What a joint does at the start, when the frames are where they are; without rigid directions.
JointForce Interior::start_force(const Mechanism& mechanism, size_t j, Ports ports) const {
    const Joint& joint = mechanism.joints[j];
    const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
    const Twist v_from = start_velocity(joint.from(), ports), v_to = start_velocity(joint.to(), ports);
    const JointPose pose = joint.pose(from, to);
    const Vector6 x = joint.deformation(pose, from, to);
    return pose.act(joint.force(x, joint.rate(from, v_from, to, v_to, x), mechanism.memory(j)));
}

/// Puts the ports where they are, the inside where it is at the start, and finds the velocities of the inside: those given,
/// the rest such as to strain the network least.
void Interior::settle_at_start(Mechanism& mechanism, Ports ports) {
    for (size_t f = 0; f < mechanism.frames.size(); ++f) mechanism.frames[f] = make_frame(mechanism.assembly.frames[f].pose);
    bool moves = false;
    for (int p = 0; p < ports_; ++p) {
        mechanism.frames[static_cast<size_t>(p)] = ports[static_cast<size_t>(p)].copy();
        const Twist velocity = ports.twist(p);
        moves = moves || !velocity.linear.isZero(0) || !velocity.angular.isZero(0);
    }
    std::fill(past_.velocity.begin(), past_.velocity.end(), Twist{});
    std::fill(rigid_.begin(), rigid_.end(), 0.0);
    for (const Given& given : given_) moves = moves || given.moves;
    if (moves) find_start_velocities(mechanism, ports);
}

/// Gives massless frames between dampers the velocities at which these balance, unless they are given.
void Interior::balance_at_start(const Mechanism& mechanism, double h, Ports ports) {
    if (!massless_.has_balances()) return;
    velocities_ = past_.velocity;
    std::fill(rigid_at_start_.begin(), rigid_at_start_.end(), 0.0);
    massless_.find_instant(
        mechanism, MasslessFrames::Find::velocities, h, mechanism.frames,
        [&](size_t j) {
            const Joint& joint = mechanism.joints[j];
            const auto [from, to] = mechanism.ends(j);
            const auto now = [&](int frame) {
                return is_inner(frame) ? velocities_[at(frame)] : start_velocity(frame, ports);
            };
            const Vector6 deformation = joint.deformation(joint.pose(from, to), from, to);
            return MasslessFrames::Acting{deformation, joint.rate(from, now(joint.from()), to, now(joint.to())),
                                          joint.elastic(deformation, mechanism.memory(j))};
        },
        [&](size_t i) { return frame_load(i).load[1]; }, velocities_, corrections_, rigid_at_start_);
    for (size_t i = 0; i < given_.size(); ++i) {
        const int frame = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])].frame;
        if (given_[i].moves && is_inner(frame)) velocities_[at(frame)] = past_.velocity[at(frame)];
    }
    past_.velocity = velocities_;
}

void Interior::find_start_velocities(const Mechanism& mechanism, Ports ports) {
    const Mechanism slow = at_rest(mechanism, kLongStep);
    std::vector<Vector6> pull(inertias_.size(), Vector6::Zero()), r;
    std::vector<double> g(rigid_.size(), 0);
    for (size_t j : port_joints_) {
        const Joint& joint = slow.joints[j];
        const int frames[2] = {joint.from(), joint.to()};
        const Blocks K = blocks(slow, j, slow.frames);
        for (int end : {0, 1}) {
            if (frames[end] >= ports_) continue;
            const Vector6 u = in_axes(slow.frame(frames[end]), joined(ports.twist(frames[end])));
            if (is_inner(frames[1 - end])) pull[at(frames[1 - end])] -= K.between(1 - end, end) * u;
            const Vector6 held = rigid_rows(slow, j, local_columns(slow, j, end)) * u;
            for_each_rigid(joint, [&](int i, int direction) { g[rigid_row(j, i)] -= held(direction); });
        }
    }
    factor_static(slow, [&] {
        r = pull;
        hold_given(slow, r);
    });
    elimination_.solve(r, g);
    for (int i = 0; i < count_; ++i) {
        const RowMajor3 R = slow.frame(driven_ + i).axes();
        past_.velocity[static_cast<size_t>(i)] = {R * head(r[static_cast<size_t>(i)]), R * tail(r[static_cast<size_t>(i)])};
    }
}

/// Adds to the matrix and the load on the frames what moves nodes as they are given to.
void Interior::hold_given(const Mechanism& slow, std::vector<Vector6>& load) {
    constexpr double kHold = 1e12;  // stiffer than everything
    for (size_t i = 0; i < given_.size(); ++i) {
        const NodeSpec& spec = slow.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        if (!given_[i].moves || !is_inner(spec.frame)) continue;
        // v_node = v − offset × ω in the frame's axes
        Matrix6 G = Matrix6::Identity();
        G.topRightCorner<3, 3>() = -skew(spec.offset);
        const Vector6 given = in_axes(slow.frame(spec.frame), joined(given_[i].velocity));
        const Matrix6 own = elimination_.diagonal(spec.frame - driven_);
        const double translation = kHold * std::max(own.topLeftCorner<3, 3>().trace(), 1e-300);
        // What holds the translation at a lever turns the frame too, and must not drown what holds the rotation
        const double rotation = std::max(kHold * std::max(own.bottomRightCorner<3, 3>().trace(), 1e-300),
                                         spec.offset.squaredNorm() * translation);
        Vector6 weight;
        weight << Vector3::Constant(translation), Vector3::Constant(rotation);
        elimination_.add_diagonal(spec.frame - driven_, G.transpose() * weight.asDiagonal() * G);
        load[at(spec.frame)] += G.transpose() * weight.cwiseProduct(given);
    }
}

/// Of the velocities given to nodes, those that the rest of what is rigid has not left as they are.
void Interior::refuse_forbidden_velocities(const Mechanism& mechanism, Ports ports) const {
    double largest = 0;
    const auto look_at = [&](const Twist& v) { largest = std::max({largest, v.linear.norm(), v.angular.norm()}); };
    for (int p = 0; p < ports_; ++p) look_at(ports.twist(p));
    for (const Twist& velocity : past_.velocity) look_at(velocity);
    for (const Given& given : given_)
        if (given.moves) look_at(given.velocity);
    const double least = kTolerated * largest;
    for (size_t i = 0; i < given_.size(); ++i) {
        const NodeSpec& spec = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        if (!given_[i].moves || !is_inner(spec.frame)) continue;
        const Twist& given = given_[i].velocity;
        Twist left = past_.velocity[at(spec.frame)];
        left.linear += left.angular.cross(mechanism.frame(spec.frame).axes() * spec.offset);
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

void Interior::start(Mechanism& mechanism, Ports ports, const double* accelerations, const double* loads) {
    const double h = mechanism.scheme.step_size();
    settle_at_start(mechanism, ports);
    refuse_forbidden_velocities(mechanism, ports);
    books_ = {};
    read_loads(mechanism, loads);
    for (size_t k = 0; k < frame_loads_.size(); ++k) {
        FrameLoad& loaded = frame_loads_[k];
        loaded.load[1] = loaded.load[2] = load_at_end(k, mechanism.frame(driven_ + static_cast<int>(loaded_[k])));
    }

    balance_at_start(mechanism, h, ports);

    // Forces of the start, for the momentum half a step before it and the accelerations
    std::vector<Vector6> wrench(mechanism.frames.size(), Vector6::Zero());
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        Joint::add_wrench(start_force(mechanism, j, ports), wrench[static_cast<size_t>(joint.from())].data(),
                          wrench[static_cast<size_t>(joint.to())].data());
    }
    std::vector<Twist> acceleration(inertias_.size());
    for (size_t i = 0; i < inertias_.size(); ++i) {
        const Twist& velocity = past_.velocity[i];
        const Inertia& inertia = inertias_[i];
        const Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const FrameView view = frame;
        const RowMajor3 R = view.axes();
        Vector6 force = wrench[static_cast<size_t>(driven_) + i];
        if (load_of_[i] >= 0) force += frame_load(i).load[1];
        force.head<3>() += inertia.mass * gravity_;
        const Vector3 spin = R.transpose() * velocity.angular;
        momenta_[i] << inertia.mass * velocity.linear, R * (inertia.moment * spin);
        momenta_[i] -= 0.5 * h * force;
        past_.u[i] << R.transpose() * velocity.linear, spin;
        if (inertia.mass > 0) acceleration[i].linear = head(force) / inertia.mass;
        const Vector3 moment = R.transpose() * tail(force) - spin.cross(inertia.moment * spin);
        if (!massless_.is_massless(i, 1)) acceleration[i].angular = R * inertia.moment.fullPivLu().solve(moment);
    }
    past_.u_before = past_.u;
    past_.velocity_before = past_.velocity;
    const auto acceleration_of = [&](int frame) {
        if (is_inner(frame)) return acceleration[at(frame)];
        if (frame >= ports_) return Twist{};
        const double* a = accelerations + 6 * ports.bodies[frame];
        return Twist{Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    };
    mechanism.start_joints([&](int frame) { return start_velocity(frame, ports); }, acceleration_of);
    for (int p = 0; p < ports_; ++p) start_accelerations_[static_cast<size_t>(p)] = acceleration_of(p);
    mechanism.before = mechanism.frames;
    set_elastic(mechanism);
    for (size_t i = 0; i < massless_.frames().size(); ++i) {
        const size_t frame = massless_.frames()[i];
        FrameLoad& own = frame_load(frame);
        own.elastic[1] = own.elastic[2] = own.elastic[0];
        own.settled = -in_axes(mechanism.frame(driven_ + static_cast<int>(frame)), own.elastic[0]);
    }
    for (size_t p = 0; p < port_u_.size(); ++p) port_u_[p] = joined(ports.twist(static_cast<int>(p)));
    port_u_before_ = port_u_;
    trial_ = mechanism.frames;
    refactor(mechanism);
}

/// Loads on the inner nodes at the end of the step; none where `loads` is null.
void Interior::read_loads(const Mechanism& mechanism, const double* loads) {
    for (FrameLoad& loaded : frame_loads_) loaded.load[0].setZero();
    for (size_t i = 0; i < inner_nodes_.size(); ++i) {
        const NodeSpec& node = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        node_loads_[i] = loads ? Vector6(Eigen::Map<const Vector6>(loads + 6 * i)) : Vector6(Vector6::Zero());
        if (is_inner(node.frame)) frame_load(at(node.frame)).load[0] += node_loads_[i];
    }
}

/// Elastic forces on massless frames where the joints' memory is, as those at the end of the step.
void Interior::set_elastic(const Mechanism& mechanism) {
    for (size_t i : massless_.frames()) frame_load(i).elastic[0].setZero();
    for (size_t j : settling_joints_) {
        const Joint& joint = mechanism.joints[j];
        const auto elastic_on = [&](int frame) {
            return is_inner(frame) && massless_.index_of(at(frame)) >= 0 ? frame_load(at(frame)).elastic[0].data() : nullptr;
        };
        Joint::add_wrench(mechanism.states[j].elastic, elastic_on(joint.from()), elastic_on(joint.to()));
    }
}

}  // namespace dttmm::plugin
