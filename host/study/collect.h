// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "study/study_folder.h"

namespace dttmm::host {

/// How many cases of a study are where.
struct StudyCount {
    size_t completed = 0, failed = 0, missing = 0, warned = 0;
    size_t unlisted = 0;  ///< have figures that the study has no column for
};

StudyCount count_cases(const std::vector<CaseOutcome>& outcomes);
/// "997 of 1000 cases completed, 2 failed, 1 not run, 14 with warnings".
std::string describe_count(const StudyCount& count);

/// Writes what the journals hold so far as tables: results.csv and results.h5 (a row per case), statistics.csv,
/// correlations.csv, failures.csv and summary.json. Each file is whole at any instant, so that it may be done again, or by
/// two at once. Returns what they hold. Throws Error(input_output).
std::vector<CaseOutcome> collect(const StudyFolder& study);

/// Statistics of the figures and the failures, on the terminal.
void print_statistics(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes);

}  // namespace dttmm::host
