// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/end_of_step.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "coupling/rotation_step.h"
#include "model/error.h"

namespace dttmm {

namespace {

/// A kept rate of convergence is trusted half as much with every step that did not measure it anew.
constexpr double kForget = 2;

/// Slower than this, the matrix is formed anew.
constexpr double kSlowestContraction = 0.1;

/// Positions are known to a few units in the last place of their size.
constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();

/// Numbers the groups of bodies that elements connect: group of every body, from 0.
std::vector<size_t> find_groups(size_t count, const std::vector<std::pair<int, int>>& neighbours) {
    std::vector<size_t> group(count);
    std::iota(group.begin(), group.end(), size_t{0});
    const auto root = [&](size_t b) {
        while (group[b] != b) b = group[b] = group[group[b]];
        return b;
    };
    for (const auto& [i, j] : neighbours) group[root(static_cast<size_t>(i))] = root(static_cast<size_t>(j));
    std::map<size_t, size_t> numbers;
    std::vector<size_t> numbered;
    for (size_t b = 0; b < count; ++b) numbered.push_back(numbers.try_emplace(root(b), numbers.size()).first->second);
    return numbered;
}

/// Whether an element holds each body: its forces then carry the rounding of the body's position.
std::vector<bool> find_held(const Model& model) {
    std::vector<bool> held(model.bodies.size());
    for (const Element& element : model.elements)
        for (const Attachment& end : {element.from, element.to})
            if (end.body >= 0) held[static_cast<size_t>(end.body)] = true;
    return held;
}

/// Distance from the centre of mass to the farthest marker, at least the largest radius of gyration.
double reach_of(const Body& body) {
    double reach = std::sqrt(body.inertia.trace() / (2 * body.mass));
    for (const Marker& marker : body.markers) reach = std::max(reach, (marker.position - body.center_of_mass).norm());
    return reach;
}

}  // namespace

EndOfStep::EndOfStep(const Model& model, const Networks& networks)
    : matrix_(static_cast<int>(model.bodies.size()), networks.neighbours()) {
    const size_t n = model.bodies.size();
    const std::vector<bool> held = find_held(model);
    const std::vector<size_t> group = find_groups(n, networks.neighbours());
    for (size_t b = 0; b < n; ++b) {
        const Body& body = model.bodies[b];
        inertias_.push_back({body.name, body.mass, body.inertia, reach_of(body), held[b], group[b]});
    }
    groups_.resize(n == 0 ? 0 : 1 + *std::max_element(group.begin(), group.end()));
    for (auto* list : {&u_, &previous_u_, &correction_, &free_momentum_, &feedback_}) list->assign(n, Vector6::Zero());
    wrenches_.resize(6 * n);
    right_hand_side_.resize(static_cast<Eigen::Index>(6 * n));
    solution_.resize(static_cast<Eigen::Index>(6 * n));
    solver_.analyzePattern(matrix_.upper());
}

std::vector<BodyState> EndOfStep::start(const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks,
                                        Loads& loads) {
    h_ = step.size;
    time_ = step.time;
    trial_ = at;
    stiffness_wanted_ = true;
    std::fill(groups_.begin(), groups_.end(), Group{});

    // a = M⁻¹ f,  α = I⁻¹ (m − ω × I ω) at t0
    loads.start(step.time);
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    networks.linearise(at, wrenches_.data(), nullptr);
    loads.add_at_start(at, wrenches_.data());
    std::vector<double> accelerations(wrenches_.size());
    std::vector<BodyState> half_step_back = at;
    for (size_t b = 0; b < at.size(); ++b) {
        const Eigen::Map<const Eigen::Vector3d> force(&wrenches_[6 * b]), moment(&wrenches_[6 * b + 3]);
        const Eigen::Matrix3d I = at[b].rotation * inertias_[b].J * at[b].rotation.transpose();
        const Eigen::Vector3d& w = at[b].angular_velocity;
        Eigen::Map<Eigen::Vector3d> a(&accelerations[6 * b]), alpha(&accelerations[6 * b + 3]);
        a = force / inertias_[b].mass;
        alpha = I.inverse() * (moment - w.cross(I * w));
        half_step_back[b].velocity -= 0.5 * h_ * a;
        half_step_back[b].angular_velocity -= 0.5 * h_ * alpha;
        previous_u_[b].head<3>() = half_step_back[b].velocity - h_ * a;
        previous_u_[b].tail<3>() = half_step_back[b].angular_velocity - h_ * alpha;
    }
    networks.start(step, at, accelerations.data());
    return half_step_back;
}

/// Angular momentum half way through a step that starts at R with the angular velocity w:
///     L = R_{½} J R_{½}ᵀ w = exp(h w~/2) R J Rᵀ w,   for the exponential leaves w alone
Eigen::Vector3d EndOfStep::momentum_over_step(size_t body, const Eigen::Matrix3d& R, const Eigen::Vector3d& w) const {
    const Eigen::Vector3d L = R * (inertias_[body].J * (R.transpose() * w));
    return RotationStep(0.5 * h_ * w).apply(L);
}

void EndOfStep::predict(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        Vector6 before;
        before << now[b].velocity, now[b].angular_velocity;
        u_[b] = 2 * before - previous_u_[b];
        previous_u_[b] = before;
    }
}

