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

/// Slower than this, the matrix is formed anew within the step.
constexpr double kTooSlow = 0.1;
/// Share by which a rigid direction may have turned against its frames since the matrix was formed.
constexpr double kTurnedRows = 0.02;
/// The same of joints at ports: as k h²/m of a stiff hinge is in the thousands, so is the error of the force they are told.
constexpr double kTurnedPorts = 1e-4;
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
/// Beyond these something has flown apart, by the host's measure of its bodies.
constexpr double kFarthest = 1e6;  // m
constexpr double kFastest = 1e8;   // m/s and rad/s

}  // namespace

void Interior::look_at_joints(const Mechanism& mechanism) {
    const Scheme& scheme = mechanism.scheme;
    for (size_t k = 0; k < layout_.rigid_joints.size(); ++k) {
        const size_t j = layout_.rigid_joints[k];
        const Joint& joint = mechanism.joints[j];
        const JointPose before = joint.pose(mechanism.frame_before(joint.from()), mechanism.frame_before(joint.to()));
        const Vector3 theta = mechanism.theta(j);
        RigidMap& known = open_.rigid_known[k] = {};
        known.add(scheme.elastic_weight(1), mechanism.pose(j), theta);
        // Three instants, one force: of one branch of θ
        known.add(scheme.elastic_weight(2), before, nearest_turn(mechanism.states[j].theta_before, theta));
    }
    massless_.look(mechanism);
}

void Interior::begin_step(const Mechanism& mechanism, const double* loads) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) mechanism.joints[j].refuse_large_rotation(mechanism.states[j]);
    if (matrix_.is_stale) refactor(mechanism);
    read_loads(loads);
    predict(mechanism);
    open_solution(mechanism);
}

/// Where the ports and the inside end if they go on as they have.
void Interior::predict(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const Vector6 u = 2 * port_u_[p] - port_u_before_[p];
        const FrameView now = mechanism.frames[p];
        Map3{open_.solution.ports[p].position} = now.origin() + h * head(u);
        MapR{open_.solution.ports[p].rotation} = rotation_from_vector(h * tail(u)) * now.axes();
    }
    for (size_t i = 0; i < layout_.inertias.size(); ++i) open_.solution.u[i] = 2 * past_.u[i] - past_.u_before[i];
    if (mechanism.steps == 0) {  // velocities of an instant: over the step what turns has turned half of it on the mean
        const Vector3 mean = mean_velocity(mechanism, open_.solution);
        for (size_t i = 0; i < layout_.inertias.size(); ++i) {
            const Vector3 drift = mechanism.frame(layout_.driven + as_int(i)).axes().transpose() * mean;
            Vector6& u = open_.solution.u[i];
            u.head<3>() = (drift + turned(0.5 * h * u.tail<3>(), u.head<3>() - drift)).eval();
        }
    }
}

/// What is known before the first iteration: ports that go on as they have.
void Interior::open_solution(const Mechanism& mechanism) {
    Solution& solution = open_.solution;
    open_.is_begun = false;
    solution.correction = solution.rate = 0;
    std::fill(solution.change.begin(), solution.change.end(), Vector6::Zero());
    std::fill(solution.q_change.begin(), solution.q_change.end(), 0.0);
    solution.q = rigid_;
    solution.scale = record_.scale;
    open_.size = kSmallestSize;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const FrameView frame = mechanism.frames[as_size(layout_.driven) + i];
        open_.size = std::max(open_.size, frame.origin().cwiseAbs().sum() + layout_.reach[i]);
    }
}

/// Puts the inner frames, moving by u over the step, where it ends, into work_.trial.
void Interior::place(const Mechanism& mechanism, std::span<const Vector6> u) const {
    const auto first = as_size(layout_.driven);
    move_frames(mechanism.scheme.step_size(), std::span(mechanism.frames).subspan(first), u,
                std::span(work_.trial).subspan(first));
}
/// The same of one of them.
void Interior::place(const Mechanism& mechanism, size_t i, const Vector6& u) const {
    const size_t f = as_size(layout_.driven) + i;
    move_frames(mechanism.scheme.step_size(), {&mechanism.frames[f], 1}, {&u, 1}, {&work_.trial[f], 1});
}

