// SPDX-License-Identifier: BSD-3-Clause
//
// Where the inside of a network stands and how it moves at the start, and how it follows slow motions from there.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "time/interior.h"
#include "time/interior_parts.h"

namespace dttmm::plugin {

namespace {

/// So slow [1/s] that springs alone resist, unless there are only dampers, or masses; 1e-2 to 1e-6 pass the same tests.
constexpr double kSlowRate = 1e-4;
/// Of the largest speed [m/s or rad/s], in start velocities: rounding, and what the stiff hold of those given gives way.
constexpr double kTolerated = 1e-7;

/// A velocity for messages, without what is too small to count.
std::string text_of(Vector3 velocity, double least) {
    for (double& x : velocity)
        if (std::abs(x) <= least) x = 0;
    return fmt::format("({:.8g}, {:.8g}, {:.8g})", velocity.x(), velocity.y(), velocity.z());
}

Vector6 in_world(FrameView frame, const Vector6& v) {
    Vector6 world;
    world << frame.axes() * v.head<3>(), frame.axes() * v.tail<3>();
    return world;
}

}  // namespace

// ---- Slow motions -------------------------------------------------------------------------------------------------------

/// hold(matrix): adds to it before it is factored. Where a motion is resisted by
/// nothing, inertias are made heavier and it is factored again.
template <class Hold>
Interior::Slow Interior::form_slow(const Mechanism& mechanism, const std::vector<Frame>& frames, const Hold& hold) const {
    Slow slow{frames, matrix_.factor, {}};
    for (size_t j : layout_.port_joints) slow.at_ports.push_back(dynamic_stiffness(mechanism, j, frames, kSlowRate));
    form_dynamic_stiffness(mechanism, frames, kSlowRate, slow.matrix);
    hold(slow.matrix);
    ++work_.factorisations;
    if (!slow.matrix.factor()) return slow;
    form_dynamic_stiffness(mechanism, frames, kSlowRate, slow.matrix);
    make_heavier(slow.matrix);
    hold(slow.matrix);
    factor(mechanism, slow.matrix, DTTMM_ERROR_SINGULAR);
    return slow;
}

/// motion: 6 per frame in its own axes, of the ports given; of the inner frames a load on them, in whose place it takes
/// their motion. q: takes the forces of rigid directions.
void Interior::follow(const Mechanism& mechanism, const Slow& slow, std::span<Vector6> motion, std::span<double> q) const {
    const auto inner = motion.subspan(as_size(layout_.driven));
    std::ranges::fill(q, 0.0);
    for (size_t k = 0; k < layout_.port_joints.size(); ++k) {
        const size_t j = layout_.port_joints[k];
        const Joint& joint = mechanism.joints[j];
        for (int end : {0, 1}) {
            if (joint.frame(end) >= layout_.ports) continue;
            const Vector6& u = motion[as_size(joint.frame(end))];
            const int other = joint.frame(1 - end);
            if (is_inner(other)) inner[at(other)] -= slow.at_ports[k].at[1 - end][end] * u;
            for_each_rigid(joint, [&](int i, int) { q[rigid_row(j, i)] -= slow.matrix.rigid(as_int(j), i, end).dot(u); });
        }
    }
    slow.matrix.solve(inner, q);
}

void Interior::follow(const Mechanism& mechanism, std::span<Vector6> motion) const {
    const std::vector<Frame> frames = frames_at_start(mechanism);
    const Slow slow = form_slow(mechanism, frames, [](Elimination&) {});
    for (size_t f = 0; f < motion.size(); ++f)
        motion[f] = f < as_size(layout_.ports) ? in_axes(frames[f], motion[f]) : Vector6(Vector6::Zero());
    std::vector<double> q(rigid_.size());
    follow(mechanism, slow, motion, q);
    for (size_t f = 0; f < motion.size(); ++f) motion[f] = in_world(frames[f], motion[f]);
}

void Interior::linearise(const Mechanism& mechanism, Ports ports, double* wrench, double* stiffness) const {
    Start start = place_at_start(mechanism, ports);
    balance_at_start(mechanism, 0, start);
    const auto on = [&](int frame) { return frame < layout_.ports ? wrench + 6 * ports.bodies[frame] : nullptr; };
    for (size_t j : layout_.port_joints) {
        const Joint& joint = mechanism.joints[j];
        Joint::add_wrench(start_force(mechanism, j, start), on(joint.from()), on(joint.to()));
    }
    if (!stiffness) return;
    const Slow slow = form_slow(mechanism, start.frames, [](Elimination&) {});
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * layout_.ports, 6 * layout_.ports);
    S.setZero();
    std::vector<Vector6> motion(mechanism.frames.size());
    std::vector<double> q(rigid_.size());
    for (int column = 0; column < 6 * layout_.ports; ++column) {
        std::ranges::fill(motion, Vector6::Zero());
        const auto port = as_size(column / 6);
        motion[port] = in_axes(start.frames[port], Vector6::Unit(column % 6));
        follow(mechanism, slow, motion, q);
        for (size_t k = 0; k < layout_.port_joints.size(); ++k) {
            const size_t j = layout_.port_joints[k];
            const Joint& joint = mechanism.joints[j];
            for (int row : {0, 1}) {
                const int frame = joint.frame(row);
                if (frame >= layout_.ports) continue;
                Vector6 force = Vector6::Zero();
                for (int end : {0, 1}) force += slow.at_ports[k].at[row][end] * motion[as_size(joint.frame(end))];
                for_each_rigid(joint,
                               [&](int i, int) { force += slow.matrix.rigid(as_int(j), i, row) * q[rigid_row(j, i)]; });
                S.block<6, 1>(6 * frame, column) += in_world(start.frames[as_size(frame)], force);
            }
        }
    }
}

