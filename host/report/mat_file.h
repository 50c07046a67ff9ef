// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "report/results.h"

namespace dttmm::host {

/// Names of MATLAB for names of channels: "bolt1.force.z" is bolt1_force_z. Letters, digits and underscores stay, any
/// other character is an underscore; a name begins with a letter, is no keyword, has at most 63 characters, and comes once.
class MatlabNames {
public:
    std::string take(std::string_view name);

private:
    std::set<std::string> taken_;
};

/// Writes results as a MAT file, level 5, compressed:
///     time, frequency, ...   places of a set of curves, n×1
///     bolt1_force_z, ...     a curve, n×1, with all its digits; complex where it has a phase; NaN where it has no value
///     channels               struct array, one per curve: name, unit, variable, over (the variable of its places),
///                            over_unit, file, label ("order 2")
///     modes, levels, ...     a struct per table of the folder: columns as numbers n×1 or cells of texts, and their units
///     parameters             struct: values of the model's parameters, SI
///     title, kind, version, model_text, command_line
/// Returns what was written. Throws Error(input_output).
std::string write_mat(const Results& results, const std::vector<CsvFile>& tables, const std::filesystem::path& path);

}  // namespace dttmm::host
