// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "analysis/modal_session.h"
#include "analysis/response.h"
#include "analysis/stop_signals.h"
#include "analysis/sweep_table.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/progress_bar.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

/// A case of the sweep and what its response was.
struct RespondedCase {
    SweepCase values;
    std::string status = "missing", reason = {};  ///< "completed", "failed", "missing"
    size_t warnings = 0;
    ResponseFindings found = {};
};

Request request_of_case(const Request& request, const RespondedCase& one, const std::filesystem::path& folder) {
    Request own = request;
    for (const auto& [name, value] : one.values) give(own, option("--set"), name + "=" + value);
    own.output = folder;
    own.quiet = true;
    return own;
}

/// Parameters as far as they are known: all of a case that completed, else what the sweep gave it.
std::vector<Parameter> parameters_of_case(const RespondedCase& one) {
    std::vector<Parameter> parameters = one.found.parameters;
    if (parameters.empty())
        for (const auto& [name, value] : one.values) parameters.push_back({name, parse_quantity(value).value, "", ""});
    return parameters;
}

std::string response_sweep_table(const std::vector<RespondedCase>& cases, const std::vector<Parameter>& parameters) {
    std::vector<SweepRow> rows;
    for (const RespondedCase& one : cases) {
        SweepRow& row = rows.emplace_back(SweepRow{parameters_of_case(one), {}});
        const bool is_completed = one.status == "completed";
        row.cells = {{{"status", ""}, one.status},
                     {{"reason", ""}, one.reason},
                     {{"warnings", ""}, is_completed ? static_cast<double>(one.warnings) : std::nan("")}};
        if (!is_completed) continue;
        for (const auto& largest : one.found.largest) {
            row.cells.push_back({{largest.name + ".largest", largest.unit}, largest.size});
            row.cells.push_back({{largest.name + ".frequency", "Hz"}, largest.frequency});
            if (largest.rpm) row.cells.push_back({{largest.name + ".rpm", "rpm"}, *largest.rpm});
        }
        for (const auto& level : one.found.levels) row.cells.push_back({{level.name + ".rms", level.unit}, level.rms});
    }
    return make_sweep_table(parameters, rows);
}

/// Of all cases that completed.
std::vector<std::string> names_of(const std::vector<RespondedCase>& cases, const auto& list) {
    std::vector<std::string> names;
    for (const RespondedCase& one : cases) {
        std::vector<std::string> own;
        for (const auto& entry : one.found.*list) own.push_back(entry.name);
        if (one.status == "completed") merge_names(names, own);
    }
    return names;
}

/// "  0.0123 mm       52.1" of a curve, "  0.0123 mm" of an RMS value; the status of a case without results.
std::string describe_response(const RespondedCase& one, const std::string& name, bool is_level) {
    if (one.status != "completed") return fmt::format("{:>13}", one.status);
    if (is_level) {
        const auto level = std::ranges::find(one.found.levels, name, &ResponseFindings::Level::name);
        return level == one.found.levels.end() ? fmt::format("{:>13}", "-")
                                               : fmt::format("{:>13.6g} {}", level->rms, level->unit);
    }
    const auto largest = std::ranges::find(one.found.largest, name, &ResponseFindings::Largest::name);
    return largest == one.found.largest.end()
               ? fmt::format("{:>13}", "-")
               : fmt::format("{:>13.6g} {:<9} {:.6g}", largest->size, largest->unit, largest->frequency);
}

