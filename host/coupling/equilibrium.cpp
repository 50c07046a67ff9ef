// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/equilibrium.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/error.h"
#include "model/index.h"
#include "model/stop_request.h"

namespace dttmm::host {

namespace {

/// Of one Newton correction [rad]: the derivative says little of what is farther.
constexpr double kMostTurn = 0.5;
/// Of the ends of a joint that turn against each other, as share of what its law holds up to: more may be a kink, to which
/// large corrections have led. Halves of halves are tried down to a fifth. Of 120 ropes 2 are then found with kinks; 7 from
/// twice as much on, 1 from half as much on with a third more iterations, 4 where only two are tried, 13 with 0.125 alone.
constexpr double kMayBeKink = 0.5, kMostBend = 0.2, kLeastBend = 0.04;
/// Of what supports and motors ask for in one load step [rad]. Bodies and springs are followed from one load step to the
/// next: two supports that turn against each other stay within half a turn.
constexpr double kMostAskedTurn = 1;
/// Newton's iteration goes to the equilibrium that a growing load leads to where a correction is at most a quarter of the
/// one before (Kantorovich). A shallow truss snaps through at 0.55. Statics.ATrussThatSnapsThroughSaysSo fails at 0.2 and
/// 0.8.
constexpr double kSmooth = 0.4;
/// Of the extent of the machine: corrections that are smaller may be rounding, and do not jump. Statics.LeesFrameAndAMotor
/// fails at 1e-13, Statics.ATrussThatSnapsThroughSaysSo at 3e-2.
constexpr double kJump = 1e-6;
/// Iterations for one load step. The elastica takes some 20 in one step, a chain of 2000 links that starts as a zigzag 13.
constexpr int kMostIterations = 1000;
/// Of the extent of the machine: what has to be moved farther in one iteration is held by nothing.
constexpr double kLostExtents = 1e6;
/// Of the extent of the machine: smaller corrections are rounding.
constexpr double kNoCorrection = 1e-13;
/// Of the extent of the machine. A correction leaves joints open by its square. Redundant joints disagree about that, and
/// their forces against each other are 1e10 times the stiffness times the disagreement. Such forces would stay. While
/// corrections are larger than this, forces of joints are therefore the least that balance, not the least change. Range
/// 1e-13 or less to 1e-5 (at 1e-3 Statics.RedundantJointsRestLikeOne).
constexpr double kAnew = 1e-8;
/// Of the largest force, those of joints included: without it a small correction only says that the resistance is large.
constexpr double kBalance = 1e-6;
/// A joint that is open by more at the end is warned of: share of the extent, or angle [rad]. Joints that agree leave 1e-13.
constexpr double kClosed = 1e-9;
/// One that is open by more contradicts another joint or a motor: share of the span, or angle [rad]. Anchors that the file
/// rounds open less: on three parallel cranks of a metre one is off by 1.7 mm at this limit.
constexpr double kContradiction = 1e-5;
/// Load steps are halved down to this share of the load.
constexpr double kLeastStep = 1.0 / 1024;
/// s by the largest stiffness over mass: what vibrates 10⁶ times slower than the fastest counts as not held.
constexpr double kLeastResistance = 1e-12;

/// The rotation vector of R with as many full turns as bring it nearest to another.
Eigen::Vector3d followed(const Eigen::Matrix3d& R, const Eigen::Vector3d& from) {
    constexpr double kNoAxis = 1e-6;  // below it rounding makes the axis [rad]
    const Eigen::AngleAxisd turn(R);
    const bool has_axis = turn.angle() > kNoAxis || from.norm() < M_PI;
    const Eigen::Vector3d axis = has_axis ? turn.axis() : from.normalized();
    const double angle = has_axis ? turn.angle() : 0;
    return (angle + 2 * M_PI * std::round((axis.dot(from) - angle) / (2 * M_PI))) * axis;
}

/// What one support may ask for, and all motors in a row [rad].
double asked_turn(const Model& model, double t0) {
    double of_supports = 0, of_motors = 0;
    for (const Node& node : model.nodes) {
        Eigen::Vector3d turn = Eigen::Vector3d::Zero();
        for (int d = 0; d < 3; ++d)
            if (const auto& signal = node.motion[as_size(3 + d)]) turn(d) = signal->value(t0);
        of_supports = std::max(of_supports, turn.norm());
    }
    for (const Joint& joint : model.joints)
        if (joint.drive && joint.type == JointType::hinge) of_motors += std::abs(joint.drive->value(t0));
    return of_supports + of_motors;
}

}  // namespace

Equilibrium::Equilibrium(const Model& model, Networks& networks, Loads& loads)
    : model_(model),
      networks_(networks),
      loads_(loads),
      joints_(model),
      size_(model, joints_.equations()),
      wrenches_(6 * model.bodies.size()),
      change_(6 * model.bodies.size()) {
    for (Eigen::VectorXd* list : {&right_hand_side_, &solution_}) list->setZero(joints_.rows());
}

// ---- The load in steps --------------------------------------------------------------------------------------------------

const RestState& Equilibrium::find(double t0) {
    search(t0);
    if (!is_smooth_) {
        const RestState found = state_;
        const double bend = bend_;
        const double share = follow(t0);
        // The same equilibrium: the search has found it
        const bool is_same = share == 1 && std::abs(state_.force - found.force) <= kBalance * found.force &&
                             std::abs(bend_ - bend) <= kBalance * bend;
        if (is_same) state_.iterations = found.iterations, state_.load_steps = found.load_steps;
        if (share < 1) {
            begin(t0);
            raise_load(t0, Steps::any);
            if (share > 0) state_.path_ends_at = share;
        }
    }
    for (const Eigen::Vector3d& turn : turned_) state_.turn = std::max(state_.turn, turn.norm());
    state_.noise = noise_;
    state_.is_loaded = is_loaded();
    return state_;
}

/// The whole load. Beside a long line that hangs there are equilibria with kinks between its links, where their law does not
/// hold. Where one may be found, smaller corrections look for one that bends joints less, by a tenth at least.
void Equilibrium::search(double t0) {
    const auto look = [&](double most_bend) {
        most_bend_ = most_bend;
        begin(t0);
        raise_load(t0, Steps::any);
    };
    double best = std::numeric_limits<double>::infinity();
    look(best);
    double least = bend_;
    for (double most_bend = kMostBend; least > kMayBeKink && most_bend > kLeastBend; most_bend /= 2) {
        try {
            look(most_bend);
        } catch (const Error& error) {
            if (error.code() != ExitCode::numerical_failure) throw;
            continue;
        }
        const bool is_same = std::abs(bend_ - least) <= kBalance * least;
        if (bend_ <= kMayBeKink || bend_ < 0.9 * least) least = bend_, best = most_bend;
        if (is_same) break;  // found twice, it is no chance
    }
    if (most_bend_ != best) look(best);
}

/// Back to the assembled machine.
void Equilibrium::begin(double t0) {
    state_ = {};
    state_.at = kept_ = start_ = states_at_start(model_);
    turned_.assign(start_.size(), Eigen::Vector3d::Zero());
    kept_turned_ = turned_;
    stiffest_ = resistance_ = least_resistance_ = 0;
    is_smooth_ = true;
    loads_.start(t0);
    joints_.start(t0);
    networks_.begin_statics();
}

/// Follows the load as it grows from zero, in steps without a jump. Returns the share up to which that leads: 0 where there
/// is no such step from the assembled machine.
double Equilibrium::follow(double t0) {
    begin(t0);
    try {
        return raise_load(t0, Steps::smooth);
    } catch (const Error& error) {  // of a spring that turns too far elsewhere
        if (error.code() != ExitCode::numerical_failure) throw;
    }
    return 0;
}

/// From zero; the share that was reached. Throws where that is not the whole, unless its steps are to be smooth.
double Equilibrium::raise_load(double t0, Steps steps) {
    steps_ = steps;
    const double asked = asked_turn(model_, t0), largest_step = asked > kMostAskedTurn ? kMostAskedTurn / asked : 1;
    double done = 0, step = largest_step;
    RestingJoints::Opening widest;
    while (done < 1) {
        const double factor = std::min(1.0, done + step);
        const Attempt attempt = iterate(factor);
        if (attempt.is_converged) {
            done = factor;
            ++state_.load_steps;
            step = std::min(2 * step, largest_step);
            networks_.keep_statics();
            kept_ = state_.at;
            kept_turned_ = turned_;
            joints_.keep();
            const bool is_open = attempt.open.size > kClosed * (attempt.open.is_length ? size_.extent : 1);
            state_.open = is_open ? describe(attempt.open) : "";
            continue;
        }
        if (attempt.open.share > widest.share) widest = attempt.open;
        is_smooth_ = false;
        step *= 0.5;
        networks_.recall_statics();
        state_.at = kept_;
        turned_ = kept_turned_;
        joints_.recall();
        // Without elements there is nothing that a smaller load would bend less: it rests at the same place
        const double least = kLeastStep * (steps == Steps::smooth && done > 0 ? done : largest_step);
        if (step >= least && !networks_.instances().empty()) continue;
        if (steps == Steps::smooth) return done;
        const std::string found = done > 0 ? fmt::format(", but one under {:.4g} of them", done) : "";
        if (widest.share > kContradiction)
            throw Error(ExitCode::numerical_failure,
                        fmt::format("{}: no equilibrium under its weight, loads and motors was found{}; {}. Do joints and "
                                    "motors contradict each other, or does a motor ask for more than the linkage reaches?",
                                    model_.path, found, describe(widest)));
        throw Error(ExitCode::numerical_failure,
                    fmt::format("{}: no equilibrium under its weight and loads was found{}; what moves on is {}. Is there "
                                "something that nothing holds, or a load above what the machine can carry?",
                                model_.path, found, attempt.mover.empty() ? "not known" : attempt.mover));
    }
    return done;
}

/// Weight of what is between the bodies counts as gravity does.
bool Equilibrium::is_loaded() const {
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(1, state_.at, loads);
    const auto on_networks = loads_.on_networks().first(6 * (model_.nodes.size() + model_.loads.size()));
    const auto acts = [](double number) { return number != 0; };
    return !model_.simulation.gravity.isZero(0) || std::ranges::any_of(loads, acts) ||
           std::ranges::any_of(on_networks, acts);
}

std::string Equilibrium::describe(const RestingJoints::Opening& open) const {
    return fmt::format("joint \"{}\" stays open by {:.3g} {}", model_.joints[open.joint].name, open.size,
                       open.is_length ? "m" : "rad");
}

double Equilibrium::heaviest() const {
    double mass = 0;
    for (const Inertia& inertia : size_.inertias) mass = std::max(mass, inertia.mass);
    return mass;
}

/// Newton's iteration at one share of the load.
Equilibrium::Attempt Equilibrium::iterate(double factor) {
    std::vector<double> loads;
    for (double load : loads_.on_networks()) loads.push_back(factor * load);
    networks_.set_static_loads(factor * model_.simulation.gravity, loads.data());
    resistance_ = least_resistance_;
    farthest_ = size_.span;
    shares_anew_ = !joints_.equations().empty();
    Attempt attempt;
    constexpr double kAny = std::numeric_limits<double>::infinity();
    double last = kAny;
    for (int i = 0; i < kMostIterations; ++i) {
        StopRequest::throw_if_made("before the equilibrium was found");
        ++state_.iterations;
        try {
            const Correction correction = correct(factor);
            attempt.correction = correction.size;
            attempt.mover = correction.mover;
            state_.residual = lacking(factor, correction.share);
            // What goes on and on is let go ever farther, until it is clear that nothing holds it
            farthest_ = correction.share * correction.size > 0.5 * farthest_ ? 2 * farthest_ : size_.span;
            if (farthest_ > kLostExtents * size_.extent) return attempt;
            if (joints_.reach_stops(state_.at)) {
                last = kAny;
                continue;
            }
            if (correction.size > kSmooth * last && correction.size > kJump * size_.extent) {
                is_smooth_ = false;
                if (steps_ == Steps::smooth) return attempt;
            }
            // Where nothing acts, what the least resistance makes of a correction that is rounding is all there is
            const double nothing = least_resistance_ * heaviest() * kNoCorrection * size_.extent;
            const bool is_small = correction.size <= kNoCorrection * size_.extent &&
                                  state_.residual <= std::max({RestState::kNoise * noise_, kBalance * strongest_, nothing});
            const bool is_noise = correction.size <= 1e-6 * size_.extent && correction.size >= 0.5 * last &&
                                  state_.residual <= std::max(RestState::kNoise * noise_, 1e-9 * state_.force);
            last = correction.size;
            if (std::exchange(shares_anew_, shares_anew_ && !is_noise && correction.size > kAnew * size_.extent)) continue;
            if (!is_small && !is_noise) continue;
            attempt.open = joints_.widest_opening(state_.at, factor, size_.span);
            if (attempt.open.share > kContradiction) return attempt;
            if (joints_.release_stops()) continue;
            if (steps_ == Steps::smooth && !is_stable(factor)) return attempt;
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
        if (correction.size <= kNoCorrection * size_.extent) return correction;
        const double excess =
            std::max({correction.turn / kMostTurn, correction.bend / most_bend_, correction.size / farthest_});
        if (!std::isfinite(excess)) break;
        if (correction.work < -correction.rounding && steps_ == Steps::any) {
            is_smooth_ = false;
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

/// Whether no motion grows where the machine is, but for one that grows as slowly as what counts as not held. Of equations
/// with joints the stiffness has a negative eigenvalue for each of their rows (Haynsworth's inertia additivity).
bool Equilibrium::is_stable(double factor) {
    resistance_ = least_resistance_;
    form(factor);
    std::ranges::fill(change_, 0.0);
    if (networks_.correct_static(change_.data()).falling > 0) return false;
    if (joints_.rows() == 0) return true;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factors(matrix_);
    const Eigen::Index of_joints = joints_.rows() - as_row(change_.size());
    return factors.info() != Eigen::Success || (factors.vectorD().array() < 0).count() <= of_joints;
}

Equilibrium::Correction Equilibrium::try_resistance(double factor) {
    solve(factor);
    const Networks::StaticMeasure inside = networks_.correct_static(change_.data());
    // Work below this share of the sum of its parts is rounding. Where joints contradict each other their forces grow, and
    // rounding is 1e-9 of the parts. Range 1e-9 (at 1e-10 Statics.AnchorsThatTheFileRounds...) to 1e-2; no test bounds it
    // there.
    constexpr double kWorkRounding = 1e-8;
    Correction all;
    all.work = inside.work;
    all.size = inside.shift;
    all.turn = inside.turn;
    all.bend = inside.bend;
    if (!inside.element.empty()) all.mover = fmt::format("element \"{}\"", inside.element);
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(factor, state_.at, loads);
    const auto add_work = [&](double work) {
        all.work += work;
        all.rounding += kWorkRounding * std::abs(work);
    };
    for (size_t i = 0; i < loads.size(); ++i) add_work(loads[i] * change_[i]);
    joints_.for_each_work(matrix_, solution_, right_hand_side_, add_work);
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
    if (joints_.rows() == 0) return;
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
    Eigen::VectorXd held = Eigen::VectorXd::Zero(joints_.rows());
    networks_.form_static(state_.at, resistance_, wrenches_.data(), [&](int row, int column, const Networks::Block& K) {
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) {
                entries.emplace_back(6 * row + i, 6 * column + j, 0.5 * K(i, j));
                entries.emplace_back(6 * column + j, 6 * row + i, 0.5 * K(i, j));
            }
        if (row == column) held.segment<6>(6 * row) += K.diagonal().cwiseAbs();
    });
    if (stiffest_ == 0) set_least_resistance(held);
    add_loads(factor, state_.at, wrenches_);
    add_load_stiffness(factor, entries);
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const BlockMatrix::Block M = size_.inertias[b].block(state_.at[b].rotation);
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                entries.emplace_back(6 * as_int(b) + i, 6 * as_int(b) + j,
                                     resistance_ * (M(i, j) + (i == j && i >= 3 ? turning_mass(b) : 0)));
    }
    for (size_t i = 0; i < wrenches_.size(); ++i) right_hand_side_(as_row(i)) = wrenches_[i];
    std::vector<double> stiffnesses;
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const double mass = size_.inertias[b].mass, turning = turning_mass(b) / (reach(b) * reach(b));
        stiffnesses.push_back(stiffest_ * mass + resistance_ * (mass + turning));
    }
    joints_.add(state_.at, factor, stiffnesses, shares_anew_, entries, right_hand_side_);
    matrix_.resize(joints_.rows(), joints_.rows());
    matrix_.setFromTriplets(entries.begin(), entries.end());
}

/// By what holds the bodies where the machine is assembled, 6 rows each.
void Equilibrium::set_least_resistance(const Eigen::VectorXd& held) {
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(1, state_.at, loads);
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const double mass = size_.inertias[b].mass, inertia = size_.inertias[b].J.trace() / 2, arm = reach(b);
        const Eigen::Map<const Vector6> load(&loads[6 * b]);
        stiffest_ = std::max({stiffest_, held.segment<3>(6 * as_row(b)).maxCoeff() / mass,
                              held.segment<3>(6 * as_row(b) + 3).maxCoeff() / inertia, load.head<3>().norm() / (mass * arm),
                              load.tail<3>().norm() / inertia});
    }
    least_resistance_ = std::max(kLeastResistance * stiffest_, 1e-10);
    if (resistance_ < least_resistance_) resistance_ = least_resistance_;
}

void Equilibrium::add_loads(double factor, const std::vector<BodyState>& at, std::vector<double>& wrenches) const {
    std::vector<double> own(wrenches.size(), 0.0);
    loads_.add_at_start(at, own.data());
    for (size_t i = 0; i < own.size(); ++i) wrenches[i] += factor * own[i];
}

/// Of forces that turn, or whose lever arms do, with their bodies: no load hangs on another body, so that all turn at once.
void Equilibrium::add_load_stiffness(double factor, Triplets& entries) const {
    if (model_.loads.empty()) return;
    const auto turned = [&](int c, double angle) {
        std::vector<BodyState> at = state_.at;
        for (BodyState& body : at) body = moved(body, angle * Vector6::Unit(3 + c));
        std::vector<double> wrenches(wrenches_.size(), 0.0);
        add_loads(factor, at, wrenches);
        return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(wrenches.data(), as_row(wrenches.size())));
    };
    for (int c = 0; c < 3; ++c) {
        const Eigen::VectorXd slope =
            slope_by_turn([&](double angle) { return Eigen::VectorXd(0.5 * (turned(c, angle) - turned(c, -angle))); });
        for (size_t b = 0; b < model_.bodies.size(); ++b)
            for (int r = 0; r < 6; ++r) {
                const int row = 6 * as_int(b) + r, column = 6 * as_int(b) + 3 + c;
                const double k = -slope(row);
                if (k == 0) continue;
                entries.emplace_back(row, column, 0.5 * k);
                entries.emplace_back(column, row, 0.5 * k);
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

// ---- What lacks ---------------------------------------------------------------------------------------------------------

/// Takes a share of the correction; the largest force that lacks there [N].
double Equilibrium::lacking(double factor, double share) {
    for (size_t b = 0; b < state_.at.size(); ++b) {
        state_.at[b] = moved(state_.at[b], share * Eigen::Map<const Vector6>(&change_[6 * b]));
        turned_[b] = followed(state_.at[b].rotation * start_[b].rotation.transpose(), turned_[b]);
    }
    joints_.change(share, solution_);
    std::ranges::fill(wrenches_, 0.0);
    const Networks::StaticMeasure inside = networks_.move_static(state_.at, share, wrenches_.data());
    std::vector<double> loads(wrenches_.size(), 0.0);
    add_loads(factor, state_.at, loads);
    noise_ = inside.noise;
    bend_ = inside.bend;
    state_.force = strongest_ = inside.force;
    strongest_ = std::max(strongest_, joints_.take_off(state_.at, wrenches_));
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
