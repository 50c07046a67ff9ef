// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Which element is loose, how loose and how sure: prints the verdict and what it rests on, and writes diagnose.json and the
/// curves of data and model into the results folder. With --plan: which sensors and blows would tell, plan.csv. Throws Error
/// as reading the data does; usage for suspects that are no elements or have no stiffness.
ExitCode diagnose(const Request& request);

}  // namespace dttmm::host
