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
/// A change of the ports feels the network's nonlinearity less than a change of everything inside, which the rate measures.
constexpr double kLinearShare = 0.1;
/// Of a frame's place, in the corrections: nothing finer can be asked for.
constexpr double kRounding = 1e-14;
/// Of the motion: no more digits are asked for.
constexpr double kFinest = 1e-13;
/// Axes lose their right angles by rounding only.
constexpr uint64_t kStepsBetweenNormalisations = 64;
/// Radius of gyration below which a mass is a point [m].
constexpr double kSmallestGyration = 1e-7;
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
    choose_burdened(mechanism);
    const auto rigid = static_cast<size_t>(elimination_.rigid_count()), ports = static_cast<size_t>(ports_);
    for (auto* list : {&rigid_, &rigid_before_}) list->assign(rigid, 0);
    for (auto* list : {&port_u_, &port_u_before_}) list->assign(ports, Vector6::Zero());
    half_wrench_.assign(mechanism.frames.size(), Vector6::Zero());
    now_.resize(mechanism.joints.size());
    anchor_.ports.assign(mechanism.frames.begin(), mechanism.frames.begin() + ports_);
    anchor_.u.assign(n, Vector6::Zero());
    anchor_.change.assign(n, Vector6::Zero());
    anchor_.q.assign(rigid, 0);
    anchor_.q_change.assign(rigid, 0);
    anchor_.wrench.assign(mechanism.frames.size(), Vector6::Zero());
    anchor_.left.assign(n, Vector6::Zero());
    other_ = anchor_;
    port_change_.setZero(6 * ports_);
    wrench_.assign(mechanism.frames.size(), Vector6::Zero());
    world_change_.resize(mechanism.frames.size());
    trial_ = mechanism.frames;
    responses_.assign(n, Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 6 * ports_));
    rigid_responses_.setZero(static_cast<Eigen::Index>(rigid), 6 * ports_);

    const Mechanism sample = at_rest(mechanism, kTrialStep);
    assemble(sample);
    factor(sample, DTTMM_ERROR_MODEL);
}

void Interior::set_reaches(const Mechanism& mechanism) {
    port_reach_.assign(static_cast<size_t>(ports_), 0);
    for (Inertia& inertia : inertias_)
        if (inertia.mass > 0) inertia.reach = std::sqrt(inertia.moment.trace() / inertia.mass);
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const auto reach_out = [&](int frame, double length) {
            if (frame >= ports_ && !is_inner(frame)) return;
            double& reach = is_inner(frame) ? inertias_[at(frame)].reach : port_reach_[static_cast<size_t>(frame)];
            reach = std::max(reach, length);
        };
        reach_out(joint.from(), joint.arm(from, to).norm());
        reach_out(joint.to(), joint.lever(to).norm());
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
        if (inertias_[i].moment.trace() <= kSmallestGyration * kSmallestGyration * inertias_[i].mass)
            inertias_[i].balance[1] = massless;
        for (Balance balance : inertias_[i].balance) settles_ = settles_ || balance == Balance::end_of_step;
    }
    for (const Joint& joint : mechanism.joints) {
        bool wanted = false;
        for (int frame : {joint.from(), joint.to()})
            if (is_inner(frame))
                for (Balance balance : inertias_[at(frame)].balance) wanted = wanted || balance == Balance::half_step;
        half_wanted_.push_back(wanted);
        halves_wanted_ = halves_wanted_ || wanted;
    }
}

