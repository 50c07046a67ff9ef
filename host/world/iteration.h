// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::host {

/// A pass on joints that leaves more of an error is slow.
inline constexpr double kSlowOnJoints = 0.3;
/// Corrections that no longer fall were 1 to 5 times their rounding: below so many times they are near it.
inline constexpr double kNearRounding = 10;
/// Corrections that no longer fall may be rounding where they are a smaller share of the motion.
inline constexpr double kMayBeRounding = 1e-9;
/// Two ways to find the same motion or momentum agree if they differ by a smaller share of it.
inline constexpr double kAgreement = kNearRounding * kMayBeRounding;
/// What one step has measured of passes and of rounding counts this many times less in the next.
inline constexpr double kTrustLost = 2;

/// Passes after which a step has failed.
inline constexpr int kMostPassesOfStep = 50;

}  // namespace dttmm::host
