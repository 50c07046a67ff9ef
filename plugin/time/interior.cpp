// SPDX-License-Identifier: BSD-3-Clause
#include "time/interior.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/rotation.h"
#include "time/inner_start.h"
#include "time/inside_math.h"
#include "time/slow_motion.h"

namespace dttmm::plugin {

namespace {

/// At which rigid directions are first looked at, to see that they can be solved [1/s]; 10 and 1e5 pass the same tests.
constexpr double kTrialRate = 1e3;
/// Slower than this, as kSlow of the host's bodies, the matrix is formed anew within the step.
constexpr double kTooSlow = 0.1;
/// Of a frame's place, of which stiff joints make forces.
constexpr double kRoundingOfPlace = 2 * std::numeric_limits<double>::epsilon();
/// Beyond these something has flown apart, by the host's measure of its bodies.
constexpr double kFarthest = 1e6;  // m
constexpr double kFastest = 1e8;   // m/s and rad/s

}  // namespace

Interior::Interior(Mechanism& mechanism, const dttmm_network& description, Loading loading)
    : mechanism_(mechanism),
      inside_(mechanism, description, std::move(loading)),
      matrix_(inside_),
      forces_(inside_),
      loads_(inside_),
      motion_(inside_, matrix_),
      instant_(inside_, matrix_.elimination()) {
    if (!mechanism.scheme.is_implicit())
        throw Error(DTTMM_ERROR_MODEL,
                    "it hangs on a node that is no body, or has a mass of its own: that wants the implicit coupling", 0);
    if (inside_.rigid_joints.empty()) return;  // start() sees it
    form_dynamic_stiffness(inside_, mechanism.frames, kTrialRate, matrix_.elimination());
    factor_or_refuse(mechanism, matrix_.elimination(), DTTMM_ERROR_MODEL);
}

// ---- The start ----------------------------------------------------------------------------------------------------------

void Interior::linearise(Ports ports, double* wrench, double* stiffness) const {
    InnerStart start(inside_, matrix_.elimination(), ports);
    start.balance(0);
    const auto on = [&](int frame) { return frame < inside_.ports ? wrench + 6 * ports.bodies[frame] : nullptr; };
    for (size_t j : inside_.port_joints) {
        const Joint& joint = mechanism_.joints[j];
        Joint::add_wrench(start.force(j), on(joint.from()), on(joint.to()));
    }
    if (stiffness) SlowMotion(inside_, matrix_.elimination(), start.frames()).write_stiffness(stiffness);
}

void Interior::follow(std::span<Vector6> motion) const {
    const std::vector<Frame> frames = described_frames(mechanism_);
    const SlowMotion slow(inside_, matrix_.elimination(), frames);
    for (size_t f = 0; f < motion.size(); ++f)
        motion[f] = f < as_size(inside_.ports) ? in_axes(frames[f], motion[f]) : Vector6(Vector6::Zero());
    std::vector<double> q(inside_.rigid.size());
    slow.follow(motion, q);
    for (size_t f = 0; f < motion.size(); ++f) motion[f] = in_world(frames[f], motion[f]);
}

void Interior::start(Ports ports, const double* accelerations, const double* loads, const std::vector<Frame>* at_rest) {
    inside_.record = {.starts_at_rest = at_rest ? 1.0 : 0.0};
    begin(at_rest ? InnerStart(inside_, *at_rest) : InnerStart(inside_, matrix_.elimination(), ports), ports, accelerations,
          loads);
    instant_.form_first_balance();
    inside_.make_room_for_steps();
    matrix_.make_room_for_steps();
    motion_.make_room_for_steps();
    instant_.make_room_for_steps();
    refactor();
}

/// Takes over the start values. `start` is freed on return, before memory for the steps is allocated.
void Interior::begin(InnerStart start, Ports ports, const double* accelerations, const double* loads) {
    start.refuse_forbidden_velocities();
    mechanism_.frames = start.frames();
    std::ranges::fill(inside_.rigid, 0.0);
    loads_.read(loads);
    loads_.start_loads();
    if (inside_.record.starts_at_rest == 0) start.balance(inside_.step_size());
    balance_at_start(start, ports, accelerations);
    for (size_t p = 0; p < inside_.port_u.size(); ++p) inside_.port_u[p] = joined(start.velocity(as_int(p)));
    inside_.port_u_before = inside_.port_u;
}

/// By the forces of the start: the momentum half a step before it, the accelerations and the memory of the joints.
void Interior::balance_at_start(const InnerStart& start, Ports ports, const double* accelerations) {
    std::vector<Vector6> wrenches(mechanism_.frames.size(), Vector6::Zero());
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        Joint::add_wrench(start.force(j), wrenches[as_size(joint.from())].data(), wrenches[as_size(joint.to())].data());
    }
    std::vector<Twist> acceleration = start.set_inertias(inside_, wrenches);
    // In balance with the forces of rigid directions, which the wrenches leave out
    if (inside_.record.starts_at_rest != 0) {
        std::ranges::fill(inside_.momenta, Vector6::Zero());
        std::ranges::fill(acceleration, Twist{});
    }
    const auto acceleration_of = [&](int frame) {
        if (inside_.is_inner(frame)) return acceleration[inside_.at(frame)];
        if (frame >= inside_.ports) return Twist{};
        const double* a = accelerations + 6 * ports.bodies[frame];
        return Twist{Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    };
    mechanism_.start_joints([&](int frame) { return start.velocity(frame); }, acceleration_of);
    for (int p = 0; p < inside_.ports; ++p) instant_.set_port_acceleration(p, acceleration_of(p));
    mechanism_.before = mechanism_.frames;
    loads_.start_elastic();
}

void Interior::refactor() {
    motion_.predict();
    motion_.move_to_trial();
    matrix_.form(inside_.trial);
    forces_.look_at_joints();
}

// ---- A step -------------------------------------------------------------------------------------------------------------

void Interior::begin_step(const double* loads) {
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) mechanism_.joints[j].refuse_large_rotation(mechanism_.states[j]);
    if (matrix_.is_stale()) refactor();
    loads_.read(loads);
    motion_.predict();
    motion_.open();
}

