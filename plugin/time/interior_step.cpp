// SPDX-License-Identifier: BSD-3-Clause
//
// How the inside of a network finds its motion over a step.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"
#include "time/interior.h"
#include "time/interior_parts.h"

namespace dttmm::plugin {

namespace {

/// A kept rate of convergence is trusted half as much with every step that did not measure it anew.
constexpr double kForget = 2;
/// Slower than this, the matrix is formed anew.
constexpr double kSlowestContraction = 0.1;
/// Slower than this, it is formed anew within the step.
constexpr double kTooSlow = 0.3;
/// Share by which a rigid direction may have turned against its frames since the matrix was formed.
constexpr double kTurnedRows = 0.02;
/// The same of joints at ports: as k h²/m of a stiff hinge is in the thousands, so is the error of the force they are told.
constexpr double kTurnedPorts = 1e-4;
/// A first pass at a step may be rough where passes contract by so much,
constexpr double kRoughly = 0.1;
/// and its correction is less than so many times that of the step before.
constexpr double kSudden = 10;
/// After so many passes a correction that has not halved is rounding,
constexpr int kPassesToFall = 4;
/// if it is so small a share of the motion, and the momentum is found.
constexpr double kLargestRounding = 1e-7;
/// A linear answer may lack so much of the momentum that may be lacking: it errs in the same sense step after step.
constexpr double kLinearly = 0.01;
/// So often in a step the anchor moves. A change of the ports that is then below kLargestRounding of the motion is rounding,
constexpr int kMostMoves = 4;
/// and up to so many times that they are answered linearly from then on, lest answers flip.
constexpr double kStillLinear = 100;
/// Of a frame's place, in the corrections: nothing finer can be asked for.
constexpr double kRounding = 1e-14;
/// Of the place itself, of which stiff joints make forces.
constexpr double kRoundingOfPlace = 2 * std::numeric_limits<double>::epsilon();
/// Smallest size of a network [m], for both.
constexpr double kSmallestSize = 1e-6;
/// Of the motion: no more digits are asked for.
constexpr double kFinest = 1e-13;
/// Axes lose their right angles by rounding only.
constexpr uint64_t kStepsBetweenNormalisations = 64;
/// Where parts are free to turn: so much more than may be left over is never left to a kept rate of convergence.
constexpr double kTrusted = 30;
/// Beyond these something has flown apart, by the host's measure of its bodies.
constexpr double kFarthest = 1e6;  // m
constexpr double kFastest = 1e8;   // m/s and rad/s

}  // namespace

void Interior::look_at_joints(const Mechanism& mechanism) {
    const Scheme& scheme = mechanism.scheme;
    for (size_t k = 0; k < rigid_joints_.size(); ++k) {
        const size_t j = rigid_joints_[k];
        const Joint& joint = mechanism.joints[j];
        const JointPose before = joint.pose(mechanism.frame_before(joint.from()), mechanism.frame_before(joint.to()));
        const Vector3 theta = mechanism.theta(j);
        RigidMap& known = rigid_known_[k] = {};
        known.add(scheme.elastic_weight(1), mechanism.pose(j), theta);
        // Three instants, one force: of one branch of θ
        known.add(scheme.elastic_weight(2), before, nearest_turn(mechanism.states[j].theta_before, theta));
    }
    massless_.look(mechanism);
}

void Interior::begin_step(const Mechanism& mechanism, const double* loads) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) mechanism.joints[j].refuse_large_rotation(mechanism.states[j]);
    if (is_stale_) refactor(mechanism);
    read_loads(mechanism, loads);
    predict(mechanism);
    open_anchor(mechanism);
}

/// Where the ports and the inside end if they go on as they have.
void Interior::predict(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const Vector6 u = 2 * port_u_[p] - port_u_before_[p];
        const FrameView now = mechanism.frames[p];
        Map3{anchor_.ports[p].position} = now.origin() + h * head(u);
        MapR{anchor_.ports[p].rotation} = rotation_from_vector(h * tail(u)) * now.axes();
    }
    for (size_t i = 0; i < inertias_.size(); ++i) anchor_.u[i] = 2 * past_.u[i] - past_.u_before[i];
    if (mechanism.steps == 0) {  // velocities of an instant: over the step what turns has turned half of it on the mean
        const Vector3 mean = mean_velocity(mechanism, anchor_);
        for (size_t i = 0; i < inertias_.size(); ++i) {
            const Vector3 drift = mechanism.frame(driven_ + as_int(i)).axes().transpose() * mean;
            Vector6& u = anchor_.u[i];
            u.head<3>() = (drift + turned(0.5 * h * u.tail<3>(), u.head<3>() - drift)).eval();
        }
    }
}

