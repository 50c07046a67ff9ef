// SPDX-License-Identifier: BSD-3-Clause
#include "study/case_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "analysis/advance.h"
#include "analysis/damped_modes.h"
#include "analysis/modal_session.h"
#include "analysis/mode_energies.h"
#include "analysis/response.h"
#include "analysis/run.h"
#include "analysis/run_warnings.h"
#include "analysis/session.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "analysis/sweep_table.h"
#include "model/error.h"
#include "model/index.h"
#include "record/results_folder.h"
#include "study/figures.h"

namespace dttmm::host {

namespace {

/// What a case found: names, units and numbers, in the order in which it found them.
struct Found {
    std::vector<Column> columns;
    std::vector<double> values;
    size_t warnings = 0;

    void add(const std::string& name, const std::string& unit, double value) {
        columns.push_back({name, unit});
        values.push_back(value);
    }
};

Found run_history(const Request& request, const StudyPlan& plan, const std::optional<std::filesystem::path>& kept) {
    Session session(request);
    session.refuse_unstable(request.run.force);
    std::optional<std::vector<int>> selection;
    if (session.halving) selection = session.selection;
    HistoryFigures figures(plan.figures, session.simulation.channels(), selection);
    const TakeRow take = [&](std::span<const double> row) { figures.take_row(row); };
    const auto found = [&] { return Found{figures.columns(), figures.values(), session.warnings.all().size()}; };
    const auto judge = [](const Ending& ending) {
        if (ending.code != ExitCode::ok) throw Error(ending.code, ending.outcome.reason);
    };
    if (kept) {
        judge({{}, run(request, session, ResultsFolder(*kept), take)});
        return found();
    }
    if (session.halving) {
        judge(session.halving->run(true));
        session.halving->write_to([&](std::span<const double> values, std::span<const double>) { take(values); });
        warn_of_run(session, session.halving->simulation(), session.halving->statistics());
        return found();
    }
    Recorder recorder(session.simulation.channels(), counts_in_summary);
    session.simulation.record_to([&](std::span<const double> row) {
        recorder.close_row(row);
        take(row);
    });
    judge(advance_to_end(session.simulation, true));
    warn_of_run(session, session.simulation, recorder);
    return found();
}

/// Frequencies; damping with --damped; shares of the kinetic energy where a pattern asks for them.
Found find_frequencies(const Request& request, const Plugins& plugins, const std::vector<std::string>& patterns) {
    Warnings warnings;
    ModalSession session(request, plugins, warnings);
    const std::vector<ModalInstance::Mode> modes = session.find_modes();
    Found found;
    for (const ModalInstance::Mode& mode : modes)
        found.add(fmt::format("mode{}.frequency", found.values.size() + 1), "Hz", mode.numbers.frequency);
    if (request.modes.is_damped && !modes.empty()) {
        const double below = range_of_damped(session.model, modes);
        size_t number = 0;
        for (const ModalInstance::Damped& one : find_damped_modes(session.machine, modes, below, warnings).modes) {
            ++number;
            found.add(fmt::format("damped{}.frequency", number), "Hz", std::abs(one.s.imag()) / (2 * std::numbers::pi));
            found.add(fmt::format("damped{}.damping_ratio", number), "1",
                      std::abs(one.s) > 0 ? -one.s.real() / std::abs(one.s) : 0);
        }
    }
    const bool has_shares =
        std::ranges::any_of(patterns, [](const std::string& text) { return text.find(".share") != text.npos; });
    for (size_t m = 0; has_shares && m < modes.size(); ++m) {
        const ModeEnergies energies = energies_of(session.model, session.machine, modes[m], as_whole<uint32_t>(m));
        for (size_t b = 0; b < energies.bodies.size(); ++b)
            for (Eigen::Index d = 0; d < 6; ++d)
                found.add(
                    fmt::format("mode{}.share.{}.{}", m + 1, session.model.bodies[b].name, direction_names()[as_size(d)]),
                    "1", energies.bodies[b].world(d));
    }
    found.warnings = warnings.all().size();
    return found;
}

/// Its files go into the case's folder, which stays only where it is to be kept.
Found find_response_of_case(const Request& asked, const Plugins& plugins, const std::filesystem::path& folder, bool keeps) {
    Request request = asked;
    request.output = folder;
    Warnings warnings;
    ResponseFindings findings;
    const ExitCode code = find_steady_response(request, plugins, warnings, findings);
    std::error_code fault;
    if (!keeps) std::filesystem::remove_all(folder, fault);
    if (code != ExitCode::ok) throw Error(code, "stopped");
    Found found;
    for (const ResponseFindings::Largest& one : findings.largest) {
        found.add(one.name + ".largest", one.unit, one.size);
        found.add(one.name + ".frequency", "Hz", one.frequency);
        if (one.rpm) found.add(one.name + ".rpm", "rpm", *one.rpm);
    }
    for (const ResponseFindings::Level& level : findings.levels) found.add(level.name + ".rms", level.unit, level.rms);
    found.warnings = warnings.all().size();
    return found;
}

Found find(const Request& request, const StudyPlan& plan, const Plugins& plugins, const std::filesystem::path& folder) {
    if (plan.command == "modes") return find_frequencies(request, plugins, plan.figures);
    if (plan.command == "response") return find_response_of_case(request, plugins, folder, plan.keeps);
    return run_history(request, plan, plan.keeps ? std::optional(folder) : std::nullopt);
}

/// The numbers of the study's columns, in their order; those that the case does not have are NaN.
std::vector<double> pick(const Found& found, const std::vector<Column>& columns) {
    std::vector<double> values(columns.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t c = 0; c < columns.size(); ++c) {
        const auto same = std::ranges::find(found.columns, columns[c].name, &Column::name);
        if (same != found.columns.end()) values[c] = found.values[as_size(same - found.columns.begin())];
    }
    return values;
}

}  // namespace

Request request_of(const StudyPlan& plan, size_t index) {
    Request request = plan.request;
    request.quiet = true;
    for (const auto& [name, value] : plan.cases.settings(index)) give(request, option("--set"), name + "=" + value);
    return request;
}

std::vector<Column> find_figures(const StudyPlan& plan, const Plugins& plugins) {
    if (plan.command == "run") {
        Session session(plan.request);
        std::optional<std::vector<int>> selection;
        if (session.halving) selection = session.selection;
        return HistoryFigures(plan.figures, session.simulation.channels(), selection).columns();
    }
    const std::filesystem::path scratch =
        std::filesystem::temp_directory_path() / fmt::format("dttmm-study-{}", Journal::make_name());
    StudyPlan trial = plan;
    trial.keeps = false;
    trial.request.quiet = true;
    const std::vector<Column> all = find(trial.request, trial, plugins, scratch).columns;
    std::vector<Column> chosen;
    for (const size_t c : choose_figures(plan.figures, all)) chosen.push_back(all[c]);
    return chosen;
}

CaseOutcome run_case(const StudyPlan& plan, size_t index, const Plugins& plugins, const std::filesystem::path& folder) {
    CaseOutcome outcome;
    try {
        const Found found = find(request_of(plan, index), plan, plugins, folder / case_name(index));
        outcome.status = "completed";
        outcome.warnings = found.warnings;
        outcome.figures = pick(found, plan.columns);
        // Of a run the figures are those that were asked for; else a pattern may have passed some over
        outcome.unlisted =
            (plan.command == "run" || plan.figures.empty()) && std::ranges::any_of(found.columns, [&](const Column& column) {
                return std::ranges::find(plan.columns, column.name, &Column::name) == plan.columns.end();
            });
    } catch (const Error& error) {
        if (StopSignals::requested()) throw;
        if (error.code() == ExitCode::input_output) throw;  // of the disk or the study's folder, no fault of the case
        outcome = {"failed", fmt::format("exit code {}: {}", static_cast<int>(error.code()), error.what())};
    }
    return outcome;
}

}  // namespace dttmm::host
