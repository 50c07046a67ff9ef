// SPDX-License-Identifier: BSD-3-Clause
#include "report/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <set>
#include <span>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/channels.h"
#include "record/csv_file.h"
#include "record/file.h"
#include "record/history_file.h"
#include "record/results_folder.h"
#include "report/base64.h"
#include "report/curve_set.h"
#include "report/pictures.h"
#include "report/recorded_motion.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

/// Levels of summary.json, which has 8: JSON is written by a function that calls itself, and 100 000 levels end the process.
constexpr int kDeepest = 64;

constexpr std::size_t kMostRows = 2000;    // of a table; a page of more is no reading
constexpr std::size_t kMostCases = 20000;  // of a study, as points

/// Files whose rows are points of curves, the column over which they are drawn, and that of the first curve.
constexpr struct {
    const char *name, *x;
    std::size_t first;
} kCurveFiles[] = {{"response.csv", "frequency", 1}, {"frf.csv", "frequency", 1},         {"psd.csv", "frequency", 1},
                   {"spectrum.csv", "frequency", 1}, {"determinant.csv", "frequency", 1}, {"orders.csv", "time", 1}};

constexpr const char* kTableFiles[] = {
    "sweep.csv", "static.csv",        "members.csv",      "damped.csv",   "levels.csv",      "identified.csv", "rms.csv",
    "mac.csv",   "sensitivities.csv", "correlations.csv", "failures.csv", "sensitivity.csv", "optimise.csv",   "plan.csv"};

/// summary.json, or what commands on measured data call it.
constexpr const char* kSummaries[] = {"summary.json", "identify.json", "diagnose.json", "sensitivity.json", "optimise.json"};

[[noreturn]] void refuse_results(const fs::path& path, const std::string& text) {
    throw Error(ExitCode::input_output, fmt::format("{}: {}", path.string(), text));
}

bool is_there(const fs::path& path) {
    std::error_code fault;
    return fs::exists(path, fault);
}

/// Of a results folder.
fs::path summary_of(const fs::path& folder) {
    for (const char* name : kSummaries)
        if (is_there(folder / name)) return folder / name;
    return folder / kSummaries[0];
}

/// The folder, or the one of the file, of results.
fs::path find_folder(const fs::path& path) {
    std::error_code fault;
    if (!fs::exists(path, fault)) throw file_error(path, "cannot read", ENOENT);
    if (fs::is_directory(path, fault)) {
        if (is_there(summary_of(path))) return path;
        for (const char* name : {"history.csv", "sweep.csv"})
            if (is_there(path / name)) return path;
        if (is_there(path / "model.toml"))
            refuse_results(path, "this is the folder of a model; run it, and name the results folder");
        refuse_results(path, "these are no results of dttmm: there is no summary.json, history.csv or sweep.csv in it");
    }
    const bool is_summary = std::ranges::any_of(kSummaries, [&](const char* name) { return path.filename() == name; });
    if (is_summary || path.filename() == "history.csv" || path.filename() == "sweep.csv")
        return path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (path.extension() == ".toml") refuse_results(path, "this is a model; run it, and name the results folder");
    refuse_results(path, "this is no results folder of dttmm; name the folder that -o or results/ has");
}

/// summary.json; null where there is none.
Json read_summary(const fs::path& file) {
    if (!is_there(file)) return nullptr;
    Json json;
    try {
        const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
            if (depth > kDeepest) refuse_results(file, fmt::format("damaged: it is nested more than {} deep", kDeepest));
            return true;
        };
        json = Json::parse(read_whole_file(file), check_depth);
    } catch (const nlohmann::json::exception& fault) {
        refuse_results(file, fmt::format("damaged: {}", fault.what()));
    }
    const auto is_text = [&](const char* name) { return json.contains(name) && json[name].is_string(); };
    if (!json.is_object() || !is_text("format") || !json["format"].get<std::string>().starts_with("dttmm-"))
        refuse_results(file, "this is no summary of dttmm: there is no \"format\" that begins with dttmm-");
    return json;
}