/// What is known of the anchor before anything is solved: ports that go on as they have.
void Interior::open_anchor(const Mechanism& mechanism) {
    is_solved_ = false;
    moves_ = 0;
    stays_linear_ = false;
    anchor_.answer = {};
    anchor_.correction = anchor_.residual = anchor_.first_correction = 0;
    anchor_.slowest_rate = 0;
    anchor_.has_own_matrix = false;
    std::fill(anchor_.change.begin(), anchor_.change.end(), Vector6::Zero());
    std::fill(anchor_.q_change.begin(), anchor_.q_change.end(), 0.0);
    anchor_.q = rigid_;
    anchor_.motion = books_.motion;
    anchor_.momentum = books_.momentum;
    for (Convergence* convergence : {&anchor_.motion, &anchor_.momentum}) convergence->forget(kForget);
    anchor_.scale = books_.scale;
    size_ = kSmallestSize;
    for (size_t i = 0; i < inertias_.size(); ++i) {
        const FrameView frame = mechanism.frames[as_size(driven_) + i];
        size_ = std::max(size_, frame.origin().cwiseAbs().sum() + reach_[i]);
    }
}

/// Puts the inner frames, moving by u over the step, where it ends, into trial_.
void Interior::place(const Mechanism& mechanism, std::span<const Vector6> u) const {
    const auto first = as_size(driven_);
    move_frames(mechanism.scheme.step_size(), std::span(mechanism.frames).subspan(first), u,
                std::span(trial_).subspan(first));
}
/// The same of one of them.
void Interior::place(const Mechanism& mechanism, size_t i, const Vector6& u) const {
    const size_t f = as_size(driven_) + i;
    move_frames(mechanism.scheme.step_size(), {&mechanism.frames[f], 1}, {&u, 1}, {&trial_[f], 1});
}

/// Forces q of a joint's rigid directions over the step.
JointForce Interior::rigid_action(const Mechanism& mechanism, size_t j, const JointPose& at_end, const Vector3& theta,
                                  const Vector6& q) const {
    RigidMap map = rigid_known_[as_size(rigid_index_[j])];
    map.add(mechanism.scheme.elastic_weight(0), at_end, nearest_turn(theta, mechanism.theta(j)));
    return map.of(q);
}

/// Of a joint over the step that ends with its frames at trial_ and its rigid directions carrying q_.
JointForce Interior::force_over_step(const Mechanism& mechanism, size_t j, const JointPose& at_end,
                                     const Joint::Strained& end) const {
    const Joint& joint = mechanism.joints[j];
    JointForce force =
        joint.weigh(mechanism.scheme, end, at_end, mechanism.states[j], mechanism.damper(j), mechanism.memory(j));
    if (joint.rigid().any()) force.add(1, rigid_action(mechanism, j, at_end, end.theta, rigid_values(mechanism, j, q_)));
    return force;
}

/// Wrenches of all joints over the step, and on massless frames at its end and half way.
void Interior::find_forces(const Mechanism& mechanism, Solution& solution) const {
    std::fill(wrench_.begin(), wrench_.end(), Vector6::Zero());
    for (size_t j : settling_joints_)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            end_wrench_[as_size(frame)].setZero();
            damping_wrench_[as_size(frame)].setZero();
        }
    q_ = solution.q;
    double largest = by_four_.add_forces(mechanism, trial_, wrench_);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends trial = {trial_[a], trial_[b]};
        const JointPose at_end = joint.pose(trial);
        const Joint::Strained end = joint.strain(mechanism.scheme, trial, at_end, mechanism.states[j], mechanism.memory(j));
        const JointForce force = force_over_step(mechanism, j, at_end, end);
        largest = std::max(largest, force.force.squaredNorm());
        Joint::add_wrench(force, wrench_[a].data(), wrench_[b].data());
        if (near_index_[j] >= 0) solution.near[as_size(near_index_[j])] = force;
        if (!massless_.is_settling(j)) continue;
        JointForce then = end.elastic;
        if (joint.rigid().any()) {
            const Vector6 q = rigid_values(mechanism, j, q_);
            then.add(1, at_end.act(at_end.axes * head(q), at_end.axes * moment_of_gradient(end.theta, tail(q))));
        }
        Joint::add_wrench(then, end_wrench_[a].data(), end_wrench_[b].data());
        if (massless_.is_half_way(j))
            Joint::add_wrench(joint.damping_half_way(trial, mechanism.ends(j), mechanism.scheme.step_size(),
                                                     mechanism.states[j], *mechanism.damper(j)),
                              damping_wrench_[a].data(), damping_wrench_[b].data());
    }
    solution.impulse = mechanism.scheme.step_size() * std::sqrt(largest);
}