/// Forces q of a joint's rigid directions over the step.
JointForce Interior::rigid_action(const Mechanism& mechanism, size_t j, const JointPose& at_end, const Vector3& theta,
                                  const Vector6& q) const {
    RigidMap map = open_.rigid_known[as_size(layout_.rigid_index[j])];
    map.add(mechanism.scheme.elastic_weight(0), at_end, nearest_turn(theta, mechanism.theta(j)));
    return map.of(q);
}

/// Of a joint over the step that ends with its frames at work_.trial and its rigid directions carrying work_.q.
JointForce Interior::force_over_step(const Mechanism& mechanism, size_t j, const JointPose& at_end,
                                     const Joint::Strained& end) const {
    const Joint& joint = mechanism.joints[j];
    JointForce force =
        joint.weigh(mechanism.scheme, end, at_end, mechanism.states[j], mechanism.damper(j), mechanism.memory(j));
    if (joint.rigid().any())
        force.add(1, rigid_action(mechanism, j, at_end, end.theta, rigid_values(mechanism, j, work_.q)));
    return force;
}

/// Wrenches of all joints over the step, and on massless frames at its end and half way.
void Interior::find_forces(const Mechanism& mechanism, Solution& solution) const {
    std::fill(work_.wrench.begin(), work_.wrench.end(), Vector6::Zero());
    for (auto* wrenches : {&work_.end_wrench, &work_.damping_wrench})
        std::fill(wrenches->begin(), wrenches->end(), Vector6::Zero());
    const auto on_massless = [&](std::vector<Vector6>& wrenches, int frame) {
        const int m = is_inner(frame) ? massless_.index_of(at(frame)) : -1;
        return m < 0 ? nullptr : wrenches[as_size(m)].data();
    };
    work_.q = solution.q;
    double largest = by_four_.add_forces(mechanism, work_.trial, work_.wrench);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends trial = {work_.trial[a], work_.trial[b]};
        const JointPose at_end = joint.pose(trial);
        const Joint::Strained end = joint.strain(mechanism.scheme, trial, at_end, mechanism.states[j], mechanism.memory(j));
        const JointForce force = force_over_step(mechanism, j, at_end, end);
        largest = std::max(largest, force.force.squaredNorm());
        Joint::add_wrench(force, work_.wrench[a].data(), work_.wrench[b].data());
        if (layout_.near_index[j] >= 0) solution.near[as_size(layout_.near_index[j])] = force;
        if (!massless_.is_settling(j)) continue;
        JointForce then = end.elastic;
        if (joint.rigid().any()) {
            const Vector6 q = rigid_values(mechanism, j, work_.q);
            then.add(1, at_end.act(at_end.axes * head(q), at_end.axes * moment_of_gradient(end.theta, tail(q))));
        }
        Joint::add_wrench(then, on_massless(work_.end_wrench, joint.from()), on_massless(work_.end_wrench, joint.to()));
        if (massless_.is_half_way(j))
            Joint::add_wrench(joint.damping_half_way(trial, mechanism.ends(j), mechanism.scheme.step_size(),
                                                     mechanism.states[j], *mechanism.damper(j)),
                              on_massless(work_.damping_wrench, joint.from()),
                              on_massless(work_.damping_wrench, joint.to()));
    }
    solution.impulse = mechanism.scheme.step_size() * std::sqrt(largest);
}

/// The load on a loaded frame at the end of the step, at its origin, when it is then at `frame`.
Vector6 Interior::load_at_end(size_t loaded, FrameView frame) const {
    return loading_.wrench(layout_.driven + as_int(layout_.loaded[loaded]), frame, open_.loads.data());
}

Vector6 Interior::load_over_step(const Scheme& scheme, size_t loaded, FrameView frame) const {
    const FrameLoad& own = frame_loads_[loaded];
    return scheme.weight(0) * load_at_end(loaded, frame) + scheme.weight(1) * own.load[1] + scheme.weight(2) * own.load[2];
}