// ---- The start ----------------------------------------------------------------------------------------------------------

/// What a joint does at the start; without rigid directions.
JointForce Interior::start_force(const Mechanism& mechanism, size_t j, const Start& start) const {
    const Joint& joint = mechanism.joints[j];
    const auto [from, to] = ends(joint, start.frames);
    const Twist &v_from = start.velocities[as_size(joint.from())], &v_to = start.velocities[as_size(joint.to())];
    const JointPose pose = joint.pose(from, to);
    const Vector6 x = joint.deformation(pose, from, to);
    return pose.act(joint.force(x, joint.rate(from, v_from, to, v_to, x), mechanism.memory(j)));
}

/// The frames as the network is described.
std::vector<Frame> Interior::frames_at_start(const Mechanism& mechanism) {
    std::vector<Frame> frames;
    frames.reserve(mechanism.assembly.frames.size());
    for (const FrameSpec& frame : mechanism.assembly.frames) frames.push_back(make_frame(frame.pose));
    return frames;
}

/// The ports where they are, the inside where it is at the start with the velocities given to nodes, the rest such as to
/// strain the network least.
Interior::Start Interior::place_at_start(const Mechanism& mechanism, Ports ports) const {
    Start start{frames_at_start(mechanism), std::vector<Twist>(mechanism.frames.size())};
    bool moves = std::ranges::any_of(layout_.given, &InteriorLayout::Given::moves);
    for (int p = 0; p < layout_.ports; ++p) {
        const auto port = as_size(p);
        start.frames[port] = ports[port].copy();
        start.velocities[port] = ports.twist(p);
        moves = moves || !start.velocities[port].linear.isZero(0) || !start.velocities[port].angular.isZero(0);
    }
    if (!moves) return start;
    std::vector<Vector6> motion(mechanism.frames.size(), Vector6::Zero());
    for (size_t p = 0; p < as_size(layout_.ports); ++p) motion[p] = in_axes(start.frames[p], joined(start.velocities[p]));
    std::vector<Vector6> hold(mechanism.frames.size());
    const Slow slow = form_slow(mechanism, start.frames, [&](Elimination& matrix) {
        std::ranges::fill(hold, Vector6::Zero());
        hold_given(mechanism, start, matrix, hold);
    });
    for (auto f = as_size(layout_.driven); f < motion.size(); ++f) motion[f] = hold[f];
    std::vector<double> q(rigid_.size());
    follow(mechanism, slow, motion, q);
    for (auto f = as_size(layout_.driven); f < motion.size(); ++f) {
        const Vector6 v = in_world(start.frames[f], motion[f]);
        start.velocities[f] = {head(v), tail(v)};
    }
    return start;
}

