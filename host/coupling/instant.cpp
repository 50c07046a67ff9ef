// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/instant.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "model/diagnostics.h"
#include "model/error.h"
#include "model/index.h"
#include "world/iteration.h"

namespace dttmm::host {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

bool turns_or_drives(const Joint& joint) {
    return (joint.type != JointType::slider && joint.type != JointType::fixed) || joint.drive;
}

/// Of every body, whether its velocities are means in all rows: joints tie it to one that turns or has a motor, or the
/// scheme damps.
std::vector<bool> have_means(const Model& model) {
    std::vector<bool> means(model.bodies.size(), model.simulation.spectral_radius < 1);
    const auto has = [&](int body) { return body >= 0 && means[as_size(body)]; };
    for (bool is_new = true; is_new;) {
        is_new = false;
        for (const Joint& joint : model.joints) {
            if (!turns_or_drives(joint) && !has(joint.first) && !has(joint.second)) continue;
            for (const int body : {joint.first, joint.second})
                if (body >= 0 && !has(body)) is_new = means[as_size(body)] = true;
        }
    }
    return means;
}

/// Refuses velocities at the start that open a joint, by more than rounding of places over a step of size h.
void refuse_opening_joints(const std::vector<Joint>& descriptions, const JointSystem& joints,
                           const std::vector<BodyState>& at, double h) {
    constexpr double kTolerated = 1e-9;
    double scale = 0;
    for (const BodyState& body : at) scale = std::max({scale, body.velocity.norm(), body.angular_velocity.norm()});
    for (size_t j = 0; j < joints.joints().size(); ++j) {
        double tolerated = kTolerated * scale;
        for (const int body : joints.joints()[j].bodies())
            if (body >= 0) tolerated += kRounding * at[as_size(body)].position.norm() / h;
        if (descriptions[j].drive) tolerated += Drives::rate_error(joints.drives()[j], h);
        if (const double speed = joints.opening_speed(j, at); speed > tolerated)
            throw ModelError(fmt::format(
                "{}: joint \"{}\": the velocities of its bodies at the start would open it at {:.3g} m/s (or rad/s); "
                "give both bodies velocities that the joint allows{}",
                descriptions[j].place, descriptions[j].name, speed,
                descriptions[j].drive ? ", or let its motor begin at rest" : ""));
    }
}

/// The stops that act from the start on: reached, and not being left.
std::vector<Stop> stops_at_start(const JointSystem& joints, const std::vector<BodyState>& at, double h) {
    std::vector<Stop> stops(joints.joints().size());
    joints.find_stops(at, stops, stops);
    for (size_t j = 0; j < stops.size(); ++j)
        if (stops[j].acts && stops[j].side * h * joints.joints()[j].coordinate_speed(at, at) > Stop::kPlay)
            stops[j].let_go();
    return stops;
}

}  // namespace

bool has_mean_velocities(const Model& model) {
    return model.simulation.spectral_radius < 1 || std::ranges::any_of(have_means(model), std::identity()) ||
           std::ranges::any_of(model.joints, [](const Joint& joint) { return joint.limits.has_value(); });
}

InstantSolver::InstantSolver(const Model& model)
    : inertias_(model.bodies.begin(), model.bodies.end()),
      have_means_(have_means(model)),
      wrenches_(6 * model.bodies.size()),
      trial_wrenches_(wrenches_),
      matrix_(model.joints.empty() ? 0 : as_int(model.bodies.size()), {}, JointSystem(model.bodies, model.joints).nodes()),
      factor_(matrix_) {
    for (const Body& body : model.bodies) inverse_moments_.push_back(body.inertia.inverse());
    for (Eigen::VectorXd* list : {&right_hand_side_, &proximal_, &solution_, &impulses_}) list->setZero(matrix_.size());
    instant_.at.resize(model.bodies.size());
    for (BodyVectors* list : {&instant_.accelerations, &trial_, &residual_, &direction_}) list->resize(model.bodies.size());
    instant_.joint_wrenches.resize(model.joints.size());
}

