// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Finds the natural frequencies of a model, prints a table (frequency, multiplicity, modal mass, where it moves most, which
/// elements hold the strain energy) or one JSON object, and writes modes.csv (the shape at every body, marker and node),
/// shapes.csv (along beams) and summary.json into the results folder. A range without a frequency gives an empty list.
/// Throws Error: model_invalid for a model in which nothing vibrates, numerical_failure where the count cannot prove the
/// list, resource_limit for frequencies too high to count.
ExitCode find_modes(const Request& request);

}  // namespace dttmm::host
