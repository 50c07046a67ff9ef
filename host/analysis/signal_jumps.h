// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

namespace dttmm::host {

/// Where a function of time jumps, or its slope does.
struct Jump {
    double time = 0;        ///< just before it [s]
    double size = 0;        ///< after less before
    bool is_slope = false;  ///< the slope jumps, by `size` per second
};

/// The largest jump of `value` from 0 to `duration` [s], if it has one of more than a hundredth of its range. What rises
/// within a millionth of the duration counts as one; one that is taken back as soon may be missed.
std::optional<Jump> find_jump(const std::function<double(double)>& value, double duration);

/// The largest jump of `value` of more than a millionth of its range, or else the largest one of its slope of more than a
/// hundredth of the range of that, as a table has at its points.
std::optional<Jump> find_jump_of_speed(const std::function<double(double)>& value, double duration);

}  // namespace dttmm::host