void Interior::iterate(Ports ports, dttmm_progress& progress) {
    double way = motion_.take_port_change(ports);
    if (!motion_.is_begun() && motion_.is_rounding(way)) {  // where they were foreseen
        motion_.forget_port_change();
        way = 0;
    }
    progress.previous = motion_.is_begun() ? motion_.correction + way : 0;
    try {
        motion_.go_on(ports);
        pass(progress);
    } catch (...) {
        motion_.predict();
        motion_.open();
        throw;
    }
    motion_.set_begun();
}

/// The forces of the motion, and the correction to which they lead. Where that falls slowly, or grows, the matrix is formed
/// where the motion is tried, and the correction is found anew: the first one would lead away.
void Interior::pass(dttmm_progress& progress) {
    motion_.move_to_trial();
    double residual = find_correction(progress.previous);
    if (motion_.rate > kTooSlow) {
        inside_.record.is_slow = 1;
        matrix_.form_at_trial();
        residual = find_correction(progress.previous);
    }
    report(residual, progress);
}

/// Returns the size of what the equations lack.
double Interior::find_correction(double previous) {
    forces_.find(motion_, loads_);
    find_lack();
    const double residual = largest_size(motion_.change, inside_.spin_weight);
    matrix_.solve(motion_.change, motion_.q_change, motion_.laws);
    motion_.correction = largest_size(motion_.change, inside_.turn_weight);
    if (!std::isfinite(motion_.correction + motion_.floor))
        throw Error(DTTMM_ERROR_NUMERIC, "the motion inside the network was not found; try a smaller step",
                    inside_.fastest_element(motion_.u));
    motion_.rate = previous > 0 && motion_.correction > motion_.floor ? motion_.correction / previous : 0;
    return residual;
}

/// What the equations lack where the motion is, into `change` (in the frames' axes) and `q_change`.
void Interior::find_lack() {
    const double h = inside_.step_size();
    loads_.add_over_step();
    find_imbalance(h, inside_.gravity, inside_.inertias, inside_.momenta, inside_.inner(mechanism_.frames),
                   inside_.inner(inside_.wrench), motion_.u, motion_.change);
    loads_.balance_massless(motion_.change);
    for (size_t j : inside_.rigid_joints) {
        const Joint& joint = mechanism_.joints[j];
        const auto [from, to] = ends(joint, inside_.trial);
        const Vector6 d = joint.opening(joint.pose(from, to), from, to);
        for_each_rigid(joint, [&](int i, int direction) { motion_.q_change[inside_.rigid_row(j, i)] = -d(direction) / h; });
    }
}