/// The load on a loaded frame at the end of the step, at its origin, when it is then at `frame`.
Vector6 Interior::load_at_end(size_t loaded, FrameView frame) const {
    Vector6 load = frame_loads_[loaded].load[0];
    for (const Lever& lever : levers_)
        if (lever.loaded == loaded) load.tail<3>() += (frame.axes() * lever.offset).cross(head(node_loads_[lever.node]));
    return load;
}

Vector6 Interior::load_over_step(const Scheme& scheme, size_t loaded, FrameView frame) const {
    const FrameLoad& own = frame_loads_[loaded];
    return scheme.weight(0) * load_at_end(loaded, frame) + scheme.weight(1) * own.load[1] + scheme.weight(2) * own.load[2];
}

/// What the equations lack at the trial motion, into `change` (in the frames' axes) and `q_change`.
void Interior::form_residuals(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const auto first = as_size(driven_);
    for (size_t k = 0; k < loaded_.size(); ++k)
        wrench_[first + loaded_[k]] += load_over_step(mechanism.scheme, k, trial_[first + loaded_[k]]);
    find_imbalance(h, gravity_, inertias_, momenta_, std::span(mechanism.frames).subspan(first),
                   std::span(wrench_).subspan(first), solution.u, solution.change);
    balance_massless(mechanism, solution);
    for (size_t j : rigid_joints_) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = trial_[as_size(joint.from())], to = trial_[as_size(joint.to())];
        const Vector6 d = joint.deformation(joint.pose(from, to), from, to);
        for_each_rigid(joint, [&](int i, int direction) { solution.q_change[rigid_row(j, i)] = -d(direction) / h; });
    }
}

/// Puts in place of what massless frames lack over the step what they lack by their own rule; the difference goes to their
/// receivers.
void Interior::balance_massless(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const std::vector<size_t>& frames = massless_.frames();
    for (size_t m = 0; m < frames.size(); ++m) {
        const size_t i = frames[m], f = as_size(driven_) + i;
        const FrameLoad& own = frame_load(i);
        const FrameView now = mechanism.frames[f], end = trial_[f];
        const Vector6 load = load_at_end(as_size(load_of_[i]), end);
        const Vector6 elastic = in_axes(end, end_wrench_[f]), load_then = in_axes(end, load);
        MasslessFrames::Residual& residual = massless_residuals_[m];
        residual.step = solution.change[i];
        // Both with the factors that make their derivatives by the end of the step those of the forces over it
        residual.end = h * (mechanism.scheme.weight(0) + massless_.relaxation(m) * mechanism.scheme.rate(0)) *
                       (elastic + settled(mechanism, m, load_then));
        residual.half_way = 0.25 * h * (elastic + load_then + in_axes(now, own.elastic[1] + own.load[1])) +
                            0.5 * h * in_axes(now, damping_wrench_[f]);
    }
    massless_.combine(massless_residuals_);
    for (size_t m = 0; m < frames.size(); ++m) {
        const size_t i = frames[m];
        const int receiver = receivers_[i];
        const Vector6 left = solution.change[i] - massless_residuals_[m].step;
        solution.change[i] = massless_residuals_[m].step;
        if (!is_inner(receiver)) continue;
        const RowMajor3 R = mechanism.frame(driven_ + as_int(i)).axes();
        Vector6 world;
        world << R * head(left), R * tail(left);
        solution.change[at(receiver)] += in_axes(mechanism.frame(receiver), passed_on(mechanism.frames, i, world));
    }
}

/// What the elastic forces on a massless frame balance at the end of the step, its axes: ψ + τ ψ' = load, exactly for a load
/// that goes along a line in between. `m`: index into massless_.frames(); load: at the end of the step.
Vector6 Interior::settled(const Mechanism& mechanism, size_t m, const Vector6& load) const {
    const double relaxation = massless_.relaxation(m) / mechanism.scheme.step_size();
    if (relaxation == 0) return load;
    const size_t i = massless_.frames()[m];
    const Vector6 load_now = in_axes(mechanism.frame(driven_ + as_int(i)), frame_load(i).load[1]);
    const double relaxed = -std::expm1(-1 / relaxation);
    return load - relaxation * relaxed * (load - load_now) + (1 - relaxed) * (frame_load(i).settled - load_now);
}

/// A wrench at a massless frame as its receiver takes it, the frames being where they are given.
Vector6 Interior::passed_on(const std::vector<Frame>& frames, size_t frame, const Vector6& left) const {
    const auto origin = [&](int f) { return FrameView(frames[as_size(f)]).origin(); };
    Vector6 wrench = left;
    wrench.tail<3>() += Vector3(origin(driven_ + as_int(frame)) - origin(receivers_[frame])).cross(head(left));
    return wrench;
}

