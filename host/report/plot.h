// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Curves of results as an SVG or PNG picture or as text: a chart per file and unit, over each other. words: results
/// folders, whose curves are drawn together, then patterns of curves. Throws Error(usage) for a pattern without a curve, and
/// as describe_results does.
ExitCode plot_curves(const Request& request);

}  // namespace dttmm::host