void EndOfStep::place_trial(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        trial_[b].velocity = u_[b].head<3>();
        trial_[b].angular_velocity = u_[b].tail<3>();
        trial_[b].position = now[b].position + h_ * trial_[b].velocity;
        trial_[b].rotation = RotationStep(h_ * trial_[b].angular_velocity).apply(now[b].rotation);
    }
}

void EndOfStep::evaluate(const std::vector<BodyState>& now, Networks& networks) {
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    ++passes_;
    if (!stiffness_wanted_) {
        networks.evaluate(trial_, wrenches_.data());
        return;
    }
    matrix_.set_zero();
    networks.evaluate(trial_, wrenches_.data(), [this](int row, int column, const BlockMatrix::Block& S) {
        // Symmetric part: away from rest S is not quite symmetric
        matrix_.add(row, column, 0.5 * h_ * h_ * S);
        matrix_.add(column, row, 0.5 * h_ * h_ * S.transpose());
    });
    factor(now);
}

/// Adds the inertia to the stiffness in the matrix, and factors.
void EndOfStep::factor(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        BlockMatrix::Block M = BlockMatrix::Block::Zero();
        M.diagonal().head<3>().setConstant(inertias_[b].mass);
        M.bottomRightCorner<3, 3>() = now[b].rotation * inertias_[b].J * now[b].rotation.transpose();
        matrix_.add(static_cast<int>(b), static_cast<int>(b), M);
    }
    solver_.factorize(matrix_.upper());
    ++factorisations_;
    stiffness_wanted_ = false;
    if (solver_.info() != Eigen::Success)
        throw Error(ExitCode::numerical_failure,
                    fmt::format("t = {:.9g} s: the matrix of the end of the step, M + h² S, is singular", time_));
}

/// One correction δ = K⁻¹ (P− + h f − P(u)), applied to u.
void EndOfStep::correct(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        Vector6 r = free_momentum_[b] + h_ * Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        r.head<3>() -= inertias_[b].mass * u_[b].head<3>();
        r.tail<3>() -= momentum_over_step(b, now[b].rotation, u_[b].tail<3>());
        right_hand_side_.segment<6>(matrix_.index(static_cast<int>(b))) = r;
    }
    solution_ = solver_.solve(right_hand_side_);
    for (size_t b = 0; b < now.size(); ++b) {
        correction_[b] = solution_.segment<6>(matrix_.index(static_cast<int>(b)));
        u_[b] += correction_[b];
    }
}

/// Opens the books of a step: what rounding feigns, and how far the rates of convergence of old are trusted.
void EndOfStep::open_groups(const std::vector<BodyState>& now) {
    for (Group& group : groups_) {
        group.contraction = std::min(1.0, kForget * group.contraction);
        group.floor_squared = 0;
    }
    const double rounding = kRounding / h_;
    for (size_t b = 0; b < now.size(); ++b) {
        if (!inertias_[b].held) continue;
        Group& group = groups_[inertias_[b].group];
        const double size_squared = now[b].position.squaredNorm() + inertias_[b].reach * inertias_[b].reach;
        group.floor_squared = std::max(group.floor_squared, rounding * rounding * size_squared);
    }
}

