// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

namespace dttmm::host {

/// Where a function of time jumps.
struct Jump {
    double time = 0;  ///< just before it [s]
    double size = 0;  ///< after less before
};

/// The largest jump of `value` from 0 to `duration` [s], if it has one of more than a hundredth of its range. What rises
/// within a millionth of the duration counts as one; one that is taken back as soon may be missed.
std::optional<Jump> find_jump(const std::function<double(double)>& value, double duration);

/// The same of its slope, as a table has at its points.
std::optional<Jump> find_jump_of_slope(const std::function<double(double)>& value, double duration);

}  // namespace dttmm::host