void Interior::report(double residual, dttmm_progress& progress) const {
    progress.correction = motion_.correction;
    progress.motion = motion_.scale;
    progress.enough = motion_.floor;
    // Stiff joints make momentum of the rounding of places
    progress.residual = std::max(residual - kRoundingOfPlace * motion_.size / inside_.step_size() * matrix_.stiffest(), 0.0);
    progress.impulse = motion_.impulse;
    progress.is_new = matrix_.formed();
    progress.element = motion_.rate > kTooSlow ? inside_.fastest_element(motion_.change) : -1;
}

void Interior::refuse_unstarted() const {
    if (!motion_.is_begun()) throw Error(DTTMM_ERROR_PHASE, "there was no iteration in this step yet");
}

void Interior::evaluate(Ports ports) {
    refuse_unstarted();
    motion_.take_port_change(ports);
    motion_.find_rigid_forces();
    for (int frame : inside_.port_frames) inside_.wrench[as_size(frame)].setZero();
    for (size_t k = 0; k < inside_.near_joints.size(); ++k) {
        const Joint& joint = mechanism_.joints[inside_.near_joints[k]];
        Joint::add_wrench(motion_.near_force(k), inside_.wrench[as_size(joint.from())].data(),
                          inside_.wrench[as_size(joint.to())].data());
    }
    for (int frame : inside_.port_frames) {
        if (!inside_.is_inner(frame)) continue;
        const size_t i = inside_.at(frame);
        inside_.place(i, motion_.motion_of(i));
        inside_.wrench[as_size(inside_.receivers[i])] += loads_.left_over(i, inside_.trial[as_size(frame)]);
    }
}

void Interior::commit(Ports ports) {
    refuse_unstarted();
    motion_.take_port_change(ports);
    motion_.find_rigid_forces();
    find_end();
    inside_.rigid = inside_.trial_q;
    for (size_t p = 0; p < inside_.port_u.size(); ++p) inside_.trial[p] = ports[p].copy();
    forces_.take_step(mechanism_, motion_);
    loads_.take_elastic();
    take_momenta();
    loads_.take_step();
    take_motion();
    matrix_.take_step();
    if (!matrix_.is_stale()) forces_.look_at_joints();
    if (mechanism_.steps > 0) instant_.forget_first_balance();  // the first row is written
}

/// The frames where the step ends and what moves them there. Changes no state: here a step may still be refused.
void Interior::find_end() {
    const double fastest_turning = std::min(kFastest, M_PI / inside_.step_size());
    motion_.find_motion(inside_.motion);
    inside_.place(inside_.motion);
    // Axes lose their right angles by rounding only: one frame a step, in turn, gets them back
    const size_t turn = mechanism_.steps % inside_.inertias.size();
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        Frame& end = inside_.trial[inside_.frame_of(i)];
        const Vector6& u = inside_.motion[i];
        if (i == turn) {  // by one step of Newton
            Eigen::Map<RowMajor3> next(end.rotation);
            next += (0.5 * next * (RowMajor3::Identity() - next.transpose() * next)).eval();
        }
        const bool is_sane = FrameView(end).origin().squaredNorm() <= kFarthest * kFarthest &&
                             u.head<3>().squaredNorm() <= kFastest * kFastest &&
                             u.tail<3>().squaredNorm() <= fastest_turning * fastest_turning;  // false for NaN
        if (!is_sane) [[unlikely]]
            refuse_divergence(i);
    }
}

void Interior::refuse_divergence(size_t i) const {
    const FrameSpec& frame = mechanism_.assembly.frames[inside_.frame_of(i)];
    const Vector3 x = FrameView(inside_.trial[inside_.frame_of(i)]).origin(),
                  v = inside_.now(i).axes() * head(inside_.motion[i]);
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("{} has diverged, or turns more than half a turn a step: position ({:.4g}, {:.4g}, {:.4g}) m, "
                            "velocity ({:.4g}, {:.4g}, {:.4g}) m/s, turning at {:.4g} rad/s; try a smaller step",
                            frame.name(), x.x(), x.y(), x.z(), v.x(), v.y(), v.z(), tail(inside_.motion[i]).norm()),
                frame.element);
}

