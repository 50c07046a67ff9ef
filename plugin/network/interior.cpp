// SPDX-License-Identifier: BSD-3-Clause
#include "network/interior.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation.h"
#include "core/state_vector.h"

namespace dttmm {

namespace {

using Map3 = Eigen::Map<Vector3>;
using MapR = Eigen::Map<RowMajor3>;

/// A kept rate of convergence is trusted half as much with every step that did not measure it anew.
constexpr double kForget = 2;
/// Slower than this, the matrix is formed anew.
constexpr double kSlowestContraction = 0.1;
/// Of a frame's place, in the corrections: nothing finer can be asked for.
constexpr double kRounding = 1e-14;
/// Of a step at which a network is first looked at, to see that it can be solved.
constexpr double kTrialStep = 1e-3;
/// A step so long that nothing has inertia in it and no damper resists: its matrix is β h² times the static stiffness.
constexpr double kLongStep = 1e4;

Vector6 joined(const Twist& twist) {
    Vector6 v;
    v << twist.linear, twist.angular;
    return v;
}
Vector3 head(const Vector6& v) { return v.head<3>(); }
Vector3 tail(const Vector6& v) { return v.tail<3>(); }

std::vector<Link> links_of(const Mechanism& mechanism) {
    const int driven = mechanism.assembly.driven_count;
    std::vector<Link> links;
    for (const Joint& joint : mechanism.joints)
        links.push_back({std::max(joint.from() - driven, -1), std::max(joint.to() - driven, -1),
                         static_cast<int>(joint.rigid().count())});
    return links;
}

/// Rigid directions of a joint, ascending.
template <class Function>
void for_each_rigid(const Joint& joint, const Function& function) {
    int i = 0;
    for (int d = 0; d < 6; ++d)
        if (joint.rigid()[static_cast<size_t>(d)]) function(i++, d);
}

/// The mechanism with its joints where its frames are and nothing moving, at a step size.
Mechanism at_rest(const Mechanism& mechanism, double step_size) {
    Mechanism rest = mechanism;
    rest.scheme.set_step_size(step_size);
    for (size_t j = 0; j < rest.joints.size(); ++j) {
        Joint& joint = rest.joints[j];
        joint.set_scheme(rest.scheme);
        joint.start(rest.scheme, rest.frame(joint.from()), rest.frame(joint.to()), Vector6::Zero(), Vector6::Zero(),
                    rest.states[j], rest.turn(j));
    }
    return rest;
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Interior::Interior(const Mechanism& mechanism, const dttmm_network& description)
    : ports_(mechanism.assembly.port_count),
      driven_(mechanism.assembly.driven_count),
      count_(mechanism.assembly.inner_count()),
      gravity_(Eigen::Map<const Vector3>(description.gravity)),
      elimination_(count_, links_of(mechanism)) {
    if (!mechanism.scheme.is_implicit())
        throw Error(DTTMM_ERROR_MODEL,
                    "it hangs on a node that is no body, or has a mass of its own: that wants the implicit coupling", 0);
    const auto n = static_cast<size_t>(count_);
    for (uint32_t i = 0; i < description.node_count; ++i) {
        if (description.nodes[i].kind != DTTMM_NODE_INNER) continue;
        inner_nodes_.push_back(static_cast<int>(i));
        node_data_.push_back(description.nodes[i]);
    }
    for (int f = 0; f < count_; ++f) {
        const FrameSpec& frame = mechanism.assembly.frames[static_cast<size_t>(driven_ + f)];
        inertias_.push_back({frame.mass, frame.inertia, 0, {Balance::momentum, Balance::momentum}, -1});
    }
    set_reaches(mechanism);
    set_balances(mechanism);
    choose_heirs(mechanism);
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        if (mechanism.joints[j].from() < ports_ || mechanism.joints[j].to() < ports_) port_joints_.push_back(j);
    state_.resize(n);
    for (auto* list : {&u_, &r_, &momentum_}) list->assign(n, Vector6::Zero());
    for (auto* list : {&wrench_, &half_wrench_}) list->assign(mechanism.frames.size(), Vector6::Zero());
    const auto rigid = static_cast<size_t>(elimination_.rigid_count());
    for (auto* list : {&rigid_, &rigid_before_}) list->assign(rigid, 0);
    for (auto* list : {&g_, &q_}) list->assign(rigid, 0);
    trial_ = mechanism.frames;
    responses_.assign(n, Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 6 * ports_));
    rigid_responses_.setZero(static_cast<Eigen::Index>(rigid), 6 * ports_);

    const Mechanism sample = at_rest(mechanism, kTrialStep);
    assemble(sample);
    factor(sample, DTTMM_ERROR_MODEL);
}

void Interior::set_reaches(const Mechanism& mechanism) {
    for (Inertia& inertia : inertias_)
        if (inertia.mass > 0) inertia.reach = std::sqrt(inertia.moment.trace() / inertia.mass);
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        if (is_inner(joint.from()))
            inertias_[at(joint.from())].reach = std::max(inertias_[at(joint.from())].reach, joint.arm(from, to).norm());
        if (is_inner(joint.to()))
            inertias_[at(joint.to())].reach = std::max(inertias_[at(joint.to())].reach, joint.lever(to).norm());
    }
}

void Interior::set_balances(const Mechanism& mechanism) {
    std::vector<bool> settles(inertias_.size(), true);
    for (const Joint& joint : mechanism.joints)
        for (int frame : {joint.from(), joint.to()})
            if (is_inner(frame) && (joint.is_damped() || joint.rigid().any())) settles[at(frame)] = false;
    for (size_t i = 0; i < inertias_.size(); ++i) {
        const Balance massless = settles[i]                          ? Balance::end_of_step
                                 : mechanism.scheme.is_trapezoidal() ? Balance::half_step
                                                                     : Balance::centred;
        if (inertias_[i].mass == 0) inertias_[i].balance[0] = massless;
        if (inertias_[i].moment.isZero(0)) inertias_[i].balance[1] = massless;
        for (Balance balance : inertias_[i].balance) settles_ = settles_ || balance == Balance::end_of_step;
    }
    for (const Joint& joint : mechanism.joints) {
        bool wanted = false;
        for (int frame : {joint.from(), joint.to()})
            if (is_inner(frame))
                for (Balance balance : inertias_[at(frame)].balance) wanted = wanted || balance == Balance::half_step;
        half_wanted_.push_back(wanted);
    }
}

/// The nearest frame over joints that has mass and inertia, or a body of the host.
void Interior::choose_heirs(const Mechanism& mechanism) {
    const auto inherits = [&](int frame) {
        if (!is_inner(frame)) return frame < ports_;
        const Inertia& inertia = inertias_[at(frame)];
        return inertia.balance[0] == Balance::momentum && inertia.balance[1] == Balance::momentum;
    };
    std::vector<int> heir(mechanism.frames.size(), -1);
    for (size_t f = 0; f < heir.size(); ++f)
        if (inherits(static_cast<int>(f))) heir[f] = static_cast<int>(f);
    for (bool grows = true; grows;) {
        grows = false;
        for (const Joint& joint : mechanism.joints) {
            int &a = heir[static_cast<size_t>(joint.from())], &b = heir[static_cast<size_t>(joint.to())];
            if ((a < 0) == (b < 0)) continue;
            (a < 0 ? a : b) = std::max(a, b);
            grows = true;
        }
    }
    for (size_t i = 0; i < inertias_.size(); ++i)
        if (!inherits(driven_ + static_cast<int>(i))) inertias_[i].heir = heir[static_cast<size_t>(driven_) + i];
}

// ---- The matrix ---------------------------------------------------------------------------------------------------------

Matrix6 Interior::local_by_from(const Mechanism& mechanism, size_t j) const {
    const Joint& joint = mechanism.joints[j];
    const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
    Matrix6 G = joint.by_from(from, to);
    for (int c : {0, 3}) G.middleCols<3>(c) = (G.middleCols<3>(c) * from.axes()).eval();
    return G;
}

Matrix6 Interior::local_by_to(const Mechanism& mechanism, size_t j) const {
    const Joint& joint = mechanism.joints[j];
    const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
    Matrix6 G = joint.by_to(from, to);
    for (int c : {0, 3}) G.middleCols<3>(c) = (G.middleCols<3>(c) * to.axes()).eval();
    return G;
}

Matrix6 Interior::mass_matrix(size_t frame) const {
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>().diagonal().setConstant(inertias_[frame].mass);
    M.bottomRightCorner<3, 3>() = inertias_[frame].moment;
    return M;
}

/// ∂f/∂d over a step, symmetric; the relative turn in place of θ.
Matrix6 Interior::gain(const Mechanism& mechanism, size_t j) const {
    const Joint& joint = mechanism.joints[j];
    Matrix6 gain = Matrix6::Zero();
    gain.topLeftCorner<3, 3>() = joint.translation_half().law.asDiagonal();
    if (!joint.turns()) return gain;
    const Matrix3 turn = joint.turn_gain(*mechanism.turn(j));
    gain.bottomRightCorner<3, 3>() = 0.5 * (turn + turn.transpose());
    return gain;
}

void Interior::assemble(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size(), square = h * h;
    elimination_.set_zero();
    for (int i = 0; i < count_; ++i) elimination_.add_diagonal(i, mass_matrix(static_cast<size_t>(i)));
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const Matrix6 Lambda = gain(mechanism, j);
        const Matrix6 G_from = local_by_from(mechanism, j), G_to = local_by_to(mechanism, j);
        const bool from_inside = is_inner(joint.from()), to_inside = is_inner(joint.to());
        if (from_inside) elimination_.add_diagonal(joint.from() - driven_, square * G_from.transpose() * Lambda * G_from);
        if (to_inside) elimination_.add_diagonal(joint.to() - driven_, square * G_to.transpose() * Lambda * G_to);
        if (from_inside && to_inside)
            elimination_.add_coupling(static_cast<int>(j), square * G_from.transpose() * Lambda * G_to);
        for_each_rigid(joint, [&](int i, int d) {
            elimination_.set_rigid(static_cast<int>(j), i, G_from.row(d).transpose(), G_to.row(d).transpose());
        });
    }
}

