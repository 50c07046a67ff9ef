// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/run_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "analysis/law_limits.h"
#include "analysis/signal_jumps.h"
#include "coupling/stability.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// The energy ledger of a run, as far as its rows tell.
struct Ledger {
    double turned_over = 0;                                  ///< largest of its items [J]
    double residual = 0, most = 0, residual_at_the_end = 0;  ///< largest magnitude, largest, last [J]
    double rounding = 0;                                     ///< below this the ledger tells nothing [J]
};

/// Of an element or joint.
bool is_force(const Channel& channel) { return channel.quantity() == "force"; }

/// Largest force of the elements and joints recorded [N].
double find_largest_force(const Recorder& recorder) {
    double largest = 0;
    for (size_t c = 1; c < recorder.channels().size(); ++c)
        if (is_force(recorder.channels()[c])) largest = std::max(largest, recorder.statistics(as_int(c)).peak);
    return largest;
}

Ledger read_ledger(const Recorder& recorder, const Model& model, double step) {
    Ledger ledger;
    for (const Body& body : model.bodies) {
        const double size = 1 + body.position.norm(), speed = 1e-11 * size / step;  // m, and rounding of it over a step
        ledger.rounding += body.mass * (1e-12 * model.simulation.gravity.norm() * size + speed * speed);
    }
    for (const Node& node : model.nodes) {  // its mass is the plugin's: one kilogram stands for it
        const double size = 1 + node.position.norm(), speed = 1e-11 * size / step;
        ledger.rounding += 1e-12 * model.simulation.gravity.norm() * size + speed * speed;
    }
    // What a joint holds moves by rounding alone: 1e-12 m
    ledger.rounding += 1e-12 * find_largest_force(recorder);
    for (size_t c = 0; c < recorder.channels().size(); ++c) {
        const Channel& channel = recorder.channels()[c];
        if (channel.of() != Channel::Of::energy) continue;
        const ChannelStatistics& statistics = recorder.statistics(as_int(c));
        if (channel.quantity() == "residual") {
            ledger.residual = statistics.peak;
            ledger.most = statistics.maximum;
            ledger.residual_at_the_end = statistics.final;
        } else {
            ledger.turned_over = std::max(ledger.turned_over, statistics.peak);
        }
    }
    return ledger;
}

/// Advice to add after another; empty where numerical damping is not possible, or there already.
const char* or_numerical_damping(const Model& model) {
    const bool helps = model.simulation.coupling == Coupling::implicit && model.simulation.spectral_radius == 1;
    return helps ? ", or a spectral_radius of 0.9" : "";
}

/// Why a run made or lost energy. A vibration that the step does not resolve appears as one of about pi − 4/(omega h) rad
/// per step; a body that turns by 4/(omega h) per step, give or take, can feed it, however slow that is.
std::string describe_energy_fault(const Model& model, const Simulation& simulation, const std::vector<FastLoad>& fast) {
    if (simulation.explicit_limit() && simulation.explicit_limit()->load > 0.8 * kExplicitLimit)
        return fmt::format("near the limit of the explicit coupling or beyond it, {}", simulation.describe_speed());
    if (!fast.empty())
        return fmt::format("{} at {} is too fast for the step of {:g} s; use --step \"{:.12g} s\"", fast.front().name,
                           fast.front().place, simulation.step_size(), fast.front().step);
    const double step = simulation.step_size(), omega_h = simulation.fastest_mode().omega * step;
    const auto jumps = [&](const Joint& joint) {
        return joint.drive && find_jump_of_speed([&](double t) { return joint.drive->value(t); }, model.simulation.duration);
    };
    if (const auto motor = std::ranges::find_if(model.joints, jumps); motor != model.joints.end())
        return fmt::format("the motor of joint \"{}\" jumps, which a shorter step does not help", motor->name);
    if (omega_h == 0 && model.nodes.empty()) return fmt::format("the step of {:g} s is too long; try a shorter one", step);
    if (omega_h == 0)
        return fmt::format("the step of {:g} s is too long for what vibrates inside the networks; try a shorter one{}", step,
                           or_numerical_damping(model));
    const Turning turning = simulation.fastest_turning();
    if (turning.per_step > 0.1 || turning.per_step * omega_h > 2) {
        const double longest = step * std::min(0.05 / turning.per_step, 1 / std::sqrt(turning.per_step * omega_h));
        return fmt::format("body \"{}\" turns {:.3g} rad per step on elements of {}; try --step \"{:.12g} s\"{}",
                           turning.body, turning.per_step, simulation.describe_speed(), divide_step(step, longest),
                           or_numerical_damping(model));
    }
    if (!model.nodes.empty())
        return fmt::format(
            "the step of {:g} s is too long for the fastest vibration, of the bodies ({}) or inside the "
            "networks; try a shorter one{}",
            step, simulation.describe_speed(), or_numerical_damping(model));
    return fmt::format("the step of {:g} s is too long for the fastest vibration, {}", step, simulation.describe_speed());
}

