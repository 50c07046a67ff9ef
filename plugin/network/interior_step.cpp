// SPDX-License-Identifier: BSD-3-Clause
//
// How the inside of a network finds its motion over a step.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation.h"
#include "network/interior.h"
#include "network/interior_parts.h"

namespace dttmm {

namespace {

/// A kept rate of convergence is trusted half as much with every step that did not measure it anew.
constexpr double kForget = 2;
/// Slower than this, the matrix is formed anew.
constexpr double kSlowestContraction = 0.1;
/// A change of the ports feels the network's nonlinearity less than a change of everything inside, which the rate measures.
constexpr double kLinearShare = 0.1;
/// So much farther than is good enough the linear answer still serves, where it served in the step before.
constexpr double kFarther = 30;
/// Of a frame's place, in the corrections: nothing finer can be asked for.
constexpr double kRounding = 1e-14;
/// Of the motion: no more digits are asked for.
constexpr double kFinest = 1e-13;
/// Axes lose their right angles by rounding only.
constexpr uint64_t kStepsBetweenNormalisations = 64;

}  // namespace

void Interior::look_at_joints(const Mechanism& mechanism) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = mechanism.frame(joint.from()), to = mechanism.frame(joint.to());
        now_[j] = {joint.axes(from), joint.arm(from, to), joint.lever(to)};
    }
}

void Interior::begin_step(const Mechanism& mechanism, const double* loads) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        if (const TurnState* turn = mechanism.turn(j)) mechanism.joints[j].refuse_large_rotation(*turn);
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
    port_way_ = std::sqrt(largest);
    // The host wants a smooth answer: which one it gets hangs on the step before, not on how near this trial is
    const bool is_near = is_good_enough(kLinearShare * books_.port_way, anchor_);
    if (is_near && is_good_enough(kLinearShare * port_way_ / kFarther, anchor_)) return anchor_;
    other_.contraction = anchor_.contraction;
    other_.scale = anchor_.scale;
    for (size_t p = 0; p < port_u_.size(); ++p) {
        std::copy_n(ports[p].position, 3, other_.ports[p].position);
        std::copy_n(ports[p].rotation, 9, other_.ports[p].rotation);
    }
    for (size_t i = 0; i < state_.size(); ++i) other_.u[i] = anchor_.u[i] + anchor_.change[i] + responses_[i] * port_change_;
    rigid_change_.noalias() = rigid_responses_ * port_change_;
    for (size_t i = 0; i < other_.q.size(); ++i)
        other_.q[i] = anchor_.q[i] + (anchor_.q_change[i] + rigid_change_(static_cast<Eigen::Index>(i))) / h;
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
    rigid_change_.noalias() = rigid_responses_ * port_change_;
    rigid_before_ = rigid_;
    for (size_t i = 0; i < rigid_.size(); ++i)
        rigid_[i] = solution.q[i] + (solution.q_change[i] + rigid_change_(static_cast<Eigen::Index>(i))) / h;
    find_imbalances(mechanism);
    books_.port_way = port_way_;
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
        state.velocity_before = state.velocity;
        state.velocity = {R * solution.u[i].head<3>() + change.linear, R * solution.u[i].tail<3>() + change.angular};
        Vector6 u;
        u << R.transpose() * state.velocity.linear, R.transpose() * state.velocity.angular;
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

}  // namespace dttmm
