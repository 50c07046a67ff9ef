// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/request.h"
#include "loader/plugins.h"
#include "model/error.h"

namespace dttmm::host {

/// Which blows and sensors would tell the suspects apart: of every place and direction a blow, and for it the accelerometers
/// that fix the stiffnesses best (greedy D-optimal exchange over responses with noise of 1 % of the largest). Prints the
/// best blows, what each leaves tied, and writes plan.csv. The suspects are looked at with the file's values and at random
/// points around them: a symmetric model hides which faults will tie.
ExitCode plan_test(const Request& request, const Plugins& plugins, const std::vector<std::string>& suspects);

}  // namespace dttmm::host
