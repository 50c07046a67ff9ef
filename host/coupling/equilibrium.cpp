// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/equilibrium.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/error.h"
#include "model/index.h"
#include "model/stop_request.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// Of one Newton correction [rad]: the derivative says little of what is farther.
constexpr double kMostTurn = 0.5;
/// Iterations for one load step. The elastica takes some 20 in one step, a chain of 2000 links that starts as a zigzag 13.
constexpr int kMostIterations = 1000;
/// Of the extent of the machine: what has to be moved farther in one iteration is held by nothing.
constexpr double kLostExtents = 1e6;
/// Of the extent of the machine: smaller corrections are rounding.
constexpr double kNoCorrection = 1e-13;
/// Of the largest force, those of joints included: without it a small correction only says that the resistance is large.
constexpr double kBalance = 1e-6;
/// Load steps are halved down to this share of the load.
constexpr double kLeastStep = 1.0 / 1024;
/// s by the largest stiffness over mass: what vibrates 10⁶ times slower than the fastest counts as not held.
constexpr double kLeastResistance = 1e-12;

double square(double x) { return x * x; }

BodyState moved(const BodyState& from, const Eigen::Matrix<double, 6, 1>& by) {
    BodyState to = from;
    to.position += by.head<3>();
    to.rotation = RotationStep(by.tail<3>()).apply(from.rotation);
    return to;
}

std::vector<BodyState> states_at_start(const Model& model) {
    std::vector<BodyState> states;
    for (const Body& body : model.bodies)
        states.push_back({body.position + body.rotation * body.center_of_mass, body.rotation, Eigen::Vector3d::Zero(),
                          Eigen::Vector3d::Zero()});
    return states;
}

}  // namespace

Equilibrium::Equilibrium(const Model& model, Networks& networks, Loads& loads)
    : model_(model),
      networks_(networks),
      loads_(loads),
      joints_(model.bodies, model.joints),
      inertias_(model.bodies.begin(), model.bodies.end()),
      stops_(model.joints.size()),
      wrenches_(6 * model.bodies.size()),
      change_(6 * model.bodies.size()) {
    rows_ = 6 * as_int(model.bodies.size());
    for (const JointEquations& joint : joints_.joints()) {
        first_row_.push_back(rows_);
        rows_ += joint.count();
    }
    for (const Inertia& inertia : inertias_) {
        reaches_.push_back(inertia.gyration_bound());
        total_mass_ += inertia.mass;
    }
    for (const JointEquations& joint : joints_.joints())
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0)
                reaches_[as_size(body)] = std::max(reaches_[as_size(body)], joint.arm(side));
    for (Eigen::VectorXd* list : {&q_, &right_hand_side_, &solution_}) list->setZero(rows_);
    find_size();
}

void Equilibrium::find_size() {
    Eigen::AlignedBox3d box;
    for (const BodyState& body : states_at_start(model_)) box.extend(body.position);
    for (const Node& node : model_.nodes) box.extend(node.position);
    if (!box.isEmpty()) {
        span_ = box.diagonal().norm();
        extent_ = std::max(box.min().cwiseAbs().norm(), box.max().cwiseAbs().norm());
    }
    for (const double length : reaches_) span_ = std::max(span_, length);
    for (const JointEquations& joint : joints_.joints())
        if (joint.has_stops() && !joint.turns())
            for (const double stop : joint.stops()) span_ = std::max(span_, std::abs(stop));
    extent_ = std::max(extent_, span_);
}

// ---- The load in steps --------------------------------------------------------------------------------------------------