void Interior::factor(const Mechanism& mechanism, dttmm_status status) {
    ++factorisations_;
    if (const auto fault = elimination_.factor()) refuse(mechanism, *fault, status);
}

void Interior::refuse(const Mechanism& mechanism, const Elimination::Fault& fault, dttmm_status status) const {
    const FrameSpec& frame = mechanism.assembly.frames[static_cast<size_t>(driven_ + fault.frame)];
    if (fault.direction >= 0) {
        const bool is_massless = fault.direction < 3 ? frame.mass == 0 : frame.inertia.isZero(0);
        throw Error(
            status,
            fmt::format("{}: nothing determines its motion in {} (its own axes): {}no element holds it there", frame.name,
                        kDirectionNames[static_cast<size_t>(fault.direction)], is_massless ? "it has no mass, and " : ""),
            frame.element);
    }
    const Joint& joint = mechanism.joints[static_cast<size_t>(fault.link)];
    int direction = 0;
    for_each_rigid(joint, [&](int i, int d) {
        if (i == fault.rigid) direction = d;
    });
    throw Error(status,
                fmt::format("its rigid direction {} is driven from both ends: what it joins is held there by other rigid "
                            "directions too; give one of them a stiffness",
                            kDirectionNames[static_cast<size_t>(direction)]),
                joint.element());
}

