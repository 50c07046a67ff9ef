// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/run.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "analysis/advance.h"
#include "analysis/halving.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "coupling/stability.h"
#include "model/diagnostics.h"
#include "model/wording.h"
#include "record/recorder.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "step/simulation.h"

namespace dttmm {

namespace {

void print_warnings(const Model& model) {
    for (const std::string& warning : model.warnings) tell(fmt::format("warning: {}", warning));
    // A load is looked at once per step: of what is shorter than a few steps little is left.
    for (const Load& load : model.loads)
        if (load.signal.shortest_time() < 5 * model.simulation.step)
            tell(fmt::format(
                "warning: {}: the load has a wave or pulse of {:.3g} s, shorter than 5 steps of {:g} s: it is poorly "
                "resolved or lost between them",
                load.place, load.signal.shortest_time(), model.simulation.step));
}

/// The largest step up to `longest` [s] that divides `step` into 1, 2, 4, 5, 8, 10, 20, ... parts: it then divides duration
/// and output step as well, and is short to write.
double divide_step(double step, double longest) {
    for (double decade = 1;; decade *= 10)
        for (double parts : {1, 2, 4, 5, 8})
            if (!(step / (decade * parts) > longest)) return step / (decade * parts);
}

/// The channels the model asks for. Throws Error(model_invalid) with the place of the list.
std::vector<int> selected_channels(const Model& model, const Simulation& simulation) {
    try {
        return select_channels(simulation.channels(), model.output.channels);
    } catch (const Error& error) {
        throw ModelError(fmt::format("{}: {}", model.output.channels_place, error.what()));
    }
}

/// An explicit coupling beyond the limit of its scheme would throw the machine apart.
void refuse_unstable(const Simulation& simulation, bool force) {
    if (!simulation.explicit_limit()) return;
    const ExplicitLimit& limit = *simulation.explicit_limit();
    if (limit.load >= kExplicitLimit && !force)
        throw Error(ExitCode::numerical_failure,
                    fmt::format("the explicit coupling would diverge at a step of {:.6g} s: {}; use --step \"{:.12g} s\", "
                                "--coupling implicit, or --force to run anyway",
                                simulation.step_size(), simulation.describe_speed(),
                                divide_step(simulation.step_size(), 0.9 * limit.longest_step)));
    if (limit.load > 0.8 * kExplicitLimit)
        tell(fmt::format("warning: {}: {} the limit of the explicit coupling", simulation.describe_speed(),
                         limit.load < kExplicitLimit ? "near" : "beyond"));
}

/// A run to a tolerance need not be told a stable step: it starts from one, its rows where they were.
Model start_stable(Model model, const Plugins& plugins) {
    if (model.simulation.coupling != Coupling::explicit_) return model;
    const auto limit = Simulation(model, plugins).explicit_limit();
    if (!limit || limit->load < kExplicitLimit) return model;
    const double step = divide_step(model.simulation.step, 0.9 * limit->longest_step);
    const double every = model.output.every * std::round(model.simulation.step / step);
    if (step < kShortestStep || every > std::numeric_limits<int>::max()) return model;
    tell(fmt::format("the explicit coupling would diverge at a step of {:g} s; beginning with {:.12g} s",
                     model.simulation.step, step));
    model.simulation.step = step;
    model.output.every = static_cast<int>(every);
    return model;
}

/// Of every owner's forces and moments, "<owner>.<quantity>", the direction with the largest peak, as a channel.
std::map<std::string, int> find_largest_directions(const Recorder& recorder) {
    std::map<std::string, int> largest;
    for (int c = 1; c < static_cast<int>(recorder.channels().size()); ++c) {
        const std::string& name = recorder.channels()[static_cast<size_t>(c)].name;
        const std::string quantity = name.substr(0, name.rfind('.'));
        if (!quantity.ends_with(".force") && !quantity.ends_with(".moment")) continue;
        const auto [entry, is_new] = largest.emplace(quantity, c);
        if (!is_new && recorder.statistics(c).peak > recorder.statistics(entry->second).peak) entry->second = c;
    }
    return largest;
}

/// One line per element and joint: the direction of its largest force or moment, when it peaks and where it ends.
void print_forces(const Recorder& recorder, const Model& model) {
    std::vector<std::string> owners;
    for (const Element& element : model.elements) owners.push_back(element.name);
    for (const Joint& joint : model.joints) owners.push_back(joint.name);
    size_t width = model.joints.empty() ? 7 : 14;
    for (const std::string& owner : owners) width = std::max(width, owner.size());
    fmt::print("{:<{}}  {:>12}  {:>13}  {:>10}  {:>13}\n", model.joints.empty() ? "element" : "element, joint", width, "",
               "peak", "at [s]", "final");
    const std::map<std::string, int> largest = find_largest_directions(recorder);
    for (const std::string& owner : owners) {
        for (const char* quantity : {"force", "moment"}) {
            const auto found = largest.find(fmt::format("{}.{}", owner, quantity));
            if (found == largest.end()) continue;
            const Channel& channel = recorder.channels()[static_cast<size_t>(found->second)];
            const ChannelStatistics& statistics = recorder.statistics(found->second);
            if (statistics.peak == 0 && quantity != std::string_view("force")) continue;
            fmt::print("{:<{}}  {:>12}  {:>13}  {:>10.5g}  {:>13}\n", owner, width, channel.name.substr(owner.size() + 1),
                       fmt::format("{:.2f} {}", statistics.peak, channel.unit), statistics.peak_time,
                       fmt::format("{:.2f} {}", statistics.final, channel.unit));
        }
    }
}

/// The energy ledger of a run, as far as its rows tell.
struct Ledger {
    double turned_over = 0;                                  ///< largest of its items [J]
    double residual = 0, most = 0, residual_at_the_end = 0;  ///< largest magnitude, largest, last [J]
    double rounding = 0;                                     ///< below this the ledger tells nothing [J]
};

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
    for (size_t c = 0; c < recorder.channels().size(); ++c) {
        const std::string& name = recorder.channels()[c].name;
        const ChannelStatistics& statistics = recorder.statistics(static_cast<int>(c));
        if (name == "energy.residual") {
            ledger.residual = statistics.peak;
            ledger.most = statistics.maximum;
            ledger.residual_at_the_end = statistics.final;
        } else if (name.starts_with("energy.")) {
            ledger.turned_over = std::max(ledger.turned_over, statistics.peak);
        }
    }
    return ledger;
}

/// Why a run made or lost energy. A vibration that the step does not resolve appears as one of about pi − 4/(omega h) rad
/// per step; a body that turns by 4/(omega h) per step, give or take, can feed it, however slow that is.
std::string describe_energy_fault(const Simulation& simulation, bool has_networks) {
    if (simulation.explicit_limit() && simulation.explicit_limit()->load > 0.8 * kExplicitLimit)
        return fmt::format("near the limit of the explicit coupling or beyond it, {}", simulation.describe_speed());
    const double step = simulation.step_size(), omega_h = simulation.fastest_mode().omega * step;
    if (omega_h == 0)
        return fmt::format(
            "the step of {:g} s is too long for what vibrates inside the networks; try a shorter one, or a "
            "spectral_radius of 0.9",
            step);
    const Turning turning = simulation.fastest_turning();
    if (turning.per_step > 0.1 || turning.per_step * omega_h > 2) {
        const double longest = step * std::min(0.05 / turning.per_step, 1 / std::sqrt(turning.per_step * omega_h));
        return fmt::format("body \"{}\" turns {:.3g} rad per step on elements of {}; try --step \"{:.12g} s\"{}",
                           turning.body, turning.per_step, simulation.describe_speed(), divide_step(step, longest),
                           simulation.explicit_limit() ? "" : ", or a spectral_radius of 0.9");
    }
    if (has_networks)
        return fmt::format(
            "the step of {:g} s is too long for the fastest vibration, of the bodies ({}) or inside the "
            "networks; try a shorter one, or a spectral_radius of 0.9",
            step, simulation.describe_speed());
    return fmt::format("the step of {:g} s is too long for the fastest vibration, {}", step, simulation.describe_speed());
}

/// What the ledger cannot account for was made or lost by the integration itself. Numerical damping loses it on request.
void warn_energy(const Recorder& recorder, const Model& model, const Simulation& simulation) {
    const Ledger ledger = read_ledger(recorder, model, simulation.step_size());
    const bool is_damped = model.simulation.coupling == Coupling::implicit && model.simulation.spectral_radius < 1;
    if (is_damped && ledger.residual_at_the_end < 0 && ledger.most <= 0.1 * ledger.turned_over) {
        const double taken = -ledger.residual_at_the_end;
        if (taken > 0.01 * ledger.turned_over)
            tell(fmt::format(
                "note: numerical damping (spectral_radius = {:g}) took {:.3g} J, {:.2g} % of the {:.3g} J turned over",
                model.simulation.spectral_radius, taken, 100 * taken / ledger.turned_over, ledger.turned_over));
        return;
    }
    // In the row of an impact on a stop the ledger stands between before and after, up to a quarter of what was lost below
    const bool has_stops = std::ranges::any_of(model.joints, [](const Joint& joint) { return joint.limits.has_value(); });
    const double residual = has_stops ? std::max(ledger.most, std::abs(ledger.residual_at_the_end)) : ledger.residual;
    if (residual > 0.1 * ledger.turned_over && residual > ledger.rounding)
        tell(fmt::format("warning: the energy balance leaves {:.3g} J unaccounted for, of {:.3g} J at most: {}", residual,
                         ledger.turned_over, describe_energy_fault(simulation, !model.nodes.empty())));
}

/// The force of an element that goes up and down from step to step: a vibration faster than the step. Only rows of every
/// step show it. The energy balance does not: a stiff element holds next to no energy.
void warn_ripple(const Recorder& recorder, const Model& model) {
    if (model.output.every != 1) return;
    constexpr double kTolerated = 0.1;  // of the element's largest force
    struct Force {
        double peak = 0, ripple = 0;  // largest of its directions [N]
    };
    std::unordered_map<std::string, Force> forces;  // by "<element>.force"
    for (size_t c = 1; c < recorder.channels().size(); ++c) {
        const std::string& name = recorder.channels()[c].name;
        Force& force = forces[name.substr(0, name.rfind('.'))];
        const ChannelStatistics& statistics = recorder.statistics(static_cast<int>(c));
        force = {std::max(force.peak, statistics.peak), std::max(force.ripple, statistics.ripple)};
    }
    double worst = kTolerated;
    std::string warning;
    for (const Element& element : model.elements) {
        const auto [peak, ripple] = forces[element.name + ".force"];
        if (ripple <= worst * peak) continue;
        worst = ripple / peak;
        warning = fmt::format(
            "warning: the force of element \"{}\" alternates from step to step by {:.3g} N and is {:.3g} N at most: a "
            "vibration that the step of {:g} s does not follow. It rings for ever unless something damps it, and its peaks "
            "are not those of the machine; try a shorter step{}",
            element.name, ripple, peak, model.simulation.step,
            model.simulation.coupling == Coupling::implicit ? ", damping of the element, or a spectral_radius of 0.9"
                                                            : " or damping of the element");
    }
    if (!warning.empty()) tell(warning);
}

/// How the step was found, in one line.
void print_halving(const Halving& halving) {
    const Level& last = halving.levels().back();
    fmt::print(
        "error at most {:.3g} % of the largest value of its kind (\"{}\"), asked for {:g} %; step {:g} s of {:g} s at "
        "first{}\n",
        100 * last.error, last.worst, 100 * halving.tolerance(), last.step, halving.first_step(),
        std::isnan(last.order) ? "" : fmt::format(", observed order {:.2f}", last.order));
}

/// A run to a tolerance that could not begin where it was told to.
void warn_skipped(const Halving& halving) {
    if (halving.first_step() != halving.asked_step())
        tell(fmt::format("the motion was not found at a step of {:g} s; it begins with {:g} s", halving.asked_step(),
                         halving.first_step()));
}

/// A tolerance reached at a step that misses the fastest vibrations holds for what the step sees.
void warn_unresolved(const Halving& halving) {
    const Simulation& simulation = halving.simulation();
    const double omega_h = simulation.fastest_mode().omega * simulation.step_size();
    if (halving.reached() && omega_h > kUnresolved)
        tell(
            fmt::format("warning: omega*h = {:.3g} at the step used: vibrations near {:.4g} Hz are not followed, and their "
                        "part in the error is only allowed for",
                        omega_h, simulation.fastest_mode().omega / (2 * M_PI)));
}

void print_report(const Recorder& recorder, const Model& model, const Simulation& simulation, const ResultsFolder& folder,
                  const Outcome& outcome, const Halving* halving) {
    if (!model.title.empty()) fmt::print("{}\n", model.title);
    print_forces(recorder, model);
    if (halving && halving->has_estimates()) print_halving(*halving);
    const auto own_steps = static_cast<double>(std::max<uint64_t>(simulation.index(), 1));
    const double omega_h = simulation.fastest_mode().omega * simulation.step_size();
    fmt::print("{} rows, {} steps of {:g} s{} in {:.3g} s ({:.3g} us and {:.3g} evaluations per step){}\nresults in {}\n",
               recorder.rows(), simulation.index() - 1, simulation.step_size(),
               halving ? fmt::format(", {} in all runs,", outcome.steps) : "", outcome.wall_time,
               1e6 * outcome.wall_time / static_cast<double>(std::max<uint64_t>(outcome.steps, 1)),
               static_cast<double>(simulation.end_of_step().passes()) / own_steps,
               omega_h > 0 ? fmt::format(", omega*h = {:.3g}", omega_h) : "", folder.path().string());
}

/// What one command works on: the model, built and checked, before anything is written.
struct Bench {
    explicit Bench(const RunRequest& request)
        : plugins(request.plugins),
          model(prepare(request, plugins)),
          simulation(model, plugins),
          selection(selected_channels(model, simulation)) {
        if (model.simulation.tolerance) halving.emplace(model, plugins, selection);
    }
    static Model prepare(const RunRequest& request, const Plugins& plugins) {
        Model model = read_model(request.model, plugins.catalogue(), request.overrides);
        if (model.simulation.tolerance && !request.force) model = start_stable(std::move(model), plugins);
        print_warnings(model);
        return model;
    }
    const Plugins plugins;
    const Model model;
    Simulation simulation;  ///< at the model's step
    const std::vector<int> selection;
    std::optional<Halving> halving;  ///< of a run to a tolerance
};

/// Closes the files, writes the summary, and tells how it went.
ExitCode conclude(const RunRequest& request, const Bench& bench, const Simulation& simulation, const ResultsFolder& folder,
                  Recorder& recorder, const Ending& ending) {
    const Halving* halving = bench.halving ? &*bench.halving : nullptr;
    recorder.finish();
    const Json summary = describe_run(bench.model, request, bench.plugins, simulation, recorder, ending.outcome, halving);
    write_json(folder.file("summary.json"), summary);

    warn_energy(recorder, bench.model, simulation);
    if (halving) {
        warn_skipped(*halving);
        warn_unresolved(*halving);
    } else {
        warn_ripple(recorder, bench.model);
    }
    if (ending.outcome.status == "failed") {
        throw Error(ending.code, fmt::format("{} ({} rows recorded in {})", ending.outcome.reason, recorder.rows(),
                                             folder.path().string()));
    }
    if (!request.quiet) print_report(recorder, bench.model, simulation, folder, ending.outcome, halving);
    if (ending.code != ExitCode::ok)
        tell(fmt::format("{} at t = {:g} s; {} rows are kept", ending.outcome.reason, ending.time, recorder.rows()));
    return ending.code;
}

}  // namespace

