// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/step_equations.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/index.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// A motion or an impulse, turned by Q.
template <class Rotation>
Eigen::Matrix<double, 6, 1> turned(const Rotation& Q, const Eigen::Matrix<double, 6, 1>& v) {
    Eigen::Matrix<double, 6, 1> to;
    to.head<3>().noalias() = Q * v.head<3>();
    to.tail<3>().noalias() = Q * v.tail<3>();
    return to;
}

/// Whether a stiffness is the same in all directions, but for what leaves rounding of an error after two passes.
bool is_even(const Eigen::Matrix3d& stiffness) {
    const double mean = stiffness.trace() / 3;
    return (stiffness - mean * Eigen::Matrix3d::Identity()).squaredNorm() <= kRounding * mean * mean;
}

/// s/(1 + s) with s = tr |M⁻¹ h² S|: no eigenvalue is larger.
double share_of_stiffness(const Inertia& inertia, const Eigen::Matrix3d& R, const BlockMatrix::Block& S) {
    const Eigen::Matrix3d inverse = R * inertia.inverse_J * R.transpose();
    const double s = S.diagonal().head<3>().cwiseAbs().sum() / inertia.mass +
                     inverse.cwiseProduct(S.bottomRightCorner<3, 3>()).cwiseAbs().sum();
    return std::isfinite(s) ? s / (1 + s) : 1;
}

}  // namespace

StepEquations::StepEquations(const Model& model, const Networks& networks)
    : inertias_(model.bodies.begin(), model.bodies.end()),
      joints_(model.bodies, model.joints),
      matrix_(as_int(model.bodies.size()), networks.neighbours(), joints_.nodes()),
      factor_(matrix_),
      struck_at_(model.joints.empty() ? 0 : model.bodies.size()),
      stiffness_shares_(model.bodies.size(), 1),
      turns_(model.bodies.size()) {
    const auto couple = [&](int first, int second) {
        if (first < 0 || second < 0) return;
        for (int body : {first, second}) turns_[as_size(body)].is_alone = false;
    };
    for (const auto& [first, second] : networks.neighbours()) couple(first, second);
    for (const Joint& joint : model.joints) couple(joint.first, joint.second);
    for (BodyVectors* list : {&free_momentum_, &u_, &correction_})
        list->assign(model.bodies.size(), Eigen::Matrix<double, 6, 1>::Zero());
    for (Eigen::VectorXd* list : {&impulses_, &right_hand_side_, &solution_}) list->setZero(matrix_.size());
}

void StepEquations::begin_step(const std::vector<BodyState>& now, const std::vector<double>& loads) {
    for (size_t b = 0; b < now.size(); ++b) {
        // R of the step before: L = exp(−h w~/2) R J Rᵀ w with R at its end
        const Eigen::Vector3d& w = now[b].angular_velocity;
        const Eigen::Vector3d L = inertias_[b].turned(now[b].rotation, w);
        free_momentum_[b] = h_ * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(&loads[6 * b]);
        free_momentum_[b].head<3>() += inertias_[b].mass * now[b].velocity;
        free_momentum_[b].tail<3>() += RotationStep(-0.5 * h_ * w).apply(L);
        if (turns_[b].is_followed) turns_[b].since.noalias() = now[b].rotation * turns_[b].then.transpose();
    }
}

