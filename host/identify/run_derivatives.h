// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "identify/figure_function.h"
#include "identify/local_sensitivity.h"

namespace dttmm::host {

/// Derivatives of the figures of a run by direct differentiation of its time scheme: of the history as it is computed, not
/// of differences of whole runs. Beside the run go two neighbours for every parameter p, with p (1 + d) and p (1 − d), each
/// on its own factored matrix. After every step they are moved to equal distances from the run (Simulation::centre). Half of
/// their difference is then d times the derivative of the state, carried on by the scheme linearised about the run. Its
/// error is that of one step, of the order of d², and does not grow with time as that of a difference of histories does.
///
/// Pairs that differ in all parameters together choose the distance, and give the errors: their derivative must be the sum.
///
/// Returns false with the reason where there is no such derivative: a run to a tolerance, a time step or a duration that
/// changes with a parameter, a plugin without the extension DTTMM_DERIVATIVE, a law that remembers numbers of its own, a
/// neighbour that fails.
bool differentiate_run(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason);

}  // namespace dttmm::host
