// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/sweep.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>
#include <thread>

#include "analysis/process_pool.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
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

struct Case {
    SweepCase parameters;
    std::filesystem::path folder;
    std::string status = "missing";  ///< "completed", "failed", "missing"
    std::string reason;
    Json summary;
};

Json read_summary(const std::filesystem::path& folder) {
    std::ifstream file(folder / "summary.json");
    return Json::parse(file, nullptr, false);
}

Request request_of(const Request& request, const Case& one) {
    Request own = request;
    for (const auto& [name, value] : one.parameters) give(own, option("--set"), name + "=" + value);
    return own;
}

std::vector<std::string> command_of(const Request& request, const Case& one) {
    std::vector<std::string> words = {"dttmm", "run", request.model, "--quiet", "-o", one.folder};
    const Request own = request_of(request, one);
    for (const auto& [option, value] : own.given) {
        if (!option->reaches_cases) continue;
        words.push_back(option->name());
        if (option->kind != Option::Kind::flag) words.push_back(value);
    }
    return words;
}

/// Judges a case by how its process ended and what it left.
void conclude(Case& one, int wait_status, const std::string& last_line) {
    one.summary = read_summary(one.folder);
    const bool exited_well = WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0;
    if (exited_well && one.summary.is_object() && one.summary.value("status", "") == "completed") {
        one.status = "completed";
        return;
    }
    one.status = "failed";
    if (WIFSIGNALED(wait_status)) {
        one.reason = fmt::format("killed by signal {} ({})", WTERMSIG(wait_status), strsignal(WTERMSIG(wait_status)));
    } else {
        one.reason = fmt::format("exit code {}{}{}", WEXITSTATUS(wait_status), last_line.empty() ? "" : ": ", last_line);
    }
}

/// A completed case of the same inputs, whole as far as the table needs it.
bool reuse(Case& one, const Model& model, const Request& request) {
    const Json summary = read_summary(one.folder);
    const auto has = [&](const char* key, bool (Json::*is)() const noexcept) {
        return summary.contains(key) && (summary[key].*is)();
    };
    const bool whole = summary.is_object() && has("status", &Json::is_string) && has("elements", &Json::is_object) &&
                       has("accelerations", &Json::is_object) && has("warnings", &Json::is_array) &&
                       std::filesystem::exists(one.folder / "history.csv") &&
                       std::filesystem::exists(one.folder / "history.h5");
    if (!whole || summary["status"] != "completed" || !summary.contains("inputs") ||
        summary["inputs"] != describe_inputs(model, request_of(request, one)))
        return false;
    one.status = "completed";
    one.summary = summary;
    return true;
}

/// Nodes and markers of a completed case that elements or loads act on.
std::set<std::string> used_places(const Json& model) {
    std::set<std::string> used;
    for (const auto& [name, element] : model.at("elements").items()) {
        if (element.contains("at")) used.insert(element["at"].begin(), element["at"].end());
        for (const char* end : {"from", "to"})
            if (element.contains(end)) used.insert(element[end].get<std::string>());
    }
    for (const Json& load : model.at("loads")) used.insert(load.at("on").get<std::string>());
    for (const auto& [name, body] : model.at("bodies").items()) used.erase(name);
    return used;
}

/// Cells of sweep.csv behind status, reason and warnings: forces of elements, accelerations of the places used.
void add_results(const Json& summary, std::vector<SweepCell>& cells) {
    const auto add = [&](const std::string& owner, const Json& quantities, const char* quantity, const char* unit,
                         std::initializer_list<const char*> statistics) {
        for (const auto& [axis, numbers] : quantities.at(quantity).items())
            for (const char* statistic : statistics)
                cells.push_back({{fmt::format("{}.{}.{}.{}", owner, quantity, axis, statistic), unit},
                                 numbers.at(statistic).get<double>()});
    };
    for (const auto& [owner, quantities] : summary.at("elements").items())
        if (quantities.contains("force")) add(owner, quantities, "force", "N", {"peak", "final"});
    const std::set<std::string> used = used_places(summary.at("model"));
    for (const auto& [owner, quantities] : summary.at("accelerations").items())
        if (used.contains(owner)) add(owner, quantities, "acceleration", "m/s^2", {"peak"});
}