void Interior::choose_burdened(const Mechanism& mechanism) {
    burden_of_.assign(inertias_.size(), -1);
    const auto choose = [&](size_t frame) {
        if (burden_of_[frame] >= 0) return;
        burden_of_[frame] = static_cast<int>(burdened_.size());
        burdened_.push_back(frame);
    };
    for (int node : inner_nodes_) {
        const int frame = mechanism.assembly.nodes[static_cast<size_t>(node)].frame;
        if (is_inner(frame)) choose(at(frame));
    }
    for (size_t i = 0; i < inertias_.size(); ++i)
        for (Balance balance : inertias_[i].balance)
            if (balance != Balance::momentum) choose(i);
    burdens_.resize(burdened_.size());
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

    // What the ports feel: their own joints, and those of the frames whose heirs they are
    std::vector<bool> at_port(mechanism.frames.size(), false);
    for (int f = 0; f < static_cast<int>(at_port.size()); ++f) {
        const bool is_estate = is_inner(f) && inertias_[at(f)].heir >= 0 && inertias_[at(f)].heir < ports_;
        if (f >= ports_ && !is_estate) continue;
        at_port[static_cast<size_t>(f)] = true;
        port_frames_.push_back(f);
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        if (at_port[static_cast<size_t>(mechanism.joints[j].from())] ||
            at_port[static_cast<size_t>(mechanism.joints[j].to())])
            port_side_joints_.push_back(j);
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

/// From the columns of [d; relative turn ε] those of [d; θ] that rigid directions hold: δθ = J⁻¹ ε.
Matrix6 Interior::rigid_rows(const Mechanism& mechanism, size_t j, const Matrix6& G) const {
    Matrix6 rows = G;
    if (const TurnState* turn = mechanism.turn(j)) rows.bottomRows<3>() = turn->conjugate.transpose() * G.bottomRows<3>();
    return rows;
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
        if (joint.rigid().none()) continue;
        const Matrix6 by_from = rigid_rows(mechanism, j, G_from), by_to = rigid_rows(mechanism, j, G_to);
        for_each_rigid(joint, [&](int i, int d) {
            elimination_.set_rigid(static_cast<int>(j), i, by_from.row(d).transpose(), by_to.row(d).transpose());
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
    look_at_joints(mechanism);
}

/// How the inside follows a unit motion of each port.
void Interior::find_responses(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    std::vector<Vector6>& r = other_.change;
    std::vector<double>& g = other_.q_change;
    for (int column = 0; column < 6 * ports_; ++column) {
        const int port = column / 6, c = column % 6;
        std::fill(r.begin(), r.end(), Vector6::Zero());
        std::fill(g.begin(), g.end(), 0.0);
        for (size_t j : port_joints_) {
            const Joint& joint = mechanism.joints[j];
            if (joint.from() != port && joint.to() != port) continue;
            const Matrix6 G_from = local_by_from(mechanism, j), G_to = local_by_to(mechanism, j);
            const Matrix6 Lambda = h * h * gain(mechanism, j);
            const bool is_from = joint.from() == port;
            const Vector6 d = (is_from ? G_from : G_to).col(c);
            const int other = is_from ? joint.to() : joint.from();
            if (is_inner(other)) r[at(other)] -= (is_from ? G_to : G_from).transpose() * (Lambda * d);
            const Vector6 held = rigid_rows(mechanism, j, is_from ? G_from : G_to).col(c);
            for_each_rigid(joint, [&](int i, int direction) {
                g[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] = -held(direction);
            });
        }
        elimination_.solve(r, g);
        for (size_t i = 0; i < r.size(); ++i) responses_[i].col(column) = r[i];
        rigid_responses_.col(column) = Eigen::Map<const Eigen::VectorXd>(g.data(), static_cast<Eigen::Index>(g.size()));
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
        const Eigen::Matrix<double, 6, Eigen::Dynamic> f = h * h * gain(mechanism, j) * D;
        Eigen::Matrix<double, 6, Eigen::Dynamic> rigid = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 6 * ports_);
        for_each_rigid(joint, [&](int i, int d) {
            rigid.row(d) = rigid_responses_.row(elimination_.rigid_begin(static_cast<int>(j)) + i);
        });
        for (int end : {0, 1})
            if (frames[end] < ports_)
                S.middleRows<6>(6 * frames[end]) +=
                    G[end].transpose() * f + rigid_rows(mechanism, j, G[end]).transpose() * rigid;
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
    std::vector<Vector6> r(state_.size(), Vector6::Zero());
    std::vector<double> g(rigid_.size(), 0);
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
            if (is_inner(frames[1 - end])) r[at(frames[1 - end])] -= square * (G[1 - end].transpose() * (gain(slow, j) * d));
            const Vector6 held = rigid_rows(slow, j, G[end]) * u;
            for_each_rigid(joint, [&](int i, int direction) {
                g[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] -= held(direction);
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
        r[at(spec.frame)] += G.transpose() * weight.cwiseProduct(given);
    }
    factor(slow, DTTMM_ERROR_SINGULAR);
    elimination_.solve(r, g);
    for (int i = 0; i < count_; ++i) {
        const RowMajor3 R = slow.frame(driven_ + i).axes();
        State& state = state_[static_cast<size_t>(i)];
        state.velocity = {R * head(r[static_cast<size_t>(i)]), R * tail(r[static_cast<size_t>(i)])};
    }
}

void Interior::start(Mechanism& mechanism, const dttmm_motion* ports, const double* accelerations, const double* loads) {
    const double h = mechanism.scheme.step_size();
    settle_at_start(mechanism, ports);
    std::fill(rigid_.begin(), rigid_.end(), 0.0);
    std::fill(rigid_before_.begin(), rigid_before_.end(), 0.0);
    read_loads(mechanism, loads);
    for (Burden& burden : burdens_) burden.load[1] = burden.load[2] = burden.load[0];
    books_ = {};

    // Forces of the start, for the momentum half a step before it and the accelerations
    std::vector<Vector6> wrench(mechanism.frames.size(), Vector6::Zero());
    for (const Joint& joint : mechanism.joints) {
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        const Vector6 f = joint.force(
            from, to, joint.rate(from, start_velocity(joint.from(), ports), to, start_velocity(joint.to(), ports)));
        const Matrix3 R = joint.axes(from);
        joint.add_wrench(joint.arm(from, to), joint.lever(to), R * head(f), R * tail(f),
                         wrench[static_cast<size_t>(joint.from())].data(), wrench[static_cast<size_t>(joint.to())].data());
    }
    std::vector<Twist> acceleration(state_.size());
    for (size_t i = 0; i < state_.size(); ++i) {
        State& state = state_[i];
        const Inertia& inertia = inertias_[i];
        const Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const FrameView view = frame;
        const RowMajor3 R = view.axes();
        Vector6 force = wrench[static_cast<size_t>(driven_) + i];
        if (burden_of_[i] >= 0) force += burden(i).load[0];
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
        if (burden_of_[i] >= 0) books_.load_power += burden(i).load[0].dot(joined(state.velocity));
    }
    // A load that a massless frame takes at once passes on to its heir
    for (size_t i = 0; i < state_.size(); ++i) {
        const Inertia& inertia = inertias_[i];
        if (inertia.heir < driven_) continue;
        Vector6 force = wrench[static_cast<size_t>(driven_) + i] + burden(i).load[0];
        for (int half : {0, 1})
            if (inertia.balance[half] == Balance::momentum) force.segment<3>(3 * half).setZero();
        Vector6& momentum = state_[at(inertia.heir)].momentum;
        const Vector3 arm = mechanism.frame(driven_ + static_cast<int>(i)).origin() - mechanism.frame(inertia.heir).origin();
        momentum.head<3>() -= 0.5 * h * head(force);
        momentum.tail<3>() -= 0.5 * h * (tail(force) + arm.cross(head(force)));
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
    for (Burden& burden : burdens_) burden.imbalance[1] = burden.imbalance[0];
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const Twist v = twist(ports[p]);
        const RowMajor3 R = mechanism.frame(static_cast<int>(p)).axes();
        port_u_[p] << R.transpose() * v.linear, R.transpose() * v.angular;
    }
    port_u_before_ = port_u_;
    trial_ = mechanism.frames;
    refactor(mechanism);
}

/// Loads on the inner nodes at the end of the step as wrenches at their frames' origins.
void Interior::read_loads(const Mechanism& mechanism, const double* loads) {
    for (Burden& burden : burdens_) burden.load[0].setZero();
    if (!loads) return;
    for (size_t i = 0; i < inner_nodes_.size(); ++i) {
        const NodeSpec& node = mechanism.assembly.nodes[static_cast<size_t>(inner_nodes_[i])];
        if (!is_inner(node.frame)) continue;
        const Eigen::Map<const Vector3> F(loads + 6 * i), M(loads + 6 * i + 3);
        Vector6& load = burden(at(node.frame)).load[0];
        load.head<3>() += F;
        load.tail<3>() += M + (mechanism.frame(node.frame).axes() * node.offset).cross(F);
    }
}

/// What is left at t_n of the forces on massless frames that balance at the end of every step: rounding, or a load that
/// jumped.
void Interior::find_imbalances(const Mechanism& mechanism) {
    if (!settles_) return;
    for (Burden& burden : burdens_) {
        burden.imbalance[1] = burden.imbalance[0];
        burden.imbalance[0] = burden.load[1];
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
                         settling(joint.from()) ? burden(at(joint.from())).imbalance[0].data() : nullptr,
                         settling(joint.to()) ? burden(at(joint.to())).imbalance[0].data() : nullptr);
    }
}

// ---- A step -------------------------------------------------------------------------------------------------------------

void Interior::look_at_joints(const Mechanism& mechanism) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        now_[j] = {joint.axes(from), joint.arm(from, to), joint.lever(to)};
    }
}

void Interior::begin_step(const Mechanism& mechanism, const double* loads) {
    read_loads(mechanism, loads);
    drop_anchor(mechanism);
}

/// Solves the step for ports that go on as they have.
void Interior::drop_anchor(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const Vector6 u = 2 * port_u_[p] - port_u_before_[p];
        const FrameView now = mechanism.frames[p];
        Map3{anchor_.ports[p].position} = now.origin() + h * (now.axes() * head(u));
        MapR{anchor_.ports[p].rotation} = now.axes() * rotation_from_vector(h * tail(u));
    }
    for (size_t i = 0; i < state_.size(); ++i) anchor_.u[i] = 2 * state_[i].u - state_[i].u_before;
    anchor_.q = rigid_;
    anchor_.contraction = std::min(kForget * books_.contraction, 1.0);
    anchor_.scale = books_.scale;
    solve(mechanism, anchor_);
}

/// The frames at the end of the step.
void Interior::place(const Mechanism& mechanism, const Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    std::copy(solution.ports.begin(), solution.ports.end(), trial_.begin());
    for (size_t i = 0; i < state_.size(); ++i) {
        const size_t f = static_cast<size_t>(driven_) + i;
        const FrameView now = mechanism.frames[f];
        const Vector6& u = solution.u[i];
        Map3{trial_[f].position} = now.origin() + h * (now.axes() * u.head<3>());
        MapR{trial_[f].rotation}.noalias() = now.axes() * rotation_from_vector(h * u.tail<3>());
    }
}

/// Wrenches of the joints over the step at the trial frames.
void Interior::find_forces(const Mechanism& mechanism, Solution& solution) const {
    std::fill(solution.wrench.begin(), solution.wrench.end(), Vector6::Zero());
    if (halves_wanted_) std::fill(half_wrench_.begin(), half_wrench_.end(), Vector6::Zero());
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const auto a = static_cast<size_t>(joint.from()), b = static_cast<size_t>(joint.to());
        const FrameView from = trial_[a], to = trial_[b];
        const JointState& state = mechanism.states[j];
        const TurnState* turn = mechanism.turn(j);
        const auto& [R, arm, lever] = now_[j];
        Vector3 f = joint.trial_force(from, joint.arm(from, to), state), m = Vector3::Zero();
        if (turn) m = joint.trial_moment(joint.trial_turn(from, to, *turn), *turn);
        if (half_wanted_[j]) {
            // F_{n+1/2}/2 = law δ₊ + k d/2
            const Vector3 f_half =
                f - state.translation.known + 0.5 * joint.translation_half().stiffness.cwiseProduct(state.translation.d);
            Vector3 m_half = Vector3::Zero();
            if (turn)
                m_half = m - turn->rotation.known +
                         turn->conjugate * (0.5 * joint.rotation_half().stiffness.cwiseProduct(turn->rotation.d));
            joint.add_wrench(arm, lever, R * f_half, R * m_half, half_wrench_[a].data(), half_wrench_[b].data());
        }
        joint.add_wrench(arm, lever, R * f, R * m, solution.wrench[a].data(), solution.wrench[b].data());
        if (joint.rigid().none()) continue;
        Vector6 rigid = Vector6::Zero(), rigid_half = Vector6::Zero();
        for_each_rigid(joint, [&](int i, int d) {
            const auto row = static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i);
            rigid_half(d) = solution.q[row];
            rigid(d) = solution.q[row] + (half_wanted_[j] ? rigid_[row] : 0);
        });
        if (turn) {
            rigid.tail<3>() = (turn->conjugate * tail(rigid)).eval();
            rigid_half.tail<3>() = (turn->conjugate * tail(rigid_half)).eval();
        }
        joint.add_wrench(arm, lever, R * head(rigid), R * tail(rigid), solution.wrench[a].data(), solution.wrench[b].data());
        if (half_wanted_[j])
            joint.add_wrench(arm, lever, R * head(rigid_half), R * tail(rigid_half), half_wrench_[a].data(),
                             half_wrench_[b].data());
    }
}