void Interior::refactor(const Mechanism& mechanism) {
    assemble(mechanism);
    factor(mechanism, DTTMM_ERROR_SINGULAR);
    find_responses(mechanism);
}

/// How the inside follows a unit motion of each port.
void Interior::find_responses(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (int column = 0; column < 6 * ports_; ++column) {
        const int port = column / 6, c = column % 6;
        std::fill(r_.begin(), r_.end(), Vector6::Zero());
        std::fill(g_.begin(), g_.end(), 0.0);
        for (size_t j : port_joints_) {
            const Joint& joint = mechanism.joints[j];
            if (joint.from() != port && joint.to() != port) continue;
            const Matrix6 G_from = local_by_from(mechanism, j), G_to = local_by_to(mechanism, j);
            const Matrix6 Lambda = h * h * gain(mechanism, j);
            const bool is_from = joint.from() == port;
            const Vector6 d = (is_from ? G_from : G_to).col(c);
            const int other = is_from ? joint.to() : joint.from();
            if (is_inner(other)) r_[at(other)] -= (is_from ? G_to : G_from).transpose() * (Lambda * d);
            for_each_rigid(joint, [&](int i, int direction) {
                g_[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] = -d(direction);
            });
        }
        elimination_.solve(r_, g_);
        for (size_t i = 0; i < r_.size(); ++i) responses_[i].col(column) = r_[i];
        rigid_responses_.col(column) = Eigen::Map<const Eigen::VectorXd>(g_.data(), static_cast<Eigen::Index>(g_.size()));
    }
}

void Interior::write_stiffness(const Mechanism& mechanism, double* stiffness) const {
    // −δ(h W_p) = G_pᵀ (h² Λ D + q) δu,   D: the joint's deformation by the motion of all ports
    const double h = mechanism.scheme.step_size();
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * ports_, 6 * ports_);
    S.setZero();
    for (size_t j : port_joints_) {
        const Joint& joint = mechanism.joints[j];
        const Matrix6 G[2] = {local_by_from(mechanism, j), local_by_to(mechanism, j)};
        const int frames[2] = {joint.from(), joint.to()};
        Eigen::Matrix<double, 6, Eigen::Dynamic> D = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 6 * ports_);
        for (int end : {0, 1}) {
            if (is_inner(frames[end])) D += G[end] * responses_[at(frames[end])];
            if (frames[end] < ports_) D.middleCols<6>(6 * frames[end]) += G[end];
        }
        Eigen::Matrix<double, 6, Eigen::Dynamic> f = h * h * gain(mechanism, j) * D;
        for_each_rigid(joint, [&](int i, int d) {
            f.row(d) = rigid_responses_.row(elimination_.rigid_begin(static_cast<int>(j)) + i);
        });
        for (int end : {0, 1})
            if (frames[end] < ports_) S.middleRows<6>(6 * frames[end]) += G[end].transpose() * f;
    }
    for (int p = 0; p < ports_; ++p) {
        const Matrix3 R = mechanism.frame(p).axes();
        for (int half : {0, 3}) {
            S.middleRows<3>(6 * p + half) = (R * S.middleRows<3>(6 * p + half)).eval();
            S.middleCols<3>(6 * p + half) = (S.middleCols<3>(6 * p + half) * R.transpose()).eval();
        }
    }
    S /= h * h;
}

// ---- The start ----------------------------------------------------------------------------------------------------------

void Interior::linearise(const Mechanism& mechanism, const dttmm_motion* ports, double* wrench, double* stiffness,
                         double* damping) const {
    Mechanism sample = mechanism;
    sample.scheme.set_step_size(kLongStep);
    Interior scratch = *this;
    scratch.settle_at_start(sample, ports);
    const auto size = 6 * static_cast<size_t>(ports_);
    std::fill_n(wrench, size, 0.0);
    for (size_t j : port_joints_) {
        const Joint& joint = sample.joints[j];
        const FrameView from = sample.frame(joint.from()), to = sample.frame(joint.to());
        const Vector6 f = joint.force(
            from, to,
            joint.rate(from, scratch.start_velocity(joint.from(), ports), to, scratch.start_velocity(joint.to(), ports)));
        const Matrix3 R = joint.axes(from);
        joint.add_wrench(joint.arm(from, to), joint.lever(to), R * head(f), R * tail(f),
                         joint.from() < ports_ ? wrench + 6 * joint.from() : nullptr,
                         joint.to() < ports_ ? wrench + 6 * joint.to() : nullptr);
    }
    if (damping) std::fill_n(damping, size * size, 0.0);
    if (!stiffness) return;
    const Mechanism slow = at_rest(sample, kLongStep);
    scratch.refactor(slow);
    scratch.write_stiffness(slow, stiffness);
    Eigen::Map<Eigen::VectorXd>(stiffness, static_cast<Eigen::Index>(size * size)) /= mechanism.scheme.elastic_weight();
}

