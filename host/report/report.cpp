// SPDX-License-Identifier: BSD-3-Clause
#include "report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "analysis/recorded_run.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/results_folder.h"
#include "report/page.h"
#include "report/results.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargePage = 20'000'000;  // bytes; browsers take it, mail does not

void refuse_foreign(const fs::path& path) {
    std::error_code fault;
    if (!fs::exists(path, fault)) return;
    if (fs::is_directory(path, fault))
        throw Error(ExitCode::input_output,
                    fmt::format("{}: is a folder; give the name of a file with -o, e.g. -o report.html", path.string()));
    std::string beginning(std::string_view(kReportBeginning).size(), ' ');
    std::ifstream(path, std::ios::binary).read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
    if (beginning != kReportBeginning && fs::file_size(path, fault) > 0)
        throw Error(ExitCode::input_output,
                    fmt::format("{}: is there and is no report of dttmm; choose another file with -o", path.string()));
}

/// Of the first results that have one; else their folder.
std::string title_of(const Json& results) {
    const auto title_in = [](const Json& object, const char* name) {
        return object.is_object() && object.contains(name) && object[name].is_string() ? object[name].get<std::string>()
                                                                                       : "";
    };
    for (const Json& one : results)
        for (const std::string& title : {title_in(one["summary"], "title"), title_in(one, "title_of_cases")})
            if (!title.empty()) return title;
    return results.front()["path"];
}

bool has_bodies_or_nodes(const Json& result) {
    const Json& model = result["model"];
    const auto has = [&](const char* table) { return model.contains(table) && !model[table].empty(); };
    return model.is_object() && (has("bodies") || has("nodes"));
}

}  // namespace

ExitCode make_report(const Request& request) {
    const fs::path path = request.output ? *request.output : path_beside(request.words.front(), ".html");
    refuse_foreign(from_start(path));
    refuse_repeated_results(request.words);
    ReportChoice choice;
    choice.patterns = split_at_commas(request.spectrum.channels);
    if (request.response.points > 0) choice.most_points = static_cast<std::size_t>(request.response.points);
    Json results = Json::array();
    for (const std::string& words : request.words) results.push_back(describe_results(words, choice));
    const auto is_run = [](const Json& one) { return one["kind"] == "run"; };
    if (!choice.patterns.empty() && std::ranges::none_of(results, is_run))
        throw Error(ExitCode::usage,
                    fmt::format("--channels chooses among the channels of a run, and {} of a run; leave it "
                                "out",
                                results.size() == 1 ? "these results are not" : "none of these results is"));
    const bool has_machine = !request.pictures.is_flat && std::ranges::any_of(results, has_bodies_or_nodes);
    const std::string title = title_of(results);
    const Json data = {{"program", "dttmm " DTTMM_VERSION},
                       {"command_line", request.command_line},
                       {"title", title},
                       {"has_machine", has_machine},
                       {"results", std::move(results)}};
    const std::string page = make_page(title, data, has_machine);
    write_atomically(from_start(path), page);
    if (!request.quiet)
        fmt::print("{}: {:.2f} MB, {}{}\n", path.string(), static_cast<double>(page.size()) / 1e6,
                   counted(request.words.size(), "results folder", "results folders"),
                   page.size() > kLargePage ? "; --channels or fewer --points make it smaller" : "");
    return ExitCode::ok;
}

}  // namespace dttmm::host
