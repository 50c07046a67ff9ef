// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::plugin {

/// What is rounding of sums and turns of a handful of numbers, as share of the largest: 45 epsilon.
inline constexpr double kRoundingOfSums = 1e-14;

/// Points that are nearer to each other are one [m].
inline constexpr double kSamePoint = 1e-9;

/// Directions that differ by less are nearly one [rad].
inline constexpr double kSmallTurn = 0.01;

/// Share of the largest below which a part is next to nothing beside it.
inline constexpr double kNextToNothing = 1e-6;

/// Passes after which an iteration has failed, as of a step of the host.
inline constexpr int kMostPassesOfStep = 50;

}  // namespace dttmm::plugin
