// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::plugin {

/// What is rounding of sums and turns of a handful of numbers, as share of the largest: 45 epsilon.
inline constexpr double kRoundingOfSums = 1e-14;

}  // namespace dttmm::plugin