/// Solves for the correction and returns its size: the largest speed of a point.
double Interior::correct(const Mechanism& mechanism, const Elimination& matrix, Solution& solution) const {
    matrix.solve(solution.change, solution.q_change);
    if (&matrix == &elimination_)
        laws_.correct(mechanism, trial_, solution.change, solution.q_change, solution.laws);
    else
        std::fill(solution.laws.begin(), solution.laws.end(), 0.0);
    return largest_size(solution.change, turn_weight_);
}

/// Of the whole, world; zero where something ties it to the ground.
Vector3 Interior::mean_velocity(const Mechanism& mechanism, const Solution& solution) const {
    Vector3 mean = Vector3::Zero();
    if (driven_ > ports_) return mean;
    for (size_t i = 0; i < inertias_.size(); ++i)
        mean += mechanism.frame(driven_ + as_int(i)).axes() * solution.u[i].head<3>();
    return mean / static_cast<double>(inertias_.size());
}

/// What the motion from which passes start says of what is good enough.
void Interior::take_measures(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const Vector3 mean = mean_velocity(mechanism, solution);
    double speed = 0;
    for (size_t i = 0; i < inertias_.size(); ++i) {
        Vector3 velocity = solution.u[i].head<3>();
        if (driven_ == ports_) velocity -= mechanism.frame(driven_ + as_int(i)).axes().transpose() * mean;
        speed = std::max(speed, velocity.squaredNorm() + turn_weight_[i] * solution.u[i].tail<3>().squaredNorm());
    }
    solution.scale = std::max(solution.scale, std::sqrt(speed));
    solution.floor = std::max(kRounding * size_ / h, kFinest * solution.scale);
}

/// Passes from the motion in `solution` on until the last change is good enough, or one if `roughly`; contraction and
/// measures as last known. solution.correction and solution.residual: of a pass before; 0: there was none.
void Interior::solve(const Mechanism& mechanism, Solution& solution, bool roughly) const {
    const double h = mechanism.scheme.step_size(), floor = solution.floor;
    const Elimination* matrix = &elimination_;
    double rate = 0;
    if (solution.has_own_matrix) solution.motion = solution.momentum = {};  // rates of a matrix that is no more
    for (int pass = 0; pass < kMostPasses; ++pass) {
        ++passes_;
        if (pass > 0) {
            for (size_t i = 0; i < inertias_.size(); ++i) solution.u[i] += solution.change[i];
            for (size_t i = 0; i < solution.q.size(); ++i) solution.q[i] += solution.q_change[i] / h;
        }
        std::copy(solution.ports.begin(), solution.ports.end(), trial_.begin());
        place(mechanism, solution.u);
        find_forces(mechanism, solution);
        form_residuals(mechanism, solution);
        if (rate > kTooSlow) {
            ++factorisations_;
            if (form_at_trial(mechanism)) matrix = &at_trial_;
            solution.has_own_matrix = true;
        }
        const double residual = largest_size(solution.change, spin_weight_);  // the momentum that is lacking [N s]
        const double correction = correct(mechanism, *matrix, solution);
        if (!std::isfinite(correction + floor)) break;
        if (solution.correction > 0 && correction > floor) {
            rate = correction / solution.correction;
            solution.slowest_rate = std::max(solution.slowest_rate, rate);
            solution.motion.measure(rate, solution.correction);
            if (solution.residual > 0) solution.momentum.measure(residual / solution.residual, solution.residual);
        }
        if (pass == 0) {
            const double first = solution.correction > 0 ? solution.correction : correction;
            solution.first_correction = std::max(solution.first_correction, first);
            solution.tolerance = std::max(floor, kShare * std::min(first, solution.scale));
            solution.answer.motion = correction;
            solution.answer.momentum = std::max(residual - kRoundingOfPlace * size_ / h * stiffest_, 0.0);
        }
        solution.correction = correction;
        solution.residual = residual;
        solution.is_rough = !is_good_enough(correction, residual, solution);
        // What no longer falls is rounding, if it is small
        if (pass >= kPassesToFall && rate > 0.5 && correction <= kLargestRounding * solution.scale &&
            residual <= kShare * solution.impulse)
            solution.is_rough = false;
        if (!solution.is_rough || (roughly && may_be_rough(correction, solution))) return;
    }
    refuse_lack_of_convergence(mechanism, solution);
}

void Interior::refuse_lack_of_convergence(const Mechanism& mechanism, const Solution& solution) const {
    const auto left = [&](size_t i) {
        return solution.change[i].head<3>().squaredNorm() + turn_weight_[i] * solution.change[i].tail<3>().squaredNorm();
    };
    size_t worst = 0;
    for (size_t i = 1; i < inertias_.size(); ++i)
        if (!(left(i) <= left(worst))) worst = i;
    const FrameSpec& frame = mechanism.assembly.frames[as_size(driven_) + worst];
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("the motion inside the network was not found in {} passes, worst at {} (last correction {:.1e} "
                            "m/s); try a smaller step",
                            kMostPasses, frame.name, solution.correction),
                frame.element);
}