/// Over the step of an impact the bodies go straight on, with the mean of their velocities. At the impact, after a share s
/// of it, they are off that way by s (1 - s) h times the jump of the velocities: there its impulses act along other
/// directions.
void StepEquations::follow_impact(const std::vector<BodyState>& now, const BodyVectors& before,
                                  const std::vector<Stop>& stops) {
    const auto stop = std::ranges::find_if(stops, &Stop::is_struck);
    if (std::ranges::count_if(stops, &Stop::is_struck) != 1) return;
    const double s = stop->share;
    if ((1 - s) * stop->arrival <= std::abs(stop->gain)) return;  // the jump is no larger than what forces do in a step
    struck_at_ = now;
    for (size_t b = 0; b < now.size(); ++b) {
        // (1 - s) of the jump is in the step of the impact
        const Eigen::Vector3d dv = now[b].velocity - before[b].head<3>(), dw = now[b].angular_velocity - before[b].tail<3>();
        struck_at_[b].position -= s * h_ * dv;
        struck_at_[b].rotation = RotationStep(-s * h_ * dw).apply(now[b].rotation);
    }
    for (size_t j = 0; j < joints_.joints().size(); ++j) {
        const JointEquations& joint = joints_.joints()[j];
        const JointEquations::Jacobian there = joint.jacobian(struck_at_), here = joint.jacobian(now);
        const auto q = impulses_.segment(matrix_.joint_index(as_int(j)), joint.count());
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0)
                free_momentum_[as_size(body)] -= (there[side] - here[side]).transpose() * q / (1 - s);
    }
}

void StepEquations::move(const std::vector<BodyState>& now, double t, std::vector<BodyState>& to) const {
    for (size_t b = 0; b < now.size(); ++b) {
        to[b].velocity = u_[b].head<3>();
        to[b].angular_velocity = u_[b].tail<3>();
        to[b].position = now[b].position + t * to[b].velocity;
        to[b].rotation = RotationStep(t * to[b].angular_velocity).apply(now[b].rotation);
    }
}

void StepEquations::add_stiffness(int row_body, int column_body, const BlockMatrix::Block& S) {
    // Symmetric part: away from rest S is not quite symmetric
    matrix_.add(row_body, column_body, 0.5 * h_ * h_ * S);
    matrix_.add(column_body, row_body, 0.5 * h_ * h_ * S.transpose());
}

bool StepEquations::factor_with_inertia(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        const BlockMatrix::Block S = matrix_.diagonal(as_int(b));
        const Eigen::Matrix3d& R = now[b].rotation;
        stiffness_shares_[b] = share_of_stiffness(inertias_[b], R, S);
        turns_[b].then = R;
        turns_[b].since.setIdentity();
        turns_[b].is_followed = turns_[b].is_alone && is_even(S.topLeftCorner<3, 3>());
        matrix_.add(as_int(b), as_int(b), inertias_[b].block(R));
    }
    joints_.write_to(matrix_);
    return factor_.factor(matrix_);
}

size_t StepEquations::least_held(const std::vector<BodyState>& now) const {
    size_t least = 0;
    double least_share = std::numeric_limits<double>::infinity();
    for (size_t b = 0; b < now.size(); ++b) {
        const Eigen::Matrix<double, 6, 1> held = matrix_.diagonal(as_int(b)).diagonal();
        const double share = held.cwiseQuotient(inertias_[b].block(now[b].rotation).diagonal()).minCoeff();
        if (share >= least_share) continue;
        least = b;
        least_share = share;
    }
    return least;
}

/// P− + h f − P(u)
StepEquations::Momentum StepEquations::residual_of(size_t body, const BodyState& now, const Momentum& u,
                                                   const std::vector<double>& wrenches) const {
    Momentum r = free_momentum_[body] + h_ * Eigen::Map<const Momentum>(&wrenches[6 * body]);
    r.head<3>() -= inertias_[body].mass * u.head<3>();
    r.tail<3>() -= inertias_[body].momentum_over_step(now.rotation, u.tail<3>(), h_);
    return r;
}

void StepEquations::correct(const std::vector<BodyState>& now, const std::vector<BodyState>& end,
                            const std::vector<double>& wrenches) {
    for (size_t b = 0; b < now.size(); ++b)
        right_hand_side_.segment<6>(matrix_.index(as_int(b))) =
            turned(turns_[b].since.transpose(), residual_of(b, now[b], u_[b], wrenches));
    if (!joints_.empty()) {
        joints_.add_impulses(matrix_, impulses_, right_hand_side_);
        joints_.write_openings(matrix_, end, h_, right_hand_side_);
    }
    lack_ = 0;
    for (size_t b = 0; b < now.size(); ++b)
        lack_ = std::max(lack_, right_hand_side_.segment<3>(matrix_.index(as_int(b))).squaredNorm());
    factor_.solve(right_hand_side_, solution_);
    if (!joints_.empty()) impulses_ += solution_;
    for (size_t b = 0; b < now.size(); ++b) {
        correction_[b] = turned(turns_[b].since, solution_.segment<6>(matrix_.index(as_int(b))));
        u_[b] += correction_[b];
    }
}

