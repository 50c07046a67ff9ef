// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "record/column.h"

namespace dttmm::host {

/// A history.csv as CsvWriter writes it, read back. The whole text stands in memory; of the numbers only the columns that
/// are asked for.
class HistoryFile {
public:
    /// Reads names and units. Throws Error(input_output) for a file that cannot be read or is no history: it names the
    /// fault.
    explicit HistoryFile(std::filesystem::path path);

    /// As the file has them; the first is "time" [s].
    const std::vector<Column>& columns() const { return columns_; }
    /// One list of values per column of `wanted` (indices into columns(), ascending). A last line without its line feed is
    /// that of a run that was killed: it is left out. Throws Error(input_output) with file:line for a row with too few or
    /// too many fields, a field that is no number, NaN or infinity.
    std::vector<std::vector<double>> read(const std::vector<int>& wanted) const;
    /// Whether the last line lacks its line feed.
    bool is_torn() const { return !text_.ends_with('\n'); }

private:
    [[noreturn]] void fail(std::size_t line, const std::string& fault) const;

    std::filesystem::path path_;
    std::string text_;
    std::size_t rows_begin_ = 0;  ///< in the text
    std::vector<Column> columns_;
};

}  // namespace dttmm::host
