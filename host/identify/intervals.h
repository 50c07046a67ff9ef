// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "identify/fit.h"
#include "identify/residuals.h"

namespace dttmm::host {

/// Sets the limits of the coordinates at 95 %. inflation: see Fit.
void find_intervals(const Residuals& residuals, Solution& solution, double inflation);

/// By how much the time step shifts the coordinates of a minimum from what exact motion would give.
Eigen::VectorXd find_step_bias(const Residuals& residuals, const Solution& solution);

}  // namespace dttmm::host
