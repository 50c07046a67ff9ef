// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "analysis/sweep_plan.h"
#include "model/error.h"

namespace dttmm::host {

/// Runs every case of a sweep in a process of its own, request.jobs at a time, each into its folder case-000001,
/// … of the results folder, and writes sweep.csv: per case the parameters (SI), the status, peak and final force of every
/// element and the peak acceleration of every marker used. A case that fails is named with its reason and the others go on.
/// A case whose folder holds a completed summary of the same inputs is not run again. Returns ok, cases_failed, or the stop
/// signal's code (running cases are stopped, sweep.csv tells what is done). Throws Error for a fault of the model or the
/// folder.
ExitCode run_sweep(const Request& request, const std::vector<SweepAxis>& axes);

}  // namespace dttmm::host