/// A line per curve and case, so that the cases of a curve stand below each other; of many the first.
void print_responses(const std::vector<RespondedCase>& cases) {
    constexpr size_t kMostLines = 60;
    const std::vector<std::string> curves = names_of(cases, &ResponseFindings::largest);
    const std::vector<std::string> levels = names_of(cases, &ResponseFindings::levels);
    std::string head = fmt::format("{:<11}", "case");
    for (const auto& [name, value] : cases.front().values) head += fmt::format(" {:>13}", name);
    size_t lines = 0;
    for (size_t c = 0; c < curves.size() + levels.size(); ++c) {
        const bool is_level = c >= curves.size();
        const std::string& name = is_level ? levels[c - curves.size()] : curves[c];
        if (lines + cases.size() > kMostLines && c > 0) {
            fmt::print("and {} more curves in sweep.csv\n", curves.size() + levels.size() - c);
            return;
        }
        fmt::print("{} of {}\n{} {:>13} {}\n", is_level ? "RMS" : "largest", name, head, "value",
                   is_level ? "" : "         at [Hz]");
        for (size_t i = 0; i < cases.size(); ++i, ++lines) {
            std::string line = case_name(i);
            for (const auto& [parameter, value] : cases[i].values) line += fmt::format(" {:>13}", value);
            fmt::print("{} {}\n", line, describe_response(cases[i], name, is_level));
        }
    }
}

size_t tell_failed_cases(const std::vector<RespondedCase>& cases) {
    size_t count = 0;
    for (size_t i = 0; i < cases.size(); ++i) {
        if (cases[i].status != "failed") continue;
        std::string at;
        for (const auto& [name, value] : cases[i].values) at += fmt::format(" {}={}", name, value);
        tell(fmt::format("{}{}: {}", case_name(i), at, cases[i].reason));
        ++count;
    }
    return count;
}

/// Of the model as the file has it.
std::vector<Parameter> known_parameters(const Request& request, const Plugins& plugins, const std::vector<SweepAxis>& axes) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model model = read_model(request.model, plugins.catalogue(), overrides);
    refuse_column_names(model);
    check_axes(axes, model.parameters, request.overrides.parameters);
    return model.parameters;
}

}  // namespace

ExitCode sweep_response(const Request& request, const std::vector<SweepAxis>& axes) {
    const StopSignals signals;
    if (request.model == "-")
        throw Error(ExitCode::usage, "a sweep reads its model once per case: give a file instead of the standard input");
    const Plugins plugins(request.plugins);
    std::vector<RespondedCase> cases;
    for (SweepCase& values : make_grid(axes)) cases.push_back({std::move(values)});
    const std::vector<Parameter> parameters = known_parameters(request, plugins, axes);
    Warnings warnings;
    ProgressBar progress(request.quiet ? -1 : 2);
    const ResultsFolder folder(results_path(request, "-response"), Claim::keep);
    std::exception_ptr fault;
    for (size_t i = 0; i < cases.size() && !StopSignals::requested(); ++i) {
        RespondedCase& one = cases[i];
        progress.update(static_cast<double>(i), static_cast<double>(cases.size()), "cases");
        Warnings own(warnings);
        try {
            const Request case_request = request_of_case(request, one, folder.file(case_name(i)));
            if (find_steady_response(case_request, plugins, own, one.found) == ExitCode::ok) one.status = "completed";
        } catch (const Error& error) {
            if (StopSignals::requested()) break;
            one.status = "failed";
            one.reason = error.what();
            if (!fault) fault = std::current_exception();
        }
        one.warnings = own.all().size();
    }
    // A single case may be at fault; if all are, the fault of the first is the sweep's
    if (fault && std::ranges::all_of(cases, [](const RespondedCase& one) { return one.status == "failed"; }))
        std::rethrow_exception(fault);
    write_atomically(folder.file("sweep.csv"), response_sweep_table(cases, parameters));
    const size_t failed = tell_failed_cases(cases);
    tell_of_earlier_cases(folder.path(), cases.size());
    const auto done = as_size(std::ranges::count(cases, "completed", &RespondedCase::status));
    if (!request.quiet) {
        print_responses(cases);
        fmt::print("{} of {} completed; results in {}\n", done, counted(cases.size(), "case", "cases"),
                   folder.describe("sweep.csv"));
    }
    warnings.print_rest("; summary.json of each case has its own");
    if (StopSignals::requested()) {
        tell(fmt::format("{}; {} of {} cases are kept", StopSignals::reason(), done, cases.size()));
        return StopSignals::exit_code();
    }
    return failed > 0 ? ExitCode::cases_failed : ExitCode::ok;
}

}  // namespace dttmm::host