/// Adds to the matrix, and to the load on the frames, what moves nodes as they are given to.
void Interior::hold_given(const Mechanism& mechanism, const Start& start, Elimination& matrix,
                          std::vector<Vector6>& load) const {
    constexpr double kHold = 1e12;  // stiffer than everything
    for (size_t i = 0; i < layout_.given.size(); ++i) {
        const NodeSpec& spec = mechanism.assembly.nodes[as_size(layout_.inner_nodes[i])];
        if (!layout_.given[i].moves || !is_inner(spec.frame)) continue;
        const auto frame = as_size(spec.frame);
        // v_node = v − offset × ω in the frame's axes
        Matrix6 G = Matrix6::Identity();
        G.topRightCorner<3, 3>() = -skew(spec.offset);
        const Vector6 given = in_axes(start.frames[frame], joined(layout_.given[i].velocity));
        const Matrix6 own = matrix.diagonal(spec.frame - layout_.driven);
        const double translation = kHold * std::max(own.topLeftCorner<3, 3>().trace(), 1e-300);
        // What holds the translation at a lever turns the frame too, and must not drown what holds the rotation
        const double rotation = std::max(kHold * std::max(own.bottomRightCorner<3, 3>().trace(), 1e-300),
                                         spec.offset.squaredNorm() * translation);
        Vector6 weight;
        weight << Vector3::Constant(translation), Vector3::Constant(rotation);
        matrix.add_diagonal(spec.frame - layout_.driven, G.transpose() * weight.asDiagonal() * G);
        load[frame] += G.transpose() * weight.cwiseProduct(given);
    }
}

/// Gives massless frames between dampers the velocities at which these balance, unless they are given.
void Interior::balance_at_start(const Mechanism& mechanism, double h, Start& start) const {
    if (!massless_.has_balances()) return;
    const auto first = start.velocities.begin() + layout_.driven;
    const std::vector<Twist> before(first, start.velocities.end());
    std::vector<Twist> velocities = before, corrections(before.size());
    std::vector<double> rigid(rigid_.size());
    massless_.find_instant(
        mechanism, h, start.frames,
        [&](size_t j) {
            const Joint& joint = mechanism.joints[j];
            const auto [from, to] = ends(joint, start.frames);
            const auto now = [&](int frame) {
                return is_inner(frame) ? velocities[at(frame)] : start.velocities[as_size(frame)];
            };
            const Vector6 deformation = joint.deformation(joint.pose(from, to), from, to);
            return MasslessFrames::Acting{deformation, joint.rate(from, now(joint.from()), to, now(joint.to())),
                                          joint.elastic(deformation, mechanism.memory(j))};
        },
        [&](size_t i) { return frame_load(i).load[1]; }, velocities, corrections, rigid);
    for (size_t i = 0; i < layout_.given.size(); ++i) {
        const int frame = mechanism.assembly.nodes[as_size(layout_.inner_nodes[i])].frame;
        if (layout_.given[i].moves && is_inner(frame)) velocities[at(frame)] = before[at(frame)];
    }
    std::ranges::copy(velocities, first);
}