const Instant& InstantSolver::start(const Model& model, const dttmm_step& step, const std::vector<BodyState>& at,
                                    Networks& networks, Loads& loads) {
    h_ = step.size;
    start_time_ = step.time;
    start_ = instant_.at = at;
    loads.start(step.time, step.size);
    std::ranges::fill(wrenches_, 0.0);
    networks.linearise(at, wrenches_.data(), nullptr);
    loads.add_at_start(at, wrenches_.data());
    JointSystem joints(model.bodies, model.joints);
    joints.drive(Drives(model).around(step));
    refuse_opening_joints(model.joints, joints, at, step.size);
    std::vector<Stop> stops = stops_at_start(joints, at, step.size);
    do {
        joints.linearise(at, at, stops);
        factor(joints, step.time);
        find_accelerations(joints);
    } while (joints.has_stops() && joints.release_pulling_stops(matrix_, solution_, stops));
    networks.start(step, at, at.empty() ? nullptr : instant_.accelerations.front().data(), loads.on_networks().data());
    return instant_;
}

const Instant& InstantSolver::start_at_rest(const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks,
                                            const Loads& loads) {
    h_ = step.size;
    start_time_ = step.time;
    start_ = instant_.at = at;
    for (Vector6& acceleration : instant_.accelerations) acceleration.setZero();
    networks.start_at_rest(step, at, loads.on_networks().data());
    return instant_;
}

const Instant& InstantSolver::solve(double time, const StepEquations& step, const std::vector<BodyState>& now,
                                    const std::vector<BodyState>& after, Networks& networks, const Loads& loads) {
    const bool is_impact = step.has_impact();
    find_means(now, after);
    if (is_impact || !networks.stand()) find_joint_wrenches(step.joint_system(), step.matrix(), step.impulses());
    if (!networks.stand()) return instant_;
    factor(step.joint_system(), time);
    std::ranges::fill(wrenches_, 0.0);
    if (networks.is_implicit()) networks.add_mean_wrenches(wrenches_.data());
    if (time == start_time_) {
        instant_.at = start_;  // the initial conditions
    } else if (networks.is_implicit() && !is_impact && std::ranges::any_of(have_means_, std::logical_not())) {
        loads.add_mean(now, wrenches_.data());
        find_velocities(after, step.joint_system());
    }
    const bool is_start = time == start_time_ && !is_impact && !instant_.accelerations.empty();
    if (is_start) {
        settle_accelerations(step.joint_system(), now, networks, loads);
        return instant_;
    }
    std::ranges::fill(wrenches_, 0.0);
    networks.stand_at(instant_.at, nullptr, wrenches_.data());
    if (is_impact) return instant_;
    loads.add_at_start(now, wrenches_.data());
    find_accelerations(step.joint_system());
    return instant_;
}

/// M and the joints as last linearised. Without joints there is nothing to factor.
void InstantSolver::factor(const JointSystem& joints, double time) {
    if (joints.empty()) return;
    matrix_.set_zero();
    for (size_t b = 0; b < inertias_.size(); ++b)
        matrix_.add(as_int(b), as_int(b), inertias_[b].block(instant_.at[b].rotation));
    joints.write_start_to(matrix_);
    if (!factor_.factor(matrix_))
        throw Error(
            ExitCode::numerical_failure,
            fmt::format("t = {:.9g} s: the equations of the joints at this instant are singular. Start beside a singular "
                        "position, or give the lightest body on joints more mass",
                        time));
}

/// Solves with the proximal E of redundant joints taken out again: until what is left of their equations no longer falls.
void InstantSolver::solve_balance(const JointSystem& joints) {
    solution_.setZero();
    double left = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < kMostPassesOfStep; ++pass) {
        proximal_ = right_hand_side_;
        for (size_t j = 0; j < joints.joints().size(); ++j) {
            const auto q = Eigen::seqN(matrix_.joint_index(as_int(j)), joints.joints()[j].count());
            proximal_(q) += matrix_.upper().diagonal()(q).cwiseProduct(solution_(q));
        }
        factor_.solve(proximal_, solution_);
        // J u − g = E (q − q before)
        double open = 0;
        for (size_t j = 0; j < joints.joints().size(); ++j)
            for (int i = matrix_.joint_index(as_int(j)), end = i + joints.joints()[j].count(); i < end; ++i)
                open = std::max(
                    open, std::abs(matrix_.upper().diagonal()(i) * solution_(i) - (proximal_(i) - right_hand_side_(i))));
        if (!(open < left)) return;
        left = open;
    }
}