Twist Interior::start_velocity(int frame, const dttmm_motion* ports) const {
    if (is_inner(frame)) return state_[at(frame)].velocity;
    return frame < ports_ ? twist(ports[frame]) : Twist{};
}

/// Puts the ports where they are, the inside where it is at the start, and finds the velocities of the inside: those given,
/// the rest such as to strain the network least.
void Interior::settle_at_start(Mechanism& mechanism, const dttmm_motion* ports) {
    for (size_t f = 0; f < mechanism.frames.size(); ++f) mechanism.frames[f] = make_frame(mechanism.assembly.frames[f].pose);
    bool moves = false;
    for (int p = 0; p < ports_; ++p) {
        Frame& frame = mechanism.frames[static_cast<size_t>(p)];
        std::copy_n(ports[p].position, 3, frame.position);
        std::copy_n(ports[p].rotation, 9, frame.rotation);
        const Twist velocity = twist(ports[p]);
        moves = moves || !velocity.linear.isZero(0) || !velocity.angular.isZero(0);
    }
    for (State& state : state_) state.velocity = Twist{};
    for (const dttmm_node& node : node_data_) moves = moves || node.moves;
    if (moves) find_start_velocities(mechanism, ports);
}

void Interior::find_start_velocities(const Mechanism& mechanism, const dttmm_motion* ports) {
    constexpr double kHold = 1e12;  // stiffer than everything
    const Mechanism slow = at_rest(mechanism, kLongStep);
    assemble(slow);
    std::fill(r_.begin(), r_.end(), Vector6::Zero());
    std::fill(g_.begin(), g_.end(), 0.0);
    const double square = kLongStep * kLongStep;
    for (size_t j : port_joints_) {
        const Joint& joint = slow.joints[j];
        const int frames[2] = {joint.from(), joint.to()};
        const Matrix6 G[2] = {local_by_from(slow, j), local_by_to(slow, j)};
        for (int end : {0, 1}) {
            if (frames[end] >= ports_) continue;
            const Twist v = twist(ports[frames[end]]);
            const RowMajor3 R = slow.frame(frames[end]).axes();
            Vector6 u;
            u << R.transpose() * v.linear, R.transpose() * v.angular;
            const Vector6 d = G[end] * u;
            if (is_inner(frames[1 - end]))
                r_[at(frames[1 - end])] -= square * (G[1 - end].transpose() * (gain(slow, j) * d));
            for_each_rigid(joint, [&](int i, int direction) {
                g_[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] -= d(direction);
            });
        }
    }
    for (size_t i = 0; i < node_data_.size(); ++i) {
        const dttmm_node& node = node_data_[i];
        const NodeSpec& spec = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        if (!node.moves || !is_inner(spec.frame)) continue;
        // v_node = v − offset × … in the frame's axes
        const RowMajor3 R = slow.frame(spec.frame).axes();
        Matrix6 G = Matrix6::Identity();
        G.topRightCorner<3, 3>() = -skew(spec.offset);
        Vector6 given;
        given << R.transpose() * Eigen::Map<const Vector3>(node.velocity),
            R.transpose() * Eigen::Map<const Vector3>(node.angular_velocity);
        const Matrix6 own = elimination_.diagonal(spec.frame - driven_);
        const double translation = kHold * std::max(own.topLeftCorner<3, 3>().trace(), 1e-300);
        const double rotation = kHold * std::max(own.bottomRightCorner<3, 3>().trace(), 1e-300);
        Vector6 weight;
        weight << Vector3::Constant(translation), Vector3::Constant(rotation);
        elimination_.add_diagonal(spec.frame - driven_, G.transpose() * weight.asDiagonal() * G);
        r_[at(spec.frame)] += G.transpose() * weight.cwiseProduct(given);
    }
    factor(slow, DTTMM_ERROR_SINGULAR);
    elimination_.solve(r_, g_);
    for (int i = 0; i < count_; ++i) {
        const RowMajor3 R = slow.frame(driven_ + i).axes();
        State& state = state_[static_cast<size_t>(i)];
        state.velocity = {R * head(r_[static_cast<size_t>(i)]), R * tail(r_[static_cast<size_t>(i)])};
    }
}