const RestState& Equilibrium::find(double t0) {
    state_ = {};
    state_.at = kept_ = states_at_start(model_);
    std::ranges::fill(stops_, Stop{});
    kept_stops_ = stops_;
    q_.setZero();
    kept_q_ = q_;
    loads_.start(t0);
    joints_.drive(Drives(model_).at(t0));
    networks_.begin_statics();
    double done = 0, step = 1;
    while (done < 1) {
        const double factor = std::min(1.0, done + step);
        const Attempt attempt = iterate(factor);
        if (attempt.is_converged) {
            done = factor;
            ++state_.load_steps;
            step *= 2;
            networks_.keep_statics();
            kept_ = state_.at;
            kept_stops_ = stops_;
            kept_q_ = q_;
            continue;
        }
        step *= 0.5;
        networks_.recall_statics();
        state_.at = kept_;
        stops_ = kept_stops_;
        q_ = kept_q_;
        // Without elements there is nothing that a smaller load would bend less: it rests at the same place
        if (step >= kLeastStep && !networks_.instances().empty()) continue;
        throw Error(ExitCode::numerical_failure,
                    fmt::format("{}: no equilibrium under its weight and loads was found{}; what moves on is {}. Is there "
                                "something that nothing holds, or a load above what the machine can carry?",
                                model_.path, done > 0 ? fmt::format(", but one under {:.4g} of them", done) : "",
                                attempt.mover.empty() ? "not known" : attempt.mover));
    }
    const std::vector<BodyState> start = states_at_start(model_);
    for (size_t b = 0; b < start.size(); ++b)
        state_.turn =
            std::max(state_.turn, Eigen::AngleAxisd(state_.at[b].rotation * start[b].rotation.transpose()).angle());
    return state_;
}

/// Newton's iteration at one share of the load.
Equilibrium::Attempt Equilibrium::iterate(double factor) {
    std::vector<double> loads;
    for (double load : loads_.on_networks()) loads.push_back(factor * load);
    networks_.set_static_loads(factor * model_.simulation.gravity, loads.data());
    resistance_ = least_resistance_;
    farthest_ = span_;
    Attempt attempt;
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kMostIterations; ++i) {
        StopRequest::throw_if_made("before the equilibrium was found");
        ++state_.iterations;
        try {
            const Correction correction = correct(factor);
            attempt.correction = correction.size;
            attempt.mover = correction.mover;
            state_.residual = lacking(factor, correction.share);
            // What goes on and on is let go ever farther, until it is clear that nothing holds it
            farthest_ = correction.share * correction.size > 0.5 * farthest_ ? 2 * farthest_ : span_;
            if (farthest_ > kLostExtents * extent_) return attempt;
            if (reach_stops()) {
                last = std::numeric_limits<double>::infinity();
                continue;
            }
            const bool is_small = correction.size <= kNoCorrection * extent_ &&
                                  state_.residual <= std::max(16 * noise_, kBalance * strongest_);
            const bool is_noise = correction.size <= 1e-6 * extent_ && correction.size >= 0.5 * last &&
                                  state_.residual <= std::max(16 * noise_, 1e-9 * state_.force);
            last = correction.size;
            if (!is_small && !is_noise) continue;
            if (release_stops()) continue;
            attempt.is_converged = true;
            return attempt;
        } catch (const NetworkError&) {
            return attempt;
        } catch (const Error& error) {
            if (error.code() != ExitCode::numerical_failure) throw;
            return attempt;
        }
    }
    return attempt;
}

// ---- One iteration ------------------------------------------------------------------------------------------------------

/// Finds the correction; what moves most by it. The resistance grows until it does not lead uphill nor too far, and then
/// falls from iteration to iteration. What the resistance does not hold back, as a node without mass, is taken in part.
Equilibrium::Correction Equilibrium::correct(double factor) {
    constexpr int kMostTries = 30;
    constexpr double kUphill = 30, kLeastGrowth = 4, kMostGrowth = 1e6, kFall = 0.1;
    resistance_ = std::max(kFall * resistance_, least_resistance_);
    double last_excess = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < kMostTries; ++attempt) {
        Correction correction = try_resistance(factor);
        if (correction.size <= kNoCorrection * extent_) return correction;
        const double excess = std::max(correction.turn / kMostTurn, correction.size / farthest_);
        if (!std::isfinite(excess)) break;
        if (correction.work < -correction.rounding) {
            resistance_ *= kUphill;
        } else if (excess <= 1) {
            return correction;
        } else if (excess > 0.5 * last_excess) {
            correction.share = 1 / excess;
            return correction;
        } else {
            resistance_ *= std::clamp(1.5 * excess, kLeastGrowth, kMostGrowth);
            last_excess = excess;
        }
    }
    throw Error(ExitCode::numerical_failure, "no correction leads downhill");
}

