// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dttmm {

struct TimeTable {
    std::vector<double> times;   ///< [s]
    std::vector<double> values;  ///< SI
};

/// A file of two columns, time and value, separated by a comma: plain SI numbers. Empty lines, lines that begin with '#' and
/// a first line of headings are passed over. `name` is relative to `folder`, the model's, and must not lead out of it, not
/// even by a link; the file must be a regular one of at most 64 MiB.
/// Throws Error(model_invalid) that names the rule and the row, never what stands in the file.
TimeTable read_table_file(const std::filesystem::path& folder, const std::string& name);

}  // namespace dttmm
