// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Results in the formats of other programs: by default RESULTS with the ending of the format, beside the folder. Replaces
/// files that were exported by dttmm, never another. Prints size and content of each file, and what it leaves out. Throws
/// Error(input_output) for what is no results and for damaged ones; Error(usage) for no format, one that these results have
/// nothing for, and a pattern without a curve.
ExitCode export_results(const Request& request);

}  // namespace dttmm::host