/// Hands what massless frames leave unbalanced of the centred forces to their heirs. It does not depend on the trial.
void Interior::pass_on_imbalances(const Mechanism& mechanism, Solution& solution) const {
    const Scheme& scheme = mechanism.scheme;
    for (size_t k = 0; k < burdened_.size(); ++k) {
        const size_t i = burdened_[k], f = static_cast<size_t>(driven_) + i;
        const Inertia& inertia = inertias_[i];
        if (inertia.heir < 0) continue;
        const Burden& own = burdens_[k];
        const Vector6 settled = scheme.load_weight(1) * own.imbalance[0] + scheme.load_weight(2) * own.imbalance[1];
        const Vector6 halved = solution.wrench[f] - half_wrench_[f] + 0.25 * (own.load[1] + own.load[2]);
        Vector6 left = Vector6::Zero();
        for (int half : {0, 3}) {
            if (inertia.balance[half / 3] == Balance::end_of_step) left.segment<3>(half) = settled.segment<3>(half);
            if (inertia.balance[half / 3] == Balance::half_step) left.segment<3>(half) = halved.segment<3>(half);
        }
        solution.left[i] = left;
        bequeath(mechanism, i, left, solution.wrench[static_cast<size_t>(inertia.heir)]);
    }
}

/// Adds a wrench at a massless frame to that at its heir.
void Interior::bequeath(const Mechanism& mechanism, size_t frame, const Vector6& left, Vector6& to_heir) const {
    const Vector3 arm =
        mechanism.frame(driven_ + static_cast<int>(frame)).origin() - mechanism.frame(inertias_[frame].heir).origin();
    to_heir.head<3>() += head(left);
    to_heir.tail<3>() += tail(left) + arm.cross(head(left));
}