/// "run", "modes", "static", "frf", "response", "spectrum", "sweep", "study".
std::string kind_of(const fs::path& folder, const Json& summary) {
    if (summary.is_null()) return is_there(folder / "history.csv") ? "run" : "sweep";
    const std::string format = summary["format"];
    for (const char* kind :
         {"modes", "static", "frf", "response", "spectrum", "identify", "diagnose", "sensitivity", "optimise"})
        if (format == fmt::format("dttmm-{}/1", kind)) return kind;
    if (format == "dttmm-summary/1") return "run";
    if (format == "dttmm-study-results/1") return "study";
    refuse_results(summary_of(folder), fmt::format("its format {} is not known to this version of the program; make the "
                                                   "results anew, or use the version that made them",
                                                   quote(format)));
}

/// UTC, to the minute.
std::string time_of_results(const fs::path& file) {
    std::error_code fault;
    const fs::file_time_type time = fs::last_write_time(file, fault);
    if (fault) return {};
    const std::time_t seconds = std::chrono::system_clock::to_time_t(std::chrono::file_clock::to_sys(time));
    std::tm parts{};
    std::array<char, 32> text{};
    if (!::gmtime_r(&seconds, &parts)) return {};
    return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &parts)};
}

/// Reads the files of one folder into the description.
class Description {
public:
    Description(const fs::path& path, const ReportChoice& choice) : folder_(find_folder(path)), choice_(choice) {
        json_["path"] = path.lexically_normal().string();
        Json summary = read_summary(summary_of(folder_));
        kind_ = kind_of(folder_, summary);
        json_["kind"] = kind_;
        for (const char* part : {"curve_sets", "tables", "notes"}) json_[part] = Json::array();
        take_summary(std::move(summary));
        if (is_there(folder_ / "history.csv")) take_history();
        for (const auto& file : kCurveFiles)
            if (is_there(folder_ / file.name)) take_curves(CsvFile(folder_ / file.name), file.x, file.first);
        take_fits();
        for (const char* file : kTableFiles)
            if (is_there(folder_ / file)) take_table(CsvFile(folder_ / file));
        if (kind_ == "study") take_study();
    }

    /// The last call.
    Json take() {
        for (CurveSet& set : sets_)
            std::erase_if(set.curves, [&](const auto& curve) { return is_station(curve.head.name); });
        for (const CurveSet& set : sets_) json_["curve_sets"].push_back(describe(set, choice_.most_points));
        if (is_there(folder_ / "history.csv"))
            json_["motion"] = describe_motion(HistoryFile(folder_ / "history.csv"), json_["model"]);
        if (kind_ == "modes") json_["lines"] = describe_lines(folder_ / "shapes.csv");
        return std::move(json_);
    }
    std::vector<CurveSet> take_sets() { return std::move(sets_); }
    Results take_results();

private:
    void take_summary(Json summary);
    void take_history();
    void take_curves(const CsvFile& file, const std::string& x, std::size_t first);
    void take_fits();
    void take_sweep(const CsvFile& file);
    void take_study();
    void take_table(const CsvFile& file);
    void note(const std::string& text) { json_["notes"].push_back(text); }
    void note_torn(const CsvFile& file) {
        if (file.is_torn()) note(file.path().filename().string() + ": the last row is not whole and is left out");
    }

    fs::path folder_;
    const ReportChoice& choice_;
    std::string kind_;
    Json json_;
    std::vector<CurveSet> sets_;
};

Results Description::take_results() {
    Results results;
    results.folder = folder_;
    results.kind = kind_;
    results.written = json_["written"];
    results.summary = std::move(json_["summary"]);
    results.model = std::move(json_["model"]);
    results.model_text = std::move(json_["model_text"]);
    for (const auto& [object, name] : {std::pair(&results.summary, "title"), std::pair(&json_, "title_of_cases")})
        if (results.title.empty() && object->is_object() && object->contains(name) && (*object)[name].is_string())
            results.title = (*object)[name];
    for (const Json& text : json_["notes"]) results.notes.push_back(text);
    results.sets = std::move(sets_);
    return results;
}

