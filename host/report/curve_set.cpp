// SPDX-License-Identifier: BSD-3-Clause
#include "report/curve_set.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "model/channel.h"
#include "model/error.h"
#include "model/index.h"
#include "record/channels.h"
#include "report/base64.h"

namespace dttmm::host {

namespace {

/// Least, largest and last value, and where they are first.
struct Extremes {
    double least = NAN, least_at = NAN, largest = NAN, largest_at = NAN, last = NAN;
};

Extremes extremes_of(const std::vector<double>& values, const std::vector<double>& places) {
    Extremes found;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i])) continue;
        if (!(values[i] >= found.least)) found.least = values[i], found.least_at = places[i];
        if (!(values[i] <= found.largest)) found.largest = values[i], found.largest_at = places[i];
        found.last = values[i];
    }
    return found;
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

std::vector<double> pick(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
    std::vector<double> picked;
    picked.reserve(rows.size());
    for (const std::size_t row : rows) picked.push_back(values[row]);
    return picked;
}

std::size_t span_begin(std::size_t span, std::size_t rows, std::size_t spans) { return span * rows / spans; }

/// Beginning and middle of every span of thin().
std::vector<std::size_t> places_of_spans(std::size_t rows, std::size_t most) {
    std::vector<std::size_t> places;
    for (std::size_t s = 0; s < most / 2; ++s) {
        const std::size_t begin = span_begin(s, rows, most / 2), end = span_begin(s + 1, rows, most / 2);
        places.push_back(begin);
        places.push_back((begin + end) / 2);
    }
    return places;
}

Json describe_curve(const Curve& curve, const CurveSet& set, std::size_t most) {
    const Extremes extremes = extremes_of(curve.values, set.places);
    Json json = {{"name", curve.head.name}, {"unit", curve.head.unit}};
    const bool is_whole = std::ranges::none_of(curve.values, [](double v) { return std::isnan(v); });
    if (is_whole && !curve.values.empty() && extremes.least == extremes.largest) {
        json["constant"] = extremes.least;
        return json;
    }
    json["least"] = number_or_null(extremes.least);
    json["least_at"] = number_or_null(extremes.least_at);
    json["largest"] = number_or_null(extremes.largest);
    json["largest_at"] = number_or_null(extremes.largest_at);
    json["last"] = number_or_null(extremes.last);
    const std::vector<std::size_t> rows = thin(curve.values, most);
    json["values"] = base64_of_floats(pick(curve.values, rows));
    if (!curve.phases.empty()) json["phases"] = base64_of_floats(pick(curve.phases, rows));
    return json;
}

/// `name` without `ending`; empty if it ends otherwise.
std::string stem(const std::string& name, std::string_view ending) {
    return name.ends_with(ending) ? name.substr(0, name.size() - ending.size()) : "";
}

}  // namespace

std::set<std::string> choose_names(const std::vector<CurveSet>& sets, const std::vector<std::string>& patterns,
                                   const std::string& option) {
    std::vector<Channel> channels = {{"time", "s"}};
    std::set<std::string> known, chosen;
    for (const CurveSet& set : sets)
        for (const Curve& curve : set.curves)
            if (known.insert(curve.head.name).second) channels.emplace_back(curve.head.name, curve.head.unit);
    if (known.empty())
        throw Error(ExitCode::usage, option +
                                         "these results have no curves over time, frequency or speed: see their CSV "
                                         "files, or `dttmm report`");
    try {
        for (const int c : select_channels(channels, patterns))
            if (c > 0) chosen.insert(channels[as_size(c)].name());
    } catch (const Error& error) {
        throw Error(ExitCode::usage, option + error.what());
    }
    return chosen;
}

std::vector<std::size_t> thin(const std::vector<double>& values, std::size_t most) {
    std::vector<std::size_t> rows;
    if (values.size() <= most) {
        for (std::size_t i = 0; i < values.size(); ++i) rows.push_back(i);
        return rows;
    }
    for (std::size_t s = 0; s < most / 2; ++s) {
        const std::size_t begin = span_begin(s, values.size(), most / 2), end = span_begin(s + 1, values.size(), most / 2);
        std::size_t least = begin, largest = begin;
        for (std::size_t i = begin; i < end; ++i) {
            if (!(values[i] >= values[least])) least = i;
            if (!(values[i] <= values[largest])) largest = i;
        }
        rows.push_back(std::min(least, largest));
        rows.push_back(std::max(least, largest));
    }
    return rows;
}

Json describe(const CurveSet& set, std::size_t most) {
    const std::size_t rows = set.places.size();
    Json json = {{"file", set.file}, {"label", set.label}, {"rows", rows}, {"x", set.x.name}, {"x_unit", set.x.unit}};
    json["span"] = rows <= most ? 1.0 : static_cast<double>(rows) / static_cast<double>(most / 2);
    json["places"] = base64_of_doubles(rows <= most ? set.places : pick(set.places, places_of_spans(rows, most)));
    json["curves"] = Json::array();
    for (const Curve& curve : set.curves) json["curves"].push_back(describe_curve(curve, set, most));
    return json;
}

CurveSet curves_of(const CsvFile& file, int x, std::size_t first, const std::vector<std::size_t>& rows) {
    CurveSet set{file.path().filename().string(), {}, {"case", "1"}, {}, {}};
    for (std::size_t i = 0; i < rows.size(); ++i)
        set.places.push_back(x < 0 ? static_cast<double>(i + 1) : file.numbers(as_size(x))[rows[i]]);
    if (x >= 0) set.x = file.columns()[as_size(x)];
    const auto has = [&](const std::string& name) { return file.find(name) >= 0; };
    const auto numbers = [&](const std::string& name) { return pick(file.numbers(as_size(file.find(name))), rows); };
    for (std::size_t c = first; c < file.columns().size(); ++c) {
        const auto& [name, unit] = file.columns()[c];
        const std::string of_real = stem(name, ".re"), of_imaginary = stem(name, ".im"), of_phase = stem(name, ".phase"),
                          of_amplitude = stem(name, ".amplitude");
        const bool is_part = has(name + ".re") || (!of_imaginary.empty() && has(of_imaginary + ".re")) || name == "phase" ||
                             (!of_phase.empty() && has(of_phase + ".amplitude"));
        if (is_part || file.is_text(c)) continue;
        Curve curve{{name, unit}, pick(file.numbers(c), rows), {}};
        if (!of_real.empty() && has(of_real + ".im")) {
            curve.head.name = of_real;
            const std::vector<double> imaginary = numbers(of_real + ".im");
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const double real = std::exchange(curve.values[i], std::hypot(curve.values[i], imaginary[i]));
                curve.complex_values.emplace_back(real, imaginary[i]);
                curve.phases.push_back(std::atan2(imaginary[i], real) * 180 / std::numbers::pi);
            }
        } else if (!of_amplitude.empty() && has(of_amplitude + ".phase")) {
            curve.phases = numbers(of_amplitude + ".phase");
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const double phase = curve.phases[i] * std::numbers::pi / 180;
                curve.complex_values.emplace_back(curve.values[i] * std::cos(phase), curve.values[i] * std::sin(phase));
            }
        }
        set.curves.push_back(std::move(curve));
    }
    return set;
}

}  // namespace dttmm::host
