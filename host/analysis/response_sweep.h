// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "analysis/request.h"
#include "analysis/sweep_plan.h"
#include "model/error.h"

namespace dttmm::host {

/// `dttmm response` of every case of a sweep, each in a folder of its own, and sweep.csv: parameters, status, largest
/// magnitude of each curve and where it is, RMS values. A case that fails leaves the others. Throws as find_steady_response
/// does where all cases fail.
ExitCode sweep_response(const Request& request, const std::vector<SweepAxis>& axes);

}  // namespace dttmm::host
