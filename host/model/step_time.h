// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace dttmm::host {

/// An instant rounded to 15 digits at least [s], which is then the number that a file has for it.
inline double rounded_time(double time) {
    constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                  1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};  // exact
    const int exponent = static_cast<int>(std::bit_cast<uint64_t>(time) >> 52) - 1023;                // time >= 0
    const int decimals = 14 - ((exponent * 78913) >> 18);  // log10(2) = 78913/2^18, rounded down
    if (decimals < 0 || decimals > 22) return time;
    const double power = kPowers[decimals];
    return static_cast<double>(static_cast<int64_t>(time * power + 0.5)) / power;  // 1e14 to 2e15
}

/// The instant after so many steps [s]: 1120 of 62.5 us end at 0.07 s, and a load that begins at 0.07 s has begun. The
/// product may be a rounding below.
inline double time_after(uint64_t steps, double step_size) { return rounded_time(static_cast<double>(steps) * step_size); }

}  // namespace dttmm::host
