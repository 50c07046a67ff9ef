// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "identify/figure_function.h"
#include "identify/local_sensitivity.h"

namespace dttmm::host {

/// Derivatives of the largest magnitudes of a response, exactly to the first order: with the complex amplitude H of a
/// channel at the frequency of its largest magnitude and dH = −H dZ H (see dttmm_derivative.h), d|H| = Re(conj(H) dH)/|H|.
/// That the frequency of a peak moves is of the second order: the peak is found so sharply first. The rows of
/// <curve>.largest in `found` are written.
///
/// Returns false with the reason where they are not found, as with damping of modes or of a machine whose structure changes
/// with a parameter.
bool differentiate_responses(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason);

/// Whether it is of that kind.
bool is_largest(const Column& figure);

}  // namespace dttmm::host
