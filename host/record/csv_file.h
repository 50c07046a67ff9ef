// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "record/column.h"

namespace dttmm::host {

/// The whole of a file. Throws Error(input_output).
std::string read_whole_file(const std::filesystem::path& path);

/// The fields of the record at `begin`, without their quotes (RFC 4180). `begin` moves behind its line feed.
std::vector<std::string> csv_record(std::string_view text, std::size_t& begin);

/// A table of results as CsvTable and CsvWriter write it, read back: names, units, rows of numbers and texts.
class CsvFile {
public:
    /// Throws Error(input_output) with file:line for a row with too few or too many fields and for a number that cannot be
    /// read. A last line without its line feed is that of a command that was killed: it is left out.
    explicit CsvFile(std::filesystem::path path);

    const std::filesystem::path& path() const { return path_; }
    const std::vector<Column>& columns() const { return columns_; }
    std::size_t rows() const { return rows_; }
    bool is_torn() const { return is_torn_; }
    /// Index of the column called `name`; -1 if there is none.
    int find(std::string_view name) const;
    /// Whether a column holds texts: it has no unit.
    bool is_text(std::size_t column) const { return columns_[column].unit.empty(); }
    /// One per row: the texts of a column without unit; the numbers of one with a unit, NaN where the field is empty.
    const std::vector<std::string>& texts(std::size_t column) const { return texts_[column]; }
    const std::vector<double>& numbers(std::size_t column) const { return numbers_[column]; }

private:
    void take(std::size_t column, const std::string& field, std::size_t line);
    [[noreturn]] void fail(std::size_t line, const std::string& fault) const;

    std::filesystem::path path_;
    std::vector<Column> columns_;
    std::vector<std::vector<std::string>> texts_;
    std::vector<std::vector<double>> numbers_;
    std::size_t rows_ = 0;
    bool is_torn_ = false;
};

}  // namespace dttmm::host