/// What the linear change of the forces leaves on a massless frame beyond what its heir has already: second order in the
/// change.
void Interior::settle_estate(const Mechanism& mechanism, size_t frame, const Solution& solution) const {
    const Inertia& inertia = inertias_[frame];
    Vector6 left = wrench_[static_cast<size_t>(driven_) + frame] + load_over_step(mechanism.scheme, burden(frame)) -
                   solution.left[frame];
    for (int half : {0, 1})
        if (inertia.balance[half] == Balance::momentum) left.segment<3>(3 * half).setZero();
    bequeath(mechanism, frame, left, wrench_[static_cast<size_t>(inertia.heir)]);
}

/// What the equations lack at the trial motion, into `change` (in the frames' axes) and `q_change`.
void Interior::form_residuals(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    for (size_t i = 0; i < state_.size(); ++i) {
        const size_t f = static_cast<size_t>(driven_) + i;
        const State& state = state_[i];
        const Inertia& inertia = inertias_[i];
        const Vector6& u = solution.u[i];
        const FrameView now = mechanism.frames[f];
        Vector3 p = state.momentum.head<3>() + h * (solution.wrench[f].head<3>() + inertia.mass * gravity_);
        Vector3 L = state.momentum.tail<3>() + h * solution.wrench[f].tail<3>();
        if (burden_of_[i] >= 0) {
            p = balanced(mechanism.scheme, i, 0, p, solution);
            L = balanced(mechanism.scheme, i, 1, L, solution);
        }
        Vector6& r = solution.change[i];
        r.head<3>().noalias() = now.axes().transpose() * p;
        r.tail<3>().noalias() = now.axes().transpose() * L;
        if (inertia.balance[0] == Balance::momentum) r.head<3>() -= inertia.mass * u.head<3>();
        if (inertia.balance[1] == Balance::momentum) {
            // L = exp(h w~/2) J w half way through the step
            const Vector3 w = u.tail<3>();
            r.tail<3>() -= turned(0.5 * h * w, inertia.moment * w);
        }
    }
    if (solution.q.empty()) return;
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (joint.rigid().none()) continue;
        const FrameView from = trial_[static_cast<size_t>(joint.from())], to = trial_[static_cast<size_t>(joint.to())];
        Vector6 d;
        d << joint.translation(from, joint.arm(from, to)),
            joint.turns() ? rotation_vector(joint.attitude(from, to)) : Vector3(Vector3::Zero());
        for_each_rigid(joint, [&](int i, int direction) {
            solution.q_change[static_cast<size_t>(elimination_.rigid_begin(static_cast<int>(j)) + i)] = -d(direction) / h;
        });
    }
}