/// The model and its text stand apart: the page shows them in places of their own.
void Description::take_summary(Json summary) {
    json_["model"] = nullptr;
    json_["model_text"] = "";
    if (summary.is_null()) {
        if (kind_ == "run")
            note(
                "There is no summary.json: the run has not ended, or it was killed. Its status, warnings and model are not "
                "known.");
        const Json first = read_summary(folder_ / "case-000001/summary.json");
        json_["has_cases"] = is_there(folder_ / "case-000001");
        if (first.is_object() && first.contains("title")) json_["title_of_cases"] = first["title"];
        json_["summary"] = nullptr;
        json_["written"] = time_of_results(folder_ / (kind_ == "run" ? "history.csv" : "sweep.csv"));
        return;
    }
    json_["written"] = time_of_results(summary_of(folder_));
    if (summary.contains("inputs") && summary["inputs"].is_object() && summary["inputs"].contains("model_text")) {
        json_["model_text"] = std::move(summary["inputs"]["model_text"]);
        summary["inputs"].erase("model_text");
    }
    if (summary.contains("model")) {
        json_["model"] = std::move(summary["model"]);
        summary.erase("model");
    }
    json_["summary"] = std::move(summary);
}

void Description::take_history() {
    const HistoryFile history(folder_ / "history.csv");
    if (history.is_torn()) note("history.csv: the last row is not whole and is left out");
    std::vector<Channel> channels;
    for (const Column& column : history.columns()) channels.emplace_back(column.name, column.unit);
    std::vector<int> chosen;
    try {
        chosen = select_channels(channels, choice_.patterns);
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("--channels: {}", error.what()));
    }
    if (chosen.size() < channels.size())
        note(fmt::format("The curves are {} of the {} recorded channels, as --channels asked for.", chosen.size() - 1,
                         channels.size() - 1));
    std::vector<std::vector<double>> values = history.read(chosen);
    CurveSet set{"history.csv", {}, history.columns().front(), std::move(values.front()), {}};
    for (std::size_t i = 1; i < chosen.size(); ++i)
        set.curves.push_back({history.columns()[as_size(chosen[i])], std::move(values[i]), {}});
    sets_.push_back(std::move(set));
}

/// Rows go order by order where there are several: a set of each.
void Description::take_curves(const CsvFile& file, const std::string& x, std::size_t first) {
    note_torn(file);
    const int rpm = file.find("rpm"), order = file.find("order");
    const bool is_by_order = rpm >= 0 && order >= 0;
    const int over = is_by_order ? rpm : file.find(x);
    if (over < 0) refuse_results(file.path(), fmt::format("damaged: there is no column {}", quote(x)));
    std::vector<double> orders = is_by_order ? file.numbers(as_size(order)) : std::vector<double>{0};
    std::ranges::sort(orders);
    orders.erase(std::ranges::unique(orders).begin(), orders.end());
    for (const double one : orders) {
        std::vector<std::size_t> rows;
        for (std::size_t row = 0; row < file.rows(); ++row)
            if (!is_by_order || file.numbers(as_size(order))[row] == one) rows.push_back(row);
        std::ranges::stable_sort(rows, {}, [&](std::size_t row) { return file.numbers(as_size(over))[row]; });
        CurveSet set = curves_of(file, over, is_by_order ? 3 : first, rows);
        if (is_by_order) set.label = fmt::format("order {:g}", one);
        sets_.push_back(std::move(set));
    }
}

/// Measured data beside the model's: histories-1.csv, responses-1.csv and so on.
void Description::take_fits() {
    for (const auto& [stem, x] : {std::pair("histories", "time"), std::pair("responses", "frequency")})
        for (int number = 1; is_there(folder_ / fmt::format("{}-{}.csv", stem, number)); ++number)
            take_curves(CsvFile(folder_ / fmt::format("{}-{}.csv", stem, number)), x, 1);
}

/// Figures over the one parameter that differs from case to case; over the number of the case if several do.
void Description::take_sweep(const CsvFile& file) {
    std::size_t first = 1;
    std::vector<std::size_t> varied;
    for (; first < file.columns().size(); ++first) {
        const std::string& name = file.columns()[first].name;
        if (file.is_text(first) || name == "curve1") break;
        const std::vector<double>& values = file.numbers(first);
        if (std::ranges::adjacent_find(values, std::ranges::not_equal_to{}) != values.end()) varied.push_back(first);
    }
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < file.rows(); ++row) rows.push_back(row);
    if (rows.empty() || first >= file.columns().size() || file.columns().front().name != "case") return;
    // Parameters that follow from the one that varies go with it
    int over = varied.empty() ? -1 : as_int(varied.back());
    if (over >= 0) {
        const std::vector<double>& values = file.numbers(varied.back());
        if (std::set<double>(values.begin(), values.end()).size() < file.rows()) over = -1;
        if (over >= 0) std::ranges::stable_sort(rows, {}, [&](std::size_t row) { return values[row]; });
    }
    sets_.push_back(curves_of(file, over, first, rows));
}

