// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::plugin {

/// What is rounding of sums and turns of a handful of numbers, as share of the largest: 45 epsilon.
inline constexpr double kRoundingOfSums = 1e-14;

/// Share of the largest below which a part is next to nothing beside it.
inline constexpr double kNextToNothing = 1e-6;

}  // namespace dttmm::plugin
