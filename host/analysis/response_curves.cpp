// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "analysis/adaptive_points.h"
#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"
#include "record/progress_bar.h"

namespace dttmm::host {

namespace {

/// What one unit of an input is.
const char* unit_of(const Excitation::Input& input) {
    return input.is_motion() ? (input.turns() ? "rad" : "m") : input.turns() ? "N*m" : "N";
}

}  // namespace

ResponseCurves::ResponseCurves(ModalMachine& machine, const ResponseChannels& channels, const Excitation& excitation,
                               std::vector<int> chosen, Warnings& warnings)
    : machine_(machine),
      channels_(channels),
      excitation_(excitation),
      chosen_(std::move(chosen)),
      warnings_(warnings),
      with_forces_(channels.has_forces(chosen_)) {}

size_t ResponseCurves::size() const {
    return chosen_.size() *
           (excitation_.is_by_inputs() ? excitation_.inputs().size() : static_cast<size_t>(excitation_.has_harmonics()));
}

std::string ResponseCurves::name(size_t curve) const {
    const std::string name = channel(curve).name();
    const auto& inputs = excitation_.inputs();
    return inputs.size() < 2 ? name : name + "/" + inputs[curve / chosen_.size()].text;
}

std::string ResponseCurves::unit(size_t curve) const {
    const std::string unit = channel(curve).unit();
    if (!excitation_.is_by_inputs()) return unit;
    const std::string per = unit_of(excitation_.inputs()[curve / chosen_.size()]);
    return unit == per ? "1" : fmt::format("{}/{}", unit, per == "N*m" ? "(N*m)" : per);
}

std::vector<AdaptivePoints::Kind> ResponseCurves::kinds() const {
    std::vector<AdaptivePoints::Kind> kinds;
    for (const int channel : chosen_) kinds.push_back(channels_.kind(channel));
    for (size_t k = 0; k < ResponseChannels::kKinds; ++k) kinds.push_back({k, 1, false});
    return kinds;
}

ResponseCurves::Values ResponseCurves::evaluate_blocks(const OperatingPoint& at) {
    const std::vector<ModalInstance::Loads> cases = excitation_.cases(at);
    const double omega = 2 * std::numbers::pi * at.frequency;
    Values values;
    for (const ModalInstance::Response& response : machine_.respond(at.frequency, cases, with_forces_)) {
        for (const int channel : chosen_) values.push_back(channels_.value(channel, response, omega));
        std::ranges::copy(channels_.largest(response, omega), std::back_inserter(values));
    }
    return values;
}

ResponseCurves::Values ResponseCurves::channels_of(const Values& blocks) const {
    Values values;
    const size_t block = chosen_.size() + ResponseChannels::kKinds;
    for (size_t i = 0; i < blocks.size(); ++i)
        if (i % block < chosen_.size()) values.push_back(blocks[i]);
    return values;
}

ResponseCurves::Values ResponseCurves::evaluate_near(const ResponseSweep& sweep, double x) {
    constexpr double kBeside = 1e-8;  // far beyond rounding of x, far within any width that damping gives
    try {
        return evaluate_blocks(sweep.at(x));
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure || x == 0) throw;
    }
    return evaluate_blocks(sweep.at((1 + kBeside) * x));
}

void ResponseCurves::try_first(const ResponseSweep& sweep) {
    if (sweep.x.empty())
        evaluate(sweep.at(sweep.own.front()));
    else if (sweep.is_adaptive)
        evaluate_near(sweep, sweep.x.front());
    else
        evaluate(sweep.at(sweep.x.front()));
}

bool ResponseCurves::find_rows(const ResponseSweep& sweep, bool shows_progress, const Take& take) {
    std::map<double, Values> adaptive;
    std::vector<double> points = sweep.x;
    if (sweep.is_adaptive) {
        adaptive = find_points(sweep);
        points.clear();
        for (const auto& [x, values] : adaptive) points.push_back(x);
    }
    ProgressBar progress(!shows_progress || sweep.is_adaptive ? -1 : 2);
    size_t own = 0, done = 0;
    const auto take_own = [&] {
        OperatingPoint at = sweep.at(sweep.own[own++]);
        at.has_own = true;
        take(at, evaluate(at));
    };
    for (const double x : points) {
        if (StopSignals::requested() && !sweep.is_adaptive) return false;
        progress.update(static_cast<double>(done++), static_cast<double>(points.size()), "rows");
        while (own < sweep.own.size() && sweep.own[own] < x) take_own();
        if (own < sweep.own.size() && sweep.own[own] == x)
            take_own();
        else
            take(sweep.at(x), sweep.is_adaptive ? adaptive.at(x) : evaluate(sweep.at(x)));
    }
    while (own < sweep.own.size() && !StopSignals::requested()) take_own();
    return !StopSignals::requested();
}

/// Points where the curves bend; those found so far if it is stopped.
std::map<double, ResponseCurves::Values> ResponseCurves::find_points(const ResponseSweep& sweep) {
    const std::vector<AdaptivePoints::Kind> block = kinds();
    const size_t cases = size() / chosen_.size();
    std::vector<AdaptivePoints::Kind> all;
    for (size_t i = 0; i < cases; ++i)
        for (AdaptivePoints::Kind kind : block) {
            kind.index += i * ResponseChannels::kKinds;  // inputs have units of their own
            all.push_back(kind);
        }
    AdaptivePoints adaptive(
        [&](double x) {
            Values values = evaluate_near(sweep, x);
            values.resize(all.size());
            return values;
        },
        all);
    if (!adaptive.find(sweep.x, kMostAdaptive, StopSignals::requested) && !StopSignals::requested()) warn_too_many();
    for (const double x : adaptive.unbounded())
        warnings_.add("unbounded-peak",
                      fmt::format("nothing damps the motion at {:.6g} Hz: there the response grows without bound, and the "
                                  "largest values printed are not its peak",
                                  sweep.at(x).frequency));
    std::map<double, Values> points;
    for (const auto& [x, values] : adaptive.points()) points.emplace_hint(points.end(), x, channels_of(values));
    return points;
}

void ResponseCurves::warn_too_many() {
    warnings_.add(
        "too-many-points",
        fmt::format("after {} points the curves are still not straight between them; give a shorter range", kMostAdaptive));
}

}  // namespace dttmm::host