void Interior::start(Mechanism& mechanism, const dttmm_motion* ports, const double* accelerations, const double* loads) {
    const double h = mechanism.scheme.step_size();
    settle_at_start(mechanism, ports);
    std::fill(rigid_.begin(), rigid_.end(), 0.0);
    std::fill(rigid_before_.begin(), rigid_before_.end(), 0.0);
    for (State& state : state_)
        for (Vector6& load : state.load) load.setZero();
    read_loads(mechanism, loads, 0);
    for (State& state : state_) state.load[1] = state.load[2] = state.load[0];
    books_ = {};

    // Forces of the start, for the momentum half a step before it and the accelerations
    std::fill(wrench_.begin(), wrench_.end(), Vector6::Zero());
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const Vector6 f = joint.force(
            from, to, joint.rate(from, start_velocity(joint.from(), ports), to, start_velocity(joint.to(), ports)));
        const Matrix3 R = joint.axes(from);
        joint.add_wrench(joint.arm(from, to), joint.lever(to), R * head(f), R * tail(f),
                         wrench_[static_cast<size_t>(joint.from())].data(), wrench_[static_cast<size_t>(joint.to())].data());
    }
    std::vector<Twist> acceleration(state_.size());
    for (size_t i = 0; i < state_.size(); ++i) {
        State& state = state_[i];
        const Inertia& inertia = inertias_[i];
        const Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const FrameView view = frame;
        const RowMajor3 R = view.axes();
        Vector6 force = wrench_[static_cast<size_t>(driven_) + i] + state.load[0];
        force.head<3>() += inertia.mass * gravity_;
        const Vector3 spin = R.transpose() * state.velocity.angular;
        state.momentum << inertia.mass * state.velocity.linear, R * (inertia.moment * spin);
        state.momentum -= 0.5 * h * force;
        state.u << R.transpose() * state.velocity.linear, spin;
        state.u_before = state.u;
        state.velocity_before = state.velocity;
        if (inertia.mass > 0) acceleration[i].linear = head(force) / inertia.mass;
        const Vector3 moment = R.transpose() * tail(force) - spin.cross(inertia.moment * spin);
        if (inertias_[i].balance[1] == Balance::momentum)
            acceleration[i].angular = R * inertia.moment.fullPivLu().solve(moment);
        books_.load_power += state.load[0].dot(joined(state.velocity));
    }
    const auto acceleration_of = [&](int frame) {
        if (is_inner(frame)) return acceleration[at(frame)];
        if (frame >= ports_) return Twist{};
        return Twist{Eigen::Map<const Vector3>(accelerations + 6 * frame),
                     Eigen::Map<const Vector3>(accelerations + 6 * frame + 3)};
    };
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const Twist v_from = start_velocity(joint.from(), ports), v_to = start_velocity(joint.to(), ports);
        joint.start(mechanism.scheme, from, to, joint.rate(from, v_from, to, v_to),
                    joint.acceleration(from, v_from, acceleration_of(joint.from()), to, v_to, acceleration_of(joint.to())),
                    mechanism.states[j], mechanism.turn(j));
    }
    find_imbalances(mechanism);
    for (State& state : state_) state.imbalance[1] = state.imbalance[0];
    trial_ = mechanism.frames;
    refactor(mechanism);
}

/// Loads on the inner nodes as wrenches at their frames' origins, at the end of the step (0) or earlier instants.
void Interior::read_loads(const Mechanism& mechanism, const double* loads, int instant) {
    const auto k = static_cast<size_t>(instant);
    for (State& state : state_) state.load[k].setZero();
    if (!loads) return;
    for (size_t i = 0; i < inner_nodes_.size(); ++i) {
        const NodeSpec& node = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        if (!is_inner(node.frame)) continue;
        const Eigen::Map<const Vector3> F(loads + 6 * i), M(loads + 6 * i + 3);
        Vector6& load = state_[at(node.frame)].load[k];
        load.head<3>() += F;
        load.tail<3>() += M + (mechanism.frame(node.frame).axes() * node.offset).cross(F);
    }
}

/// What is left at t_n of the forces on massless frames that balance at the end of every step: rounding, or a load that
/// jumped.
void Interior::find_imbalances(const Mechanism& mechanism) {
    if (!settles_) return;
    for (State& state : state_) {
        state.imbalance[1] = state.imbalance[0];
        state.imbalance[0] = state.load[0];
    }
    for (const Joint& joint : mechanism.joints) {
        const auto settling = [&](int frame) {
            return is_inner(frame) && (inertias_[at(frame)].balance[0] == Balance::end_of_step ||
                                       inertias_[at(frame)].balance[1] == Balance::end_of_step);
        };
        if (!settling(joint.from()) && !settling(joint.to())) continue;
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const Vector6 f = joint.force(from, to, Vector6::Zero());
        const Matrix3 R = joint.axes(from);
        joint.add_wrench(joint.arm(from, to), joint.lever(to), R * head(f), R * tail(f),
                         settling(joint.from()) ? state_[at(joint.from())].imbalance[0].data() : nullptr,
                         settling(joint.to()) ? state_[at(joint.to())].imbalance[0].data() : nullptr);
    }
}

// ---- A step -------------------------------------------------------------------------------------------------------------

void Interior::begin_step(const Mechanism& mechanism, const double* loads) { read_loads(mechanism, loads, 0); }

void Interior::predict() const {
    for (size_t i = 0; i < state_.size(); ++i) u_[i] = 2 * state_[i].u - state_[i].u_before;
    q_ = rigid_;
}

/// The inner frames at the end of the step.
void Interior::place(const Mechanism& mechanism) const {
    const double h = mechanism.scheme.step_size();
    for (size_t i = 0; i < state_.size(); ++i) {
        const size_t f = static_cast<size_t>(driven_) + i;
        const FrameView now = mechanism.frames[f];
        Frame& trial = trial_[f];
        Map3{trial.position} = now.origin() + h * (now.axes() * u_[i].head<3>());
        MapR{trial.rotation} = now.axes() * rotation_from_vector(h * u_[i].tail<3>());
    }
}

