// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Finds parameters of a model from measured natural frequencies and shapes, responses and histories. Prints the verdict and
/// a table of the values with their intervals, and writes identify.json and the curves of data and model into the results
/// folder. Throws Error as reading the data does; usage where nothing is free.
ExitCode identify(const Request& request);

}  // namespace dttmm::host