/// The means over the two steps.
void InstantSolver::find_means(const std::vector<BodyState>& now, const std::vector<BodyState>& after) {
    for (size_t b = 0; b < now.size(); ++b) {
        BodyState& at = instant_.at[b] = now[b];
        at.velocity = 0.5 * (now[b].velocity + after[b].velocity);
        at.angular_velocity = 0.5 * (now[b].angular_velocity + after[b].angular_velocity);
        instant_.accelerations[b] << (after[b].velocity - now[b].velocity) / h_,
            (after[b].angular_velocity - now[b].angular_velocity) / h_;
    }
}

/// Velocities out of those over the step that begins there, under the mean wrenches_ over it.
void InstantSolver::find_velocities(const std::vector<BodyState>& after, const JointSystem& joints) {
    right_hand_side_.setZero();
    for (size_t b = 0; b < after.size(); ++b) {
        BodyState& at = instant_.at[b];
        const Eigen::Map<const Vector6> mean(&wrenches_[6 * b]);
        const double mass = inertias_[b].mass;
        const Eigen::Vector3d velocity = after[b].velocity - 0.5 * h_ / mass * mean.head<3>();
        const Eigen::Vector3d L =
            inertias_[b].momentum_over_step(at.rotation, after[b].angular_velocity, h_) - 0.5 * h_ * mean.tail<3>();
        if (joints.empty()) {
            at.velocity = velocity;
            at.angular_velocity = at.rotation * (inverse_moments_[b] * (at.rotation.transpose() * L));
        } else {
            right_hand_side_.segment<6>(matrix_.index(as_int(b))) << mass * velocity, L;
        }
    }
    if (joints.empty()) return;
    solve_balance(joints);
    for (size_t b = 0; b < after.size(); ++b) {
        if (have_means_[b]) continue;
        const auto u = solution_.segment<6>(matrix_.index(as_int(b)));
        instant_.at[b].velocity = u.head<3>();
        instant_.at[b].angular_velocity = u.tail<3>();
    }
}

/// Accelerations and joint forces under wrenches_:  M a + Jᵀ q = f,  I α + … = m − ω × I ω,  J a = −C̈ at constant
/// velocities.
void InstantSolver::find_accelerations(const JointSystem& joints) {
    for (size_t b = 0; b < inertias_.size(); ++b) {
        const Eigen::Vector3d& w = instant_.at[b].angular_velocity;
        const Eigen::Matrix3d& R = instant_.at[b].rotation;
        Vector6 f = Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        f.tail<3>() -= w.cross(inertias_[b].turned(R, w));
        if (joints.empty())
            instant_.accelerations[b] << f.head<3>() / inertias_[b].mass,
                R * (inverse_moments_[b] * (R.transpose() * f.tail<3>()));
        else
            right_hand_side_.segment<6>(matrix_.index(as_int(b))) = f;
    }
    if (joints.empty()) return;
    joints.write_curvatures(matrix_, instant_.at, right_hand_side_);
    solve_balance(joints);
    for (size_t b = 0; b < inertias_.size(); ++b) instant_.accelerations[b] = solution_.segment<6>(matrix_.index(as_int(b)));
    impulses_ = h_ * solution_;
    find_joint_wrenches(joints, matrix_, impulses_);
}

