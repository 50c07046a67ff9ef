// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "record/channels.h"
#include "record/file.h"

namespace dttmm {

/// history.csv: the names, the units, then one row per output time; commas, line feeds, quotes where a text needs them
/// (RFC 4180). A number is the shortest text that reads back as the same double.
///
/// Streamed: rows wait in memory until 64 KiB have come together or the last write is 0.1 s ago, and each write holds whole
/// rows only, so a run that fails, is killed or fills the disk leaves whole rows.
/// Nothing is allocated after the constructor.
class CsvWriter {
public:
    /// Creates the file and writes names and units; empties a file that is there. Throws Error(input_output).
    CsvWriter(const std::filesystem::path& path, const std::vector<Channel>& channels);
    CsvWriter(const CsvWriter&) = delete;
    CsvWriter& operator=(const CsvWriter&) = delete;
    /// Writes the rows that wait, without complaint if that fails.
    ~CsvWriter();

    /// values: one per channel. Throws Error(input_output); the file is then cut to its last whole row.
    void write_row(std::span<const double> values);
    /// Brings all rows to the disk and closes the file. Throws Error(input_output).
    void finish();

private:
    using Clock = std::chrono::steady_clock;

    void write_waiting_rows();

    File file_;
    std::string waiting_;           ///< whole rows not yet written
    std::uintmax_t file_size_ = 0;  ///< bytes written, all whole rows
    Clock::time_point last_write_;
};

}  // namespace dttmm
