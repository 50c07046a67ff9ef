// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "loader/plugins.h"
#include "model/model.h"

namespace dttmm::host {

/// A model without a step gets the first step of its run to a tolerance, and the number of steps per row. A model with a
/// step comes back as it is. The first step
///   - is at most a thousandth of the duration: a picture of the history is then smooth;
///   - resolves the fastest vibration of the bodies with ω h <= 1 (halving.h), but not below 1e-4 of the duration: where so
///     fast a vibration matters, the halvings that follow find it;
///   - leaves the error of every load and motion of a support at most 10 % (load_speed.h), but not below 1e-6 of the
///   duration: the limit of what is
///     run without being asked for;
///   - divides the output step, or the duration where no output step is given, into 1, 2, 4, 5, 8, 10, ... parts.
/// Without an output step there is a row per first step, at most 10 000 rows. Throws Error like Simulation.
Model choose_step(Model model, const Plugins& plugins);

}  // namespace dttmm::host