/// Takes a pass into the books; true if every group may stop.
bool EndOfStep::judge(int pass) {
    for (Group& group : groups_) {
        group.previous_squared = group.correction_squared;
        group.correction_squared = 0;
        group.scale_squared *= 0.98;
    }
    for (size_t b = 0; b < u_.size(); ++b) {
        // Square of the largest speed of a point of the body, at most
        const double reach_squared = inertias_[b].reach * inertias_[b].reach;
        const auto speed_squared = [&](const Vector6& u) {
            return 2 * (u.head<3>().squaredNorm() + reach_squared * u.tail<3>().squaredNorm());
        };
        Group& group = groups_[inertias_[b].group];
        group.scale_squared = std::max(group.scale_squared, speed_squared(u_[b]));
        const double correction = speed_squared(correction_[b]);
        if (!std::isfinite(correction)) fail(pass);
        group.correction_squared = std::max(group.correction_squared, correction);
    }
    bool done = true;
    for (Group& group : groups_) {
        if (pass == 1 ||
            (pass > 1 && group.correction_squared > group.floor_squared)) {  // a later one at rounding measures nothing
            const double rate =
                group.previous_squared > 0 ? std::sqrt(group.correction_squared / group.previous_squared) : 0;
            group.contraction = rate < 1 ? rate / (1 - rate) : 1e3;
            if (rate > kSlowestContraction && group.correction_squared > group.floor_squared) stiffness_wanted_ = true;
        }
        const double remaining_squared = group.contraction * group.contraction * group.correction_squared;
        done = done && (group.correction_squared <= group.floor_squared ||
                        remaining_squared <= std::max(kTolerance * kTolerance * group.scale_squared, group.floor_squared));
    }
    return done;
}

const Feedback& EndOfStep::solve(const dttmm_step& step, const std::vector<BodyState>& now, Networks& networks,
                                 const Loads& loads) {
    time_ = step.time;
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    loads.add_over_step(now, wrenches_.data());
    for (size_t b = 0; b < now.size(); ++b) {
        // R of the step before: L = exp(−h w~/2) R J Rᵀ w with R at its end
        const Eigen::Vector3d& w = now[b].angular_velocity;
        const Eigen::Vector3d L = now[b].rotation * (inertias_[b].J * (now[b].rotation.transpose() * w));
        free_momentum_[b] = h_ * Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        free_momentum_[b].head<3>() += inertias_[b].mass * now[b].velocity;
        free_momentum_[b].tail<3>() += RotationStep(-0.5 * h_ * w).apply(L);
    }

    predict(now);
    open_groups(now);
    for (int pass = 0; pass < kMostPasses; ++pass) {
        if (pass == 0 || networks.is_implicit() || stiffness_wanted_) {
            if (networks.is_implicit()) place_trial(now);
            evaluate(now, networks);
        }
        correct(now);
        if (judge(pass)) {
            form_feedback(now);
            return feedback_;
        }
    }
    fail(kMostPasses);
}

void EndOfStep::form_feedback(const std::vector<BodyState>& now) {
    const double per_step = 1 / h_;
    for (size_t b = 0; b < now.size(); ++b) {
        const Eigen::Matrix3d& R = now[b].rotation;
        const Eigen::Vector3d angular_acceleration = per_step * (u_[b].tail<3>() - now[b].angular_velocity);
        feedback_[b].head<3>() = inertias_[b].mass * per_step * (u_[b].head<3>() - now[b].velocity);
        feedback_[b].tail<3>() = R * (inertias_[b].J * (R.transpose() * angular_acceleration));
    }
}

void EndOfStep::fail(int passes) const {
    size_t worst = 0;
    for (size_t b = 1; b < correction_.size(); ++b)
        if (!(correction_[b].squaredNorm() <= correction_[worst].squaredNorm())) worst = b;
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "t = {:.9g} s: the end of the step was not found in {} passes (last correction {:.1e} m/s), worst at body "
            "\"{}\"; try a smaller step",
            time_, passes, correction_[worst].norm(), inertias_[worst].name));
}

}  // namespace dttmm