ExitCode run(const RunRequest& request) {
    const StopSignals signals;
    Bench bench(request);
    refuse_unstable(bench.simulation, request.force);

    const ResultsFolder folder(request.output.value_or(default_results_path(request.model)));
    const Attributes attributes = {{"title", bench.model.title}, {"version", DTTMM_VERSION}, {"model", bench.model.source}};
    const auto make_recorder = [&](Recorder::Rows rows) {
        return Recorder(folder, bench.simulation.channels(), bench.selection, attributes, rows);
    };
    if (bench.halving) {
        Halving& halving = *bench.halving;
        const Ending ending = halving.run(request.quiet);
        Recorder recorder = make_recorder(halving.has_estimates() ? Recorder::Rows::estimated : Recorder::Rows::plain);
        halving.write_to(recorder);
        return conclude(request, bench, halving.simulation(), folder, recorder, ending);
    }
    Recorder recorder = make_recorder(Recorder::Rows::plain);
    bench.simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    const Ending ending = advance_to_end(bench.simulation, request.quiet);
    return conclude(request, bench, bench.simulation, folder, recorder, ending);
}

void check(const RunRequest& request) {
    const Bench bench(request);
    const Model& model = bench.model;
    const Simulation& simulation = bench.simulation;
    const FastestMode& fastest = simulation.fastest_mode();
    const bool implicit = model.simulation.coupling == Coupling::implicit;
    fmt::print("{}: valid\n", request.model.string());
    int equations = 0;
    for (const JointEquations& joint : simulation.end_of_step().joints()) equations += joint.lasting();
    fmt::print(
        "  {} ({} unknowns per step), {}{}, {} ({} equations), {}, {}\n", counted(model.bodies.size(), "body", "bodies"),
        6 * model.bodies.size(), model.nodes.empty() ? "" : counted(model.nodes.size(), "node", "nodes") + ", ",
        counted(model.elements.size(), "element", "elements"), counted(model.joints.size(), "joint", "joints"), equations,
        counted(model.loads.size(), "load", "loads"), counted(simulation.channels().size(), "channel", "channels"));
    const std::string damping =
        implicit && model.simulation.spectral_radius < 1
            ? fmt::format(" with numerical damping (spectral_radius = {:g})", model.simulation.spectral_radius)
            : "";
    fmt::print("  {} coupling{}, {} steps of {:g} s, a row every {} steps\n", implicit ? "implicit" : "explicit", damping,
               simulation.step_count() - 1, model.simulation.step, model.output.every);
    if (model.simulation.tolerance)
        fmt::print("  repeated at half the step until the results are within {:g} %\n", 100 * *model.simulation.tolerance);
    if (fastest.omega > 0)
        fmt::print("  fastest vibration {}: omega*h = {:.4g}{}\n", describe(fastest), fastest.omega * simulation.step_size(),
                   simulation.explicit_limit() ? ""
                   : model.nodes.empty()       ? " (the implicit coupling is stable at any)"
                                         : " (the implicit coupling is stable at any; masses inside networks not counted)");
    if (simulation.explicit_limit() && simulation.explicit_limit()->load > 0)
        fmt::print("  the explicit coupling is stable up to a step of {:.4g} s; at {:g} s: {}\n",
                   simulation.explicit_limit()->longest_step, simulation.step_size(), simulation.describe_speed());
    refuse_unstable(simulation, request.force);
}