/// What the ledger cannot account for was made or lost by the integration itself. Numerical damping loses it on request.
void warn_energy(const Recorder& recorder, const Model& model, const Simulation& simulation,
                 const std::vector<FastLoad>& fast, Warnings& warnings) {
    const Ledger ledger = read_ledger(recorder, model, simulation.step_size());
    const bool is_damped = model.simulation.coupling == Coupling::implicit && model.simulation.spectral_radius < 1;
    if (is_damped && ledger.residual_at_the_end < 0 && ledger.most <= 0.1 * ledger.turned_over) {
        const double taken = -ledger.residual_at_the_end;
        if (taken > 0.01 * ledger.turned_over)
            warnings.note(
                "numerical-damping",
                fmt::format("numerical damping (spectral_radius = {:g}) took {:.3g} J, {:.2g} % of the {:.3g} J turned over",
                            model.simulation.spectral_radius, taken, 100 * taken / ledger.turned_over, ledger.turned_over));
        return;
    }
    // In the row of an impact on a stop the ledger stands between before and after, up to a quarter of what was lost below
    const bool has_stops = std::ranges::any_of(model.joints, [](const Joint& joint) { return joint.limits.has_value(); });
    const double residual = has_stops ? std::max(ledger.most, std::abs(ledger.residual_at_the_end)) : ledger.residual;
    if (residual > 0.1 * ledger.turned_over && residual > ledger.rounding)
        warnings.add("energy-balance",
                     fmt::format("the energy balance leaves {:.3g} J unaccounted for, of {:.3g} J at most: {}", residual,
                                 ledger.turned_over, describe_energy_fault(model, simulation, fast)));
}

/// What goes up and down from row to row: the largest of all directions.
struct Alternating {
    std::string_view owner;
    double peak = 0, ripple = 0, final = 0;
    double share() const { return ripple / peak; }
    /// With numerical damping what dies falls by a share per step: a tenth is as good as a thousandth of it.
    bool lasts() const { return final > 0.1 * ripple; }
    std::string text(const char* unit) const {
        return fmt::format(
            "\"{}\" alternates from step to step, by {:.3g} {} as a mean over ten steps, and is {:.3g} {} at most", owner,
            ripple, unit, peak, unit);
    }
};

/// Of the channels wanted the owner that alternates most for its peak, if that is by more than a tenth and by more than
/// `least`; of what lasts, if any does.
template <class Wanted>
std::optional<Alternating> find_worst(const Recorder& recorder, const Wanted& wanted, double least) {
    constexpr double kTolerated = 0.1;
    std::map<std::string_view, Alternating> found;
    const auto for_each_wanted = [&](const auto& look) {
        for (size_t c = 1; c < recorder.channels().size(); ++c)
            if (const Channel& channel = recorder.channels()[c]; wanted(channel))
                look(channel.owner(), recorder.statistics(as_int(c)));
    };
    const auto alternates = [&](const auto& one) { return one.ripple > kTolerated * one.peak && one.ripple > least; };
    // An owner does where one of its directions does: of a large machine these are few
    for_each_wanted([&](std::string_view owner, const ChannelStatistics& statistics) {
        if (alternates(statistics)) found[owner].owner = owner;
    });
    for_each_wanted([&](std::string_view owner, const ChannelStatistics& statistics) {
        const auto own = found.find(owner);
        if (own == found.end()) return;
        own->second.peak = std::max(own->second.peak, statistics.peak);
        own->second.ripple = std::max(own->second.ripple, statistics.ripple);
        own->second.final = std::max(own->second.final, statistics.ripple_final);
    });
    std::optional<Alternating> worst;
    for (const auto& [owner, one] : found) {
        if (!alternates(one)) continue;
        if (!worst || std::pair(one.lasts(), one.share()) > std::pair(worst->lasts(), worst->share())) worst = one;
    }
    return worst;
}