/// Wrenches of the joints over the step, on every frame at its origin.
void Interior::add_joint_forces(const Mechanism& mechanism) const {
    std::fill(wrench_.begin(), wrench_.end(), Vector6::Zero());
    std::fill(half_wrench_.begin(), half_wrench_.end(), Vector6::Zero());
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const auto a = static_cast<size_t>(joint.from()), b = static_cast<size_t>(joint.to());
        const FrameView from_now = mechanism.frames[a], to_now = mechanism.frames[b];
        const FrameView from = trial_[a], to = trial_[b];
        const JointState& state = mechanism.states[j];
        const TurnState* turn = mechanism.turn(j);
        const Vector3 arm = joint.arm(from_now, to_now), lever = joint.lever(to_now);
        const Matrix3 R = joint.axes(from_now);
        Vector3 f = joint.trial_force(from, joint.arm(from, to), state), m = Vector3::Zero();
        if (turn) m = joint.trial_moment(joint.trial_turn(from, to, *turn), *turn);
        Vector6 rigid = Vector6::Zero(), rigid_half = Vector6::Zero();
        for_each_rigid(joint, [&](int i, int d) {
            const auto row = static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i);
            rigid_half(d) = q_[row];
            rigid(d) = half_wanted_[j] ? q_[row] + rigid_[row] : q_[row];
        });
        if (half_wanted_[j]) {
            // F_{n+1/2}/2 = law δ₊ + k d/2
            const Vector3 f_half = f - state.translation.known +
                                   0.5 * joint.translation_half().stiffness.cwiseProduct(state.translation.d) +
                                   head(rigid_half);
            Vector3 m_half = Vector3::Zero();
            if (turn)
                m_half = m - turn->rotation.known +
                         turn->conjugate *
                             (0.5 * joint.rotation_half().stiffness.cwiseProduct(turn->rotation.d) + tail(rigid_half));
            joint.add_wrench(arm, lever, R * f_half, R * m_half, half_wrench_[a].data(), half_wrench_[b].data());
        }
        if (joint.rigid().any()) {
            f += head(rigid);
            if (turn) m += turn->conjugate * tail(rigid);
        }
        joint.add_wrench(arm, lever, R * f, R * m, wrench_[a].data(), wrench_[b].data());
    }
}

/// Hands what massless frames leave unbalanced of the centred forces to their heirs. It does not depend on the trial.
void Interior::pass_on_imbalances(const Mechanism& mechanism) const {
    const Scheme& scheme = mechanism.scheme;
    for (size_t i = 0; i < state_.size(); ++i) {
        const Inertia& inertia = inertias_[i];
        if (inertia.heir < 0) continue;
        const State& state = state_[i];
        const size_t f = static_cast<size_t>(driven_) + i, to = static_cast<size_t>(inertia.heir);
        Vector6 left = Vector6::Zero();
        for (int half : {0, 1}) {
            if (inertia.balance[half] == Balance::end_of_step)
                left.segment<3>(3 * half) = scheme.load_weight(1) * state.imbalance[0].segment<3>(3 * half) +
                                            scheme.load_weight(2) * state.imbalance[1].segment<3>(3 * half);
            if (inertia.balance[half] == Balance::half_step)
                left.segment<3>(3 * half) =
                    (wrench_[f] - half_wrench_[f] + 0.25 * (state.load[1] + state.load[2])).segment<3>(3 * half);
        }
        const Vector3 arm = mechanism.frame(static_cast<int>(f)).origin() - mechanism.frame(inertia.heir).origin();
        wrench_[to].head<3>() += head(left);
        wrench_[to].tail<3>() += tail(left) + arm.cross(head(left));
    }
}

/// What the equations lack at the trial motion: r in the frames' axes, g of the rigid directions.
void Interior::form_residuals(const Mechanism& mechanism) const {
    const Scheme& scheme = mechanism.scheme;
    const double h = scheme.step_size();
    for (size_t i = 0; i < state_.size(); ++i) {
        const size_t f = static_cast<size_t>(driven_) + i;
        const State& state = state_[i];
        const Inertia& inertia = inertias_[i];
        const FrameView now = mechanism.frames[f];
        const Vector6 load = scheme.load_weight(0) * state.load[0] + scheme.load_weight(1) * state.load[1] +
                             scheme.load_weight(2) * state.load[2];
        Vector6 impulse = h * (wrench_[f] + load);
        impulse.head<3>() += h * inertia.mass * gravity_;
        for (int half : {0, 1}) {
            Vector3 world = impulse.segment<3>(3 * half);
            switch (inertia.balance[half]) {
                case Balance::momentum:
                    world += state.momentum.segment<3>(3 * half);
                    break;
                case Balance::end_of_step:
                    world -= h * (scheme.load_weight(1) * state.imbalance[0].segment<3>(3 * half) +
                                  scheme.load_weight(2) * state.imbalance[1].segment<3>(3 * half));
                    break;
                case Balance::half_step:
                    world = h * (half_wrench_[f].segment<3>(3 * half) +
                                 0.25 * (state.load[0] + state.load[1]).segment<3>(3 * half));
                    break;
                case Balance::centred:
                    break;
            }
            r_[i].segment<3>(3 * half) = now.axes().transpose() * world;
        }
        if (inertia.balance[0] == Balance::momentum) {
            momentum_[i].head<3>() = inertia.mass * u_[i].head<3>();
            r_[i].head<3>() -= momentum_[i].head<3>();
        }
        if (inertia.balance[1] == Balance::momentum) {
            // L = exp(h w~/2) J w half way through the step
            const Vector3 w = u_[i].tail<3>();
            momentum_[i].tail<3>() = rotation_from_vector(0.5 * h * w) * (inertia.moment * w);
            r_[i].tail<3>() -= momentum_[i].tail<3>();
        }
    }
    if (g_.empty()) return;
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (joint.rigid().none()) continue;
        const FrameView from = trial_[static_cast<size_t>(joint.from())], to = trial_[static_cast<size_t>(joint.to())];
        Vector6 d;
        d << joint.translation(from, joint.arm(from, to)),
            joint.turns() ? rotation_vector(joint.attitude(from, to)) : Vector3(Vector3::Zero());
        for_each_rigid(joint, [&](int i, int direction) {
            g_[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] = -d(direction) / h;
        });
    }
}

