// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/first_step.h"

#include <algorithm>
#include <cmath>

#include "analysis/halving.h"
#include "analysis/load_speed.h"
#include "model/index.h"
#include "model/read_simulation.h"
#include "step/simulation.h"

namespace dttmm::host {

namespace {

constexpr double kFewestSteps = 1000, kMostStepsForVibrations = 1e4, kMostStepsForLoads = 1e6;
constexpr double kMostRows = 1e4;
/// For the spectrum of a load: 65 536 samples, which show parts up to 3e4 periods in the duration and take some 10 ms.
constexpr double kStepsOfSpectrum = 4096;

/// The fewest steps per row that divide `steps` and give at most kMostRows rows.
int choose_steps_per_row(int64_t steps) {
    int every = 1;
    while (steps % every != 0 || static_cast<double>(steps / every) > kMostRows) ++every;
    return every;
}

}  // namespace

Model choose_step(Model model, const Plugins& plugins) {
    SimulationSettings& settings = model.simulation;
    if (settings.step > 0) return model;
    const double duration = settings.duration;
    settings.step = std::clamp(duration / kFewestSteps, kShortestStep, kLongestStep);
    const Simulation simulation(model, plugins);  // for its vibrations and the weights of its loads

    const double omega = simulation.fastest_mode().omega;
    double longest = settings.step;
    if (omega > 0) longest = std::min(longest, std::max(kUnresolved / omega, duration / kMostStepsForVibrations));
    const std::vector<Acting> all_acting = find_acting(model, duration / kStepsOfSpectrum);
    const auto is_short_enough = [&](double h) {
        if (h <= std::max(duration / kMostStepsForLoads, kShortestStep)) return true;
        return h <= longest && std::ranges::all_of(all_acting, [&](const Acting& acting) {
                   return compute_largest_error(acting.parts, simulation.load_weights(), h) <= kTolerableExtrapolatedError;
               });
    };
    if (model.output.step > 0) {
        settings.step = divide_step(model.output.step, is_short_enough);
        model.output.every = as_int(std::lround(model.output.step / settings.step));
    } else {
        settings.step = divide_step(duration, is_short_enough);
        model.output.every = choose_steps_per_row(std::llround(duration / settings.step));
    }
    return model;
}

}  // namespace dttmm::host
