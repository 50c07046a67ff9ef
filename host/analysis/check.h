// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"

namespace dttmm::host {

/// Reads and builds everything without a step. Prints what the file is good for (run, modes, frf) and why not for the
/// others, what would be solved, the step count, omega*h, the lowest natural frequency, bodies and elements
/// (machine_table.h). Throws Error where the file is good for nothing, or an explicit coupling would be unstable and force
/// is not set.
void check(const Request& request);

}  // namespace dttmm::host
