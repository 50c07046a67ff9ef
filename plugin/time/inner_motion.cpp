// SPDX-License-Identifier: BSD-3-Clause
#include "time/inner_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/rotation.h"
#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

InnerMotion::InnerMotion(Inside& inside, const InteriorMatrix& matrix)
    : q(inside.rigid.size(), 0.0),
      q_change(q),
      laws(matrix.law_count(), 0.0),
      near(inside.near_joints.size()),
      inside_(inside),
      matrix_(matrix) {
    port_change_.setZero(6 * inside.ports);
    rigid_change_.setZero(as_row(q.size()));
}

void InnerMotion::make_room_for_steps() {
    const std::vector<Frame>& frames = inside_.mechanism.frames;
    ports_.assign(frames.begin(), frames.begin() + inside_.ports);
    for (auto* list : {&u, &change}) list->assign(as_size(inside_.count), Vector6::Zero());
}

void InnerMotion::predict() {
    const double h = inside_.step_size();
    for (size_t p = 0; p < ports_.size(); ++p) {
        const Vector6 way = 2 * inside_.port_u[p] - inside_.port_u_before[p];
        const FrameView now = inside_.mechanism.frames[p];
        Eigen::Map<Vector3>{ports_[p].position} = now.origin() + h * head(way);
        Eigen::Map<RowMajor3>{ports_[p].rotation} = rotation_from_vector(h * tail(way)) * now.axes();
    }
    for (size_t i = 0; i < u.size(); ++i) u[i] = 2 * inside_.past.u[i] - inside_.past.u_before[i];
    if (inside_.mechanism.steps ==
        0) {  // velocities of an instant: over the step what turns has turned half of it on the mean
        const Vector3 mean = mean_velocity();
        for (size_t i = 0; i < u.size(); ++i) {
            const Vector3 drift = inside_.now(i).axes().transpose() * mean;
            u[i].head<3>() = (drift + turned(0.5 * h * u[i].tail<3>(), u[i].head<3>() - drift)).eval();
        }
    }
}

void InnerMotion::move_to_trial() {
    std::ranges::copy(ports_, inside_.trial.begin());
    inside_.place(u);
}

void InnerMotion::open() {
    is_begun_ = false;
    correction = rate = 0;
    std::ranges::fill(change, Vector6::Zero());
    std::ranges::fill(q_change, 0.0);
    q = inside_.rigid;
    size = 0;
    for (size_t i = 0; i < u.size(); ++i) size = std::max(size, inside_.now(i).origin().cwiseAbs().sum() + inside_.reach[i]);
}

double InnerMotion::take_port_change(Ports ports) {
    double largest = 0, poison = 0;  // the latter 0, or not a number
    for (size_t p = 0; p < ports_.size(); ++p) {
        const FrameView now = inside_.mechanism.frames[p], anchor = ports_[p], trial = ports[p];
        auto way = port_change_.segment<6>(as_row(6 * p));
        way << now.axes().transpose() * (trial.origin() - anchor.origin()),
            now.axes().transpose() * rotation_vector(trial.axes() * anchor.axes().transpose());
        way /= inside_.step_size();
        const double speed =
            way.head<3>().squaredNorm() + inside_.port_reach[p] * inside_.port_reach[p] * way.tail<3>().squaredNorm();
        largest = std::max(largest, speed);
        poison += 0 * speed;
    }
    return std::sqrt(largest + poison);
}

bool InnerMotion::is_rounding(double speed) const { return speed <= kRoundingOfSums * size / inside_.step_size(); }

void InnerMotion::go_on(Ports ports) {
    for (size_t p = 0; p < ports_.size(); ++p) ports_[p] = ports[p].copy();
    find_rigid_forces();
    q = inside_.trial_q;
    find_motion(u);
    take_measures();
    forget_port_change();
}

/// Of the whole, world; zero where something ties it to the ground.
Vector3 InnerMotion::mean_velocity() const {
    Vector3 mean = Vector3::Zero();
    if (inside_.driven > inside_.ports) return mean;
    for (size_t i = 0; i < u.size(); ++i) mean += inside_.now(i).axes() * u[i].head<3>();
    return mean / static_cast<double>(u.size());
}

/// What the motion from which passes start says of what is good enough.
void InnerMotion::take_measures() {
    const Vector3 mean = mean_velocity();
    double speed = 0;
    for (size_t i = 0; i < u.size(); ++i) {
        Vector3 velocity = u[i].head<3>();
        if (inside_.driven == inside_.ports) velocity -= inside_.now(i).axes().transpose() * mean;
        speed = std::max(speed, velocity.squaredNorm() + inside_.turn_weight[i] * u[i].tail<3>().squaredNorm());
    }
    scale = std::sqrt(speed);
    floor = kRoundingOfSums * std::max(size / inside_.step_size(), scale);
}

void InnerMotion::find_rigid_forces() {
    rigid_change_.noalias() = matrix_.rigid_responses() * port_change_;
    for (size_t i = 0; i < q.size(); ++i)
        inside_.trial_q[i] = q[i] + (q_change[i] + rigid_change_(as_row(i))) / inside_.step_size();
}

/// A correction turns a frame from where the matrix was formed; ω leads there from where the frame was at t_n.
Vector6 InnerMotion::motion_of(size_t inner) const {
    Vector6 more = change_of_inner(inner);
    if (matrix_.is_own())
        more.tail<3>() = (rotation_vector_rate(inside_.step_size() * u[inner].tail<3>()) * more.tail<3>()).eval();
    return u[inner] + more;
}

void InnerMotion::find_motion(std::span<Vector6> motion) const {
    if (matrix_.is_own()) {
        for (size_t i = 0; i < motion.size(); ++i) motion[i] = motion_of(i);
        return;
    }
    const auto moved = as_size(port_change_.isZero(0) ? 0 : port_change_.size());
    add_changes(u, change, matrix_.responses(), {port_change_.data(), moved}, motion);
}

/// What leads a frame from where the forces were worked out to the end of the step, over h, in its axes.
Vector6 InnerMotion::change_of(int frame) const {
    if (inside_.is_inner(frame)) return change_of_inner(inside_.at(frame));
    if (frame < inside_.ports) return port_change_.segment<6>(6 * frame);
    return Vector6::Zero();
}

JointForce InnerMotion::near_force(size_t k) const {
    const Joint& joint = inside_.mechanism.joints[inside_.near_joints[k]];
    JointForce force = near[k];
    force.add(1, matrix_.near_change(k, change_of(joint.from()), change_of(joint.to()), q, laws));
    return force;
}

}  // namespace dttmm::plugin
