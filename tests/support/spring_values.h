// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <vector>

namespace dttmm::test {

/// Values of a spring_damper: stiffness, damping, rotational stiffness, rotational damping of three directions each; then
/// "not given" for all that laws want, however many there are.
inline std::vector<double> spring_values(const std::array<double, 12>& linear) {
    constexpr size_t kMost = 1000;
    std::vector<double> values(linear.begin(), linear.end());
    values.push_back(0);  // loss_factor
    values.resize(kMost, std::numeric_limits<double>::quiet_NaN());
    return values;
}

/// The linear ones of such values.
inline std::vector<double> linear_values(const std::vector<double>& values) { return {values.begin(), values.begin() + 12}; }

}  // namespace dttmm::test
