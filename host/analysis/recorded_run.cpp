// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/recorded_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/channels.h"
#include "record/file.h"
#include "record/history_file.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

/// A row may stand so far from its place, as share of the interval. Times are whole multiples of the step, rounded: a
/// million rows err by 1e-10. The phase at the end of the band errs by pi times this.
constexpr double kLargestShift = 1e-6;

[[noreturn]] void refuse(const fs::path& path, const std::string& text) {
    throw Error(ExitCode::input_output, fmt::format("{}: {}", path.string(), text));
}

/// The history of a results folder; says what else the folder is.
fs::path find_history(const fs::path& results) {
    std::error_code fault;
    if (!fs::exists(results, fault)) throw file_error(results, "cannot read", ENOENT);
    if (!fs::is_directory(results, fault)) {
        if (results.extension() == ".h5")
            refuse(results, "an HDF5 file is not read; name history.csv beside it, which has the same numbers");
        return results;
    }
    if (fs::exists(results / "history.csv", fault)) return results / "history.csv";
    if (fs::exists(results / "sweep.csv", fault))
        refuse(results,
               "these are the results of a sweep; name one of its cases, e.g. " + (results / "case-000001").string());
    for (const char* command : {"modes", "static", "frf", "response"})
        if (fs::exists(results / fmt::format("{}.csv", command), fault))
            refuse(results, fmt::format("these are results of `dttmm {}`; name those of `dttmm run`", command));
    if (fs::exists(results / "model.toml", fault))
        refuse(results, "this is the folder of a model; run it, and name the results of `dttmm run`");
    refuse(results, "there is no history.csv in it; name the results folder of `dttmm run`");
}

double parse_instant(const std::string& option, const std::string& text) {
    try {
        return parse_quantity(text, "s");
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("{} {}: {}", option, quote(text), error.what()));
    }
}

/// Not asked for, these are left out: an energy vibrates at twice the frequency, a quaternion is no vibration.
bool is_usual(const std::string& name) { return !name.starts_with("energy.") && name.find(".quaternion.") == name.npos; }

std::vector<int> choose(const std::vector<Column>& columns, const std::vector<std::string>& patterns) {
    std::vector<Channel> channels;
    for (const Column& column : columns) channels.emplace_back(column.name, column.unit);
    std::vector<int> chosen;
    try {
        chosen = select_channels(channels, patterns);
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("--channels: {}", error.what()));
    }
    std::erase_if(chosen, [&](int c) { return c > 0 && patterns.empty() && !is_usual(columns[as_size(c)].name); });
    return chosen;
}

/// The column of `name`; says which names are near.
int find_column(const std::vector<Column>& columns, const std::string& name) {
    const auto found = std::ranges::find(columns, name, &Column::name);
    if (found != columns.end()) return as_int(found - columns.begin());
    std::vector<std::string> names;
    for (const Column& column : columns) names.push_back(column.name);
    throw Error(ExitCode::usage,
                fmt::format("--speed: there is no channel {} in the history{}", quote(name), suggestion(name, names)));
}

}  // namespace

std::vector<std::string> split_at_commas(const std::vector<std::string>& texts) {
    std::vector<std::string> parts;
    for (const std::string& text : texts)
        for (std::size_t begin = 0; begin <= text.size();) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            if (end > begin) parts.push_back(text.substr(begin, end - begin));
            begin = end + 1;
        }
    return parts;
}

Json read_json_file(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return nullptr;
    Json json = Json::parse(file, nullptr, false);
    return json.is_discarded() ? Json(nullptr) : json;
}

RecordedRun::RecordedRun(const fs::path& results, Warnings& warnings)
    : warnings_(warnings),
      history_(find_history(results)),
      summary_(read_json_file(history_.parent_path() / "summary.json")) {
    if (!summary_.is_object() || summary_.value("format", "") != "dttmm-summary/1") summary_ = nullptr;
}

void RecordedRun::read(const std::vector<std::string>& patterns, const std::string& always, const std::string& from,
                       const std::string& to) {
    const HistoryFile file(history_);
    std::vector<int> chosen = choose(file.columns(), split_at_commas(patterns));
    const int extra = always.empty() ? -1 : find_column(file.columns(), always);
    std::vector<int> wanted = chosen;
    if (extra >= 0 && !std::ranges::binary_search(wanted, extra))
        wanted.insert(std::ranges::upper_bound(wanted, extra), extra);
    std::vector<std::vector<double>> columns = file.read(wanted);
    if (file.is_torn()) warnings_.note("torn-row", history_.string() + ": the last row is not whole and is left out");

    std::vector<double>& times = columns.front();
    if (times.size() < 2)
        refuse(history_, fmt::format("{}: a spectrum needs two or more", counted(times.size(), "row", "rows")));
    const double slack = kLargestShift * (times[1] - times[0]);
    const double first = from.empty() ? times.front() : parse_instant("--from", from);
    const double last = to.empty() ? times.back() : parse_instant("--to", to);
    if (!(first < last) || first < times.front() - slack || last > times.back() + slack)
        throw Error(ExitCode::usage,
                    fmt::format("the window from {:g} s to {:g} s is not within the record, which is from {:g} s to {:g} s",
                                first, last, times.front(), times.back()));
    const auto inside = [&](double t) { return t >= first - slack && t <= last + slack; };
    const auto begin = std::ranges::find_if(times, inside) - times.begin();
    const auto end = std::ranges::find_if(times.begin() + begin, times.end(), std::not_fn(inside)) - times.begin();
    for (std::vector<double>& column : columns) column = {column.begin() + begin, column.begin() + end};
    rows_ = as_size(end - begin);
    if (rows_ < 2)
        throw Error(
            ExitCode::usage,
            fmt::format("the window from {:g} s to {:g} s has {}: a spectrum needs two or more; widen --from and --to",
                        first, last, counted(rows_, "row", "rows")));
    check_spacing(times);
    for (std::size_t i = 1; i < wanted.size(); ++i) {
        const Column& column = file.columns()[as_size(wanted[i])];
        if (wanted[i] == extra) {
            always_ = columns[i];
            always_unit_ = column.unit;
        }
        if (!std::ranges::binary_search(chosen, wanted[i])) continue;
        channels_.push_back(column);
        values_.push_back(std::move(columns[i]));
    }
}

void RecordedRun::check_spacing(const std::vector<double>& times) {
    start_ = times.front();
    interval_ = (times.back() - start_) / static_cast<double>(rows_ - 1);
    for (std::size_t n = 1; n < rows_; ++n) {
        const double spacing = times[n] - times[n - 1];
        if (spacing > 0 && std::abs(times[n] - start_ - static_cast<double>(n) * interval_) <= kLargestShift * interval_ &&
            std::abs(spacing - interval_) <= kLargestShift * interval_)
            continue;
        // The place to name is where the spacing differs from the first one
        std::size_t odd = 1;
        while (odd + 1 < rows_ && std::abs(times[odd + 1] - times[odd] - (times[1] - times[0])) <= 1e-3 * interval_) ++odd;
        refuse(history_,
               fmt::format("rows are not equally spaced: {:g} s apart at first, {:g} s after t = {:g} s; choose an "
                           "equally spaced part with --from and --to, or run with an --output-step",
                           times[1] - times[0], times[std::min(odd + 1, rows_ - 1)] - times[odd], times[odd]));
    }
}

}  // namespace dttmm::host
