// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace dttmm::plugin {

// All that decides how natural frequencies are searched and what counts as found. Tests that fail at half or at twice, or
// farther out, are named. Where none is, those of modal/ and 107 of the commands about modes and rest pass at both.

/// From one frequency of a search to the next, and of brackets; what lies within one such step of rounding, as ω, is hidden
/// by it where forces at rest balance to some digits only. Half: NearlyEqualFrequenciesOfABeamAreAsNearAsOthers; twice:
/// ModesAtRest.SlowGrowthIsSaid.
constexpr double kWiden = 4;
/// Times −ω²: a shift at which what is slower than ω counts as held.
constexpr double kFixed = kWiden;
/// high/low of an interval in whose middle the shapes of its modes are looked for. Also between two frequencies that count
/// as apart. 2.1: ABeamBetweenTwoPointsOfOneRigidBody.
constexpr double kNarrow = 1.3;
/// Rounds of inverse iteration with one factor. 3: NearlyEqualFrequenciesOfABeamAreAsNearAsOthers.
constexpr int kRounds = 5;
/// Frequencies so near each other count as equal. Half, twice: FrequenciesWithinTwoBillionthsCountAsEqual.
constexpr double kEqual = 2e-9;
/// Of ω: the widest interval in which a mode is confirmed. λ of modes that are refined together lie nearer than that.
constexpr double kWidestBracket = 1e-5;
/// The same where forces at rest may bring a frequency near to zero. Of 864 columns near their critical loads 52 are refused
/// with 1e-5, 8 with 1e-4, 5 with 1e-2; 39 known to 6e-5 or less lie where their neighbours lead to, to 1 % of ω².
constexpr double kWidestAtRest = 1e-4;
/// Of unit mass: less is left of a shape that says what others do.
constexpr double kSameShape = 1e-6;
/// Rounding of a rigid-body mode's λ, as share of the largest stiffness over the whole mass. Half, twice:
/// ASlowVibrationIsFoundRefusedOrFree. Of results it changes: 8e-14: ASlowSpringIsNoRigidBodyMode; 4e-12: SlowGrowthIsSaid.
constexpr double kRigidRounding = 1e-12;
/// Times √rounding: what rounding makes of spins with little inertia reaches so far as a rule, and two steps of the search
/// farther at most. Half, twice: PreloadedModes.ATieThatPressesAFreeTube.
constexpr double kNoise = 1024;
/// Strain of a rigid-body mode, as share of λ where the count begins. More is a mode too slow to be counted. Strain that is
/// larger than such a share of the shift is reported: with a quarter of it, 63 more of 1000 loaded trusses are. With 4e-4
/// fewer trusses are refused, and a vibration of 0.002 Hz is listed with 0 Hz:
/// ModesWrong.ASpringTooSoftToBeCountedIsNotCalledFree. 8e-6: Trusses.ALoadedTrussOnBallJointsIsNotUnstable. Half, twice:
/// ASlowVibrationIsFoundRefusedOrFree.
constexpr double kStrain = 1e-4;
/// The strain of more shapes is not looked at: that of 90 took 0.4 s.
constexpr std::size_t kMostShapes = 40;

}  // namespace dttmm::plugin
