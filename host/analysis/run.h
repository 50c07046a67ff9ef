// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Runs a model from 0 to its duration into its results folder and prints the table of peak and final forces; with a
/// tolerance, repeats that at half the step until it is reached. A run that fails or is stopped half way leaves what it has
/// recorded, with the reason in summary.json. Returns ok, or the stop signal's code; throws Error for everything else,
/// numerical_failure also when an explicit coupling would be unstable and force is not set (to a tolerance it starts from a
/// stable step), or when the tolerance is out of reach.
ExitCode run(const Request& request);

}  // namespace dttmm::host
