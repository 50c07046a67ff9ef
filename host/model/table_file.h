// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

struct TableColumn {
    std::string word, plural;  ///< "time", "times", for messages
    std::string unit;          ///< SI
    std::string heading;       ///< an example of one, "t [ms]"
};

/// A file of columns separated by commas: rows of plain numbers [SI], the first column ascending. Empty lines and lines that
/// begin with '#' are passed over. A line of headings may come first, and a line of units, e.g. "ms,kN", after it or alone;
/// both hold no number. The units may stand in brackets in the headings. Without units the numbers are SI. `name` is
/// relative to `folder`, the model's, and must not lead out of it, not even by a link; the file must be a regular one of at
/// most 64 MiB. Throws Error(model_invalid) that names the rule and the row, never what stands in the file.
std::vector<std::vector<double>> read_columns_file(const std::filesystem::path& folder, const std::string& name,
                                                   const std::vector<TableColumn>& columns);

struct TimeTable {
    std::vector<double> times;   ///< [s]
    std::vector<double> values;  ///< SI
};

/// The same of two columns, time and value. `unit` is the SI unit of the values.
TimeTable read_table_file(const std::filesystem::path& folder, const std::string& name, std::string_view unit);

}  // namespace dttmm::host
