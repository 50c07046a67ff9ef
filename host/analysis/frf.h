// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Frequency response between two places and directions, damping as the elements have it: receptance [m/N], mobility and
/// accelerance as frf.csv in the results folder, the largest point on the terminal.
ExitCode find_response(const Request& request);

}  // namespace dttmm::host
