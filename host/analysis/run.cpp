// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>

#include "analysis/advance.h"
#include "analysis/material_fits.h"
#include "analysis/run_warnings.h"
#include "analysis/session.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "analysis/trace_file.h"
#include "model/index.h"
#include "record/recorder.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

/// Of every owner's forces and moments, "<owner>.<quantity>", the direction with the largest peak, as a channel.
std::map<std::string, int> find_largest_directions(const Recorder& recorder) {
    std::map<std::string, int> largest;
    for (int c = 1; c < as_int(recorder.channels().size()); ++c) {
        const Channel& channel = recorder.channels()[as_size(c)];
        if (channel.quantity() != "force" && channel.quantity() != "moment") continue;
        const auto [entry, is_new] = largest.emplace(channel.without_axis(), c);
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
            const Channel& channel = recorder.channels()[as_size(found->second)];
            const ChannelStatistics& statistics = recorder.statistics(found->second);
            if (statistics.peak == 0 && quantity != std::string_view("force")) continue;
            fmt::print("{:<{}}  {:>12}  {:>13}  {:>10.5g}  {:>13}\n", owner, width, channel.name().substr(owner.size() + 1),
                       fmt::format("{:.5g} {}", statistics.peak, channel.unit()), statistics.peak_time,
                       fmt::format("{:.5g} {}", statistics.final, channel.unit()));
        }
    }
    if (count > kMostOwners) fmt::print("and {} with smaller forces; summary.json has all of them\n", count - kMostOwners);
}

/// How the step was found, in one line.
void print_halving(const Halving& halving) {
    const Level& last = halving.levels().back();
    fmt::print(
        "error of the time steps at most {:.3g} % of the largest value of its kind (\"{}\"), asked for {:g} %; step {:g} s "
        "of {:g} s at "
        "first{}\n",
        100 * last.error, last.worst, 100 * halving.tolerance(), last.step, halving.first_step(),
        std::isnan(last.order) ? "" : fmt::format(", observed order {:.2f}", last.order));
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
               omega_h > 0 ? fmt::format(", {:.3g} steps per period of the fastest vibration (omega*h = {:.3g})",
                                         2 * M_PI / omega_h, omega_h)
                           : "",
               folder.describe());
}

/// Closes the files, writes the summary, and tells how it went.
ExitCode conclude(const Request& request, Session& session, const Simulation& simulation, const ResultsFolder& folder,
                  Recorder& recorder, const Ending& ending) {
    const Halving* halving = session.halving ? &*session.halving : nullptr;
    recorder.finish();
    warn_of_run(session, simulation, recorder);
    report_fits(session.model, session.plugins, session.warnings);
    session.warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& out) {
        write_run(out, session.model, request, session.plugins, simulation, recorder, ending.outcome, halving,
                  session.warnings);
    });
    if (ending.outcome.status == "failed") {
        throw Error(ending.code, fmt::format("{} ({} rows recorded in {})", ending.outcome.reason, recorder.rows(),
                                             folder.path().string()));
    }
    if (!request.quiet) print_report(recorder, session.model, simulation, folder, ending.outcome, halving);
    if (ending.code != ExitCode::ok)
        tell(fmt::format("{} at t = {:g} s; {} rows are kept", ending.outcome.reason, ending.time, recorder.rows()));
    return ending.code;
}

}  // namespace

ExitCode run(const Request& request) {
    const StopSignals signals;
    Session session(request);
    session.refuse_unstable(request.run.force);
    return run(request, session, ResultsFolder(request.output.value_or(default_results_path(request.model))), {});
}

ExitCode run(const Request& request, Session& session, const ResultsFolder& folder, const TakeRow& take) {
    const auto make_recorder = [&](Recorder::Rows rows) {
        const Attributes attributes = {
            {"title", session.model.title.c_str()}, {"version", DTTMM_VERSION}, {"model", session.model.source.c_str()}};
        return Recorder(folder, session.simulation.channels(), session.selection, attributes, rows,
                        session.halving ? Recorder::of_every_channel : counts_in_summary);
    };
    std::optional<TraceFile> trace;
    if (request.run.trace) trace.emplace(*request.run.trace);
    const auto trace_from = [&](Simulation& simulation) {
        if (trace) simulation.trace_to([&](const StepReport& report) { trace->write(simulation, report); });
    };
    if (session.halving) {
        Halving& halving = *session.halving;
        halving.prepare_with(trace_from);
        const Ending ending = halving.run(request.quiet);
        Recorder recorder = make_recorder(halving.has_estimates() ? Recorder::Rows::estimated : Recorder::Rows::plain);
        halving.write_to([&](std::span<const double> values, std::span<const double> errors) {
            recorder.close_selected_row(values, errors);
            if (take) take(values);
        });
        recorder.adopt_unselected(halving.statistics());
        return conclude(request, session, halving.simulation(), folder, recorder, ending);
    }
    trace_from(session.simulation);
    Recorder recorder = make_recorder(Recorder::Rows::plain);
    session.simulation.record_to([&](std::span<const double> row) {
        recorder.close_row(row);
        if (take) take(row);
    });
    const Ending ending = advance_to_end(session.simulation, request.quiet);
    return conclude(request, session, session.simulation, folder, recorder, ending);
}

}  // namespace dttmm::host
