// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "model/index.h"
#include "model/model.h"
#include "record/column.h"

namespace dttmm::host {

/// The numbered cases of a study: what each gives the parameters that differ from case to case.
struct CaseTable {
    std::vector<Column> parameters;  ///< names and SI units
    Eigen::MatrixXd values;          ///< a row per case [SI]

    size_t cases() const { return as_size(values.rows()); }
    /// name → text of a value, as --set takes them. index: from 0.
    std::vector<std::pair<std::string, std::string>> settings(size_t index) const;
    /// cases.csv: names, units, a row per case; the first column is its number from 1.
    std::string text() const;
    /// What text() gave. Throws Error(input_output), `file` named, for anything else.
    static CaseTable parse(const std::string& text, const std::filesystem::path& file);
};

inline constexpr long kMostStudyCases = 10'000'000;

/// Reads a table of cases: names, perhaps units, a row per case, as cases.csv or a spreadsheet has them; a column "case" is
/// left out. A cell is a number in the unit of its column, else in SI, or a quantity as "500 N/mm". Throws Error: usage for
/// a column that is no parameter and for a value without the unit that the file gives, model_invalid for a cell that is no
/// number, input_output for a file that cannot be read.
CaseTable read_case_table(const std::filesystem::path& file, const std::vector<Parameter>& parameters);

}  // namespace dttmm::host