Vector6 Interior::load_over_step(const Scheme& scheme, const Burden& burden) {
    return scheme.load_weight(0) * burden.load[0] + scheme.load_weight(1) * burden.load[1] +
           scheme.load_weight(2) * burden.load[2];
}

/// What a half of a burdened frame must balance over the step, world axes: `momentum` and the loads; or, without a mass, the
/// forces in the form that its balance takes, times h.
Vector3 Interior::balanced(const Scheme& scheme, size_t frame, int half, const Vector3& momentum,
                           const Solution& solution) const {
    const double h = scheme.step_size();
    const Burden& own = burden(frame);
    const size_t f = static_cast<size_t>(driven_) + frame;
    const auto part = [&](const Vector6& v) { return Vector3(v.segment<3>(3 * half)); };
    switch (inertias_[frame].balance[half]) {
        case Balance::half_step:
            return h * part(half_wrench_[f] + 0.25 * (own.load[0] + own.load[1]));
        case Balance::end_of_step:
            return h * part(solution.wrench[f] + load_over_step(scheme, own) - scheme.load_weight(1) * own.imbalance[0] -
                            scheme.load_weight(2) * own.imbalance[1]);
        case Balance::centred:
            return h * part(solution.wrench[f] + load_over_step(scheme, own));
        default:
            return momentum + h * part(load_over_step(scheme, own));
    }
}