/// What the equations lack at the trial motion, into `change` (in the frames' axes) and `q_change`.
void Interior::form_residuals(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const auto first = as_size(layout_.driven);
    for (size_t k = 0; k < layout_.loaded.size(); ++k)
        work_.wrench[first + layout_.loaded[k]] +=
            load_over_step(mechanism.scheme, k, work_.trial[first + layout_.loaded[k]]);
    find_imbalance(h, layout_.gravity, layout_.inertias, momenta_, std::span(mechanism.frames).subspan(first),
                   std::span(work_.wrench).subspan(first), solution.u, solution.change);
    balance_massless(mechanism, solution);
    for (size_t j : layout_.rigid_joints) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = work_.trial[as_size(joint.from())], to = work_.trial[as_size(joint.to())];
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
        const size_t i = frames[m], f = as_size(layout_.driven) + i;
        const FrameLoad& own = frame_load(i);
        const FrameView now = mechanism.frames[f], end = work_.trial[f];
        const Vector6 load = load_at_end(as_size(layout_.load_of[i]), end);
        const Vector6 elastic = in_axes(end, work_.end_wrench[m]), load_then = in_axes(end, load);
        MasslessFrames::Residual& residual = work_.massless_residuals[m];
        residual.step = solution.change[i];
        // Both with the factors that make their derivatives by the end of the step those of the forces over it
        residual.end = h * (mechanism.scheme.weight(0) + massless_.relaxation(m) * mechanism.scheme.rate(0)) *
                       (elastic + settled(mechanism, m, load_then));
        residual.half_way = 0.25 * h * (elastic + load_then + in_axes(now, own.elastic[1] + own.load[1])) +
                            0.5 * h * in_axes(now, work_.damping_wrench[m]);
    }
    massless_.combine(work_.massless_residuals);
    for (size_t m = 0; m < frames.size(); ++m) {
        const size_t i = frames[m];
        const int receiver = layout_.receivers[i];
        const Vector6 left = solution.change[i] - work_.massless_residuals[m].step;
        solution.change[i] = work_.massless_residuals[m].step;
        if (!is_inner(receiver)) continue;
        const RowMajor3 R = mechanism.frame(layout_.driven + as_int(i)).axes();
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
    const Vector6 load_now = in_axes(mechanism.frame(layout_.driven + as_int(i)), frame_load(i).load[1]);
    const double relaxed = -std::expm1(-1 / relaxation);
    return load - relaxation * relaxed * (load - load_now) + (1 - relaxed) * (frame_load(i).settled - load_now);
}

/// A wrench at a massless frame as its receiver takes it, the frames being where they are given.
Vector6 Interior::passed_on(const std::vector<Frame>& frames, size_t frame, const Vector6& left) const {
    const auto origin = [&](int f) { return FrameView(frames[as_size(f)]).origin(); };
    Vector6 wrench = left;
    wrench.tail<3>() += Vector3(origin(layout_.driven + as_int(frame)) - origin(layout_.receivers[frame])).cross(head(left));
    return wrench;
}

/// Solves for the correction and returns its size: the largest speed of a point.
double Interior::correct(const Mechanism& mechanism, Solution& solution) const {
    matrix_.factor.solve(solution.change, solution.q_change);
    if (work_.laws.are_wanted(record_.is_slow != 0))
        work_.laws.correct(mechanism, work_.trial, solution.change, solution.q_change, solution.laws);
    return largest_size(solution.change, layout_.turn_weight);
}

/// Of the whole, world; zero where something ties it to the ground.
Vector3 Interior::mean_velocity(const Mechanism& mechanism, const Solution& solution) const {
    Vector3 mean = Vector3::Zero();
    if (layout_.driven > layout_.ports) return mean;
    for (size_t i = 0; i < layout_.inertias.size(); ++i)
        mean += mechanism.frame(layout_.driven + as_int(i)).axes() * solution.u[i].head<3>();
    return mean / static_cast<double>(layout_.inertias.size());
}

/// What the motion from which passes start says of what is good enough.
void Interior::take_measures(const Mechanism& mechanism, Solution& solution) const {
    const double h = mechanism.scheme.step_size();
    const Vector3 mean = mean_velocity(mechanism, solution);
    double speed = 0;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        Vector3 velocity = solution.u[i].head<3>();
        if (layout_.driven == layout_.ports)
            velocity -= mechanism.frame(layout_.driven + as_int(i)).axes().transpose() * mean;
        speed = std::max(speed, velocity.squaredNorm() + layout_.turn_weight[i] * solution.u[i].tail<3>().squaredNorm());
    }
    solution.scale = std::max(solution.scale, std::sqrt(speed));
    solution.floor = std::max(kRounding * open_.size / h, kFinest * solution.scale);
}

