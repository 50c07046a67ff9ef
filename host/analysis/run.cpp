// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "analysis/advance.h"
#include "analysis/first_step.h"
#include "analysis/halving.h"
#include "analysis/load_speed.h"
#include "analysis/machine_table.h"
#include "analysis/modal_machine.h"
#include "analysis/modes.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "coupling/stability.h"
#include "model/diagnostics.h"
#include "model/read_simulation.h"
#include "model/wording.h"
#include "record/recorder.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "record/warnings.h"
#include "step/simulation.h"

namespace dttmm::host {

namespace {

/// Loads that the step does not resolve; also for the sake of what is said about the energy later.
std::vector<FastLoad> warn_loads(const Model& model, const Simulation& simulation, Warnings& warnings) {
    const double tolerable = model.simulation.tolerance ? kTolerableExtrapolatedError : kTolerableLoadError;
    std::vector<FastLoad> fast = find_fast_loads(model, simulation, tolerable);
    for (const FastLoad& load : fast) warnings.add("load-too-fast", describe(load, model, simulation.step_size()));
    return fast;
}

/// Whether an element has a damper: a parameter called so that is not zero.
bool is_damped(const Element& element, const dttmm_element_type& type) {
    auto value = element.values.begin();
    for (uint32_t p = 0; p < type.parameter_count; ++p)
        for (uint32_t i = 0; i < type.parameters[p].count; ++i, ++value)
            if (std::string_view(type.parameters[p].name).find("damping") != std::string_view::npos && *value > 0)
                return true;
    return false;
}

/// A node without mass and damper takes its place under a load at once. Where the load is there from the start the node
/// jumps within the first step, and what the first rows say of its motion is by the length of that step.
void warn_jumps(const Model& model, const ElementCatalogue& catalogue, Warnings& warnings) {
    std::vector<bool> is_held(model.nodes.size());
    for (const Element& element : model.elements) {
        const dttmm_element_type& type = *catalogue.types[static_cast<size_t>(element.type)];
        if (type.ends != DTTMM_ENDS_AT && !is_damped(element, type)) continue;
        for (const Attachment& end : element.ends)
            if (end.node >= 0) is_held[static_cast<size_t>(end.node)] = true;
    }
    for (const Load& load : model.loads) {
        if (load.on.node < 0 || is_held[static_cast<size_t>(load.on.node)] || load.signal.value(0) == 0) continue;
        const Node& node = model.nodes[static_cast<size_t>(load.on.node)];
        if (node.fixed.all()) continue;
        warnings.add(
            "load-jumps",
            fmt::format("{}: at the start this load is {:g} {} on node \"{}\", which has neither mass nor damper: it "
                        "jumps within the first step, and its first velocities and accelerations depend on the step. "
                        "Let the load rise, or give the node a mass or its elements damping",
                        load.place, load.signal.value(0), load.is_moment ? "N m" : "N", node.name));
    }
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
void refuse_unstable(const Simulation& simulation, bool force, Warnings& warnings) {
    if (!simulation.explicit_limit()) return;
    const ExplicitLimit& limit = *simulation.explicit_limit();
    if (limit.load >= kExplicitLimit && !force)
        throw Error(ExitCode::numerical_failure,
                    fmt::format("the explicit coupling would diverge at a step of {:.6g} s: {}; use --step \"{:.12g} s\", "
                                "--coupling implicit, or --force to run anyway",
                                simulation.step_size(), simulation.describe_speed(),
                                divide_step(simulation.step_size(), 0.9 * limit.longest_step)));
    if (limit.load > 0.8 * kExplicitLimit)
        warnings.add("near-explicit-limit",
                     fmt::format("{}: {} the limit of the explicit coupling", simulation.describe_speed(),
                                 limit.load < kExplicitLimit ? "near" : "beyond"));
}

/// A run to a tolerance need not be told a stable step: it starts from one, its rows where they were.
Model start_stable(Model model, const Plugins& plugins, Warnings& warnings) {
    if (model.simulation.coupling != Coupling::explicit_) return model;
    const auto limit = Simulation(model, plugins).explicit_limit();
    if (!limit || limit->load < kExplicitLimit) return model;
    const double step = divide_step(model.simulation.step, 0.9 * limit->longest_step);
    const double every = model.output.every * std::round(model.simulation.step / step);
    if (step < kShortestStep || every > std::numeric_limits<int>::max()) return model;
    warnings.note("stable-first-step",
                  fmt::format("the explicit coupling would diverge at a step of {:g} s; beginning with {:.12g} s",
                              model.simulation.step, step));
    model.simulation.step = step;
    model.output.every = static_cast<int>(every);
    return model;
}

/// Of every owner's forces and moments, "<owner>.<quantity>", the direction with the largest peak, as a channel.
std::map<std::string, int> find_largest_directions(const Recorder& recorder) {
    std::map<std::string, int> largest;
    for (int c = 1; c < static_cast<int>(recorder.channels().size()); ++c) {
        const Channel& channel = recorder.channels()[static_cast<size_t>(c)];
        if (channel.quantity() != "force" && channel.quantity() != "moment") continue;
        const auto [entry, is_new] = largest.emplace(std::string(channel.without_axis()), c);
        if (!is_new && recorder.statistics(c).peak > recorder.statistics(entry->second).peak) entry->second = c;
    }
    return largest;
}

/// One line per element and joint: the direction of its largest force or moment, when it peaks and where it ends. Of many
/// those with the largest forces, the largest first.
void print_forces(const Recorder& recorder, const Model& model) {
    constexpr size_t kMostOwners = 30;
    std::vector<std::string> owners;
    for (const Element& element : model.elements) owners.push_back(element.name);
    for (const Joint& joint : model.joints) owners.push_back(joint.name);
    const std::map<std::string, int> largest = find_largest_directions(recorder);
    const size_t count = owners.size();
    if (count > kMostOwners) {
        const auto peak = [&](const std::string& owner) {
            const auto found = largest.find(owner + ".force");
            return found == largest.end() ? 0 : recorder.statistics(found->second).peak;
        };
        std::ranges::stable_sort(owners, std::greater(), peak);
        owners.resize(kMostOwners);
    }
    size_t width = model.joints.empty() ? 7 : 14;
    for (const std::string& owner : owners) width = std::max(width, owner.size());
    fmt::print("{:<{}}  {:>12}  {:>13}  {:>10}  {:>13}\n", model.joints.empty() ? "element" : "element, joint", width, "",
               "peak", "at [s]", "final");
    for (const std::string& owner : owners) {
        for (const char* quantity : {"force", "moment"}) {
            const auto found = largest.find(fmt::format("{}.{}", owner, quantity));
            if (found == largest.end()) continue;
            const Channel& channel = recorder.channels()[static_cast<size_t>(found->second)];
            const ChannelStatistics& statistics = recorder.statistics(found->second);
            if (statistics.peak == 0 && quantity != std::string_view("force")) continue;
            fmt::print("{:<{}}  {:>12}  {:>13}  {:>10.5g}  {:>13}\n", owner, width, channel.name.substr(owner.size() + 1),
                       fmt::format("{:.5g} {}", statistics.peak, channel.unit), statistics.peak_time,
                       fmt::format("{:.5g} {}", statistics.final, channel.unit));
        }
    }
    if (count > kMostOwners) fmt::print("and {} with smaller forces; summary.json has all of them\n", count - kMostOwners);
}

/// The energy ledger of a run, as far as its rows tell.
struct Ledger {
    double turned_over = 0;                                  ///< largest of its items [J]
    double residual = 0, most = 0, residual_at_the_end = 0;  ///< largest magnitude, largest, last [J]
    double rounding = 0;                                     ///< below this the ledger tells nothing [J]
};

/// Of an element or joint, or of a section of one.
bool is_force(const Channel& channel) { return channel.quantity().ends_with("force"); }

/// Largest force of the elements and joints recorded [N].
double find_largest_force(const Recorder& recorder) {
    double largest = 0;
    for (size_t c = 1; c < recorder.channels().size(); ++c)
        if (is_force(recorder.channels()[c])) largest = std::max(largest, recorder.statistics(static_cast<int>(c)).peak);
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
        if (channel.of != Channel::Of::energy) continue;
        const ChannelStatistics& statistics = recorder.statistics(static_cast<int>(c));
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

/// Why a run made or lost energy. A vibration that the step does not resolve appears as one of about pi − 4/(omega h) rad
/// per step; a body that turns by 4/(omega h) per step, give or take, can feed it, however slow that is.
std::string describe_energy_fault(const Model& model, const Simulation& simulation, const std::vector<FastLoad>& fast) {
    if (simulation.explicit_limit() && simulation.explicit_limit()->load > 0.8 * kExplicitLimit)
        return fmt::format("near the limit of the explicit coupling or beyond it, {}", simulation.describe_speed());
    if (!fast.empty())
        return fmt::format("the load at {} is too fast for the step of {:g} s; use --step \"{:.12g} s\"",
                           model.loads[fast.front().index].place, simulation.step_size(), fast.front().step);
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
    if (!model.nodes.empty())
        return fmt::format(
            "the step of {:g} s is too long for the fastest vibration, of the bodies ({}) or inside the "
            "networks; try a shorter one, or a spectral_radius of 0.9",
            step, simulation.describe_speed());
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

/// The force of an element that goes up and down from step to step: a vibration faster than the step. Only rows of every
/// step show it. The energy balance does not: a stiff element holds next to no energy.
void warn_ripple(const Recorder& recorder, const Model& model, Warnings& warnings) {
    if (model.output.every != 1) return;
    constexpr double kTolerated = 0.1;  // of the element's largest force
    // Beside the largest force of the machine this is rounding: it moves what is held by 1e-16 of its size
    const double rounding = 1e-8 * find_largest_force(recorder);
    struct Force {
        double peak = 0, ripple = 0;  // largest of its directions [N]
    };
    std::unordered_map<std::string_view, Force> forces;  // by element
    for (size_t c = 1; c < recorder.channels().size(); ++c) {
        const Channel& channel = recorder.channels()[c];
        if (channel.of != Channel::Of::element || channel.quantity() != "force") continue;
        Force& force = forces[channel.owner()];
        const ChannelStatistics& statistics = recorder.statistics(static_cast<int>(c));
        force = {std::max(force.peak, statistics.peak), std::max(force.ripple, statistics.ripple)};
    }
    double worst = kTolerated;
    std::string warning;
    for (const Element& element : model.elements) {
        const auto [peak, ripple] = forces[element.name];
        if (ripple <= worst * peak || ripple <= rounding) continue;
        worst = ripple / peak;
        warning = fmt::format(
            "the force of element \"{}\" alternates from step to step by {:.3g} N and is {:.3g} N at most: a "
            "vibration that the step of {:g} s does not follow. It rings for ever unless something damps it, and its peaks "
            "are not those of the machine; try a shorter step{}",
            element.name, ripple, peak, model.simulation.step,
            model.simulation.coupling == Coupling::implicit ? ", damping of the element, or a spectral_radius of 0.9"
                                                            : " or damping of the element");
    }
    if (!warning.empty()) warnings.add("alternating-force", warning);
}

/// Elements beyond what their laws hold for.
void warn_limits(const Simulation& simulation, Warnings& warnings) {
    for (const Limit& limit : simulation.limits()) {
        if (limit.most <= 1) continue;
        const Channel& channel = simulation.channels()[limit.channel];
        warnings.add("beyond-limit",
                     fmt::format("\"{}\" is {:.3g} at t = {:g} s: beyond 1 the law of element \"{}\" does not hold and its "
                                 "results are wrong; \"dttmm elements\" says what limits it",
                                 channel.name, limit.most, limit.time, limit.element));
    }
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

void print_report(const Recorder& recorder, const Model& model, const Simulation& simulation, const ResultsFolder& folder,
                  const Outcome& outcome, const Halving* halving) {
    if (!model.title.empty()) fmt::print("{}\n", model.title);
    print_forces(recorder, model);
    if (halving && halving->has_estimates()) print_halving(*halving);
    const auto own_steps = static_cast<double>(std::max<uint64_t>(simulation.index(), 1));
    const double omega_h = simulation.fastest_mode().omega * simulation.step_size();
    fmt::print("{} rows, {} steps of {:g} s{} in {:.3g} s ({:.3g} us and {:.3g} evaluations per step){}\nresults in {}{}\n",
               recorder.rows(), simulation.index() - 1, simulation.step_size(),
               halving ? fmt::format(", {} in all runs,", outcome.steps) : "", outcome.wall_time,
               1e6 * outcome.wall_time / static_cast<double>(std::max<uint64_t>(outcome.steps, 1)),
               static_cast<double>(simulation.end_of_step().passes()) / own_steps,
               omega_h > 0 ? fmt::format(", omega*h = {:.3g}", omega_h) : "", folder.path().string(),
               folder.replaced().empty() ? "" : fmt::format(" (those of {} are replaced)", folder.replaced()));
}

/// What one command works on: the model, built and checked, before anything is written.
struct Bench {
    explicit Bench(const Request& request)
        : plugins(request.plugins),
          model(prepare(request)),
          simulation(model, plugins),
          selection(selected_channels(model, simulation)) {
        warn_jumps(model, plugins.catalogue(), warnings);
        if (model.simulation.tolerance)
            halving.emplace(model, plugins, selection);
        else
            fast_loads = warn_loads(model, simulation, warnings);
    }
    Model prepare(const Request& request) {
        Model read = read_model(request.model, plugins.catalogue(), request.overrides);
        has_chosen_step = read.simulation.step == 0;
        read = choose_step(std::move(read), plugins);
        if (read.simulation.tolerance && !request.force) read = start_stable(std::move(read), plugins, warnings);
        warnings.add(read.warnings);
        return read;
    }
    Warnings warnings;
    const Plugins plugins;
    bool has_chosen_step = false;  ///< neither file nor options give one
    const Model model;
    Simulation simulation;  ///< at the model's step
    const std::vector<int> selection;
    std::optional<Halving> halving;    ///< of a run to a tolerance
    std::vector<FastLoad> fast_loads;  ///< at the step of the results
};

/// Closes the files, writes the summary, and tells how it went.
ExitCode conclude(const Request& request, Bench& bench, const Simulation& simulation, const ResultsFolder& folder,
                  Recorder& recorder, const Ending& ending) {
    const Halving* halving = bench.halving ? &*bench.halving : nullptr;
    recorder.finish();
    if (halving) bench.fast_loads = warn_loads(bench.model, simulation, bench.warnings);
    warn_energy(recorder, bench.model, simulation, bench.fast_loads, bench.warnings);
    warn_limits(simulation, bench.warnings);
    if (halving) {
        warn_skipped(*halving, bench.warnings);
        warn_unresolved(*halving, bench.warnings);
    } else {
        warn_ripple(recorder, bench.model, bench.warnings);
    }
    bench.warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& out) {
        write_run(out, bench.model, request, bench.plugins, simulation, recorder, ending.outcome, halving, bench.warnings);
    });
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

ExitCode run(const Request& request) {
    const StopSignals signals;
    Bench bench(request);
    refuse_unstable(bench.simulation, request.force, bench.warnings);

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

namespace {

/// Frequencies of a larger model take `dttmm modes` longer than a check should.
constexpr size_t kMostChecked = 1000;

/// A file without [simulation], with dofs, or with elements that only the modes can have is no fault: it is not for a run.
bool is_for_modes_only(const Request& request, const Plugins& plugins) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    read_model(request.model, plugins.catalogue(), overrides);
    try {
        Model model = read_model(request.model, plugins.catalogue(), request.overrides);
        if (model.simulation.step == 0) model.simulation.step = kShortestStep;  // networks want one, whichever
        const Networks networks(model, plugins);
    } catch (const Error&) {
        return true;
    }
    return false;
}

/// The lowest natural frequency above zero, in words. Throws Error where there are no modes.
std::string describe_lowest(const Model& model, const Plugins& plugins) {
    if (model.bodies.size() + model.nodes.size() > kMostChecked)
        return fmt::format("natural frequencies not looked for, as there are more than {} bodies and nodes", kMostChecked);
    ModalMachine machine(model, plugins);
    const std::vector<ModalInstance::Mode> modes = machine.find_modes();
    for (const ModalInstance::Mode& mode : modes)
        if (mode.numbers.frequency > 0) return fmt::format("lowest natural frequency {:.6g} Hz", mode.numbers.frequency);
    return fmt::format("no natural frequency above 0 Hz among the first {}", modes.size());
}

std::string indented(std::string text) {
    for (size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) text.insert(at + 1, "    ");
    return text;
}

void print_parts(const Model& model) {
    fmt::print("  {}, {}, {}, {}, {}\n", counted(model.bodies.size(), "body", "bodies"),
               counted(model.nodes.size(), "node", "nodes"), counted(model.elements.size(), "element", "elements"),
               counted(model.joints.size(), "joint", "joints"), counted(model.loads.size(), "load", "loads"));
}

void print_run(const Bench& bench) {
    const Model& model = bench.model;
    const Simulation& simulation = bench.simulation;
    const FastestMode& fastest = simulation.fastest_mode();
    const bool implicit = model.simulation.coupling == Coupling::implicit;
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
    fmt::print("  {} coupling{}, {} of {:g} s{}, a row every {}\n", implicit ? "implicit" : "explicit", damping,
               counted(simulation.step_count() - 1, "step", "steps"), model.simulation.step,
               bench.has_chosen_step ? " (chosen, as no step is given)" : "",
               model.output.every == 1 ? "step" : fmt::format("{} steps", model.output.every));
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
}

}  // namespace

void check(const Request& request) {
    const Plugins plugins(request.plugins);
    std::optional<Bench> bench;
    std::string no_run, no_modes, lowest;
    std::exception_ptr run_fault;
    try {
        bench.emplace(request);
    } catch (const Error& error) {
        if (!is_for_modes_only(request, plugins)) throw;
        no_run = error.what();
        run_fault = std::current_exception();
    }
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model for_modes = read_model(request.model, plugins.catalogue(), overrides);
    try {
        lowest = describe_lowest(for_modes, plugins);
    } catch (const Error& error) {
        if (!bench) std::rethrow_exception(run_fault);
        no_modes = error.what();
    }
    const Model& model = bench ? bench->model : for_modes;
    Warnings own;
    Warnings& warnings = bench ? bench->warnings : own;
    warnings.add(model.warnings);

    fmt::print("{}: valid\n  good for {}\n", request.model.string(),
               !bench             ? "modes and frf"
               : no_modes.empty() ? "run, modes and frf"
                                  : "run");
    if (!bench) fmt::print("  not for run: {}\n", indented(no_run));
    if (!no_modes.empty()) fmt::print("  not for modes and frf: {}\n", indented(no_modes));
    if (bench)
        print_run(*bench);
    else
        print_parts(model);
    if (!lowest.empty()) {
        fmt::print("  {}\n", lowest);
        warn_preload(model, warnings);
    }
    fmt::print("{}", describe_machine(model, plugins.catalogue()));
    if (bench) refuse_unstable(bench->simulation, request.force, warnings);
    warnings.print_rest("");
}

}  // namespace dttmm::host
