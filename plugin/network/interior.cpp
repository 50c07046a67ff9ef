// SPDX-License-Identifier: BSD-3-Clause
//
// What a network has inside, its matrix and its results; its start and its steps are in files of their own.
#include "network/interior.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/state_vector.h"
#include "network/interior_parts.h"

namespace dttmm {

namespace {

/// Radius of gyration below which a mass is a point [m].
constexpr double kSmallestGyration = 1e-7;
/// Of a step at which a network is first looked at, to see that it can be solved.
constexpr double kTrialStep = 1e-3;

std::vector<Link> links_of(const Mechanism& mechanism) {
    const int driven = mechanism.assembly.driven_count;
    std::vector<Link> links;
    for (const Joint& joint : mechanism.joints)
        links.push_back({std::max(joint.from() - driven, -1), std::max(joint.to() - driven, -1),
                         static_cast<int>(joint.rigid().count())});
    return links;
}

}  // namespace

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
    rigid_change_.setZero(static_cast<Eigen::Index>(rigid));
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
    // −δ(h W_p) = G_pᵀ (h² Λ D + q) δu,   D: the joint's deformation by the motion of a port
    const double h = mechanism.scheme.step_size();
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * ports_, 6 * ports_);
    S.setZero();
    for (size_t j : port_joints_) {
        const Joint& joint = mechanism.joints[j];
        const Matrix6 G[2] = {local_by_from(mechanism, j), local_by_to(mechanism, j)};
        const Matrix6 held[2] = {rigid_rows(mechanism, j, G[0]), rigid_rows(mechanism, j, G[1])};
        const Matrix6 Lambda = h * h * gain(mechanism, j);
        const int frames[2] = {joint.from(), joint.to()};
        for (int column = 0; column < ports_; ++column) {
            Matrix6 D = Matrix6::Zero(), rigid = Matrix6::Zero();
            for (int end : {0, 1}) {
                if (is_inner(frames[end])) D += G[end] * responses_[at(frames[end])].middleCols<6>(6 * column);
                if (frames[end] == column) D += G[end];
            }
            for_each_rigid(joint, [&](int i, int d) {
                rigid.row(d) = rigid_responses_.block<1, 6>(elimination_.rigid_begin(static_cast<int>(j)) + i, 6 * column);
            });
            for (int end : {0, 1})
                if (frames[end] < ports_)
                    S.block<6, 6>(6 * frames[end], 6 * column) +=
                        G[end].transpose() * (Lambda * D) + held[end].transpose() * rigid;
        }
    }
    for (int row = 0; row < 2 * ports_; ++row)
        for (int column = 0; column < 2 * ports_; ++column) {
            auto block = S.block<3, 3>(3 * row, 3 * column);
            block =
                (mechanism.frame(row / 2).axes() * block * mechanism.frame(column / 2).axes().transpose() / (h * h)).eval();
        }
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
