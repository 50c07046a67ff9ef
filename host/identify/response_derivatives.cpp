// SPDX-License-Identifier: BSD-3-Clause
#include "identify/response_derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
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

/// A figure: a curve at the operating point of its largest magnitude.
struct CurveAt {
    Eigen::Index figure;
    size_t curve;
    OperatingPoint at;
};

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

/// Slopes of the magnitudes by ln of one parameter and their bends, as SmallChanges has them.
std::vector<double> slopes_of_amplitudes(const FigureFunction& function, ResponseMachine& middle, double highest,
                                         const std::vector<CurveAt>& places, Eigen::Index parameter) {
    Warnings silent(Warnings::Silent::yes);
    const std::vector<Complex> H = amplitudes(middle, places);
    std::vector<double> slopes;
    for (const double change : SmallChanges::kShares) {
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
        places.push_back({f, as_size(curve - findings.largest.begin()), curve->at});
    }
    return places;
}

}  // namespace

bool is_largest(const Column& figure) { return figure.name.ends_with(kLargest); }

bool differentiate_responses(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason) {
    Warnings silent(Warnings::Silent::yes);
    ResponseFindings findings;
    const std::vector<CurveAt> places = find_places(function, findings);
    ResponseMachine middle(function.plan().request, function.plugins(), silent);
    middle.session.machine.damp(findings.highest);
    const auto parameters = as_size(function.nominal().size());
    const std::vector<TaskResult> results = map_in_processes(parameters, jobs, [&](size_t p) {
        return slopes_of_amplitudes(function, middle, findings.highest, places, as_row(p));
    });
    reason = first_reason(results);
    if (!reason.empty()) return false;
    const auto [slopes, errors] = SmallChanges(results, places.size());
    for (size_t c = 0; c < places.size(); ++c) {
        const Eigen::Index f = places[c].figure;
        found.figures(f) = findings.largest[places[c].curve].size;
        found.slopes.row(f) = slopes.row(as_row(c));
        found.errors.row(f) = errors.row(as_row(c));
    }
    return true;
}

}  // namespace dttmm::host