/// Solves for the correction, applies it, and returns its size: the largest speed of a point.
double Interior::correct(double h) const {
    elimination_.solve(r_, g_);
    double largest = 0;
    for (size_t i = 0; i < r_.size(); ++i) {
        const double reach = inertias_[i].reach;
        u_[i] += r_[i];
        largest = std::max(largest, r_[i].head<3>().squaredNorm() + reach * reach * r_[i].tail<3>().squaredNorm());
    }
    for (size_t i = 0; i < g_.size(); ++i) q_[i] += g_[i] / h;
    return std::sqrt(largest);
}

void Interior::solve(const Mechanism& mechanism, const dttmm_motion* ports) const {
    const double h = mechanism.scheme.step_size();
    for (int p = 0; p < ports_; ++p) {
        std::copy_n(ports[p].position, 3, trial_[static_cast<size_t>(p)].position);
        std::copy_n(ports[p].rotation, 9, trial_[static_cast<size_t>(p)].rotation);
    }
    predict();
    double size = 0, speed = 0;
    for (size_t i = 0; i < u_.size(); ++i) {
        const Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const double reach = inertias_[i].reach;
        size =
            std::max(size, std::abs(frame.position[0]) + std::abs(frame.position[1]) + std::abs(frame.position[2]) + reach);
        speed = std::max(speed, u_[i].head<3>().squaredNorm() + reach * reach * u_[i].tail<3>().squaredNorm());
    }
    scale_ = std::max(books_.scale, std::sqrt(speed));
    contraction_ = std::min(kForget * books_.contraction, 1.0);
    rate_ = 0;
    const double floor = kRounding * size / h;
    double previous = 0;
    for (int pass = 0; pass < kMostPasses; ++pass) {
        ++passes_;
        place(mechanism);
        add_joint_forces(mechanism);
        pass_on_imbalances(mechanism);
        form_residuals(mechanism);
        const double correction = correct(h);
        if (!std::isfinite(correction)) break;
        if (pass > 0 && correction > floor) {
            rate_ = previous > 0 ? correction / previous : 0;
            contraction_ = rate_ < 1 ? rate_ / (1 - rate_) : 1e3;
        }
        previous = correction;
        if (pass == 0) scale_ = std::max(scale_, correction);
        if (correction <= floor || contraction_ * correction <= std::max(kTolerance * scale_, floor)) return;
    }
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("the motion inside the network was not found in {} passes (last correction {:.1e} m/s); try a "
                            "smaller step",
                            kMostPasses, previous),
                mechanism.assembly.frames.back().element);
}

/// What the last correction changes in the wrenches on the ports.
void Interior::add_port_changes(const Mechanism& mechanism, double* wrench) const {
    const double h = mechanism.scheme.step_size();
    for (size_t j : port_joints_) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        Vector6 d = Vector6::Zero();
        if (is_inner(joint.from())) d += local_by_from(mechanism, j) * r_[at(joint.from())];
        if (is_inner(joint.to())) d += local_by_to(mechanism, j) * r_[at(joint.to())];
        Vector6 f = Vector6::Zero();
        f.head<3>() = h * joint.translation_half().law.cwiseProduct(head(d));
        if (joint.turns()) f.tail<3>() = h * (joint.turn_gain(*mechanism.turn(j)) * tail(d));
        Vector6 rigid = Vector6::Zero();
        for_each_rigid(joint, [&](int i, int direction) {
            rigid(direction) = g_[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] / h;
        });
        f.head<3>() += head(rigid);
        if (joint.turns()) f.tail<3>() += mechanism.turn(j)->conjugate * tail(rigid);
        const Matrix3 R = joint.axes(from);
        joint.add_wrench(joint.arm(from, to), joint.lever(to), R * head(f), R * tail(f),
                         joint.from() < ports_ ? wrench + 6 * joint.from() : nullptr,
                         joint.to() < ports_ ? wrench + 6 * joint.to() : nullptr);
    }
}

void Interior::evaluate(const Mechanism& mechanism, const dttmm_motion* trial, double* wrench) const {
    solve(mechanism, trial);
    for (int p = 0; p < ports_; ++p) Eigen::Map<Vector6>{wrench + 6 * p} = wrench_[static_cast<size_t>(p)];
    add_port_changes(mechanism, wrench);
}

