// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "model/model.h"
#include "record/column.h"

namespace dttmm::host {

/// A field of sweep.csv behind the parameters. Names differ within a row.
struct SweepCell {
    Column column;
    std::variant<double, std::string> value;
};

/// A case as sweep.csv shows it.
struct SweepRow {
    std::vector<Parameter> parameters;  ///< those that are known, in any order
    std::vector<SweepCell> cells;
};

/// How folders, sweep.csv and messages call a case, counted from 0: "case-000001".
std::string case_name(size_t index);
/// Says so where the folder of a sweep of `count` cases has the next case too: it is of an earlier sweep.
void tell_of_earlier_cases(const std::filesystem::path& folder, size_t count);

/// Adds to `all` the names of `own` that it lacks, each behind the name before it in `own`. Cases of a sweep may have
/// different elements: the names of the largest case stay in its order.
void merge_names(std::vector<std::string>& all, const std::vector<std::string>& own);

/// sweep.csv, of runs, responses and natural frequencies: a row of names, a row of units, then a row per case: its name, all
/// parameters of the model in SI, expressions included, then the cells of all cases, by merge_names(). A field that a case
/// does not have is empty. `parameters`: names and units.
std::string make_sweep_table(const std::vector<Parameter>& parameters, const std::vector<SweepRow>& rows);

/// Throws Error(model_invalid) for a parameter that is called like a column of ours: "case", "status", "reason", "curve1",
/// "mac1" and so on.
void refuse_column_names(const Model& model);

}  // namespace dttmm::host