/// Moves the momenta on by the forces over the step and gives to the receivers what massless frames leave; the motion with
/// its memory likewise.
void Interior::take_momenta() {
    loads_.pass_momenta_on();
    loads_.add_over_step();
    for (size_t i : inside_.massless.frames())
        for (int half : {0, 1})
            if (inside_.massless.is_massless(i, half)) {
                inside_.momenta[i].segment<3>(3 * half).setZero();
                inside_.wrench[inside_.frame_of(i)].segment<3>(3 * half).setZero();
            }
    PastMotion& past = inside_.past;
    past.velocity.swap(past.velocity_before);
    take_step(inside_.step_size(), inside_.gravity, inside_.inertias, inside_.inner(mechanism_.frames),
              inside_.inner(inside_.wrench), inside_.motion, inside_.momenta, past.velocity);
    past.u.swap(past.u_before);
    past.u.swap(inside_.motion);
    if (mechanism_.steps > 0) return;
    past.u_before = past.u;
    for (size_t i = 0; i < past.velocity.size(); ++i) {  // the initial velocities are the mean of both
        Twist &before = past.velocity_before[i], &now = past.velocity[i];
        before.linear = 2 * before.linear - now.linear;
        before.angular = 2 * before.angular - now.angular;
    }
}

/// Moves the frames to the end of the step.
void Interior::take_motion() {
    const double h = inside_.step_size();
    for (size_t p = 0; p < inside_.port_u.size(); ++p) {
        const FrameView now = mechanism_.frames[p], next = inside_.trial[p];
        Vector6 u;
        u << next.origin() - now.origin(), rotation_vector(next.axes() * now.axes().transpose());
        inside_.port_u_before[p] = mechanism_.steps == 0 ? Vector6(u / h) : inside_.port_u[p];
        inside_.port_u[p] = u / h;
    }
    mechanism_.before.swap(mechanism_.frames);
    mechanism_.frames.swap(inside_.trial);  // the ground is in all three
}

// ---- Results ------------------------------------------------------------------------------------------------------------

double Interior::work() const {
    double work = inside_.record.load_work;
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        const FrameView before = mechanism_.before[inside_.frame_of(i)];
        const Vector3& start = mechanism_.assembly.frames[inside_.frame_of(i)].pose.position;
        work += inside_.inertias[i].mass * inside_.gravity.dot(before.origin() - start);
    }
    return work;
}

Twist Interior::momentum() const {
    // x_n × p = x_{n−1} × p, for p is along what leads from one to the other
    Twist total;
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        const Vector3 p = head(inside_.momenta[i]);
        total.linear += p;
        total.angular += inside_.now(i).origin().cross(p) + tail(inside_.momenta[i]);
    }
    return total;
}

Twist Interior::newmark_momentum() const {
    // With F the elastic force on a frame, y = x − β h² F/m and P − β h (F_n − F_{n−1}) move in leap-frog by F_n alone.
    // Their moment does not change: y × F = x × F.
    const Scheme& scheme = mechanism_.scheme;
    const MasslessFrames& massless = inside_.massless;
    std::vector<Vector6> now(mechanism_.frames.size(), Vector6::Zero()), before = now;
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const auto a = as_size(mechanism_.joints[j].from()), b = as_size(mechanism_.joints[j].to());
        Joint::add_wrench(mechanism_.states[j].elastic, now[a].data(), now[b].data());
        JointForce force = mechanism_.states[j].known;  // without a damper (1 − 2s) F_n + s F_{n−1}
        force.add(-scheme.elastic_weight(1), mechanism_.states[j].elastic);
        JointForce earlier;
        earlier.add(1 / scheme.elastic_weight(2), force);
        Joint::add_wrench(earlier, before[a].data(), before[b].data());
    }
    for (size_t i : massless.frames()) {
        if (!inside_.is_inner(inside_.receivers[i])) continue;
        const size_t f = inside_.frame_of(i);
        const auto receiver = as_size(inside_.receivers[i]);
        now[receiver] += loads_.passed_on(mechanism_.frames, i, loads_.massless_part(i, now[f]));
        before[receiver] += loads_.passed_on(mechanism_.before, i, loads_.massless_part(i, before[f]));
    }
    const double h = inside_.step_size(), beta = scheme.elastic_weight(0);
    Twist total;
    for (size_t i = 0; i < inside_.inertias.size(); ++i) {
        if (massless.is_massless(i, 0)) continue;
        const size_t f = inside_.frame_of(i);
        Vector6 P = inside_.momenta[i] - beta * h * (now[f] - before[f]);
        if (massless.is_massless(i, 1)) P.tail<3>().setZero();
        const Vector3 y = inside_.now(i).origin() - beta * h * h / inside_.inertias[i].mass * head(now[f]);
        total.linear += head(P);
        total.angular += y.cross(head(P)) + tail(P);
    }
    return total;
}

}  // namespace dttmm::plugin
