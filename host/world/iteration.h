// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::host {

/// A pass on joints that leaves more of an error is slow.
inline constexpr double kSlowOnJoints = 0.3;
/// Corrections that no longer fall were 1 to 5 times their rounding: below so many times they are near it.
inline constexpr double kNearRounding = 10;

/// Passes after which a step has failed.
inline constexpr int kMostPassesOfStep = 50;

}  // namespace dttmm::host