/// Solves for the correction and returns its size: the largest speed of a point.
double Interior::correct(Solution& solution) const {
    elimination_.solve(solution.change, solution.q_change);
    double largest = 0;
    for (size_t i = 0; i < state_.size(); ++i) {
        const double reach = inertias_[i].reach;
        const Vector6& change = solution.change[i];
        largest = std::max(largest, change.head<3>().squaredNorm() + reach * reach * change.tail<3>().squaredNorm());
        if (!(largest >= 0)) break;
    }
    return std::sqrt(largest);
}

/// Passes from the motion in `solution` on until the last change is good enough; contraction and scale as last known.
void Interior::solve(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    double size = 0, speed = 0;
    for (size_t i = 0; i < state_.size(); ++i) {
        const double reach = inertias_[i].reach;
        const Vector6& u = solution.u[i];
        size =
            std::max(size, FrameView(mechanism.frames[static_cast<size_t>(driven_) + i]).origin().cwiseAbs().sum() + reach);
        speed = std::max(speed, u.head<3>().squaredNorm() + reach * reach * u.tail<3>().squaredNorm());
    }
    solution.scale = std::max(solution.scale, std::sqrt(speed));
    solution.rate = 0;
    const double floor = std::max(kRounding * size / h, kFinest * solution.scale);
    double previous = 0;
    for (int pass = 0; pass < kMostPasses; ++pass) {
        ++passes_;
        if (pass > 0) {
            for (size_t i = 0; i < state_.size(); ++i) solution.u[i] += solution.change[i];
            for (size_t i = 0; i < solution.q.size(); ++i) solution.q[i] += solution.q_change[i] / h;
        }
        place(mechanism, solution);
        find_forces(mechanism, solution);
        pass_on_imbalances(mechanism, solution);
        form_residuals(mechanism, solution);
        const double correction = correct(solution);
        if (!std::isfinite(correction)) break;
        if (pass > 0 && correction > floor) {
            solution.rate = previous > 0 ? correction / previous : 0;
            solution.contraction = solution.rate < 1 ? solution.rate / (1 - solution.rate) : 1e3;
        }
        previous = correction;
        if (pass == 0) solution.tolerance = std::max(floor, std::min(kShare * correction, kTolerance * solution.scale));
        if (is_good_enough(correction, solution)) return;
    }
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("the motion inside the network was not found in {} passes (last correction {:.1e} m/s); try a "
                            "smaller step",
                            kMostPasses, previous),
                mechanism.assembly.frames.back().element);
}

bool Interior::is_good_enough(double correction, const Solution& solution) {
    return std::min(solution.contraction, 1.0) * correction <= solution.tolerance;
}

/// The solution for a motion of the ports: the anchored one, to which port_change_ is to be added linearly, if that is good
/// enough, else one of its own.
const Interior::Solution& Interior::respond(const Mechanism& mechanism, const dttmm_motion* ports) const {
    const double h = mechanism.scheme.step_size();
    double largest = 0;
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const FrameView now = mechanism.frames[p], anchor = anchor_.ports[p], trial = ports[p];
        auto change = port_change_.segment<6>(static_cast<Eigen::Index>(6 * p));
        change << now.axes().transpose() * (trial.origin() - anchor.origin()),
            now.axes().transpose() * rotation_vector(trial.axes() * anchor.axes().transpose());
        change /= h;
        largest = std::max(
            largest, change.head<3>().squaredNorm() + port_reach_[p] * port_reach_[p] * change.tail<3>().squaredNorm());
    }
    if (is_good_enough(kLinearShare * std::sqrt(largest), anchor_)) return anchor_;
    other_.contraction = anchor_.contraction;
    other_.scale = anchor_.scale;
    for (size_t p = 0; p < port_u_.size(); ++p) {
        std::copy_n(ports[p].position, 3, other_.ports[p].position);
        std::copy_n(ports[p].rotation, 9, other_.ports[p].rotation);
    }
    for (size_t i = 0; i < state_.size(); ++i) other_.u[i] = anchor_.u[i] + anchor_.change[i] + responses_[i] * port_change_;
    const Eigen::VectorXd rigid = rigid_responses_ * port_change_;
    for (size_t i = 0; i < other_.q.size(); ++i)
        other_.q[i] = anchor_.q[i] + (anchor_.q_change[i] + rigid(static_cast<Eigen::Index>(i))) / h;
    solve(mechanism, other_);
    port_change_.setZero();
    return other_;
}

