// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "analysis/sweep_plan.h"
#include "model/error.h"

namespace dttmm::host {

/// Natural frequencies of every case of a sweep, in one table: frequencies against the parameters, each curve followed
/// through crossings by the likeness of its shapes (MAC). Prints it and writes sweep.csv. Throws as find_modes does.
ExitCode sweep_modes(const Request& request, const std::vector<SweepAxis>& axes);

}  // namespace dttmm::host
