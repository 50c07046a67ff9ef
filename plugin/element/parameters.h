// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <iterator>
#include <limits>

#include "dttmm_plugin.h"

namespace dttmm::plugin {

/// Declarations of parameters, for the tables of the elements. Ranges include their ends, so that the smallest positive
/// number stands for "more than zero".
inline constexpr double kLargest = std::numeric_limits<double>::max();
inline constexpr double kPositive = std::numeric_limits<double>::min();
inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kRigid = std::numeric_limits<double>::infinity();

inline bool is_given(double value) { return !std::isnan(value); }

/// Three numbers ≥ 0, zero if not given; one number stands for all.
constexpr dttmm_parameter spread3(const char* name, const char* unit, const char* documentation) {
    return {name, unit, 3, DTTMM_PARAMETER_SPREADS, 0, 0, kLargest, nullptr, 0, documentation};
}

/// `count` numbers that the model may leave out.
constexpr dttmm_parameter optional(const char* name, const char* unit, uint32_t count, double minimum, double maximum,
                                   const char* documentation) {
    return {name, unit, count, 0, kNotGiven, minimum, maximum, nullptr, 0, documentation};
}

/// One number, zero if not given.
constexpr dttmm_parameter zero_by_default(const char* name, const char* unit, double minimum, const char* documentation) {
    return {name, unit, 1, 0, 0, minimum, kLargest, nullptr, 0, documentation};
}

/// The host's bounds for masses and places: beyond them numbers drown one another, or overflow.
/// Of frequencies; a host refuses it in a run, by its name.
inline constexpr const char* kLossFactorHelp =
    "of its stiffness k, k (1 + i loss_factor) in vibration; in frequencies only, a run refuses it";

inline constexpr double kHeaviestMass = 1e12, kFarthestPlace = 1e6,
                        kLargestInertia = kHeaviestMass * kFarthestPlace * kFarthestPlace;

/// The mass of an element that is one.
inline constexpr dttmm_parameter kMassParameter = {
    "mass", "kg", 1, DTTMM_PARAMETER_REQUIRED, 0, kPositive, kHeaviestMass, nullptr, 0, "of the mass"};

}  // namespace dttmm::plugin