/// Whether what a first pass leaves over may be left to the next trial: passes are known to converge fast, and its
/// correction is like that of the step before.
bool Interior::may_be_rough(double correction, const Solution& solution) const {
    return solution.motion.measured_at > 0 && solution.motion.contraction <= kRoughly &&
           correction <= kSudden * books_.first_correction;
}

bool Interior::is_good_enough(double correction, double residual, const Solution& solution) const {
    if (correction <= solution.floor) return true;
    const double allowed = kShare * solution.impulse;
    return solution.motion.left(correction) <= solution.tolerance && solution.momentum.left(residual) <= allowed &&
           (!has_free_parts_ || residual <= kTrusted * allowed);
}

bool Interior::is_never_linear() const { return has_free_parts_ || has_near_laws_ || books_.port_turn > kTurnedPorts; }

/// Whether the linear answer to port_change_ leaves no more over than is good enough.
bool Interior::linear_answer_serves() const {
    if (!is_solved_) return false;
    if (port_change_.isZero(0)) return true;
    if (anchor_.is_rough || is_never_linear()) return false;
    const double change = speed_of_port_change();
    if (stays_linear_) return change <= kStillLinear * kLargestRounding * anchor_.scale;
    if (change <= anchor_.floor) return true;
    if (!anchor_.answer.is_known_for(change)) return false;
    const double part = change / anchor_.answer.speed;
    return part * anchor_.answer.motion <= anchor_.tolerance &&
           part * anchor_.answer.momentum <= kLinearly * kShare * anchor_.impulse;
}

/// Sets port_change_: what leads the ports from the anchor to where they are to go.
void Interior::take_port_change(const Mechanism& mechanism, Ports ports) const {
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const FrameView now = mechanism.frames[p], anchor = anchor_.ports[p], trial = ports[p];
        auto change = port_change_.segment<6>(as_row(6 * p));
        change << now.axes().transpose() * (trial.origin() - anchor.origin()),
            now.axes().transpose() * rotation_vector(trial.axes() * anchor.axes().transpose());
        change /= mechanism.scheme.step_size();
    }
}

/// The largest of a point of the ports' bodies [m/s]; NaN if a port's motion is.
double Interior::speed_of_port_change() const {
    double largest = 0, poison = 0;  // the latter 0, or not a number
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const auto change = port_change_.segment<6>(as_row(6 * p));
        const double size =
            change.head<3>().squaredNorm() + port_reach_[p] * port_reach_[p] * change.tail<3>().squaredNorm();
        largest = std::max(largest, size);
        poison += 0 * size;
    }
    return std::sqrt(largest + poison);
}

/// Begins a solution for ports port_change_ away from the anchor by the linear answer. `solution` may be the anchor itself.
void Interior::begin_solution(const Mechanism& mechanism, Ports ports, Solution& solution) const {
    for (size_t p = 0; p < port_u_.size(); ++p) solution.ports[p] = ports[p].copy();
    const bool is_as_foreseen = &solution == &anchor_ && moves_ == 0 && port_change_.isZero(0);
    if (!is_as_foreseen) find_motion(anchor_, solution.u);
    rigid_change_.noalias() = rigid_responses_ * port_change_;
    for (size_t i = 0; i < solution.q.size(); ++i)
        solution.q[i] = anchor_.q[i] + (anchor_.q_change[i] + rigid_change_(as_row(i))) / mechanism.scheme.step_size();
    take_measures(mechanism, solution);
    port_change_.setZero();
}

bool Interior::expect(const Mechanism& mechanism, Ports ports) {
    // Where parts turn, or trials do not come to rest, all answers are worked out from one point: smooth, as the host wants
    if (is_solved_ && !anchor_.is_rough && is_never_linear()) return false;
    take_port_change(mechanism, ports);
    if (is_solved_ && !anchor_.is_rough && moves_ >= kMostMoves) {
        stays_linear_ = stays_linear_ || speed_of_port_change() <= kLargestRounding * anchor_.scale;
        return false;
    }
    const bool is_first = !is_solved_;
    if (is_first) {
        // Where they were foreseen but for rounding there is nothing to answer
        if (speed_of_port_change() <= kRounding * size_ / mechanism.scheme.step_size()) port_change_.setZero();
    } else {
        if (!anchor_.is_rough && linear_answer_serves()) return false;
        anchor_.answer.speed = speed_of_port_change();
        anchor_.correction += anchor_.answer.speed;  // of this and the linear answer, the first pass tells what is left
        ++moves_;
    }
    is_solved_ = false;
    begin_solution(mechanism, ports, anchor_);
    try {
        solve(mechanism, anchor_, is_first && !is_never_linear());
    } catch (...) {
        predict(mechanism);
        open_anchor(mechanism);
        throw;
    }
    is_solved_ = true;
    return anchor_.is_rough;
}