Equilibrium::Correction Equilibrium::try_resistance(double factor) {
    solve(factor);
    const Networks::StaticMeasure inside = networks_.correct_static(change_.data());
    constexpr double kWorkRounding = 1e-12;
    Correction all;
    all.work = inside.work;
    all.size = inside.shift;
    all.turn = inside.turn;
    if (!inside.element.empty()) all.mover = fmt::format("element \"{}\"", inside.element);
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(factor, state_.at, loads);
    const auto add_work = [&](double work) {
        all.work += work;
        all.rounding += kWorkRounding * std::abs(work);
    };
    for (size_t i = 0; i < loads.size(); ++i) add_work(loads[i] * change_[i]);
    for (auto row = as_row(change_.size()); row < rows_; ++row)
        add_work(-(q_(row) + solution_(row)) * right_hand_side_(row));
    for (size_t b = 0; b < model_.bodies.size(); ++b) {
        const Eigen::Map<const Vector6> u(&change_[6 * b]);
        const double turn = u.tail<3>().norm(), shift = std::max(u.head<3>().norm(), reach(b) * turn);
        all.turn = std::max(all.turn, turn);
        if (shift <= all.size) continue;
        all.size = shift;
        all.mover = fmt::format("body \"{}\"", model_.bodies[b].name);
    }
    return all;
}

/// Solves the condensed equations formed where the machine is.
void Equilibrium::solve(double factor) {
    form(factor);
    if (rows_ == 0) return;
    if (!has_same_pattern()) {
        lu_.analyzePattern(matrix_);
        pattern_ = matrix_;
    }
    lu_.factorize(matrix_);
    if (lu_.info() != Eigen::Success)
        throw Error(ExitCode::numerical_failure, "the equations of the equilibrium are singular");
    solution_ = lu_.solve(right_hand_side_);
    for (size_t i = 0; i < change_.size(); ++i) change_[i] = solution_(as_row(i));
}

/// As the matrix that was analysed last.
bool Equilibrium::has_same_pattern() const {
    const auto same = [&](const int* one, const int* other, Eigen::Index count) {
        return std::equal(one, one + count, other);
    };
    return matrix_.rows() == pattern_.rows() && matrix_.nonZeros() == pattern_.nonZeros() &&
           same(matrix_.outerIndexPtr(), pattern_.outerIndexPtr(), matrix_.outerSize() + 1) &&
           same(matrix_.innerIndexPtr(), pattern_.innerIndexPtr(), matrix_.nonZeros());
}

void Equilibrium::form(double factor) {
    Triplets entries;
    std::ranges::fill(wrenches_, 0.0);
    Eigen::VectorXd held = Eigen::VectorXd::Zero(rows_);
    networks_.form_static(state_.at, resistance_, wrenches_.data(), [&](int row, int column, const Networks::Block& K) {
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) {
                entries.emplace_back(6 * row + i, 6 * column + j, 0.5 * K(i, j));
                entries.emplace_back(6 * column + j, 6 * row + i, 0.5 * K(i, j));
            }
        if (row == column) held.segment<6>(6 * row) += K.diagonal().cwiseAbs();
    });
    if (stiffest_ == 0) {
        std::vector<double> loads(wrenches_.size(), 0.0);
        add_loads(1, state_.at, loads);
        for (size_t b = 0; b < inertias_.size(); ++b) {
            const double mass = inertias_[b].mass, inertia = inertias_[b].J.trace() / 2, arm = reach(b);
            const Eigen::Map<const Vector6> load(&loads[6 * b]);
            stiffest_ = std::max({stiffest_, held.segment<3>(6 * as_row(b)).maxCoeff() / mass,
                                  held.segment<3>(6 * as_row(b) + 3).maxCoeff() / inertia,
                                  load.head<3>().norm() / (mass * arm), load.tail<3>().norm() / inertia});
        }
        least_resistance_ = std::max(kLeastResistance * stiffest_, 1e-10);
        if (resistance_ < least_resistance_) resistance_ = least_resistance_;
    }
    add_loads(factor, state_.at, wrenches_);
    add_load_stiffness(factor, entries);
    for (size_t b = 0; b < inertias_.size(); ++b) {
        const BlockMatrix::Block M = inertias_[b].block(state_.at[b].rotation);
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                entries.emplace_back(6 * as_int(b) + i, 6 * as_int(b) + j,
                                     resistance_ * (M(i, j) + (i == j && i >= 3 ? turning_mass(b) : 0)));
    }
    for (size_t i = 0; i < wrenches_.size(); ++i) right_hand_side_(as_row(i)) = wrenches_[i];
    add_joints(factor, entries);
    matrix_.resize(rows_, rows_);
    matrix_.setFromTriplets(entries.begin(), entries.end());
}

