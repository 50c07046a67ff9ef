// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// What vibrates in a recorded run: levels, amplitude spectra and densities of its channels as levels.csv and spectrum.csv
/// in the results folder; on request identified.csv and orders.csv. The largest peaks on the terminal.
ExitCode find_spectrum(const Request& request);

}  // namespace dttmm::host