/// Number of warnings of a case as text; empty where it left no summary.
std::string count_warnings(const Case& one) {
    return one.summary.is_object() && one.summary.contains("warnings") ? std::to_string(one.summary["warnings"].size()) : "";
}

/// The codes of all warnings of the cases, and how many cases have any: ", 2 with warnings (energy-balance)".
std::string describe_warnings_of(const std::vector<Case>& cases) {
    size_t count = 0;
    std::set<std::string> codes;
    for (const Case& one : cases) {
        if (!one.summary.is_object() || !one.summary.contains("warnings") || one.summary["warnings"].empty()) continue;
        ++count;
        for (const Json& warning : one.summary["warnings"]) codes.insert(warning.value("code", ""));
    }
    return count == 0 ? "" : fmt::format(", {} with warnings ({})", count, fmt::join(codes, ", "));
}

/// What is known of the parameters of a case: of one that completed what it said, else what the sweep gave it.
std::vector<Parameter> parameters_of(const Case& one) {
    std::vector<Parameter> parameters;
    if (one.status == "completed" && one.summary.contains("model"))
        for (const auto& [name, value] : one.summary["model"]["parameters"].items())
            parameters.push_back({name, value.get<double>(), "", ""});
    for (const auto& [name, value] : one.parameters) parameters.push_back({name, parse_quantity(value).value, "", ""});
    return parameters;
}

std::string sweep_table(const std::vector<Case>& cases, const std::vector<Parameter>& parameters) {
    std::vector<SweepRow> rows;
    for (const Case& one : cases) {
        SweepRow& row = rows.emplace_back(SweepRow{parameters_of(one), {}});
        row.cells = {{{"status", ""}, one.status}, {{"reason", ""}, one.reason}, {{"warnings", ""}, count_warnings(one)}};
        if (one.status == "completed") add_results(one.summary, row.cells);
    }
    return make_sweep_table(parameters, rows);
}

/// Whether a case completed and has this element, with a force.
bool has_force(const Case& one, const std::string& element) {
    if (one.status != "completed") return false;
    const Json& all = one.summary.at("elements");
    return all.contains(element) && all.at(element).contains("force");
}

/// Largest of the peaks of an element's directions in a case [N].
double peak_force(const Case& one, const std::string& element) {
    double peak = 0;
    for (const auto& [axis, numbers] : one.summary.at("elements").at(element).at("force").items())
        peak = std::max(peak, numbers["peak"].get<double>());
    return peak;
}

/// Elements that have a force, unlike masses: of all cases that completed; if none did, all elements of the file.
std::vector<std::string> elements_with_forces(const std::vector<Case>& cases, const Model& model) {
    std::vector<std::string> names;
    for (const Case& one : cases) {
        if (one.status != "completed") continue;
        std::vector<std::string> own;
        for (const auto& [name, quantities] : one.summary.at("elements").items())
            if (quantities.contains("force")) own.push_back(name);
        merge_names(names, own);
    }
    if (std::ranges::find(cases, "completed", &Case::status) == cases.end())
        for (const Element& element : model.elements) names.push_back(element.name);
    return names;
}

/// What was varied and the peak force of every element, a line per case; of many the first.
void print_table(const std::vector<Case>& cases, const Model& model) {
    constexpr size_t kMostCases = 40, kMostElements = 8;
    const std::vector<std::string> names = elements_with_forces(cases, model);
    const size_t shown = std::min(cases.size(), kMostCases), elements = std::min(names.size(), kMostElements);
    std::vector<std::vector<std::string>> lines = {{"case"}};
    for (const auto& [name, value] : cases.front().parameters) lines.front().push_back(name);
    for (size_t e = 0; e < elements; ++e) lines.front().push_back(names[e] + " [N]");
    for (size_t i = 0; i < shown; ++i) {
        lines.push_back({std::to_string(i + 1)});
        for (const auto& [name, value] : cases[i].parameters) lines.back().push_back(value);
        for (size_t e = 0; e < elements; ++e) {
            const char* none = "-";
            lines.back().push_back(has_force(cases[i], names[e])    ? fmt::format("{:.5g}", peak_force(cases[i], names[e]))
                                   : cases[i].status == "completed" ? none
                                                                    : cases[i].status);
        }
    }
    std::vector<size_t> width(lines.front().size());
    for (const auto& line : lines)
        for (size_t c = 0; c < line.size(); ++c) width[c] = std::max(width[c], line[c].size());
    fmt::print("largest size of the force of every element; sweep.csv has its directions and the final values with sign\n");
    for (const auto& line : lines) {
        std::string text;
        for (size_t c = 0; c < line.size(); ++c) text += fmt::format("{}{:>{}}", c == 0 ? "" : "  ", line[c], width[c]);
        fmt::print("{}\n", text);
    }
    if (shown < cases.size() || elements < names.size())
        fmt::print("sweep.csv has all {} cases and {} elements\n", cases.size(), names.size());
}

