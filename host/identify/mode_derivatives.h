// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "identify/figure_function.h"
#include "identify/local_sensitivity.h"

namespace dttmm::host {

/// Derivatives of natural frequencies by the change of the dynamic stiffness at their shapes: see dttmm_derivative.h. Near
/// frequencies, which a small change makes repel each other, do not disturb them. Central differences of the stiffness at
/// two distances are extrapolated; errors are what that changes. found: has a row for every figure; those of
/// mode<n>.frequency are written.
///
/// Returns false with the reason where the plugin does not tell. Throws Error as FigureFunction::evaluate does.
bool differentiate_modes(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason);

/// Whether all figures are of that kind.
bool are_frequencies(const FigureFunction& function);

}  // namespace dttmm::host