/// Sets work_.port_change: what leads the ports from where they were at the last iteration to where they are to go.
void Interior::take_port_change(const Mechanism& mechanism, Ports ports) const {
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const FrameView now = mechanism.frames[p], anchor = open_.solution.ports[p], trial = ports[p];
        auto change = work_.port_change.segment<6>(as_row(6 * p));
        change << now.axes().transpose() * (trial.origin() - anchor.origin()),
            now.axes().transpose() * rotation_vector(trial.axes() * anchor.axes().transpose());
        change /= mechanism.scheme.step_size();
    }
}

/// The largest of a point of the ports' bodies [m/s]; NaN if a port's motion is.
double Interior::speed_of_port_change() const {
    double largest = 0, poison = 0;  // the latter 0, or not a number
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const auto change = work_.port_change.segment<6>(as_row(6 * p));
        const double size =
            change.head<3>().squaredNorm() + layout_.port_reach[p] * layout_.port_reach[p] * change.tail<3>().squaredNorm();
        largest = std::max(largest, size);
        poison += 0 * size;
    }
    return std::sqrt(largest + poison);
}

/// The motion that the last iteration leads to, the ports going work_.port_change further.
void Interior::go_on(const Mechanism& mechanism, Ports ports) {
    Solution& solution = open_.solution;
    for (size_t p = 0; p < port_u_.size(); ++p) solution.ports[p] = ports[p].copy();
    find_rigid_forces(mechanism, solution);
    solution.q = work_.q;
    find_motion(solution, solution.u);
    take_measures(mechanism, solution);
    work_.port_change.setZero();
}

void Interior::iterate(const Mechanism& mechanism, Ports ports, dttmm_progress& progress) {
    take_port_change(mechanism, ports);
    double way = speed_of_port_change();
    if (!open_.is_begun && way <= kRounding * open_.size / mechanism.scheme.step_size()) {  // where they were foreseen
        work_.port_change.setZero();
        way = 0;
    }
    progress.previous = open_.is_begun ? open_.solution.correction + way : 0;
    try {
        go_on(mechanism, ports);
        pass(mechanism, progress);
    } catch (...) {
        predict(mechanism);
        open_solution(mechanism);
        throw;
    }
    open_.is_begun = true;
}

/// The forces of the motion in open_.solution, and the correction to which they lead.
void Interior::pass(const Mechanism& mechanism, dttmm_progress& progress) {
    Solution& solution = open_.solution;
    ++work_.passes;
    std::copy(solution.ports.begin(), solution.ports.end(), work_.trial.begin());
    place(mechanism, solution.u);
    find_forces(mechanism, solution);
    form_residuals(mechanism, solution);
    if (solution.rate > kTooSlow) {
        record_.is_slow = 1;
        form_at_trial(mechanism);
    }
    const double residual = largest_size(solution.change, layout_.spin_weight);
    solution.correction = correct(mechanism, solution);
    if (!std::isfinite(solution.correction + solution.floor))
        throw Error(DTTMM_ERROR_NUMERIC, "the motion inside the network was not found; try a smaller step",
                    fastest_element(mechanism, solution.u));
    solution.rate =
        progress.previous > 0 && solution.correction > solution.floor ? solution.correction / progress.previous : 0;
    progress.correction = solution.correction;
    progress.motion = solution.scale;
    progress.enough = solution.floor;
    // Stiff joints make momentum of the rounding of places
    progress.residual =
        std::max(residual - kRoundingOfPlace * open_.size / mechanism.scheme.step_size() * matrix_.stiffest, 0.0);
    progress.impulse = solution.impulse;
    progress.is_new = matrix_.is_fresh || matrix_.is_own;
    progress.element = solution.rate > kTooSlow ? fastest_element(mechanism, solution.change) : -1;
}

/// Of the frame that moves most.
int Interior::fastest_element(const Mechanism& mechanism, std::span<const Vector6> u) const {
    const auto size = [&](size_t i) {
        return u[i].head<3>().squaredNorm() + layout_.turn_weight[i] * u[i].tail<3>().squaredNorm();
    };
    size_t worst = 0;
    for (size_t i = 1; i < layout_.inertias.size(); ++i)
        if (!(size(i) <= size(worst))) worst = i;
    return mechanism.assembly.frames[as_size(layout_.driven) + worst].element;
}

