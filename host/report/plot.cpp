// SPDX-License-Identifier: BSD-3-Clause
#include "report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/recorded_run.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/channels.h"
#include "record/results_folder.h"
#include "report/results.h"
#include "report/svg_chart.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostPoints = 3000;  // of a line: four times the width of the picture
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

/// The names of all curves that a pattern selects.
std::set<std::string> choose(const std::vector<CurveSet>& sets, const std::vector<std::string>& patterns) {
    std::vector<Channel> channels = {{"time", "s"}};
    for (const CurveSet& set : sets)
        for (const Curve& curve : set.curves) channels.emplace_back(curve.head.name, curve.head.unit);
    std::set<std::string> names;
    try {
        for (const int c : select_channels(channels, patterns))
            if (c > 0) names.insert(channels[as_size(c)].name());
    } catch (const Error& error) {
        throw Error(ExitCode::usage, error.what());
    }
    return names;
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

/// results/pump.svg for results/pump.
fs::path picture_path(const Request& request) {
    if (request.output) return *request.output;
    std::error_code fault;
    fs::path path = fs::path(request.words.front()).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    if (!fs::is_directory(path, fault)) path = path.parent_path();
    if (path.empty() || path == "." || path == "..") return path / "plot.svg";
    path += ".svg";
    return path;
}

}  // namespace

ExitCode plot_curves(const Request& request) {
    const fs::path path = picture_path(request);
    if (path != "-" && path.extension() != ".svg")
        throw Error(ExitCode::usage, fmt::format("{}: the picture is SVG; give a name that ends with .svg", path.string()));
    const std::vector<std::string> patterns = split_at_commas({request.words.begin() + 1, request.words.end()});
    const std::vector<CurveSet> sets = read_curve_sets(request.words.front());
    const std::vector<Chart> charts = make_charts(sets, choose(sets, patterns), request.is_logarithmic);
    const std::string picture = draw_svg(fmt::format("{} of {}", fmt::join(patterns, ", "), request.words.front()), charts);
    if (path == "-") {
        fmt::print("{}", picture);
        return ExitCode::ok;
    }
    write_atomically(from_start(path), picture);
    if (!request.quiet) fmt::print("{}\n", path.string());
    return ExitCode::ok;
}

}  // namespace dttmm::host
