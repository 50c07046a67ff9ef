// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Steady vibration over frequency or speed, under unit inputs or the harmonic and random loads of the model: complex
/// amplitudes of channels as response.csv, densities and RMS under random loads as psd.csv and rms.csv in the results
/// folder, the largest of each channel on the terminal.
ExitCode find_steady_response(const Request& request);

}  // namespace dttmm::host