namespace {

/// The value of a parameter that the model leaves out, as the model would write it.
std::string describe_default(const dttmm_parameter& parameter) {
    if (parameter.flags & DTTMM_PARAMETER_REQUIRED) return "required";
    if (std::isnan(parameter.default_value)) return "optional";
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (parameter.words[w].value == parameter.default_value)
            if (!std::isfinite(parameter.default_value) || parameter.flags & DTTMM_PARAMETER_WORDS_ONLY)
                return fmt::format("default {}", parameter.words[w].name);
    return fmt::format("default {:g}", parameter.default_value);
}

/// What it may be: a range, words, or both.
std::string describe_range(const dttmm_parameter& parameter) {
    std::string range;
    if (!(parameter.flags & DTTMM_PARAMETER_WORDS_ONLY)) {
        const double most = std::numeric_limits<double>::max();
        const bool has_least = parameter.minimum > -most, has_most = parameter.maximum < most;
        const bool is_positive = parameter.minimum == std::numeric_limits<double>::min();
        range = is_positive ? (has_most ? fmt::format("> 0 to {:g}", parameter.maximum) : "> 0")
                : has_most  ? fmt::format("{:g} to {:g}", parameter.minimum, parameter.maximum)
                : has_least ? fmt::format(">= {:g}", parameter.minimum)
                            : "any";
        if (parameter.flags & DTTMM_PARAMETER_INTEGER) range += ", whole";
    }
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        range += fmt::format("{}{}", range.empty() ? "" : " | ", parameter.words[w].name);
    return range;
}

std::string describe_unit(const dttmm_parameter& parameter) {
    const std::string unit = std::string_view(parameter.unit) == "1" ? "number" : parameter.unit;
    return parameter.count == 1 ? unit : fmt::format("{} x {}", parameter.count, unit);
}

void print_parameter(const dttmm_parameter& parameter) {
    const bool is_word = parameter.flags & DTTMM_PARAMETER_WORDS_ONLY;
    fmt::print("    {:<22} {:<14} {:<12} {:<20} {}\n", parameter.name, is_word ? "a word" : describe_unit(parameter),
               describe_default(parameter), describe_range(parameter), parameter.documentation);
}

}  // namespace

void print_elements(const std::vector<std::string>& files) {
    const Plugins plugins(files);
    for (const PluginLibrary& library : plugins.libraries()) {
        const dttmm_plugin& table = library.table();
        fmt::print("plugin {}: {} {}\n", library.name(), table.name, table.version);
        for (uint32_t t = 0; t < table.element_type_count; ++t) {
            const dttmm_element_type& type = table.element_types[t];
            fmt::print("\n  {} ({})  {}\n", type.name, type.ends == DTTMM_ENDS_AT ? "at" : "from, to",
                       type.documentation ? type.documentation : "");
            for (uint32_t p = 0; p < type.parameter_count; ++p) print_parameter(type.parameters[p]);
        }
        fmt::print("\n");
    }
}

}  // namespace dttmm