void Interior::commit(Mechanism& mechanism, const dttmm_motion* accepted) {
    const double h = mechanism.scheme.step_size();
    solve(mechanism, accepted);
    place(mechanism);
    mechanism.before = mechanism.frames;
    double power = 0;
    for (size_t i = 0; i < state_.size(); ++i) {
        State& state = state_[i];
        Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const RowMajor3 R = MapR(frame.rotation);
        // P(u) + M δ: what the linear equations give the frame, however well u agrees
        Vector6 momentum = momentum_[i];
        momentum.head<3>() += inertias_[i].mass * r_[i].head<3>();
        momentum.tail<3>() += inertias_[i].moment * r_[i].tail<3>();
        state.momentum << R * head(momentum), R * tail(momentum);
        state.velocity_before = state.velocity;
        state.velocity = {R * u_[i].head<3>(), R * u_[i].tail<3>()};
        if (mechanism.steps == 0) {  // the initial velocities are the mean of both
            state.velocity_before.linear = 2 * state.velocity_before.linear - state.velocity.linear;
            state.velocity_before.angular = 2 * state.velocity_before.angular - state.velocity.angular;
        }
        state.u_before = mechanism.steps == 0 ? u_[i] : state.u;
        state.u = u_[i];
        frame = trial_[static_cast<size_t>(driven_) + i];
        // One step of Newton keeps the axes orthonormal to rounding
        RowMajor3 next = MapR(frame.rotation);
        next += 0.5 * next * (RowMajor3::Identity() - next.transpose() * next);
        MapR{frame.rotation} = next;
        power += 0.5 * state.load[1].dot(joined(state.velocity) + joined(state.velocity_before));
        state.load[2] = state.load[1];
        state.load[1] = state.load[0];
    }
    for (int p = 0; p < ports_; ++p) mechanism.frames[static_cast<size_t>(p)] = trial_[static_cast<size_t>(p)];
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        joint.advance(mechanism.scheme, mechanism.steps, mechanism.frame(joint.from()), mechanism.frame(joint.to()),
                      mechanism.states[j], mechanism.turn(j));
    }
    rigid_before_ = rigid_;
    rigid_ = q_;
    if (mechanism.steps > 0) books_.load_work += 0.5 * h * (books_.load_power + power);
    books_.load_power = power;
    find_imbalances(mechanism);
    books_.contraction = contraction_;
    books_.scale = 0.98 * scale_;
    if (rate_ > kSlowestContraction) refactor(mechanism);
}

// ---- Results ------------------------------------------------------------------------------------------------------------

Twist Interior::velocity(const Mechanism& mechanism, int frame, const Vector3& offset) const {
    const State& state = state_[at(frame)];
    const Vector3 arm = FrameView(mechanism.before[static_cast<size_t>(frame)]).axes() * offset;
    const Vector3 w = 0.5 * (state.velocity.angular + state.velocity_before.angular);
    return {0.5 * (state.velocity.linear + state.velocity_before.linear) + w.cross(arm), w};
}

Twist Interior::acceleration(const Mechanism& mechanism, int frame, const Vector3& offset) const {
    const State& state = state_[at(frame)];
    const double h = mechanism.scheme.step_size();
    const Vector3 arm = FrameView(mechanism.before[static_cast<size_t>(frame)]).axes() * offset;
    const Vector3 w = 0.5 * (state.velocity.angular + state.velocity_before.angular);
    const Vector3 alpha = (state.velocity.angular - state.velocity_before.angular) / h;
    return {(state.velocity.linear - state.velocity_before.linear) / h + alpha.cross(arm) + w.cross(w.cross(arm)), alpha};
}

double Interior::kinetic_energy(const Mechanism& mechanism) const {
    double twice = 0;
    for (size_t i = 0; i < state_.size(); ++i) {
        const State& state = state_[i];
        const Vector3 v = 0.5 * (state.velocity.linear + state.velocity_before.linear);
        const Vector3 w = FrameView(mechanism.before[static_cast<size_t>(driven_) + i]).axes().transpose() *
                          (0.5 * (state.velocity.angular + state.velocity_before.angular));
        twice += inertias_[i].mass * v.squaredNorm() + w.dot(inertias_[i].moment * w);
    }
    return 0.5 * twice;
}

double Interior::work(const Mechanism& mechanism) const {
    double work = books_.load_work;
    for (size_t i = 0; i < state_.size(); ++i) {
        const Vector3& start = mechanism.assembly.frames[static_cast<size_t>(driven_) + i].pose.position;
        work +=
            inertias_[i].mass * gravity_.dot(FrameView(mechanism.before[static_cast<size_t>(driven_) + i]).origin() - start);
    }
    return work;
}

Twist Interior::momentum(const Mechanism& mechanism) const {
    // x_n × p = x_{n−1} × p, for p is along what leads from one to the other
    Twist total;
    for (size_t i = 0; i < state_.size(); ++i) {
        const Vector3 p = head(state_[i].momentum);
        total.linear += p;
        total.angular += mechanism.frame(driven_ + static_cast<int>(i)).origin().cross(p) + tail(state_[i].momentum);
    }
    return total;
}

Vector6 Interior::rigid_force(const Mechanism& mechanism, size_t j) const {
    Vector6 f = Vector6::Zero();
    for_each_rigid(mechanism.joints[j], [&](int i, int d) {
        const auto row = static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i);
        f(d) = rigid_[row] + (half_wanted_[j] ? rigid_before_[row] : 0);
        if (mechanism.steps == 1) f(d) *= 2;  // the first step carries half the weight of its start
    });
    return f;
}

void Interior::add_state_parts(std::vector<std::pair<void*, size_t>>& parts) {
    parts.emplace_back(state_.data(), state_.size() * sizeof(State));
    parts.emplace_back(rigid_.data(), rigid_.size() * sizeof(double));
    parts.emplace_back(rigid_before_.data(), rigid_before_.size() * sizeof(double));
    parts.emplace_back(&books_, sizeof books_);
}

}  // namespace dttmm
