// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>

#include "report/results.h"

namespace dttmm::host {

/// Results as universal files: datasets 151, 164 (SI), nodes, then the functions or modes. Nodes: every body with its
/// markers behind it, then the nodes of the model, numbered from 1, where they are at the start, world axes: the order of
/// modes.csv. The place of a body is the origin of its axes, not its centre of mass: its channels and shapes are of there.
/// All times are those at which the results were written: the same results give the same bytes.

/// Curves over time, frequency or speed as datasets 58; nodes as 2411. The texts of each: name and unit; title; date; file;
/// what the codes cannot say. The function is
///     1 time response      over time
///     9 power density      a unit per Hz
///     4 frequency response complex, with a unit per force, moment or motion of a known input, which is the reference
///     5 transmissibility   the same where both have one unit
///     12 spectrum          other complex curves: amplitudes under all loads of the model, or of a recorded run
///     0 general            others
/// The direction is that of the channel of a place, +1 to +3 along and +4 to +6 about the world's axes; what belongs to an
/// element or has no axis has node 0 and direction 0. Points without a value are left out. Returns what was written and
/// what the format cannot hold, a line each. Throws Error(usage) where there is no such curve.
std::string write_functions(const Results& results, std::ostream& out);

/// Natural vibrations as datasets 55; nodes as 15 and 2411. Stations of beams follow behind the nodes in the order of
/// shapes.csv. Real modes have six degrees of freedom at every node; shape and modal mass are scaled as in modes.csv, with
/// the damping ratio 0. Where there are damped modes, they follow as complex modes at the places, with the eigenvalue in
/// 1/s; their modal A and B are not known and 0. Returns as write_functions does. Throws Error(usage) where these are no
/// modes, Error(input_output) for a damaged file.
std::string write_modes(const Results& results, std::ostream& out);

}  // namespace dttmm::host