void print_failures(const std::vector<Case>& cases) {
    for (const Case& one : cases) {
        if (one.status != "failed") continue;
        std::string at;
        for (const auto& [name, value] : one.parameters) at += fmt::format(" {}={}", name, value);
        tell(fmt::format("{}{}: {}", one.folder.filename().string(), at, one.reason));
    }
}

}  // namespace

namespace {

/// The parameters of the first case that can be read. A single case may be at fault; if all are, the fault of the first is
/// the sweep's.
std::vector<Parameter> read_parameters(const std::vector<Case>& cases, const Request& request, const Plugins& plugins) {
    std::exception_ptr first;
    for (const Case& one : cases) {
        try {
            return read_model(request.model, plugins.catalogue(), request_of(request, one).overrides).parameters;
        } catch (const Error&) {
            if (!first) first = std::current_exception();
        }
    }
    std::rethrow_exception(first);
}

}  // namespace

ExitCode run_sweep(const Request& request, const std::vector<SweepAxis>& axes) {
    const StopSignals signals;
    if (request.model == "-")
        throw Error(ExitCode::usage, "a sweep reads its model once per case: give a file instead of the standard input");
    const Plugins plugins(request.plugins);
    std::vector<Case> cases;
    for (SweepCase& parameters : make_grid(axes)) cases.push_back({std::move(parameters), {}, "missing", {}, {}});
    const Model model = read_model(request.model, plugins.catalogue(), request.overrides);
    check_axes(axes, model.parameters, request.overrides.parameters);
    refuse_column_names(model);
    const std::vector<Parameter> parameters = read_parameters(cases, request, plugins);

    const ResultsFolder folder(request.output.value_or(default_results_path(request.model)), Claim::keep);
    std::vector<Case*> todo;
    for (size_t i = 0; i < cases.size(); ++i) {
        cases[i].folder = folder.file(case_name(i));
        if (!reuse(cases[i], model, request)) todo.push_back(&cases[i]);
    }
    const size_t reused = cases.size() - todo.size();
    const int jobs = request.jobs > 0 ? request.jobs : as_int(std::max(1u, std::thread::hardware_concurrency()));
    ProgressBar progress(request.quiet ? -1 : 2);
    size_t done = reused;
    run_processes(
        todo.size(), jobs, [&](size_t i) { return command_of(request, *todo[i]); },
        [&](size_t i, int wait_status, const std::string& last_line) {
            conclude(*todo[i], wait_status, last_line);
            ++done;
        },
        [&] { progress.update(static_cast<double>(done), static_cast<double>(cases.size()), "cases"); });

    write_atomically(folder.file("sweep.csv"), sweep_table(cases, parameters));
    print_failures(cases);
    tell_of_earlier_cases(folder.path(), cases.size());
    const auto count = [&](const char* status) {
        return std::count_if(cases.begin(), cases.end(), [&](const Case& one) { return one.status == status; });
    };
    if (!request.quiet) print_table(cases, model);
    if (!request.quiet)
        fmt::print("{} of {} cases completed ({} of them reused), {} failed, {} not run{}\nresults in {}\n",
                   count("completed"), cases.size(), reused, count("failed"), count("missing"), describe_warnings_of(cases),
                   (folder.path() / "sweep.csv").string());
    if (StopSignals::requested()) return StopSignals::exit_code();
    return count("failed") > 0 ? ExitCode::cases_failed : ExitCode::ok;
}

}  // namespace dttmm::host