/// The solution for a motion of the ports: the anchored one, to which port_change_ is to be added linearly, if that is good
/// enough, else one of its own.
const Interior::Solution& Interior::respond(const Mechanism& mechanism, Ports ports, bool finally) const {
    take_port_change(mechanism, ports);
    if (linear_answer_serves() && !(finally && anchor_.is_rough)) return anchor_;
    other_.motion = anchor_.motion;
    other_.momentum = anchor_.momentum;
    other_.scale = anchor_.scale;
    other_.correction = other_.residual = 0;
    other_.slowest_rate = anchor_.slowest_rate;
    other_.has_own_matrix = anchor_.has_own_matrix;
    begin_solution(mechanism, ports, other_);
    solve(mechanism, other_, false);
    return other_;
}

void Interior::find_motion(const Solution& solution, std::span<Vector6> motion) const {
    const auto change = as_size(port_change_.isZero(0) ? 0 : port_change_.size());
    add_changes(solution.u, solution.change, responses_, {port_change_.data(), change}, motion);
}

/// The motion of an inner frame over the step, with the linear answer to the ports.
Vector6 Interior::motion_of(size_t frame, const Solution& solution) const {
    return solution.u[frame] + solution.change[frame] + response(frame) * port_change_;
}

/// What a massless frame leaves over the step of its massless halves, at its origin.
Vector6 Interior::estate(const Mechanism& mechanism, size_t i, FrameView end) const {
    const Vector6 left = wrench_[as_size(driven_) + i] + load_over_step(mechanism.scheme, as_size(load_of_[i]), end) +
                         momenta_[i] / mechanism.scheme.step_size();
    return massless_part(i, left);
}

Vector6 Interior::massless_part(size_t i, Vector6 wrench) const {
    for (int half : {0, 1})
        if (!massless_.is_massless(i, half)) wrench.segment<3>(3 * half).setZero();
    return wrench;
}

/// Forces of the rigid directions where a solution ends.
void Interior::find_rigid_forces(const Mechanism& mechanism, const Solution& solution) const {
    rigid_change_.noalias() = rigid_responses_ * port_change_;
    for (size_t i = 0; i < q_.size(); ++i)
        q_[i] = solution.q[i] + (solution.q_change[i] + rigid_change_(as_row(i))) / mechanism.scheme.step_size();
}

/// What leads a frame from where the forces were worked out to the end of the step, over h, in its axes.
Vector6 Interior::change_of(int frame, const Solution& solution) const {
    if (is_inner(frame)) return solution.change[at(frame)] + response(at(frame)) * port_change_;
    if (frame < ports_) return port_change_.segment<6>(6 * frame);
    return Vector6::Zero();
}

/// The force of near_joints_[k] over the step: from where it was worked out on linear, for the ports want a smooth answer,
/// not the rounding of positions times the stiffness.
JointForce Interior::near_force(const Mechanism& mechanism, size_t k, const Solution& solution) const {
    const size_t j = near_joints_[k];
    const Joint& joint = mechanism.joints[j];
    const Vector6 u_from = change_of(joint.from(), solution), u_to = change_of(joint.to(), solution);
    const EndBlocks& K = near_blocks_[k];
    const double h = mechanism.scheme.step_size();
    Vector6 on_from = (K.at[0][0] * u_from + K.at[0][1] * u_to) / -h, on_to = (K.at[1][0] * u_from + K.at[1][1] * u_to) / h;
    for_each_rigid(joint, [&](int i, int) {
        const double q = q_[rigid_row(j, i)] - solution.q[rigid_row(j, i)];
        on_from -= q * elimination_.rigid(as_int(j), i, 0);
        on_to += q * elimination_.rigid(as_int(j), i, 1);
    });
    if (joint.has_laws()) laws_.add_force(j, solution.laws, on_from, on_to);
    const RowMajor3 R_from = mechanism.frame(joint.from()).axes(), R_to = mechanism.frame(joint.to()).axes();
    JointForce force = solution.near[k];
    force.add(1, {R_from * head(on_from), R_from * tail(on_from), R_to * tail(on_to)});
    return force;
}

