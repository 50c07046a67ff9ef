// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "analysis/json.h"
#include "identify/comparison.h"
#include "identify/observations.h"
#include "record/results_folder.h"

namespace dttmm::host {

/// Data beside what the model predicts: histories-1.csv, responses-1.csv and so on, one file per set of times or
/// frequencies; NAME.measured and NAME.predicted side by side, of
/// histories NAME.residual too, measured less predicted.
void write_fit_curves(const ResultsFolder& folder, const Observations& observations, const Comparison& comparison,
                      const Eigen::VectorXd& predicted);

/// Measured modes beside those of the model.
Json describe_pairs(const Observations& observations, const std::vector<ModePair>& pairs);
void print_pairs(const Observations& observations, const std::vector<ModePair>& pairs);

}  // namespace dttmm::host
