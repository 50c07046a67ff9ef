// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// One HTML file that shows results of any commands, one beside the other, and opens without a network: by default beside
/// the first results folder. Replaces a report, never another file. Throws Error(input_output) for what is no results.
ExitCode make_report(const Request& request);

}  // namespace dttmm::host