void Interior::evaluate(const Mechanism& mechanism, Ports ports) const {
    const Solution& solution = respond(mechanism, ports, false);
    find_rigid_forces(mechanism, solution);
    for (int frame : port_frames_) wrench_[as_size(frame)].setZero();
    for (size_t k = 0; k < near_joints_.size(); ++k) {
        const Joint& joint = mechanism.joints[near_joints_[k]];
        Joint::add_wrench(near_force(mechanism, k, solution), wrench_[as_size(joint.from())].data(),
                          wrench_[as_size(joint.to())].data());
    }
    for (int frame : port_frames_) {
        if (!is_inner(frame)) continue;
        place(mechanism, at(frame), motion_of(at(frame), solution));
        wrench_[as_size(receivers_[at(frame)])] +=
            passed_on(mechanism.frames, at(frame), estate(mechanism, at(frame), trial_[as_size(frame)]));
    }
}

void Interior::commit(Mechanism& mechanism, Ports ports) {
    const Solution& solution = respond(mechanism, ports, true);
    find_rigid_forces(mechanism, solution);
    find_end(mechanism, solution);
    rigid_ = q_;
    // A step with a matrix formed for it converges like no other
    const bool is_like_the_next = !is_fresh_ && !solution.has_own_matrix;
    books_.motion = is_like_the_next ? solution.motion : Convergence{};
    books_.momentum = is_like_the_next ? solution.momentum : Convergence{};
    is_fresh_ = false;
    books_.scale = 0.98 * solution.scale;
    books_.first_correction = anchor_.first_correction;
    const bool is_slow = solution.slowest_rate > kSlowestContraction;
    for (size_t p = 0; p < port_u_.size(); ++p) trial_[p] = ports[p].copy();
    take_forces(mechanism, solution);
    set_elastic(mechanism);
    take_momenta(mechanism);
    take_loads(mechanism);
    take_motion(mechanism);
    books_.port_turn = turn_at_ports(mechanism);
    is_stale_ = is_slow || books_.port_turn > kTurnedPorts || rigid_directions_have_turned(mechanism);
    if (!is_stale_) look_at_joints(mechanism);
}

/// Against their frames, since the matrix was formed: their forces would be found slowly, or not at all, and no motion would
/// show it.
bool Interior::rigid_directions_have_turned(const Mechanism& mechanism) const {
    for (size_t j : rigid_joints_)
        for (int end : {0, 1}) {
            const Matrix6 rows = rigid_rows(mechanism, j, local_columns(mechanism, j, end));
            bool turned = false;
            for_each_rigid(mechanism.joints[j], [&](int i, int d) {
                const Vector6& then = elimination_.rigid(as_int(j), i, end);
                turned = turned ||
                         (rows.row(d).transpose() - then).squaredNorm() > kTurnedRows * kTurnedRows * then.squaredNorm();
            });
            if (turned) return true;
        }
    return false;
}

/// Of the joints at ports since the matrix was formed, as share of their directions and arms: the linear answer to the ports
/// goes by them, and no pass in here shows how far that is wrong.
double Interior::turn_at_ports(const Mechanism& mechanism) const {
    double largest = 0;
    for (size_t k = 0; k < near_joints_.size(); ++k)
        for (int end : {0, 1}) {
            const Matrix6& then = near_columns_[k].at[end];
            const Matrix6 now = local_columns(mechanism, near_joints_[k], end);
            largest = std::max(largest, (now - then).squaredNorm() / then.squaredNorm());
        }
    return std::sqrt(largest);
}

/// The frames where the step ends and what moves them there. Changes no state: here a step may still be refused.
void Interior::find_end(const Mechanism& mechanism, const Solution& solution) const {
    const double fastest_turning = std::min(kFastest, M_PI / mechanism.scheme.step_size());
    find_motion(solution, motion_);
    place(mechanism, motion_);
    for (size_t i = 0; i < inertias_.size(); ++i) {
        const size_t f = as_size(driven_) + i;
        const Vector6& u = motion_[i];
        if (mechanism.steps % kStepsBetweenNormalisations == 0) {  // by one step of Newton
            MapR next(trial_[f].rotation);
            next += (0.5 * next * (RowMajor3::Identity() - next.transpose() * next)).eval();
        }
        const bool is_sane = FrameView(trial_[f]).origin().squaredNorm() <= kFarthest * kFarthest &&
                             u.head<3>().squaredNorm() <= kFastest * kFastest &&
                             u.tail<3>().squaredNorm() <= fastest_turning * fastest_turning;  // false for NaN
        if (!is_sane) [[unlikely]]
            refuse_divergence(mechanism, i);
    }
}

void Interior::refuse_divergence(const Mechanism& mechanism, size_t i) const {
    const size_t f = as_size(driven_) + i;
    const FrameSpec& frame = mechanism.assembly.frames[f];
    const Vector3 x = FrameView(trial_[f]).origin(), v = mechanism.frame(as_int(f)).axes() * head(motion_[i]);
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("{} has diverged, or turns more than half a turn a step: position ({:.4g}, {:.4g}, {:.4g}) m, "
                            "velocity ({:.4g}, {:.4g}, {:.4g}) m/s, turning at {:.4g} rad/s; try a smaller step",
                            frame.name, x.x(), x.y(), x.z(), v.x(), v.y(), v.z(), tail(motion_[i]).norm()),
                frame.element);
}