double StepEquations::residual(const std::vector<BodyState>& now, const BodyVectors& u,
                               const std::vector<double>& wrenches) {
    for (size_t b = 0; b < now.size(); ++b)
        right_hand_side_.segment<6>(matrix_.index(as_int(b))) = residual_of(b, now[b], u[b], wrenches);
    if (!joints_.empty()) joints_.add_impulses(matrix_, impulses_, right_hand_side_);
    double sum = 0;
    for (size_t b = 0; b < now.size(); ++b)
        sum += inertias_[b].energy_of(now[b].rotation, right_hand_side_.segment<6>(matrix_.index(as_int(b))));
    return sum;
}

void StepEquations::write_feedback(const std::vector<BodyState>& now, BodyVectors& feedback) {
    const double per_step = 1 / h_;
    for (size_t b = 0; b < now.size(); ++b) {
        const Eigen::Vector3d angular_acceleration = per_step * (u_[b].tail<3>() - now[b].angular_velocity);
        feedback[b].head<3>() = inertias_[b].mass * per_step * (u_[b].head<3>() - now[b].velocity);
        feedback[b].tail<3>() = inertias_[b].turned(now[b].rotation, angular_acceleration);
    }
    if (joints_.empty()) return;
    right_hand_side_.setZero();
    solution_ = impulses_;
    for (size_t j = 0; j < joints_.stops().size(); ++j)
        if (joints_.stops()[j].acts) solution_(stop_index(j)) = 0;
    joints_.add_impulses(matrix_, solution_, right_hand_side_);
    for (size_t b = 0; b < now.size(); ++b) feedback[b] -= per_step * right_hand_side_.segment<6>(matrix_.index(as_int(b)));
}

int StepEquations::stop_index(size_t joint) const {
    return matrix_.joint_index(as_int(joint)) + joints_.joints()[joint].coordinate_row();
}

void StepEquations::place_before_start(const std::vector<BodyState>& at, std::vector<Stop>& stops) const {
    for (size_t j = 0; j < stops.size(); ++j)
        if (const JointEquations& joint = joints_.joints()[j]; joint.has_stops())
            stops[j].start = joint.coordinate(at) - h_ * joint.coordinate_speed(at, at);
}

namespace {

/// Whether no stop but that of a joint begins or ends to act over this step or did so over the one before: speeds of
/// coordinates then change by forces only.
bool only_forces_act(const std::vector<Stop>& before, const std::vector<Stop>& stops, size_t but) {
    for (size_t j = 0; j < stops.size(); ++j)
        if (j != but && (before[j].acts != stops[j].acts || before[j].is_foreseen || stops[j].is_foreseen)) return false;
    return true;
}

/// Share of a step after which a coordinate has gone `there`; `way` over the whole step, of at least that, and `gain` more
/// than over the step before.
double share_of(double there, double way, double gain) {
    // there = s way - s (1 - s) gain/2
    const double half = 0.5 * gain, slope = way - half;
    return 2 * there / (slope + std::copysign(std::sqrt(std::max(slope * slope + 4 * half * there, 0.0)), way));
}

}  // namespace

