// SPDX-License-Identifier: BSD-3-Clause
#include "identify/response_derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <limits>
#include <string_view>

#include "analysis/response.h"
#include "analysis/response_machine.h"
#include "identify/forked_map.h"
#include "identify/small_changes.h"
#include "model/error.h"
#include "model/index.h"
#include "study/case_runner.h"

namespace dttmm::host {

namespace {

using Complex = std::complex<double>;

constexpr std::string_view kLargest = ".largest";

/// A curve at the operating point of its largest magnitude, which is a figure, or at another one.
struct CurveAt {
    Eigen::Index figure;
    size_t curve;
    OperatingPoint at;
    bool is_peak;          ///< which moves with the machine
    bool is_next = false;  ///< the largest peak beside that of the figure
    double shift = 0;      ///< to a point beside a peak [Hz, of an order rad/s]
    double error = 0;      ///< of a peak's place, as share of the shift
};

/// The same curve elsewhere along the same frequencies or speeds.
CurveAt shifted(const CurveAt& place, double by) {
    ResponseSweep sweep;
    sweep.is_speed = place.at.speed.has_value();
    sweep.order = place.at.order;
    CurveAt beside = place;
    beside.at = sweep.at(place.at.speed.value_or(place.at.frequency) + by);
    return beside;
}

/// Slope and second derivative of ln |H| along frequencies or speeds.
struct Top {
    double slope, curvature;
    double away() const { return -slope / curvature; }
};

Top top_of(ResponseCurves& curves, const CurveAt& place, double step) {
    const auto size = [&](double by) { return std::log(std::abs(curves.evaluate(shifted(place, by).at)[place.curve])); };
    const double above = size(step), middle = size(0), below = size(-step);
    return {(above - below) / (2 * step), (above - 2 * middle + below) / (step * step)};
}

/// Moves a place to where the curve is largest and returns true. A slope at a fixed frequency is that of a peak only there:
/// within a resonance of quality Q it changes by some Q times what the place is off by, as share of the peak's width. Where
/// no peak is found the place stays, and its error has no bound.
bool finds_peak(ResponseCurves& curves, CurveAt& place) {
    constexpr double kFirstStep = 1e-4, kFlat = 1e-6;  // of the frequency: flat curves have no place that matters
    constexpr double kOfWidth =
        0.01;  // steps, of half the width at 0.7 of the peak. Range 1e-3 or less to 0.02 (0.1 PeaksMove...)
    constexpr double kEnough = 1e-7;  // of a step. Range 1e-10 or less to 1e-7 (1e-4 PeaksMove...)
    constexpr int kMostPasses = 20;   // 5 are enough in the tests, 3 are not
    const double x = place.at.speed.value_or(place.at.frequency);
    const auto size = [&](const CurveAt& at) { return std::abs(curves.evaluate(at.at)[at.curve]); };
    place.error = std::numeric_limits<double>::infinity();
    CurveAt found = place;
    double step = kFirstStep * x;
    for (int pass = 0; pass < kMostPasses; ++pass) {
        const Top wide = top_of(curves, found, step);
        if (pass == 0 && std::abs(wide.curvature) * x * x < kFlat && std::abs(wide.slope) * x < kFlat) {
            place.error = 1;
            place.shift = step;
            return true;
        }
        const double width = std::min(x, 1 / std::sqrt(std::max(0.0, -wide.curvature)));
        if (!(wide.curvature < 0) || step > 2 * kOfWidth * width) {
            step = wide.curvature < 0 ? kOfWidth * width : step / 4;
            continue;
        }
        const Top narrow = top_of(curves, found, step / 2);
        const double by = narrow.away() + (narrow.away() - wide.away()) / 3, last = found.error;
        if (!(std::abs(by) < width)) return false;
        found = shifted(found, by);
        found.shift = step;
        found.error = std::max(kEnough, std::abs(by) / step);
        if (found.error > kEnough && found.error <= last / 2) continue;
        if (!(size(found) >= (1 - 1e-9) * size(place))) return false;
        place = found;
        return true;
    }
    return false;
}

/// The next peak goes where it is not found, or where nothing damps it.
bool drops(ResponseCurves& curves, CurveAt& place) {
    try {
        return place.is_peak && !finds_peak(curves, place) && place.is_next;
    } catch (const Error& error) {
        if (!place.is_next || error.code() != ExitCode::numerical_failure) throw;
        return true;
    }
}

/// Its amplitudes at these places.
std::vector<Complex> amplitudes(ResponseMachine& machine, const std::vector<CurveAt>& places) {
    std::vector<Complex> values;
    for (const CurveAt& place : places) values.push_back(machine.curves.evaluate(place.at)[place.curve]);
    return values;
}

/// A load with a frequency of its own takes its row with it.
void refuse_moving_loads(const Excitation& middle, const Excitation& other, const std::vector<CurveAt>& places) {
    const bool has_own = std::ranges::any_of(places, [](const CurveAt& place) { return place.at.has_own; });
    if (middle.orders() != other.orders() || (has_own && middle.own_frequencies() != other.own_frequencies()))
        throw Error(ExitCode::usage, "the frequency of a load changes with a parameter");
}

/// Slopes of the magnitudes by ln of one parameter and their bends, as SmallChanges has them. The places beside peaks have
/// theirs at the smallest share only, behind the others.
std::vector<double> slopes_of_amplitudes(const FigureFunction& function, ResponseMachine& middle, double highest,
                                         const std::vector<CurveAt>& figures, const std::vector<CurveAt>& beside,
                                         Eigen::Index parameter) {
    Warnings silent(Warnings::Silent::yes);
    std::vector<CurveAt> places = figures;
    places.insert(places.end(), beside.begin(), beside.end());
    const std::vector<Complex> H = amplitudes(middle, places);
    std::vector<double> slopes;
    for (const double change : SmallChanges::kShares) {
        if (change != SmallChanges::kShares.back())
            places.resize(figures.size());
        else
            places.insert(places.end(), beside.begin(), beside.end());
        std::vector<std::vector<Complex>> sides;
        for (const double sign : {1.0, -1.0}) {
            const Request request = function.request_with(parameter, 1 + sign * change);
            ResponseMachine machine(request, function.plugins(), silent);
            refuse_moving_loads(middle.excitation, machine.excitation, places);
            machine.session.machine.damp(highest);
            machine.session.machine.respond_beside(middle.session.machine);
            sides.push_back(amplitudes(machine, places));
        }
        for (size_t f = 0; f < places.size(); ++f) {
            const auto along = [&](const Complex& of) {
                return H[f] == 0.0 ? 0 : (std::conj(H[f]) * of).real() / std::abs(H[f]);
            };
            const SlopeAt slope = SlopeAt::of(along(sides[0][f]), along(H[f]), along(sides[1][f]), change);
            slopes.push_back(slope.mean);
            slopes.push_back(slope.bend);
        }
    }
    return slopes;
}

/// Where the figures are largest.
std::vector<CurveAt> find_places(const FigureFunction& function, ResponseFindings& findings) {
    const std::filesystem::path scratch =
        std::filesystem::temp_directory_path() / fmt::format("dttmm-{}", Journal::make_name());
    Warnings silent(Warnings::Silent::yes);
    Request request = function.plan().request;
    request.output = scratch;
    const ExitCode code = find_steady_response(request, function.plugins(), silent, findings);
    std::error_code ignored;
    std::filesystem::remove_all(scratch, ignored);
    if (code != ExitCode::ok) throw Error(code, "stopped");
    std::vector<CurveAt> places;
    for (Eigen::Index f = 0; f < as_row(function.figures().size()); ++f) {
        const Column& figure = function.figures()[as_size(f)];
        if (!is_largest(figure)) continue;
        const std::string name = figure.name.substr(0, figure.name.size() - kLargest.size());
        const auto curve = std::ranges::find(findings.largest, name, &ResponseFindings::Largest::name);
        places.push_back({f, as_size(curve - findings.largest.begin()), curve->at, curve->is_peak});
        if (curve->next) places.push_back({f, places.back().curve, *curve->next, true, true});
    }
    return places;
}

}  // namespace

bool is_largest(const Column& figure) { return figure.name.ends_with(kLargest); }

bool differentiate_responses(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason) {
    Warnings silent(Warnings::Silent::yes);
    ResponseFindings findings;
    std::vector<CurveAt> places = find_places(function, findings);
    ResponseMachine middle(function.plan().request, function.plugins(), silent);
    middle.session.machine.damp(findings.highest);
    std::erase_if(places, [&](CurveAt& place) { return drops(middle.curves, place); });
    const size_t count = places.size();
    std::vector<CurveAt> beside;
    std::vector<size_t> beside_of(count);  // where in `beside`; only of peaks with a shift
    for (size_t c = 0; c < count; ++c) {
        beside_of[c] = beside.size();
        if (places[c].shift > 0) beside.push_back(shifted(places[c], places[c].shift));
    }
    const auto parameters = as_size(function.nominal().size());
    const std::vector<TaskResult> results = map_in_processes(parameters, jobs, [&](size_t p) {
        return slopes_of_amplitudes(function, middle, findings.highest, places, beside, as_row(p));
    });
    reason = first_reason(results);
    if (!reason.empty()) return false;
    const auto [slopes, errors] = SmallChanges(results, count);
    constexpr size_t kLast = SmallChanges::kShares.size() - 1;
    found.competing_at.setZero(found.figures.size());
    for (size_t c = 0; c < count; ++c) {
        const Eigen::Index f = places[c].figure, at = as_row(c);
        const double size = std::abs(amplitudes(middle, {places[c]}).front());
        if (places[c].is_next) {
            const Eigen::RowVectorXd nearer = slopes.row(at) - found.slopes.row(f);
            found.competing_at(f) = places[c].at.frequency;
            found.competing.row(f) = slopes.row(at);
            found.reach.row(f) = std::abs(found.figures(f) - size) / nearer.array().abs();
            continue;
        }
        found.figures(f) = size;
        found.slopes.row(f) = slopes.row(at);
        found.errors.row(f) = errors.row(at);
        if (std::isinf(places[c].error)) found.errors.row(f).setConstant(places[c].error);
        if (!(places[c].shift > 0)) continue;
        for (size_t p = 0; p < parameters; ++p) {
            const std::vector<double>& numbers = results[p].numbers;
            const double change = numbers[2 * ((kLast + 1) * count + beside_of[c])] - numbers[2 * (kLast * count + c)];
            found.errors(f, as_row(p)) += places[c].error * std::abs(change);
        }
    }
    return true;
}

}  // namespace dttmm::host