/// What leads a frame from where the joints' forces were worked out to the end of the step, over h, in its axes.
Vector6 Interior::change_of(int frame, const Solution& solution) const {
    if (is_inner(frame)) return solution.change[at(frame)] + responses_[at(frame)] * port_change_;
    if (frame < ports_) return port_change_.segment<6>(6 * frame);
    return Vector6::Zero();
}

/// The change of a joint's force, joint axes: linear from where it was worked out to the end of the step. `from`, `to`: the
/// changes of its frames, world axes.
Vector6 Interior::force_change(const Mechanism& mechanism, size_t j, const Twist& from, const Twist& to,
                               const Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const Joint& joint = mechanism.joints[j];
    const TurnState* turn = mechanism.turn(j);
    const auto& [R, arm, lever] = now_[j];
    Vector6 f = Vector6::Zero();
    const Vector3 gap = to.linear + to.angular.cross(lever) - from.linear - from.angular.cross(arm);
    f.head<3>() = h * joint.translation_half().law.cwiseProduct(R.transpose() * gap);
    if (turn) f.tail<3>() = joint.moment_change(h * (R.transpose() * (to.angular - from.angular)), *turn);
    if (joint.rigid().none()) return f;
    Vector6 rigid = Vector6::Zero();
    for_each_rigid(joint, [&](int i, int direction) {
        const int row = elimination_.rigid_begin(static_cast<int>(j)) + i;
        rigid(direction) = (solution.q_change[static_cast<size_t>(row)] + rigid_responses_.row(row).dot(port_change_)) / h;
    });
    f.head<3>() += head(rigid);
    if (turn) f.tail<3>() += turn->conjugate * tail(rigid);
    return f;
}

void Interior::evaluate(const Mechanism& mechanism, const dttmm_motion* trial, double* wrench) const {
    const Solution& solution = respond(mechanism, trial);
    const auto change = [&](int frame) {
        const Vector6 local = change_of(frame, solution);
        const RowMajor3 R = mechanism.frame(frame).axes();
        return Twist{R * head(local), R * tail(local)};
    };
    for (int frame : port_frames_) wrench_[static_cast<size_t>(frame)] = solution.wrench[static_cast<size_t>(frame)];
    for (size_t j : port_side_joints_) {
        const Joint& joint = mechanism.joints[j];
        const Vector6 f = force_change(mechanism, j, change(joint.from()), change(joint.to()), solution);
        const auto& [R, arm, lever] = now_[j];
        joint.add_wrench(arm, lever, R * head(f), R * tail(f), wrench_[static_cast<size_t>(joint.from())].data(),
                         wrench_[static_cast<size_t>(joint.to())].data());
    }
    for (int frame : port_frames_)
        if (is_inner(frame)) settle_estate(mechanism, at(frame), solution);
    for (int p = 0; p < ports_; ++p) Eigen::Map<Vector6>{wrench + 6 * p} = wrench_[static_cast<size_t>(p)];
}

void Interior::commit(Mechanism& mechanism, const dttmm_motion* accepted) {
    const Solution& solution = respond(mechanism, accepted);
    take_momentum(mechanism, solution);
    take_motion(mechanism, solution, accepted);
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        joint.advance(mechanism.scheme, mechanism.steps, mechanism.frame(joint.from()), mechanism.frame(joint.to()),
                      mechanism.states[j], mechanism.turn(j));
    }
    const double h = mechanism.scheme.step_size();
    const Eigen::VectorXd rigid = rigid_responses_ * port_change_;
    rigid_before_ = rigid_;
    for (size_t i = 0; i < rigid_.size(); ++i)
        rigid_[i] = solution.q[i] + (solution.q_change[i] + rigid(static_cast<Eigen::Index>(i))) / h;
    find_imbalances(mechanism);
    books_.contraction = solution.contraction;
    books_.scale = 0.98 * solution.scale;
    if (solution.rate > kSlowestContraction)
        refactor(mechanism);
    else
        look_at_joints(mechanism);
}

