// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

ExitCode optimise(const Request& request);

}  // namespace dttmm::host