/// The force of an element that goes up and down from step to step, or else the acceleration of a body, marker or node: a
/// vibration faster than the step. Only rows of every step show it. The energy balance does not: what is stiff or light
/// holds next to no energy. An acceleration that numerical damping has calmed by the end is no more than a note.
void warn_ripple(const Recorder& recorder, const Session& session, Warnings& warnings) {
    const Model& model = session.model;
    if (model.output.every != 1) return;
    const double step = model.simulation.step;
    // Beside the largest force of the machine this is rounding: it moves what is held by 1e-16 of its size
    const double rounding = 1e-8 * find_largest_force(recorder);
    const auto is_of_element = [](const Channel& c) { return c.of() == Channel::Of::element && is_force(c); };
    if (const auto worst = find_worst(recorder, is_of_element, rounding)) {
        warnings.add(
            "alternating-force",
            fmt::format("the force of element {}: a vibration that the step of {:g} s does not follow. It rings for "
                        "ever unless something damps it, and its peaks are not those of the machine; try a shorter "
                        "step or damping of the element{}",
                        worst->text("N"), step, or_numerical_damping(model)));
        return;
    }
    if (!session.fast_loads.empty()) return;  // the cause, and another warning names it
    const auto accelerates = [](const Channel& c) { return c.quantity() == "acceleration" && c.by_default(); };
    constexpr double kUnseen = 0.02;  // m/s^2, two thousandths of g: what sensors on machines do not tell from noise
    const auto worst = find_worst(recorder, accelerates, kUnseen);
    if (!worst) return;
    const std::string text = fmt::format(
        "the acceleration of {}, though no force of an element alternates by a tenth of its peak: a vibration of something "
        "light or stiff that the step of {:g} s does not follow, or rounding. Its peaks are not those of the machine",
        worst->text("m/s^2"), step);
    // Without numerical damping the rows may end where a vibration seen once a step happens to be small
    if (model.simulation.spectral_radius < 1 && !worst->lasts())
        warnings.note("alternating-acceleration", text + "; it has died out at the end");
    else
        warnings.add("alternating-acceleration", text + "; try a shorter step" + or_numerical_damping(model));
}

/// Peaks that may stand between rows.
void warn_rows(const Recorder& recorder, const Model& model, const Simulation& simulation, Warnings& warnings) {
    const double spacing = model.output.every * model.simulation.step;
    if (!(spacing > 1.5 * simulation.step_size())) return;
    constexpr double kMissed = 0.05;  // of the peak
    const double rounding = 1e-8 * find_largest_force(recorder);
    std::unordered_map<std::string_view, double> largest;  // by element or joint
    const auto for_each_force = [&](const auto& look) {
        for (size_t c = 1; c < recorder.channels().size(); ++c) {
            const Channel& channel = recorder.channels()[c];
            if ((channel.of() == Channel::Of::element || channel.of() == Channel::Of::joint) &&
                channel.quantity() == "force")
                look(channel, recorder.statistics(as_int(c)));
        }
    };
    for_each_force([&](const Channel& channel, const ChannelStatistics& statistics) {
        double& most = largest[channel.owner()];
        most = std::max(most, statistics.peak);
    });
    const Channel* worst = nullptr;
    double worst_share = kMissed;
    for_each_force([&](const Channel& channel, const ChannelStatistics& statistics) {
        const double share = statistics.bend / 8 / statistics.peak;
        if (statistics.peak < largest[channel.owner()] || statistics.peak <= rounding || !(share > worst_share)) return;
        worst = &channel;
        worst_share = share;
    });
    if (!worst) return;
    // So many steps that the rows of today are among those to be
    const double step = simulation.step_size();
    const long every = std::lround(spacing / step);
    long advised = std::max(1L, std::lround(std::floor(spacing / step * std::sqrt(0.01 / worst_share))));
    while (every % advised != 0) --advised;
    warnings.add("peaks-between-rows",
                 fmt::format("rows every {:g} s are too far apart for the peak of \"{}\": between them it may be {:.2g} % "
                             "larger, or missed. Record more often, e.g. --output-step \"{:.12g} s\"",
                             spacing, worst->name(), 100 * worst_share, static_cast<double>(advised) * step));
}

/// Of a body on elements, about its axis of spin: how fast that axis wobbles by itself [rad/s].
double nutation_of(const Body& body, const BodyState& state) {
    const Eigen::Matrix3d inertia = state.rotation * body.inertia * state.rotation.transpose();
    const Eigen::Vector3d momentum = inertia * state.angular_velocity;
    if (momentum.isZero(0)) return 0;
    // I u' = u × L, for u small and across L:  ω = |L|/√(I₁ I₂)
    const Eigen::Vector3d axis = momentum.normalized(), one = axis.unitOrthogonal(), other = axis.cross(one);
    const double product = one.dot(inertia * one) * other.dot(inertia * other) - std::pow(one.dot(inertia * other), 2);
    // A sphere has no axis
    const double across = std::sqrt(product), along = axis.dot(inertia * axis);
    return std::abs(along - across) > 0.1 * across ? momentum.norm() / across : 0;
}