/// Moves the momentum on by the forces at the end of the step, those of each joint a pair that balances exactly.
void Interior::take_momentum(const Mechanism& mechanism, const Solution& solution) {
    const double h = mechanism.scheme.step_size();
    for (size_t f = 0; f < mechanism.frames.size(); ++f) {
        const Vector6 local = change_of(static_cast<int>(f), solution);
        const RowMajor3 R = mechanism.frame(static_cast<int>(f)).axes();
        world_change_[f] = {R * head(local), R * tail(local)};
        wrench_[f] = solution.wrench[f];
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const auto a = static_cast<size_t>(joint.from()), b = static_cast<size_t>(joint.to());
        const Vector6 f = force_change(mechanism, j, world_change_[a], world_change_[b], solution);
        const auto& [R, arm, lever] = now_[j];
        joint.add_wrench(arm, lever, R * head(f), R * tail(f), wrench_[a].data(), wrench_[b].data());
    }
    for (size_t i = 0; i < state_.size(); ++i)
        if (inertias_[i].heir >= 0) settle_estate(mechanism, i, solution);
    for (size_t i = 0; i < state_.size(); ++i) {
        State& state = state_[i];
        Vector6 impulse = h * wrench_[static_cast<size_t>(driven_) + i];
        if (burden_of_[i] >= 0) impulse += h * load_over_step(mechanism.scheme, burden(i));
        if (inertias_[i].balance[0] == Balance::momentum)
            state.momentum.head<3>() += head(impulse) + h * inertias_[i].mass * gravity_;
        if (inertias_[i].balance[1] == Balance::momentum) state.momentum.tail<3>() += tail(impulse);
    }
}

/// Moves the frames to the end of the step.
void Interior::take_motion(Mechanism& mechanism, const Solution& solution, const dttmm_motion* accepted) {
    const double h = mechanism.scheme.step_size();
    mechanism.before = mechanism.frames;
    double power = 0;
    for (size_t i = 0; i < state_.size(); ++i) {
        State& state = state_[i];
        Frame& frame = mechanism.frames[static_cast<size_t>(driven_) + i];
        const Twist& change = world_change_[static_cast<size_t>(driven_) + i];
        const RowMajor3 R = MapR(frame.rotation);
        const Vector6 u = solution.u[i] + change_of(driven_ + static_cast<int>(i), solution);
        state.velocity_before = state.velocity;
        state.velocity = {R * solution.u[i].head<3>() + change.linear, R * solution.u[i].tail<3>() + change.angular};
        if (mechanism.steps == 0) {  // the initial velocities are the mean of both
            state.velocity_before.linear = 2 * state.velocity_before.linear - state.velocity.linear;
            state.velocity_before.angular = 2 * state.velocity_before.angular - state.velocity.angular;
        }
        state.u_before = mechanism.steps == 0 ? u : state.u;
        state.u = u;
        Map3{frame.position} += h * state.velocity.linear;
        RowMajor3 next = R * rotation_from_vector(h * u.tail<3>());
        if (mechanism.steps % kStepsBetweenNormalisations == 0)  // by one step of Newton
            next += 0.5 * next * (RowMajor3::Identity() - next.transpose() * next);
        MapR{frame.rotation} = next;
    }
    for (size_t k = 0; k < burdened_.size(); ++k) {
        const State& state = state_[burdened_[k]];
        Burden& own = burdens_[k];
        power += 0.5 * own.load[1].dot(joined(state.velocity) + joined(state.velocity_before));
        own.load[2] = own.load[1];
        own.load[1] = own.load[0];
    }
    for (size_t p = 0; p < port_u_.size(); ++p) {
        Frame& frame = mechanism.frames[p];
        const FrameView now = frame, next = accepted[p];
        Vector6 u;
        u << now.axes().transpose() * (next.origin() - now.origin()), rotation_vector(now.axes().transpose() * next.axes());
        port_u_before_[p] = mechanism.steps == 0 ? Vector6(u / h) : port_u_[p];
        port_u_[p] = u / h;
        std::copy_n(accepted[p].position, 3, frame.position);
        std::copy_n(accepted[p].rotation, 9, frame.rotation);
    }
    if (mechanism.steps > 0) books_.load_work += 0.5 * h * (books_.load_power + power);
    books_.load_power = power;
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
    parts.emplace_back(burdens_.data(), burdens_.size() * sizeof(Burden));
    parts.emplace_back(rigid_.data(), rigid_.size() * sizeof(double));
    parts.emplace_back(rigid_before_.data(), rigid_before_.size() * sizeof(double));
    parts.emplace_back(port_u_.data(), port_u_.size() * sizeof(Vector6));
    parts.emplace_back(port_u_before_.data(), port_u_before_.size() * sizeof(Vector6));
    parts.emplace_back(&books_, sizeof books_);
}

}  // namespace dttmm