void Interior::find_motion(const Solution& solution, std::span<Vector6> motion) const {
    const auto change = as_size(work_.port_change.isZero(0) ? 0 : work_.port_change.size());
    add_changes(solution.u, solution.change, matrix_.responses, {work_.port_change.data(), change}, motion);
}

/// The motion of an inner frame over the step, with the linear answer to the ports.
Vector6 Interior::motion_of(size_t frame, const Solution& solution) const {
    return solution.u[frame] + solution.change[frame] + response(frame) * work_.port_change;
}

/// What a massless frame leaves over the step of its massless halves, at its origin.
Vector6 Interior::estate(const Mechanism& mechanism, size_t i, FrameView end) const {
    const Vector6 left = work_.wrench[as_size(layout_.driven) + i] +
                         load_over_step(mechanism.scheme, as_size(layout_.load_of[i]), end) +
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
    work_.rigid_change.noalias() = matrix_.rigid_responses * work_.port_change;
    for (size_t i = 0; i < work_.q.size(); ++i)
        work_.q[i] = solution.q[i] + (solution.q_change[i] + work_.rigid_change(as_row(i))) / mechanism.scheme.step_size();
}

/// What leads a frame from where the forces were worked out to the end of the step, over h, in its axes.
Vector6 Interior::change_of(int frame, const Solution& solution) const {
    if (is_inner(frame)) return solution.change[at(frame)] + response(at(frame)) * work_.port_change;
    if (frame < layout_.ports) return work_.port_change.segment<6>(6 * frame);
    return Vector6::Zero();
}

/// The force of layout_.near_joints[k] over the step: from where it was worked out on linear, for the ports want a smooth
/// answer, not the rounding of positions times the stiffness.
JointForce Interior::near_force(const Mechanism& mechanism, size_t k, const Solution& solution) const {
    const size_t j = layout_.near_joints[k];
    const Joint& joint = mechanism.joints[j];
    const Vector6 u_from = change_of(joint.from(), solution), u_to = change_of(joint.to(), solution);
    const EndBlocks& K = matrix_.near_blocks[k];
    const double h = mechanism.scheme.step_size();
    Vector6 on_from = (K.at[0][0] * u_from + K.at[0][1] * u_to) / -h, on_to = (K.at[1][0] * u_from + K.at[1][1] * u_to) / h;
    for_each_rigid(joint, [&](int i, int) {
        const double q = work_.q[rigid_row(j, i)] - solution.q[rigid_row(j, i)];
        on_from -= q * matrix_.factor.rigid(as_int(j), i, 0);
        on_to += q * matrix_.factor.rigid(as_int(j), i, 1);
    });
    if (joint.has_laws()) work_.laws.add_force(j, solution.laws, on_from, on_to);
    const RowMajor3 R_from = mechanism.frame(joint.from()).axes(), R_to = mechanism.frame(joint.to()).axes();
    JointForce force = solution.near[k];
    force.add(1, {R_from * head(on_from), R_from * tail(on_from), R_to * tail(on_to)});
    return force;
}

void Interior::refuse_unstarted() const {
    if (!open_.is_begun) throw Error(DTTMM_ERROR_PHASE, "there was no iteration in this step yet");
}

void Interior::evaluate(const Mechanism& mechanism, Ports ports) const {
    refuse_unstarted();
    const Solution& solution = open_.solution;
    take_port_change(mechanism, ports);
    find_rigid_forces(mechanism, solution);
    for (int frame : layout_.port_frames) work_.wrench[as_size(frame)].setZero();
    for (size_t k = 0; k < layout_.near_joints.size(); ++k) {
        const Joint& joint = mechanism.joints[layout_.near_joints[k]];
        Joint::add_wrench(near_force(mechanism, k, solution), work_.wrench[as_size(joint.from())].data(),
                          work_.wrench[as_size(joint.to())].data());
    }
    for (int frame : layout_.port_frames) {
        if (!is_inner(frame)) continue;
        place(mechanism, at(frame), motion_of(at(frame), solution));
        work_.wrench[as_size(layout_.receivers[at(frame)])] +=
            passed_on(mechanism.frames, at(frame), estate(mechanism, at(frame), work_.trial[as_size(frame)]));
    }
}