/// The forces over the step, those of each joint a pair that balances exactly. The joints' memory moves on.
void Interior::take_forces(Mechanism& mechanism, const Solution& solution) {
    std::fill(wrench_.begin(), wrench_.end(), Vector6::Zero());
    by_four_.advance(mechanism, trial_, wrench_);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends next = {trial_[a], trial_[b]};
        const int near = near_index_[j];
        JointForce rigid, force;
        if (near < 0 && joint.rigid().any())
            rigid = rigid_action(mechanism, j, joint.pose(next), joint.rotation(next.from, next.to),
                                 rigid_values(mechanism, j, rigid_));
        joint.advance(mechanism.scheme, next, mechanism.ends(j), mechanism.states[j], mechanism.damper(j),
                      mechanism.law_memory_of(j), near < 0 ? &force : nullptr);
        if (near >= 0)
            force = near_force(mechanism, as_size(near), solution);
        else if (joint.rigid().any())
            force.add(1, rigid);
        Joint::add_wrench(force, wrench_[a].data(), wrench_[b].data());
    }
}

/// Moves the momenta on by the forces over the step and gives to the receivers what massless frames leave; the motion with
/// its memory likewise.
void Interior::take_momenta(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    const auto first = as_size(driven_);
    for (size_t i : massless_.frames()) {
        const int receiver = receivers_[i];
        if (!is_inner(receiver)) continue;
        Vector6 force = passed_on(mechanism.frames, i, estate(mechanism, i, trial_[first + i]));
        for (int half : {0, 1})
            if (massless_.is_massless(at(receiver), half)) force.segment<3>(3 * half).setZero();
        momenta_[at(receiver)] += h * force;
    }
    for (size_t k = 0; k < loaded_.size(); ++k)
        wrench_[first + loaded_[k]] += load_over_step(mechanism.scheme, k, trial_[first + loaded_[k]]);
    for (size_t i : massless_.frames())
        for (int half : {0, 1})
            if (massless_.is_massless(i, half)) {
                momenta_[i].segment<3>(3 * half).setZero();
                wrench_[first + i].segment<3>(3 * half).setZero();
            }
    past_.velocity.swap(past_.velocity_before);
    take_step(h, gravity_, inertias_, std::span(mechanism.frames).subspan(first), std::span(wrench_).subspan(first), motion_,
              momenta_, past_.velocity);
    past_.u.swap(past_.u_before);
    past_.u.swap(motion_);
    if (mechanism.steps > 0) return;
    past_.u_before = past_.u;
    for (size_t i = 0; i < inertias_.size(); ++i) {  // the initial velocities are the mean of both
        Twist &before = past_.velocity_before[i], &now = past_.velocity[i];
        before.linear = 2 * before.linear - now.linear;
        before.angular = 2 * before.angular - now.angular;
    }
}

/// Work of the loads, and their memory.
void Interior::take_loads(const Mechanism& mechanism) {
    for (size_t m = 0; m < massless_.frames().size(); ++m) {
        const size_t i = massless_.frames()[m], f = as_size(driven_) + i;
        const FrameView end = trial_[f];
        const Vector6 load = load_at_end(as_size(load_of_[i]), end);
        FrameLoad& own = frame_load(i);
        own.settled = settled(mechanism, m, in_axes(end, load));
        own.elastic[2] = own.elastic[1];
        own.elastic[1] = own.elastic[0];
    }
    // Mean force times displacement: exact for Newmark's rule
    books_.load_work += books_.last_work;
    books_.last_work = 0;
    const double h = mechanism.scheme.step_size();
    for (size_t k = 0; k < loaded_.size(); ++k) {
        FrameLoad& own = frame_loads_[k];
        const Vector6 next = load_at_end(k, trial_[as_size(driven_) + loaded_[k]]);
        books_.last_work += 0.5 * h * (own.load[1] + next).dot(joined(past_.velocity[loaded_[k]]));
        own.load[2] = own.load[1];
        own.load[1] = next;
    }
}

/// Moves the frames to the end of the step.
void Interior::take_motion(Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const FrameView now = mechanism.frames[p], next = trial_[p];
        Vector6 u;
        u << next.origin() - now.origin(), rotation_vector(next.axes() * now.axes().transpose());
        port_u_before_[p] = mechanism.steps == 0 ? Vector6(u / h) : port_u_[p];
        port_u_[p] = u / h;
    }
    mechanism.before.swap(mechanism.frames);
    mechanism.frames.swap(trial_);  // the ground is in all three
}

}  // namespace dttmm::plugin
