// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

namespace dttmm::host {

/// How far chi2 has risen at a distance from its minimum.
struct Rise {
    double chi2 = 0;
    bool is_converged = true;  ///< the other unknowns are at their best
};

/// One end of an interval.
struct LimitFound {
    std::optional<double> distance;  ///< from the minimum; none: chi2 does not rise so far
    bool is_converged = true;        ///< false: the distance is the best guess
};

/// The distance at which chi2 has risen by what is allowed, to 5 % of the distance. None: it does not within `reach`.
/// Where the model has no answer the limit is unknown: none, and not converged. first: a guess of the distance.
LimitFound find_limit(const std::function<Rise(double distance)>& rise, double first, double reach, double allowed);

}  // namespace dttmm::host