void Equilibrium::add_loads(double factor, const std::vector<BodyState>& at, std::vector<double>& wrenches) const {
    std::vector<double> own(wrenches.size(), 0.0);
    loads_.add_at_start(at, own.data());
    for (size_t i = 0; i < own.size(); ++i) wrenches[i] += factor * own[i];
}

/// Of forces that turn, or whose lever arms do, with their bodies, by differences: no load hangs on another body.
void Equilibrium::add_load_stiffness(double factor, Triplets& entries) const {
    constexpr double kTurn = 1e-5;
    if (model_.loads.empty()) return;
    for (int c = 0; c < 3; ++c) {
        std::vector<double> difference(wrenches_.size(), 0.0);
        for (const double sign : {1.0, -1.0}) {
            std::vector<BodyState> at = state_.at;
            Vector6 by = Vector6::Zero();
            by(3 + c) = sign * kTurn;
            for (BodyState& body : at) body = moved(body, by);
            std::vector<double> wrenches(wrenches_.size(), 0.0);
            add_loads(factor, at, wrenches);
            for (size_t i = 0; i < wrenches.size(); ++i) difference[i] += sign * wrenches[i];
        }
        for (size_t b = 0; b < model_.bodies.size(); ++b)
            for (int r = 0; r < 6; ++r) {
                const int row = 6 * as_int(b) + r, column = 6 * as_int(b) + 3 + c;
                const double k = -difference[6 * b + as_size(r)] / (2 * kTurn);
                if (k == 0) continue;
                entries.emplace_back(row, column, 0.5 * k);
                entries.emplace_back(column, row, 0.5 * k);
            }
    }
}

// ---- Joints -------------------------------------------------------------------------------------------------------------

/// Equations and forces of all joints. What redundant joints share is settled by a small E, which multiplies the change of q
/// only.
void Equilibrium::add_joints(double factor, Triplets& entries) {
    constexpr double kProximal = 1e-10;
    for (size_t j = 0; j < joints_.joints().size(); ++j) {
        const JointEquations& joint = joints_.joints()[j];
        const int first = joint_row(j);
        const JointEquations::Jacobian J = joint.jacobian(state_.at);
        const JointEquations::Values C = joint.residual(state_.at, factor * joints_.drives()[j].end);
        double stiffest = 0;
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0)
                stiffest =
                    std::max(stiffest, stiffest_ * inertias_[as_size(body)].mass +
                                           resistance_ * (inertias_[as_size(body)].mass +
                                                          turning_mass(as_size(body)) / square(reach(as_size(body)))));
        for (int row = 0; row < joint.count(); ++row) {
            const bool is_stop = row == joint.lasting();
            const bool is_idle = is_stop && !stops_[j].acts;  // zeros all the same: the pattern stays
            entries.emplace_back(first + row, first + row, is_idle ? 1 : -kProximal / stiffest);
            right_hand_side_(first + row) = is_idle ? -q_(first + row)
                                            : is_stop
                                                ? joint.stops()[stops_[j].side > 0 ? 0 : 1] - joint.coordinate(state_.at)
                                                : -C(row);
            for (const auto side : JointEquations::kSides) {
                const int body = joint.bodies()[side];
                if (body < 0) continue;
                for (int c = 0; c < 6; ++c) {
                    const double slope = is_idle ? 0 : J[side](row, c);
                    entries.emplace_back(first + row, 6 * body + c, slope);
                    entries.emplace_back(6 * body + c, first + row, slope);
                    right_hand_side_(6 * body + c) -= slope * q_(first + row);
                }
            }
        }
        add_joint_stiffness(j, entries);
    }
}

