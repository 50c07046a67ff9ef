// SPDX-License-Identifier: BSD-3-Clause
#include "identify/limit_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/stop_signals.h"
#include "model/error.h"

namespace dttmm::host {

LimitFound find_limit(const std::function<Rise(double distance)>& rise, double first, double reach, double allowed) {
    constexpr double kEnough = 0.1;  // of what is allowed: 5 % of the interval
    constexpr int kMostTries = 20;   // each is a fit of the other unknowns
    double distance = first, within = 0, beyond = std::numeric_limits<double>::infinity();
    for (int n = 0; n < kMostTries; ++n) {
        distance = std::min(distance, reach);
        Rise risen;
        try {
            risen = rise(distance);
        } catch (const Error&) {
            if (StopSignals::requested()) throw;
            return {std::nullopt, false};
        }
        if (std::abs(risen.chi2 - allowed) < kEnough * allowed) return {distance, risen.is_converged};
        if (distance >= reach && risen.chi2 < allowed) return {std::nullopt, true};
        (risen.chi2 < allowed ? within : beyond) = distance;
        // chi2 is nearly a parabola; far from one no step is trusted beyond a factor of three
        distance *= std::clamp(std::sqrt(allowed / std::max(risen.chi2, 1e-12)), 1.0 / 3, 3.0);
        if (distance <= within || distance >= beyond) distance = (within + beyond) / 2;
        if (beyond - within < kEnough / 2 * beyond) return {distance, risen.is_converged};  // a step
    }
    return {distance, false};
}

}  // namespace dttmm::host