/// Of the velocities given to nodes, those that the rest of what is rigid has not left as they are.
void Interior::refuse_forbidden_velocities(const Mechanism& mechanism, const Start& start) const {
    double largest = 0;
    const auto look_at = [&](const Twist& v) { largest = std::max({largest, v.linear.norm(), v.angular.norm()}); };
    for (const Twist& velocity : start.velocities) look_at(velocity);
    for (const InteriorLayout::Given& given : layout_.given)
        if (given.moves) look_at(given.velocity);
    const double least = kTolerated * largest;
    for (size_t i = 0; i < layout_.given.size(); ++i) {
        const NodeSpec& spec = mechanism.assembly.nodes[as_size(layout_.inner_nodes[i])];
        if (!layout_.given[i].moves || !is_inner(spec.frame)) continue;
        const Twist& given = layout_.given[i].velocity;
        Twist left = start.velocities[as_size(spec.frame)];
        const FrameView frame = start.frames[as_size(spec.frame)];
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

void Interior::start(Mechanism& mechanism, Ports ports, const double* accelerations, const double* loads,
                     const std::vector<Frame>* at_rest) {
    const double h = mechanism.scheme.step_size();
    Start start = at_rest ? Start{*at_rest, std::vector<Twist>(at_rest->size())} : place_at_start(mechanism, ports);
    refuse_forbidden_velocities(mechanism, start);
    mechanism.frames = start.frames;
    std::fill(rigid_.begin(), rigid_.end(), 0.0);
    record_ = {};
    read_loads(loads);
    for (size_t k = 0; k < frame_loads_.size(); ++k) {
        FrameLoad& loaded = frame_loads_[k];
        loaded.load[1] = loaded.load[2] = load_at_end(k, mechanism.frame(layout_.driven + as_int(layout_.loaded[k])));
    }
    balance_at_start(mechanism, h, start);
    past_.velocity.assign(start.velocities.begin() + layout_.driven, start.velocities.end());

    // Forces of the start, for the momentum half a step before it and the accelerations
    std::vector<Vector6> wrench(mechanism.frames.size(), Vector6::Zero());
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        Joint::add_wrench(start_force(mechanism, j, start), wrench[as_size(joint.from())].data(),
                          wrench[as_size(joint.to())].data());
    }
    const std::vector<Twist> acceleration = start_inertias(mechanism, wrench);
    const auto acceleration_of = [&](int frame) {
        if (is_inner(frame)) return acceleration[at(frame)];
        if (frame >= layout_.ports) return Twist{};
        const double* a = accelerations + 6 * ports.bodies[frame];
        return Twist{Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    };
    mechanism.start_joints([&](int frame) { return start.velocities[as_size(frame)]; }, acceleration_of);
    for (int p = 0; p < layout_.ports; ++p) instant_.of_ports[as_size(p)] = acceleration_of(p);
    mechanism.before = mechanism.frames;
    set_elastic(mechanism);
    for (size_t i = 0; i < massless_.frames().size(); ++i) {
        const size_t frame = massless_.frames()[i];
        FrameLoad& own = frame_load(frame);
        own.elastic[1] = own.elastic[2] = own.elastic[0];
        own.settled = -in_axes(mechanism.frame(layout_.driven + as_int(frame)), own.elastic[0]);
    }
    for (size_t p = 0; p < port_u_.size(); ++p) port_u_[p] = joined(start.velocities[p]);
    port_u_before_ = port_u_;
    form_first_balance(mechanism);
    make_room_for_steps(mechanism);
    refactor(mechanism);
}

/// Momenta and motions of the step before the start, under the wrenches of the joints at the start; accelerations then.
std::vector<Twist> Interior::start_inertias(const Mechanism& mechanism, std::span<const Vector6> wrench) {
    const double h = mechanism.scheme.step_size();
    std::vector<Twist> acceleration(layout_.inertias.size());
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const Twist& velocity = past_.velocity[i];
        const Inertia& inertia = layout_.inertias[i];
        const RowMajor3 R = mechanism.frame(layout_.driven + as_int(i)).axes();
        Vector6 force = wrench[as_size(layout_.driven) + i];
        if (layout_.load_of[i] >= 0) force += frame_load(i).load[1];
        force.head<3>() += inertia.mass * layout_.gravity;
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
    return acceleration;
}

/// At the end of the step; none where `loads` is null.
void Interior::read_loads(const double* loads) {
    if (loads)
        std::copy_n(loads, open_.loads.size(), open_.loads.begin());
    else
        std::ranges::fill(open_.loads, 0.0);
}

/// Elastic forces on massless frames where the joints' memory is, as those at the end of the step.
void Interior::set_elastic(const Mechanism& mechanism) {
    for (size_t i : massless_.frames()) frame_load(i).elastic[0].setZero();
    for (size_t j : layout_.settling_joints) {
        const Joint& joint = mechanism.joints[j];
        const auto elastic_on = [&](int frame) {
            return is_inner(frame) && massless_.index_of(at(frame)) >= 0 ? frame_load(at(frame)).elastic[0].data() : nullptr;
        };
        Joint::add_wrench(mechanism.states[j].elastic, elastic_on(joint.from()), elastic_on(joint.to()));
    }
}

}  // namespace dttmm::plugin