/// ∂(Jᵀ q)/∂(pose): the forces of a joint turn with its bodies. By central differences, exact for what is of second degree.
void Equilibrium::add_joint_stiffness(size_t j, Triplets& entries) {
    const JointEquations& joint = joints_.joints()[j];
    const Eigen::VectorXd q = reactions(j);
    if (q.isZero(0)) return;
    constexpr double kTurn = 1e-5;
    for (const auto moving : JointEquations::kSides) {
        const int column_body = joint.bodies()[moving];
        if (column_body < 0) continue;
        BodyState& body = state_.at[as_size(column_body)];
        const BodyState still = body;
        for (int c = 0; c < 6; ++c) {
            Vector6 by = Vector6::Zero();
            by(c) = c < 3 ? kTurn * std::max(joint.arm(moving), 1e-3) : kTurn;
            Vector6 difference[2] = {Vector6::Zero(), Vector6::Zero()};
            for (const double sign : {1.0, -1.0}) {
                body = moved(still, sign * by);
                const JointEquations::Jacobian J = joint.jacobian(state_.at);
                for (const auto side : JointEquations::kSides) difference[side] += sign * J[side].transpose() * q;
            }
            body = still;
            for (const auto side : JointEquations::kSides) {
                const int row_body = joint.bodies()[side];
                if (row_body < 0) continue;
                for (int r = 0; r < 6; ++r) {
                    const double k = 0.5 * difference[side](r) / (2 * by(c));
                    entries.emplace_back(6 * row_body + r, 6 * column_body + c, k);
                    entries.emplace_back(6 * column_body + c, 6 * row_body + r, k);
                }
            }
        }
    }
}

std::vector<double> Equilibrium::load_stiffness() const {
    Triplets entries;
    add_load_stiffness(1, entries);
    std::vector<double> all(36 * model_.bodies.size(), 0.0);
    for (const auto& entry : entries)
        all[36 * as_size(entry.row() / 6) + 6 * as_size(entry.row() % 6) + as_size(entry.col() % 6)] += entry.value();
    return all;
}

std::vector<double> Equilibrium::joint_stiffness() {
    std::vector<double> all(144 * model_.joints.size(), 0.0);
    for (size_t j = 0; j < model_.joints.size(); ++j) {
        Triplets entries;
        add_joint_stiffness(j, entries);
        const auto at = [&](int index) {
            const size_t side = index / 6 == joints_.joints()[j].bodies()[JointEquations::kFirst] ? 0 : 6;
            return side + as_size(index % 6);
        };
        for (const auto& entry : entries) all[144 * j + 12 * at(entry.row()) + at(entry.col())] += entry.value();
    }
    return all;
}

/// Of its equations; of a stop that does not act 0.
Eigen::VectorXd Equilibrium::reactions(size_t j) const {
    const JointEquations& joint = joints_.joints()[j];
    Eigen::VectorXd q = q_.segment(joint_row(j), joint.count());
    if (joint.has_stops() && !stops_[j].acts) q(joint.lasting()) = 0;
    return q;
}

/// On the first body at the anchor, in the axes of that body.
Equilibrium::Vector6 Equilibrium::joint_wrench(size_t j, const std::vector<BodyState>& at) const {
    const JointEquations& joint = joints_.joints()[j];
    const bool is_on_ground = joint.bodies()[JointEquations::kFirst] < 0;
    const auto side = is_on_ground ? JointEquations::kSecond : JointEquations::kFirst;
    const Vector6 wrench = (is_on_ground ? 1.0 : -1.0) * joint.jacobian(at)[side].transpose() * reactions(j);
    const Eigen::Vector3d arm = joint.anchor(at) - at[as_size(joint.bodies()[side])].position;
    const Eigen::Matrix3d axes = joint.axes(at);
    Vector6 own;
    own << axes.transpose() * wrench.head<3>(), axes.transpose() * (wrench.tail<3>() - arm.cross(wrench.head<3>()));
    return own;
}