/// At the start networks are asked with the accelerations of the bodies. Where they join masses rigidly to bodies their
/// wrench is W(a) = W(0) − N a, N symmetric and not negative: the inertia of these masses. Conjugate gradients solve
/// (M + N) a + Jᵀ q = f + W(0), preconditioned by M and the joints. Where N is zero they end with the second wrench. At rest
/// the accelerations are rounding errors. The tolerance is then relative to the forces in balance.
void InstantSolver::settle_accelerations(const JointSystem& joints, const std::vector<BodyState>& now, Networks& networks,
                                         const Loads& loads) {
    // Of the accelerations, or of what loads and networks alone would make. 1e-16 to 1e-9 pass the tests of first rows, 1e-7
    // fails one.
    constexpr double kEnough = 1e-13;
    constexpr double kRoundOff = 1e-6;  // below this a correction that does not shrink is round-off of the wrench
    constexpr int kMostSteps = 50;      // without rounding there are 6 per body on such masses at most
    const auto ask_networks = [&] {
        std::ranges::fill(wrenches_, 0.0);
        networks.stand_at(instant_.at, trial_.front().data(), wrenches_.data());
    };
    const auto ask = [&] {
        ask_networks();
        loads.add_at_start(now, wrenches_.data());
    };
    const auto go = [&](double share) {
        for (size_t b = 0; b < trial_.size(); ++b) trial_[b] += share * direction_[b];
    };
    trial_ = instant_.accelerations;
    std::ranges::fill(wrenches_, 0.0);
    loads.add_at_start(now, wrenches_.data());
    double reference = norm_of_wrenches();
    ask_networks();
    reference += norm_of_wrenches();
    loads.add_at_start(now, wrenches_.data());
    find_accelerations(joints);
    trial_ = instant_.accelerations;  // from here on all keep the joints closed
    for (Vector6& direction : direction_) direction.setZero();
    double before = 0;
    for (int iteration = 0;; ++iteration) {
        ask();
        trial_wrenches_ = wrenches_;
        find_accelerations(joints);
        for (size_t b = 0; b < trial_.size(); ++b) residual_[b] = instant_.accelerations[b] - trial_[b];
        const double size = norm(residual_), all = std::max(norm(trial_), reference);
        const bool shrinks = iteration == 0 || size < before;
        if (!(size > kEnough * kEnough * all) || (!shrinks && size < kRoundOff * kRoundOff * all)) return;
        if (iteration == kMostSteps) return;
        const double share = iteration > 0 ? size / before : 0;
        for (size_t b = 0; b < trial_.size(); ++b) direction_[b] = residual_[b] + share * direction_[b];
        go(1);
        ask();
        double curvature = norm(direction_);  // pᵀ (M + N) p
        for (size_t b = 0; b < trial_.size(); ++b)
            curvature += direction_[b].dot(Eigen::Map<const Vector6>(&trial_wrenches_[6 * b]) -
                                           Eigen::Map<const Vector6>(&wrenches_[6 * b]));
        go(size / std::max(curvature, norm(direction_)) - 1);  // N is not negative but for round-off
        before = size;
    }
}

/// aᵀ M a
double InstantSolver::norm(const BodyVectors& a) const {
    double sum = 0;
    for (size_t b = 0; b < a.size(); ++b) {
        const Eigen::Vector3d linear = a[b].head<3>(), angular = a[b].tail<3>();
        sum += inertias_[b].mass * linear.squaredNorm() + angular.dot(inertias_[b].turned(instant_.at[b].rotation, angular));
    }
    return sum;
}

/// fᵀ M⁻¹ f of wrenches_
double InstantSolver::norm_of_wrenches() const {
    double sum = 0;
    for (size_t b = 0; b < inertias_.size(); ++b) {
        const Eigen::Map<const Vector6> wrench(&wrenches_[6 * b]);
        const Eigen::Vector3d moment = instant_.at[b].rotation.transpose() * wrench.tail<3>();
        sum += wrench.head<3>().squaredNorm() / inertias_[b].mass + moment.dot(inverse_moments_[b] * moment);
    }
    return sum;
}

/// Joint wrenches by their impulses over a step, in the joints' rows of a matrix.
void InstantSolver::find_joint_wrenches(const JointSystem& joints, const BlockMatrix& matrix,
                                        const Eigen::VectorXd& impulses) {
    for (size_t j = 0; j < joints.joints().size(); ++j) {
        // What acts on the second body acts back on the first; both about the anchor
        const JointEquations& joint = joints.joints()[j];
        const auto side = joint.bodies()[JointEquations::kFirst] >= 0 ? JointEquations::kFirst : JointEquations::kSecond;
        const double* q = impulses.data() + matrix.joint_index(as_int(j));
        Vector6& wrench = instant_.joint_wrenches[j];
        wrench = (side == JointEquations::kFirst ? 1 : -1) / h_ * joints.impulse(j, side, q);
        const Eigen::Vector3d arm = instant_.at[as_size(joint.bodies()[side])].position - joint.anchor(instant_.at);
        wrench.tail<3>() += arm.cross(wrench.head<3>());
    }
}

}  // namespace dttmm::host
