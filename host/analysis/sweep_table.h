// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "model/model.h"
#include "record/column.h"

namespace dttmm::host {

/// A case as sweep.csv shows it.
struct SweepRow {
    std::vector<Parameter> parameters;  ///< those that are known, in any order
    /// Of the columns behind the parameters; those that are missing are empty.
    std::vector<std::variant<double, std::string>> cells;
};

/// How folders, sweep.csv and messages call a case, counted from 0: "case-000001".
std::string case_name(size_t index);
/// Says so where the folder of a sweep of `count` cases has the next case too: it is of an earlier sweep.
void tell_of_earlier_cases(const std::filesystem::path& folder, size_t count);

/// sweep.csv, of runs and of natural frequencies: a row of names, a row of units, then a row per case: its name, all
/// parameters of the model in SI, expressions included, then `columns`. `parameters`: names and units.
std::string make_sweep_table(const std::vector<Parameter>& parameters, const std::vector<Column>& columns,
                             const std::vector<SweepRow>& rows);

/// Throws Error(model_invalid) for a parameter that is called like a column of ours: "case", "status", "reason", "curve1",
/// "mac1" and so on.
void refuse_column_names(const Model& model);

}  // namespace dttmm::host
