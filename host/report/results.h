// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "report/curve_set.h"

namespace dttmm::host {

/// What a report shows of results.
struct ReportChoice {
    std::vector<std::string> patterns;  ///< of channels of a run, as in --channels; none: all
    std::size_t most_points = 4000;     ///< of a curve
};

/// One results folder of any command, or the history.csv of a run, as the page reads it: kind, summary.json, model, curves,
/// tables, motion, shapes, notes. Throws Error(input_output) for what is no results of dttmm, and says what it is; for a
/// damaged file of results, with its place; Error(usage) for a pattern without a channel.
Json describe_results(const std::filesystem::path& path, const ReportChoice& choice);

/// All curves of the same, whole: one set per file, of orders over speed one per order. Throws as describe_results does.
std::vector<CurveSet> read_curve_sets(const std::filesystem::path& path);

}  // namespace dttmm::host
