// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_closure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/error.h"
#include "model/index.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// Of the speeds at a stop: less is no parting.
constexpr double kParting = 1e-9;

/// What stays open at rounding of the motion, over that rounding: more is a contradiction between joints and stops.
constexpr double kOpen = 1e4;

/// A pass that leaves more of the correction before is slow.
constexpr double kSlow = 0.3;

}  // namespace

JointClosure::JointClosure(const std::vector<Body>& bodies, const std::vector<Joint>& joints)
    : system_(bodies, joints), matrix_(as_int(bodies.size()), {}, system_.nodes()), factor_(matrix_) {
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

/// A stop has acted unless ODE lets the joint part from it; true if one has parted.
bool JointClosure::judge(std::vector<Stop>& stops, double h, const std::vector<BodyState>& after) const {
    bool parted = false;
    for (size_t j = 0; j < stops.size(); ++j) {
        if (!stops[j].acts) continue;
        const double speed = system_.coordinate_speed(j, after);
        const double parting = stops[j].side * (speed - stops[j].speed) - Stop::kPlay / h;  // ODE's stop has no play
        stops[j].acts = parting <= kParting * (std::abs(speed) + std::abs(stops[j].speed) + Stop::kPlay / h);
        parted = parted || !stops[j].acts;
    }
    return parted;
}

void JointClosure::close(const std::vector<BodyState>& now, double h, std::vector<Stop>& stops,
                         std::vector<BodyState>& after) {
    system_.linearise(now, stops);
    if (judge(stops, h, after)) system_.linearise(now, stops);
    engine_ = after;
    if (find_closed(now, h, after)) return;
    // A stop at a dead centre can hold the joints open: it lets go
    bool released = false;
    for (Stop& stop : stops) {
        released = released || stop.acts;
        stop.acts = false;
    }
    if (!released) fail();
    after = engine_;
    system_.linearise(now, stops);
    if (!find_closed(now, h, after)) fail();
}

/// Whether the joints and the stops that act can be closed together.
bool JointClosure::find_closed(const std::vector<BodyState>& now, double h, std::vector<BodyState>& after) {
    factor(now);
    double before = std::numeric_limits<double>::infinity();  // the correction of the last pass
    for (int pass = 0; pass < kMostPasses; ++pass) {
        for (size_t b = 0; b < now.size(); ++b) {
            after[b].position = now[b].position + h * after[b].velocity;
            after[b].rotation = RotationStep(h * after[b].angular_velocity).apply(now[b].rotation);
        }
        right_hand_side_.setZero();
        system_.write_openings(matrix_, after, h, right_hand_side_);
        factor_.solve(right_hand_side_, solution_);
        double correction = 0, scale = 0;
        for (size_t b = 0; b < now.size(); ++b) {
            const auto change = solution_.segment<6>(matrix_.index(as_int(b)));
            after[b].velocity += change.head<3>();
            after[b].angular_velocity += change.tail<3>();
            const double reach = reaches_[b];
            correction = std::max(correction, change.head<3>().norm() + reach * change.tail<3>().norm());
            scale = std::max({scale, after[b].velocity.norm() + reach * after[b].angular_velocity.norm(),
                              (now[b].position.norm() + reach) / h});
        }
        if (!std::isfinite(correction)) fail();
        // Near rounding no pass gains any more
        const bool stalls = correction > kSlow * before;
        if (correction <= kRounding * scale || (stalls && correction <= 10 * kRounding * scale))
            return right_hand_side_.cwiseAbs().maxCoeff() <= kOpen * kRounding * scale;
        if (stalls) {
            system_.tighten();
            factor(now);
        }
        before = correction;
    }
    return false;
}

void JointClosure::fail() const {
    Eigen::Index worst = 0;
    int joint = 0;
    right_hand_side_.cwiseAbs().maxCoeff(&worst);
    for (size_t j = 0; j < names_.size(); ++j)
        if (const int start = matrix_.joint_index(as_int(j)); worst >= start && worst < start + system_.joints()[j].count())
            joint = as_int(j);
    throw Error(ExitCode::numerical_failure,
                fmt::format("joint \"{}\" does not close within a step; {}", names_[as_size(joint)],
                            system_.is_near_singular() ? kSingularCure : "try a smaller step"));
}

}  // namespace dttmm::host