/// By central differences: what is neglected and rounding are 1e-10 of the forces.
Eigen::Matrix<double, 6, 12> Equilibrium::joint_turning(size_t j) const {
    constexpr double kTurn = 1e-5;
    const JointEquations& joint = joints_.joints()[j];
    Eigen::Matrix<double, 6, 12> turning = Eigen::Matrix<double, 6, 12>::Zero();
    std::vector<BodyState> at = state_.at;
    for (const auto side : JointEquations::kSides) {
        const int body = joint.bodies()[side];
        if (body < 0) continue;
        for (int c = 0; c < 6; ++c) {
            const double step = c < 3 ? kTurn * std::max(joint.arm(side), 1e-3) : kTurn;
            for (const double sign : {1.0, -1.0}) {
                at[as_size(body)] = moved(state_.at[as_size(body)], sign * step * Vector6::Unit(c));
                turning.col(6 * as_row(size_t{side}) + c) += sign / (2 * step) * joint_wrench(j, at);
            }
        }
        at[as_size(body)] = state_.at[as_size(body)];
    }
    return turning;
}

/// Makes stops act that are passed; true if one more does.
bool Equilibrium::reach_stops() {
    bool is_reached = false;
    for (size_t j = 0; j < stops_.size(); ++j) {
        const JointEquations& joint = joints_.joints()[j];
        if (!joint.has_stops() || stops_[j].acts) continue;
        const double at = joint.coordinate(state_.at);
        const int side = at < joint.stops()[0] - Stop::kPlay ? 1 : at > joint.stops()[1] + Stop::kPlay ? -1 : 0;
        if (side == 0) continue;
        stops_[j].acts = is_reached = true;
        stops_[j].side = side;
    }
    return is_reached;
}

/// Lets go the stops that would pull; true if there is one.
bool Equilibrium::release_stops() {
    bool is_released = false;
    for (size_t j = 0; j < stops_.size(); ++j) {
        if (!stops_[j].acts) continue;
        const double q = q_(joint_row(j) + joints_.joints()[j].lasting());
        if (stops_[j].side * q <= 0) continue;  // the force along the coordinate is −q: up from the lower stop
        stops_[j] = {};
        is_released = true;
    }
    return is_released;
}

// ---- What lacks ---------------------------------------------------------------------------------------------------------

/// Takes a share of the correction; the largest force that lacks there [N].
double Equilibrium::lacking(double factor, double share) {
    for (size_t b = 0; b < state_.at.size(); ++b)
        state_.at[b] = moved(state_.at[b], share * Eigen::Map<const Vector6>(&change_[6 * b]));
    const auto joints = rows_ - as_row(change_.size());
    q_.tail(joints) += share * solution_.tail(joints);
    std::ranges::fill(wrenches_, 0.0);
    const Networks::StaticMeasure inside = networks_.move_static(state_.at, share, wrenches_.data());
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(factor, state_.at, loads);
    noise_ = inside.noise;
    state_.force = strongest_ = inside.force;
    for (size_t j = 0; j < joints_.joints().size(); ++j) {
        const JointEquations& joint = joints_.joints()[j];
        const JointEquations::Jacobian J = joint.jacobian(state_.at);
        const Eigen::VectorXd q = reactions(j);
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0) {
                const Vector6 force = J[side].transpose() * q;
                Eigen::Map<Vector6>(&wrenches_[6 * as_size(body)]) -= force;
                strongest_ = std::max(strongest_, force.head<3>().norm());
            }
    }
    double residual = inside.residual;
    for (size_t b = 0; b < state_.at.size(); ++b) {
        const Eigen::Map<const Vector6> load(&loads[6 * b]);
        const Vector6 r = Eigen::Map<const Vector6>(&wrenches_[6 * b]) + load;
        state_.force = std::max(state_.force, load.head<3>().norm());
        strongest_ = std::max({strongest_, load.head<3>().norm(), load.tail<3>().norm() / reach(b)});
        residual = std::max({residual, r.head<3>().norm(), r.tail<3>().norm() / reach(b)});
    }
    return residual;
}

}  // namespace dttmm::host
