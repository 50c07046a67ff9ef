// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "identify/figure_function.h"
#include "identify/local_sensitivity.h"

namespace dttmm::host {

/// Derivatives of natural frequencies by the change of the dynamic stiffness at their shapes: see dttmm_derivative.h. Near
/// frequencies, which a small change makes repel each other, do not disturb them. The rows of mode<n>.frequency in `found`
/// are written.
///
/// Returns false with the reason where they are not found, as of a plugin without the extension or a machine whose structure
/// changes with a parameter.
bool differentiate_modes(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason);

/// Whether it is of that kind.
bool is_natural_frequency(const Column& figure);

}  // namespace dttmm::host