/// Vibrations that gyroscopic moments make, which the fastest vibration leaves out. A body on a joint nutates with what
/// carries it: nothing is said of it.
void warn_spin(const Model& model, const Simulation& simulation, Warnings& warnings) {
    constexpr double kMost = 0.35;  // rad per step: the period then errs by (ω h)²/12, 1 %
    const double step = simulation.step_size();
    const Body* fastest = nullptr;
    double most = std::max(kMost / step, simulation.fastest_mode().omega);
    for (size_t b = 0; b < model.bodies.size(); ++b) {
        const auto holds = [&](const Joint& joint) { return joint.first == as_int(b) || joint.second == as_int(b); };
        if (std::ranges::any_of(model.joints, holds)) continue;
        const double nutation = nutation_of(model.bodies[b], simulation.bodies()[b]);
        if (nutation > most) fastest = &model.bodies[b], most = nutation;
    }
    if (!fastest) return;
    warnings.add(
        "gyroscopic-step",
        fmt::format("body \"{}\" spins: its axis nutates at about {:.4g} Hz, {:.3g} steps per period, which omega*h "
                    "leaves out. A vibration of that kind errs by more than 1 %; use --step \"{:.12g} s\"",
                    fastest->name, most / (2 * M_PI), 2 * M_PI / (most * step), divide_step(step, kMost / most)));
}

/// What the linkages did without.
void warn_singular_positions(const Simulation& simulation, const Model& model, Warnings& warnings) {
    const SingularPosition::Passed& passed = simulation.end_of_step().singular_position().passed();
    if (passed.steps == 0) return;
    warnings.add(
        "singular-position",
        fmt::format("a linkage passes singular positions, the first at t = {:.4g} s (joint \"{}\"): over {} steps "
                    "equations of its joints were let go, and the momentum chose the branch. Forces of these joints "
                    "and accelerations are not reliable there; a smaller step narrows it",
                    passed.time, model.joints[passed.joint].name, passed.steps));
}

/// Impacts that fall within two steps.
void warn_lost_impacts(const Simulation& simulation, const Model& model, Warnings& warnings) {
    const StepStops::LostImpacts& lost = simulation.end_of_step().stops().lost_impacts();
    if (lost.steps == 0) return;
    warnings.add("impacts-together",
                 fmt::format("two stops are reached within two steps, the first time at t = {:.4g} s (joint \"{}\"), {} in "
                             "all: the later impact draws the machine off the earlier stop, which has not taken all of the "
                             "speed yet. Speeds after it are wrong by a part of that; a smaller step separates them",
                             lost.time, model.joints[lost.joint].name, counted(as_size(lost.steps), "time", "times")));
}

/// A run to a tolerance that could not begin at the step asked for.
void warn_skipped(const Halving& halving, Warnings& warnings) {
    if (halving.first_step() != halving.asked_step())
        warnings.note("shorter-first-step",
                      fmt::format("the motion was not found at a step of {:g} s; it begins with {:g} s",
                                  halving.asked_step(), halving.first_step()));
}

/// A tolerance reached at a step that misses the fastest vibrations holds for what the step sees.
void warn_unresolved(const Halving& halving, Warnings& warnings) {
    const Simulation& simulation = halving.simulation();
    const double omega_h = simulation.fastest_mode().omega * simulation.step_size();
    if (halving.reached() && omega_h > kUnresolved)
        warnings.add("unresolved-vibration",
                     fmt::format("omega*h = {:.3g} at the step used: vibrations near {:.4g} Hz are not followed, and their "
                                 "part in the error is only allowed for",
                                 omega_h, simulation.fastest_mode().omega / (2 * M_PI)));
}

/// Where stops are reached together, errors are of first order with a factor that changes from step to step.
void warn_close_impacts(const Simulation& simulation, Warnings& warnings) {
    if (const long steps = simulation.end_of_step().stops().close_impacts(); steps > 0)
        warnings.add("close-impacts",
                     fmt::format("{} a stop is reached within two steps of another one. There the motion is of first order, "
                                 "and the errors that are stated may be several times too small",
                                 counted(as_size(steps), "time", "times")));
}

}  // namespace

void warn_of_run(Session& session, const Simulation& simulation, const Recorder& recorder) {
    Warnings& warnings = session.warnings;
    if (session.halving) session.look_at_loads(simulation);
    warn_energy(recorder, session.model, simulation, session.fast_loads, warnings);
    if (!session.model.simulation.tolerance) warn_spin(session.model, simulation, warnings);
    warn_limits(simulation.limits(), simulation.channels(), "", warnings);
    warn_singular_positions(simulation, session.model, warnings);
    warn_lost_impacts(simulation, session.model, warnings);
    warn_rows(recorder, session.model, simulation, warnings);
    if (!session.halving) return warn_ripple(recorder, session, warnings);
    warn_skipped(*session.halving, warnings);
    warn_unresolved(*session.halving, warnings);
    warn_close_impacts(simulation, warnings);
}

}  // namespace dttmm::host