/// The parameters that vary and the figures of every case, as numbers of four bytes; of a large study evenly chosen cases.
void Description::take_study() {
    const CsvFile file(folder_ / "results.csv");
    const Json study = read_summary(folder_ / "study.json");
    std::set<std::string> varied;
    if (study.is_object() && study.contains("varied") && study["varied"].is_array())
        for (const Json& one : study["varied"])
            if (one.is_array() && !one.empty() && one[0].is_string()) varied.insert(one[0].get<std::string>());
    if (study.is_object() && study.contains("inputs") && study["inputs"].is_object())
        json_["model_text"] = study["inputs"].value("model_text", "");
    const std::size_t every = (file.rows() + kMostCases - 1) / kMostCases;
    Json columns = Json::array();
    constexpr std::size_t kFirst = 3;  // behind case, status and warnings
    for (std::size_t c = kFirst; c < file.columns().size(); ++c) {
        if (file.is_text(c)) continue;
        std::vector<double> values;
        for (std::size_t row = 0; row < file.rows(); row += every) values.push_back(file.numbers(c)[row]);
        columns.push_back({{"name", file.columns()[c].name},
                           {"unit", file.columns()[c].unit},
                           {"is_parameter", varied.contains(file.columns()[c].name)},
                           {"data", base64_of_floats(values)}});
    }
    json_["study"] = {{"columns", columns}, {"every", every}, {"left_out", every > 1}};
}

void Description::take_table(const CsvFile& file) {
    note_torn(file);
    if (file.path().filename() == "sweep.csv") take_sweep(file);
    Json table = {{"file", file.path().filename().string()}, {"columns", Json::array()}, {"rows", Json::array()}};
    for (const Column& column : file.columns()) table["columns"].push_back({{"name", column.name}, {"unit", column.unit}});
    table["left_out"] = file.rows() - std::min(file.rows(), kMostRows);
    for (std::size_t row = 0; row < std::min(file.rows(), kMostRows); ++row) {
        Json& cells = table["rows"].emplace_back(Json::array());
        for (std::size_t c = 0; c < file.columns().size(); ++c)
            cells.push_back(file.is_text(c)                       ? Json(file.texts(c)[row])
                            : std::isfinite(file.numbers(c)[row]) ? Json(file.numbers(c)[row])
                                                                  : Json());
    }
    json_["tables"].push_back(std::move(table));
}

}  // namespace

Json describe_results(const fs::path& path, const ReportChoice& choice) { return Description(path, choice).take(); }

void refuse_repeated_results(const std::vector<std::string>& paths) {
    for (std::size_t i = 0; i < paths.size(); ++i)
        for (std::size_t other = 0; other < i; ++other) {
            std::error_code fault;
            if (fs::equivalent(find_folder(paths[i]), find_folder(paths[other]), fault))
                throw Error(ExitCode::usage, fmt::format("{} and {} are the same results; name them once",
                                                         quote(paths[other]), quote(paths[i])));
        }
}

fs::path path_beside(const std::string& results, const char* ending) {
    std::error_code fault;
    fs::path path = fs::path(results).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    if (!fs::is_directory(path, fault)) path = path.parent_path();
    if (path.empty() || path.filename() == "." || path.filename() == "..") {
        path = from_start(path.empty() ? "." : path).lexically_normal();
        if (!path.has_filename()) path = path.parent_path();
    }
    path += ending;
    return path;
}

Results read_results(const fs::path& path) {
    const ReportChoice all;
    return Description(path, all).take_results();
}

std::vector<CsvFile> read_tables(const fs::path& folder) {
    std::set<fs::path> files;
    std::error_code fault;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, fault)) {
        const fs::path name = entry.path().filename();
        const bool is_curves = name == "history.csv" || name.string().starts_with("histories-") ||
                               name.string().starts_with("responses-") ||
                               std::ranges::any_of(kCurveFiles, [&](const auto& file) { return name == file.name; });
        if (name.extension() == ".csv" && !is_curves) files.insert(entry.path());
    }
    return {files.begin(), files.end()};
}

std::vector<CurveSet> read_curve_sets(const fs::path& path) {
    const ReportChoice all;
    return Description(path, all).take_sets();
}

}  // namespace dttmm::host