bool StepEquations::add_first_stop(const std::vector<BodyState>& end, const std::vector<Stop>& reached,
                                   const std::vector<Stop>& before, std::vector<Stop>& stops) const {
    double first = std::numeric_limits<double>::infinity();  // share of the step after which a stop is reached
    size_t which = stops.size();
    Stop added;
    for (size_t j = 0; j < stops.size(); ++j) {
        const JointEquations& joint = joints_.joints()[j];
        if (!joint.has_stops() || stops[j].acts) continue;
        const double start = stops[j].start, way = joint.way(start, joint.coordinate(end));
        for (int side : {1, -1}) {
            const double stop = joint.stop(side);
            if (side * (start + way - stop) >= -2 * Stop::kPlay) continue;  // one that acts is passed by kPlay
            if (reached[j].acts && reached[j].side == side) {
                stops[j] = reached[j];
                return true;
            }
            if (side * (start - stop) <= Stop::kPlay) continue;  // at a dead centre
            const double gain = way - joint.way(stops[j].before, start);
            double share = (stop - start) / way;
            if (only_forces_act(before, stops, j)) {
                const double by_force = share_of(stop - start, way, gain);
                if (by_force >= 0 && by_force <= 1) share = by_force;
            }
            if (share >= first) continue;
            first = share;
            which = j;
            added = {stops[j].before, start, true, stop - side * Stop::kPlay, side, true, share, std::abs(way), gain};
        }
    }
    if (which == stops.size()) return false;
    for (Stop& stop : stops)  // an impact elsewhere changes speeds: what is being left must not hold them
        if (stop.leaving_step > 0) stop.let_go();
    stops[which] = added;
    return true;
}

bool StepEquations::leave_stops(const std::vector<BodyState>& end, const std::vector<Stop>& before,
                                std::vector<Stop>& stops) const {
    bool changed = false;
    for (size_t j = 0; j < before.size(); ++j) {
        const Stop& reached = before[j];
        Stop& stop = stops[j];
        if (!reached.acts || !reached.is_foreseen || reached.leaving_step > 1 || stop.acts) continue;
        if (!only_forces_act(before, stops, j)) continue;
        const JointEquations& joint = joints_.joints()[j];
        const double gain =
            joint.way(stop.start, joint.coordinate(end)) - joint.way(stop.before, stop.start);  // over a step
        const bool is_drawn_off = reached.side * gain > 0;
        if (!is_drawn_off && reached.leaving_step == 0) continue;
        // The first step leads to where it is after (2 - share) h, the second has the speed of half a step later
        const double steps = reached.leaving_step == 0 ? 0.5 * std::pow(2 - reached.share, 2) : 2.5 - reached.share;
        // Dampers alone draw it off before the impact, and not after it: back to the stop
        const double to = is_drawn_off ? stop.start + steps * gain : joint.stop(reached.side) - reached.side * Stop::kPlay;
        // It leaves no faster than it came: forces then change its speed little within these steps
        if ((2.5 - reached.share) * std::abs(gain) > reached.arrival) continue;
        if (reached.side * (to - joint.stop(-reached.side)) > 0) continue;
        const int next = reached.leaving_step + 1;
        stop = {stop.before, stop.start, true, to, reached.side, true, reached.share, reached.arrival, gain, next};
        changed = true;
    }
    return changed;
}

bool StepEquations::has_impact() const {
    for (size_t j = 0; j < joints_.stops().size(); ++j) {
        const Stop& stop = joints_.stops()[j];
        const JointEquations& joint = joints_.joints()[j];
        if (stop.acts && std::max(std::abs(joint.way(stop.before, stop.start)), std::abs(joint.way(stop.start, stop.end))) >
                             2 * Stop::kPlay)
            return true;
    }
    return false;
}

/// Impulses at t_n times the mean of the speeds before and after: what they change of the kinetic energy.
double StepEquations::coordinate_work(const std::vector<BodyState>& now, const std::vector<BodyState>& end,
                                      bool (JointEquations::*counts)() const) const {
    double work = 0;
    for (size_t j = 0; j < joints_.joints().size(); ++j)
        if ((joints_.joints()[j].*counts)())
            work -= impulses_(stop_index(j)) * 0.5 * (joints_.coordinate_speed(j, now) + joints_.coordinate_speed(j, end));
    return work;
}

}  // namespace dttmm::host
