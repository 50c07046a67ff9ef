// SPDX-License-Identifier: BSD-3-Clause
#include "report/plot.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/recorded_run.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/channels.h"
#include "record/results_folder.h"
#include "report/gnuplot.h"
#include "report/results.h"
#include "report/svg_chart.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostPoints = 1500;  // of a line: twice the width of a chart, for the least and the largest value
constexpr std::size_t kMostLines = 28;     // in one chart: so many differ in colour and dashes

/// "m/s²" for "m/s^2"; nothing for a pure number.
std::string unit_text(std::string unit) {
    if (unit == "1") return {};
    for (const auto& [from, to] : {std::pair("^2", "²"), std::pair("^3", "³"), std::pair("*", "·")})
        for (size_t at = unit.find(from); at != unit.npos; at = unit.find(from, at))
            unit.replace(at, std::string(from).size(), to);
    return unit;
}

std::string with_unit(const std::string& name, const std::string& unit) {
    const std::string text = unit_text(unit);
    return text.empty() ? name : fmt::format("{} [{}]", name == "rpm" ? "speed" : name, text);
}

/// Words of the command: results folders first, at least one; then patterns, at least one.
struct Words {
    std::vector<std::string> results, patterns;
};

Words split_words(const std::vector<std::string>& words) {
    const auto is_results = [](const std::string& word) {
        std::error_code fault;
        return fs::is_directory(word, fault) || word.ends_with(".csv") || word.ends_with("summary.json");
    };
    const auto first = std::find_if_not(words.begin() + 1, words.end() - 1, is_results);
    return {{words.begin(), first}, split_at_commas({first, words.end()})};
}

/// Curves of all results; of several the label of a curve begins with the name of its folder.
std::vector<CurveSet> read_sets(const std::vector<std::string>& results) {
    std::vector<CurveSet> all;
    for (const std::string& one : results)
        for (CurveSet& set : read_curve_sets(one)) {
            if (results.size() > 1) {
                fs::path path = fs::path(one).lexically_normal();
                if (path.has_extension() || !path.has_filename()) path = path.parent_path();
                set.label = path.filename().string() + (set.label.empty() ? "" : ", " + set.label);
            }
            all.push_back(std::move(set));
        }
    return all;
}

ChartLine thinned(const CurveSet& set, const Curve& curve) {
    ChartLine line{set.label.empty() ? curve.head.name : curve.head.name + ", " + set.label, {}, {}};
    for (const std::size_t row : thin(curve.values, kMostPoints)) {
        line.x.push_back(set.places[row]);
        line.y.push_back(curve.values[row]);
    }
    return line;
}

/// A chart per file and unit, in the order of the files.
std::vector<Chart> make_charts(const std::vector<CurveSet>& sets, const std::set<std::string>& names, bool is_logarithmic) {
    std::vector<Chart> charts;
    std::vector<std::pair<std::string, std::string>> keys;
    for (const CurveSet& set : sets)
        for (const Curve& curve : set.curves) {
            if (!names.contains(curve.head.name)) continue;
            const std::pair key(set.file, curve.head.unit);
            const auto found = std::ranges::find(keys, key);
            const auto place = as_size(found - keys.begin());
            if (found == keys.end()) {
                keys.push_back(key);
                charts.push_back({with_unit(set.x.name, set.x.unit), unit_text(curve.head.unit), {}, is_logarithmic});
            }
            charts[place].lines.push_back(thinned(set, curve));
        }
    for (const Chart& chart : charts)
        if (chart.lines.size() > kMostLines)
            throw Error(ExitCode::usage, fmt::format("{} in one chart cannot be distinguished; choose at most {} of a unit",
                                                     counted(chart.lines.size(), "curve", "curves"), kMostLines));
    return charts;
}

/// Columns and rows of a chart in the terminal.
std::pair<int, int> terminal_size() {
    winsize size{};
    const bool is_known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return {is_known ? std::clamp<int>(size.ws_col, 40, 240) : 100,
            is_known ? std::clamp<int>(size.ws_row - 2, 12, 60) : 30};
}

}  // namespace

ExitCode plot_curves(const Request& request) {
    const fs::path path = request.output ? *request.output : path_beside(request.words.front(), ".svg");
    if (path != "-" && path.extension() != ".svg" && path.extension() != ".png")
        throw Error(ExitCode::usage,
                    fmt::format("{}: the picture is SVG or PNG; give a name that ends with .svg or .png", path.string()));
    const Words words = split_words(request.words);
    refuse_repeated_results(words.results);
    const std::vector<CurveSet> sets = read_sets(words.results);
    const std::vector<Chart> charts = make_charts(sets, choose_names(sets, words.patterns), request.response.is_logarithmic);
    const std::string title = fmt::format("{} of {}", fmt::join(words.patterns, ", "), fmt::join(words.results, ", "));
    if (request.pictures.is_text) {
        const auto [columns, rows] = terminal_size();
        fmt::print("{}", draw_text(charts, columns, rows));
        return ExitCode::ok;
    }
    if (path == "-") {
        fmt::print("{}", draw_svg(title, charts));
        return ExitCode::ok;
    }
    if (path.extension() == ".png")
        draw_png(title, charts, from_start(path));
    else
        write_atomically(from_start(path), draw_svg(title, charts));
    if (!request.quiet) fmt::print("{}\n", path.string());
    return ExitCode::ok;
}

}  // namespace dttmm::host
