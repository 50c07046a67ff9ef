// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_closure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/error.h"
#include "model/index.h"
#include "world/iteration.h"
#include "world/rotation_step.h"

namespace dttmm::host {

JointClosure::JointClosure(const std::vector<Body>& bodies, const std::vector<Joint>& joints)
    : system_(bodies, joints),
      no_stops_(joints.size()),
      matrix_(as_int(bodies.size()), {}, system_.nodes()),
      factor_(matrix_) {
    for (const Body& body : bodies) {
        inertias_.emplace_back(body);
        const int index = as_int(reaches_.size());
        reaches_.push_back(std::max(inertias_.back().gyration_bound(), system_.longest_arm(index)));
    }
    for (const Joint& joint : joints) names_.push_back(joint.name);
    right_hand_side_.setZero(matrix_.size());
    solution_.setZero(matrix_.size());
}

void JointClosure::factor(const std::vector<BodyState>& now) {
    matrix_.set_zero();
    for (size_t b = 0; b < now.size(); ++b) matrix_.add(as_int(b), as_int(b), inertias_[b].block(now[b].rotation));
    system_.write_to(matrix_);
    if (!factor_.factor(matrix_)) fail();
}

void JointClosure::close(const std::vector<BodyState>& now, double h, const LetGo& let_go,
                         const std::vector<BodyState>& predicted, std::vector<BodyState>& after) {
    system_.linearise(now, now, no_stops_, let_go);
    factor(now);
    double before = std::numeric_limits<double>::infinity();  // the correction of the last pass
    for (int pass = 0;; ++pass) {
        if (pass == kMostPassesOfStep) fail();
        right_hand_side_.setZero();
        system_.write_speeds(matrix_, after, predicted, right_hand_side_);
        const double correction = correct(after);
        double scale = 0;
        for (size_t b = 0; b < now.size(); ++b)
            scale = std::max({scale, after[b].velocity.norm() + reaches_[b] * after[b].angular_velocity.norm(),
                              (now[b].position.norm() + reaches_[b]) / h});
        // Near rounding no pass gains any more
        const bool stalls = correction > kSlowOnJoints * before;
        if (correction <= kRounding * scale || (stalls && correction <= kNearRounding * kRounding * scale)) break;
        if (stalls) {
            system_.tighten();
            factor(now);
        }
        before = correction;
    }
    for (size_t b = 0; b < now.size(); ++b) {
        after[b].position = now[b].position + h * after[b].velocity;
        after[b].rotation = RotationStep(h * after[b].angular_velocity).apply(now[b].rotation);
    }
}

/// Changes the velocities along M⁻¹ Jᵀ so that J times the change is what the right-hand side asks for, but for E; the
/// largest change of a speed.
double JointClosure::correct(std::vector<BodyState>& after) {
    factor_.solve(right_hand_side_, solution_);
    double largest = 0;
    for (size_t b = 0; b < after.size(); ++b) {
        const auto change = solution_.segment<6>(matrix_.index(as_int(b)));
        after[b].velocity += change.head<3>();
        after[b].angular_velocity += change.tail<3>();
        largest = std::max(largest, change.head<3>().norm() + reaches_[b] * change.tail<3>().norm());
    }
    if (!std::isfinite(largest)) fail();
    return largest;
}

void JointClosure::fail() const {
    Eigen::Index worst = 0;
    int joint = 0;
    right_hand_side_.cwiseAbs().maxCoeff(&worst);
    for (size_t j = 0; j < names_.size(); ++j)
        if (const int start = matrix_.joint_index(as_int(j)); worst >= start && worst < start + system_.joints()[j].count())
            joint = as_int(j);
    throw Error(ExitCode::numerical_failure,
                fmt::format("joint \"{}\" does not close within a step; try a smaller step", names_[as_size(joint)]));
}

}  // namespace dttmm::host
