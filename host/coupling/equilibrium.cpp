// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/equilibrium.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "model/error.h"
#include "model/index.h"
#include "model/stop_request.h"

namespace dttmm::host {

namespace {

/// Of one Newton correction [rad]: the derivative says little of what is farther.
constexpr double kMostTurn = 0.5;
/// Of the ends of a joint that turn or shift against each other, as share of what its law holds up to: more may be a kink or
/// a tear, to which large corrections have led. Halves of halves are tried down to a fifth. Before shifts counted, 2 of 120
/// ropes were found with kinks; 7 from twice as much on, 1 from half as much on with a third more iterations, 4 where only
/// two were tried, 13 with 0.125 alone.
constexpr double kMayBeKink = 0.5, kMostBend = 0.2, kLeastBend = 0.04;
/// Of what supports and motors ask for in one load step [rad]. Bodies and springs are followed from one load step to the
/// next: two supports that turn against each other stay within half a turn.
constexpr double kMostAskedTurn = 1;
/// Newton's iteration goes to the equilibrium that a growing load leads to where a correction is at most a quarter of the
/// one before (Kantorovich), and falls more than that did. A shallow truss snaps through at 0.55.
/// Statics.ATrussThatSnapsThroughSaysSo fails at 0.2 and 0.8.
constexpr double kSmooth = 0.4;
/// Of the extent of the machine: corrections that are smaller may be rounding, and do not jump. Statics.LeesFrameAndAMotor
/// fails at 1e-13, Statics.ATrussThatSnapsThroughSaysSo at 3e-2.
constexpr double kJump = 1e-6;
/// Iterations for one load step. The elastica takes some 20 in one step, a chain of 2000 links that starts as a zigzag 13.
constexpr int kMostIterations = 1000;
/// Iterations with the symmetric part of the derivative of loads without a potential. Of 129 machines under moments that it
/// finds in one load step half take 18 or less, 28 more than 30, five 62 to 74. Where it finds nothing they are in vain.
constexpr int kMostDescending = 60;
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
/// Of a step that may pass a kink.
constexpr double kOfKink = 0.25;
/// Of the distance that a step moves. Without its load the machine goes back by less only after a jump, for the step is
/// short. Statics.Slanted... fails at 0.
constexpr double kReturns = 0.1;
/// Load steps are halved down to this share of the load.
constexpr double kLeastStep = 1.0 / 1024;
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
    : model_(model), has_elements_(!networks.instances().empty()), equations_(model, networks, loads) {}

// ---- The load in steps --------------------------------------------------------------------------------------------------

const RestState& Equilibrium::find(double t0) {
    const bool has_descended = descend(t0);
    if (!has_descended) search(t0);
    if (!is_smooth_) {
        const RestState found = state_;
        const RestEquations::Balance balance = equations_.balance();
        const double share = follow(t0);
        // The same equilibrium: the search has found it
        const auto is_near = [](double one, double other) { return std::abs(one - other) <= kBalance * other; };
        const bool is_same = share == 1 && is_near(equations_.balance().force, balance.force) &&
                             is_near(equations_.balance().bend, balance.bend);
        if (is_same) state_.iterations = found.iterations, state_.load_steps = found.load_steps;
        if (share < 1 || (has_descended && !is_same)) {
            if (!has_descended || !descend(t0)) {
                begin(t0);
                raise_load(t0, Steps::any, 0);
            }
            if (share > 0 && share < 1) state_.path_ends_at = share;
            state_.has_path = share > 0 || !has_elements_;
        }
    }
    const RestEquations::Balance& balance = equations_.balance();
    state_.at = equations_.at();
    state_.turn = equations_.largest_turn();
    state_.residual = balance.residual;
    state_.force = balance.force;
    state_.noise = balance.noise;
    state_.is_loaded = equations_.is_loaded();
    return state_;
}

/// The whole load. Beside a long line that hangs there are equilibria with kinks between its links, or torn ones, where
/// their law does not hold. Where one may be found, or none is, smaller corrections look for one that lasts, and that
/// strains joints less, by a tenth at least.
void Equilibrium::search(double t0) {
    std::exception_ptr failure;  // the first
    const auto look = [&](double most_bend) {
        most_bend_ = most_bend;
        begin(t0);
        try {
            raise_load(t0, Steps::any, 0);
        } catch (const Error& error) {
            if (error.code() != ExitCode::numerical_failure) throw;
            if (!failure) failure = std::current_exception();
            return false;
        }
        return true;
    };
    constexpr double kNone = std::numeric_limits<double>::infinity();
    double best = kNone, least = look(kNone) ? bend() : kNone;
    if (!bends_) {
        if (failure) std::rethrow_exception(failure);
        return;
    }
    bool falls = falls_;
    for (double most_bend = kMostBend; least > kMayBeKink && most_bend > kLeastBend; most_bend /= 2) {
        if (!look(most_bend)) continue;
        const bool is_same = falls == falls_ && least < kNone && std::abs(bend() - least) <= kBalance * least,
                   is_better = bend() <= kMayBeKink || bend() < 0.9 * least;
        if (least == kNone || (falls == falls_ ? is_better : falls)) falls = falls_, least = bend(), best = most_bend;
        if (is_same) break;  // found twice, it is no chance
    }
    if (least == kNone) std::rethrow_exception(failure);
    if (most_bend_ != best) look(best);
}

/// Under moments that keep their direction, and other loads on bodies without a potential, no work says which way is
/// downhill, and the whole derivative leads to equilibria that do not last. Where these loads are small beside the rest, the
/// symmetric part of it leads to one that does; where they are large to none. Whether it has.
bool Equilibrium::descend(double t0) {
    if (!equations_.has_unsymmetric_loads() || asked_turn(model_, t0) > kMostAskedTurn) return false;
    most_bend_ = std::numeric_limits<double>::infinity();
    steps_ = Steps::any;
    begin(t0);
    equations_.take_symmetric(true);
    const Attempt attempt = iterate(1, kMostDescending);
    const bool lasts =
        attempt.is_converged && bend() <= kMayBeKink && equations_.is_stable() && !accept(attempt).has_value();
    equations_.take_symmetric(false);
    return lasts;
}

/// Takes where the iteration has ended. Returns why not, where a law does not hold there.
std::optional<Error> Equilibrium::accept(const Attempt& attempt) {
    try {
        equations_.keep();
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure) throw;
        return error;
    }
    ++state_.load_steps;
    const bool is_open = attempt.open.size > kClosed * (attempt.open.is_length ? equations_.size().extent : 1);
    state_.open = is_open ? describe(attempt.open) : "";
    return std::nullopt;
}

/// Back to the assembled machine.
void Equilibrium::begin(double t0) {
    state_ = {};
    resistance_ = 0;
    is_smooth_ = true;
    equations_.begin(t0);
}

/// Follows the load as it grows from zero, in steps without a jump, from where preloads alone bring the machine; where it
/// cannot from there, as a pendulum that only its weight holds, from where next to no load brings it. Returns the share up
/// to which that leads: 0 where there is no such step.
double Equilibrium::follow(double t0) {
    for (const double from : {0.0, kLeastStep}) try {
            if (from > 0 && !has_elements_) break;
            begin(t0);
            steps_ = Steps::any;
            if (!iterate(from, from > 0 ? kMostDescending : kMostIterations).is_converged) continue;
            is_smooth_ = true;
            equations_.keep();
            if (const double share = raise_load(t0, Steps::smooth, from); share > from) return share;
        } catch (const Error& error) {  // of a spring that turns too far elsewhere
            if (error.code() != ExitCode::numerical_failure) throw;
        }
    return 0;
}

/// Returns the share that was reached. Throws where that is not the whole, unless its steps are to be smooth.
double Equilibrium::raise_load(double t0, Steps steps, double done) {
    steps_ = steps;
    const double asked = asked_turn(model_, t0), largest_step = asked > kMostAskedTurn ? kMostAskedTurn / asked : 1;
    double step = largest_step;
    RestingJoints::Opening widest;
    std::optional<Error> beyond;  // the first place where a law does not hold
    while (done < 1) {
        const double factor = std::min(1.0, done + step);
        const Attempt attempt = iterate(factor, kMostIterations);
        const std::optional<Error> refused = attempt.is_converged ? accept(attempt) : std::nullopt;
        if (attempt.is_converged && !refused) {
            done = factor;
            step = std::min(2 * step, largest_step);
            continue;
        }
        if (attempt.open.share > widest.share) widest = attempt.open;
        if (!beyond) beyond = refused;
        is_smooth_ = false;
        step *= 0.5;
        equations_.recall();
        // Without elements there is nothing that a smaller load would bend less: it rests at the same place
        const double least = kLeastStep * (steps == Steps::smooth && done > 0 ? done : largest_step);
        if (step >= least && has_elements_) continue;
        if (steps == Steps::smooth) {
            const double shortest = std::min(least, 1 - done);
            if (refused || !has_elements_ || !pass_kink(done, shortest)) return done;
            done += kOfKink * shortest;
            step = least;
            ++state_.load_steps;
            equations_.keep();
            continue;
        }
        if (refused)
            throw Error(ExitCode::numerical_failure,
                        beyond->what() + (done > 0 ? fmt::format("; an equilibrium where it holds was found under {:.4g} of "
                                                                 "the weight and loads",
                                                                 done)
                                                   : ""));
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

/// Where a law has a kink, as where a slider gives way, corrections do not fall fast, however short the step. Without that
/// step the machine then goes back to where it was; one that snaps through stays near where it is. Takes a share kOfKink of
/// the step, if so.
bool Equilibrium::pass_kink(double done, double step) {
    steps_ = Steps::any;
    const auto go = [&](double factor) { return iterate(factor, kMostIterations); };
    const double beyond = done + kOfKink * step;
    equations_.recall();
    const Attempt there = go(beyond);
    bool passes = there.is_converged && equations_.is_stable();
    if (passes) {
        const Attempt back = go(done);
        passes = back.is_converged && back.way >= kReturns * there.way;
        equations_.recall();
    }
    passes = passes && go(beyond).is_converged;
    if (!passes) equations_.recall();
    steps_ = Steps::smooth;
    return passes;
}

std::string Equilibrium::describe(const RestingJoints::Opening& open) const {
    return fmt::format("joint \"{}\" stays open by {:.3g} {}", model_.joints[open.joint].name, open.size,
                       open.is_length ? "m" : "rad");
}

/// Newton's iteration at one share of the load.
Equilibrium::Attempt Equilibrium::iterate(double factor, int most_iterations) {
    equations_.set_load(factor);
    equations_.share_anew(true);
    const MachineSize& size = equations_.size();
    resistance_ = equations_.least_resistance();
    farthest_ = size.span;
    Attempt attempt;
    constexpr double kAny = std::numeric_limits<double>::infinity();
    double last = kAny, last_fall = kAny;
    for (int i = 0; i < most_iterations; ++i) {
        StopRequest::throw_if_made("before the equilibrium was found");
        ++state_.iterations;
        try {
            const RestEquations::Correction correction = correct();
            attempt.correction = correction.size;
            attempt.mover = correction.mover;
            attempt.way += correction.share * correction.size;
            const RestEquations::Balance& balance = equations_.move(correction.share);
            // What goes on and on is let go ever farther, until it is clear that nothing holds it
            farthest_ = correction.share * correction.size > 0.5 * farthest_ ? 2 * farthest_ : size.span;
            if (farthest_ > kLostExtents * size.extent) return attempt;
            if (equations_.reach_stops()) {
                last = last_fall = kAny;
                continue;
            }
            const double fall = last < kAny ? correction.size / last : 0;
            if ((fall > kSmooth || fall > last_fall) && correction.size > kJump * size.extent) {
                is_smooth_ = false;
                if (steps_ == Steps::smooth) return attempt;
            }
            // Where nothing acts, what the least resistance makes of a correction that is rounding is all there is
            const double nothing = equations_.least_resistance() * equations_.heaviest() * kNoCorrection * size.extent;
            const bool is_small =
                correction.size <= kNoCorrection * size.extent &&
                balance.residual <= std::max({RestState::kNoise * balance.noise, kBalance * balance.strongest, nothing});
            const bool is_noise = correction.size <= 1e-6 * size.extent && correction.size >= 0.5 * last &&
                                  balance.residual <= std::max(RestState::kNoise * balance.noise, 1e-9 * balance.force);
            // The next correction: of Newton's iteration the shares by which they fall are squared (Kantorovich)
            const double next = last < kAny ? std::min(fall, 1.0) * correction.size : correction.size;
            const bool is_newton = resistance_ <= equations_.least_resistance() && !equations_.has_unsymmetric_loads();
            const bool is_found =
                (is_newton && last < kAny ? std::min(fall, 1.0) : 1) * next <= kNoCorrection * size.extent &&
                balance.residual <= RestState::kNoise * balance.noise;
            last_fall = last < kAny ? fall : kAny;
            last = correction.size;
            falls_ = correction.falling > 0;
            if (equations_.shares_anew()) {
                equations_.share_anew(!is_noise && correction.size > kAnew * size.extent);
                continue;
            }
            if (!is_small && !is_noise && !is_found) continue;
            attempt.open = equations_.widest_opening();
            if (attempt.open.share > kContradiction) return attempt;
            if (equations_.release_stops()) continue;
            if (steps_ == Steps::smooth && !equations_.is_stable()) return attempt;
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
RestEquations::Correction Equilibrium::correct() {
    constexpr int kMostTries = 30;
    constexpr double kUphill = 30, kLeastGrowth = 4, kMostGrowth = 1e6, kFall = 0.1;
    const MachineSize& size = equations_.size();
    resistance_ *= kFall;
    double last_excess = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < kMostTries; ++attempt) {
        resistance_ = std::max(resistance_, equations_.least_resistance());
        RestEquations::Correction correction = equations_.correct(resistance_);
        resistance_ = std::max(resistance_, equations_.least_resistance());
        bends_ = bends_ || correction.bend > 0;
        if (correction.size <= kNoCorrection * size.extent) return correction;
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

}  // namespace dttmm::host