void Interior::commit(Mechanism& mechanism, Ports ports) {
    refuse_unstarted();
    const Solution& solution = open_.solution;
    take_port_change(mechanism, ports);
    find_rigid_forces(mechanism, solution);
    find_end(mechanism, solution);
    rigid_ = work_.q;
    record_.scale = 0.98 * solution.scale;
    for (size_t p = 0; p < port_u_.size(); ++p) work_.trial[p] = ports[p].copy();
    take_forces(mechanism, solution);
    set_elastic(mechanism);
    take_momenta(mechanism);
    take_loads(mechanism);
    take_motion(mechanism);
    record_.port_turn = turn_at_ports(mechanism);
    matrix_.is_stale = matrix_.is_own || record_.port_turn > kTurnedPorts || rigid_directions_have_turned(mechanism);
    matrix_.is_fresh = false;
    if (!matrix_.is_stale) look_at_joints(mechanism);
    if (mechanism.steps > 0) first_balance_.reset();  // the first row is written
}

/// Against their frames, since the matrix was formed: their forces would be found slowly, or not at all, and no motion would
/// show it.
bool Interior::rigid_directions_have_turned(const Mechanism& mechanism) const {
    for (size_t j : layout_.rigid_joints)
        for (int end : {0, 1}) {
            const Matrix6 rows = rigid_rows(mechanism, j, local_columns(mechanism, j, end));
            bool turned = false;
            for_each_rigid(mechanism.joints[j], [&](int i, int d) {
                const Vector6& then = matrix_.factor.rigid(as_int(j), i, end);
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
    for (size_t k = 0; k < layout_.near_joints.size(); ++k)
        for (int end : {0, 1}) {
            const Matrix6& then = matrix_.near_columns[k].at[end];
            const Matrix6 now = local_columns(mechanism, layout_.near_joints[k], end);
            largest = std::max(largest, (now - then).squaredNorm() / then.squaredNorm());
        }
    return std::sqrt(largest);
}

/// The frames where the step ends and what moves them there. Changes no state: here a step may still be refused.
void Interior::find_end(const Mechanism& mechanism, const Solution& solution) const {
    const double fastest_turning = std::min(kFastest, M_PI / mechanism.scheme.step_size());
    find_motion(solution, work_.motion);
    place(mechanism, work_.motion);
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const size_t f = as_size(layout_.driven) + i;
        const Vector6& u = work_.motion[i];
        if (mechanism.steps % kStepsBetweenNormalisations == 0) {  // by one step of Newton
            MapR next(work_.trial[f].rotation);
            next += (0.5 * next * (RowMajor3::Identity() - next.transpose() * next)).eval();
        }
        const bool is_sane = FrameView(work_.trial[f]).origin().squaredNorm() <= kFarthest * kFarthest &&
                             u.head<3>().squaredNorm() <= kFastest * kFastest &&
                             u.tail<3>().squaredNorm() <= fastest_turning * fastest_turning;  // false for NaN
        if (!is_sane) [[unlikely]]
            refuse_divergence(mechanism, i);
    }
}

void Interior::refuse_divergence(const Mechanism& mechanism, size_t i) const {
    const size_t f = as_size(layout_.driven) + i;
    const FrameSpec& frame = mechanism.assembly.frames[f];
    const Vector3 x = FrameView(work_.trial[f]).origin(), v = mechanism.frame(as_int(f)).axes() * head(work_.motion[i]);
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("{} has diverged, or turns more than half a turn a step: position ({:.4g}, {:.4g}, {:.4g}) m, "
                            "velocity ({:.4g}, {:.4g}, {:.4g}) m/s, turning at {:.4g} rad/s; try a smaller step",
                            frame.name(), x.x(), x.y(), x.z(), v.x(), v.y(), v.z(), tail(work_.motion[i]).norm()),
                frame.element);
}

/// The forces over the step, those of each joint a pair that balances exactly. The joints' memory moves on.
void Interior::take_forces(Mechanism& mechanism, const Solution& solution) {
    std::fill(work_.wrench.begin(), work_.wrench.end(), Vector6::Zero());
    by_four_.advance(mechanism, work_.trial, work_.wrench);
    for (size_t j : others_) {
        const Joint& joint = mechanism.joints[j];
        const auto a = as_size(joint.from()), b = as_size(joint.to());
        const Ends next = {work_.trial[a], work_.trial[b]};
        const int near = layout_.near_index[j];
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
        Joint::add_wrench(force, work_.wrench[a].data(), work_.wrench[b].data());
    }
}

/// Moves the momenta on by the forces over the step and gives to the receivers what massless frames leave; the motion with
/// its memory likewise.
void Interior::take_momenta(const Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    const auto first = as_size(layout_.driven);
    for (size_t i : massless_.frames()) {
        const int receiver = layout_.receivers[i];
        if (!is_inner(receiver)) continue;
        Vector6 force = passed_on(mechanism.frames, i, estate(mechanism, i, work_.trial[first + i]));
        for (int half : {0, 1})
            if (massless_.is_massless(at(receiver), half)) force.segment<3>(3 * half).setZero();
        momenta_[at(receiver)] += h * force;
    }
    for (size_t k = 0; k < layout_.loaded.size(); ++k)
        work_.wrench[first + layout_.loaded[k]] +=
            load_over_step(mechanism.scheme, k, work_.trial[first + layout_.loaded[k]]);
    for (size_t i : massless_.frames())
        for (int half : {0, 1})
            if (massless_.is_massless(i, half)) {
                momenta_[i].segment<3>(3 * half).setZero();
                work_.wrench[first + i].segment<3>(3 * half).setZero();
            }
    past_.velocity.swap(past_.velocity_before);
    take_step(h, layout_.gravity, layout_.inertias, std::span(mechanism.frames).subspan(first),
              std::span(work_.wrench).subspan(first), work_.motion, momenta_, past_.velocity);
    past_.u.swap(past_.u_before);
    past_.u.swap(work_.motion);
    if (mechanism.steps > 0) return;
    past_.u_before = past_.u;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {  // the initial velocities are the mean of both
        Twist &before = past_.velocity_before[i], &now = past_.velocity[i];
        before.linear = 2 * before.linear - now.linear;
        before.angular = 2 * before.angular - now.angular;
    }
}

/// Work of the loads, and their memory.
void Interior::take_loads(const Mechanism& mechanism) {
    for (size_t m = 0; m < massless_.frames().size(); ++m) {
        const size_t i = massless_.frames()[m], f = as_size(layout_.driven) + i;
        const FrameView end = work_.trial[f];
        const Vector6 load = load_at_end(as_size(layout_.load_of[i]), end);
        FrameLoad& own = frame_load(i);
        own.settled = settled(mechanism, m, in_axes(end, load));
        own.elastic[2] = own.elastic[1];
        own.elastic[1] = own.elastic[0];
    }
    // Mean force times displacement: exact for Newmark's rule
    record_.load_work += record_.last_work;
    record_.last_work = 0;
    const double h = mechanism.scheme.step_size();
    for (size_t k = 0; k < layout_.loaded.size(); ++k) {
        FrameLoad& own = frame_loads_[k];
        own.load[0] = load_at_end(k, work_.trial[as_size(layout_.driven) + layout_.loaded[k]]);
        record_.last_work += 0.5 * h * (own.load[1] + own.load[0]).dot(joined(past_.velocity[layout_.loaded[k]]));
        own.load[2] = own.load[1];
        own.load[1] = own.load[0];
    }
}

/// Moves the frames to the end of the step.
void Interior::take_motion(Mechanism& mechanism) {
    const double h = mechanism.scheme.step_size();
    for (size_t p = 0; p < port_u_.size(); ++p) {
        const FrameView now = mechanism.frames[p], next = work_.trial[p];
        Vector6 u;
        u << next.origin() - now.origin(), rotation_vector(next.axes() * now.axes().transpose());
        port_u_before_[p] = mechanism.steps == 0 ? Vector6(u / h) : port_u_[p];
        port_u_[p] = u / h;
    }
    mechanism.before.swap(mechanism.frames);
    mechanism.frames.swap(work_.trial);  // the ground is in all three
}

}  // namespace dttmm::plugin
