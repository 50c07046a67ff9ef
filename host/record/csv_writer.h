// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "record/column.h"
#include "record/file.h"

namespace dttmm::host {

/// Adds `text` to a line of a CSV file as a field: between quotes where it needs them (RFC 4180).
void add_csv_field(std::string_view text, std::string& line);

/// Two rows: the names of `columns`, then their units.
std::string csv_header(const std::vector<Column>& columns);

/// history.csv: the names, the units, then one row per output time; commas, line feeds, quotes where a text needs them
/// (RFC 4180). A number is the shortest text that reads back as the same double.
///
/// Streamed: rows wait in memory until 64 KiB have come together or the last write is 0.1 s ago, and each write holds whole
/// rows only, so a run that fails, is killed or fills the disk leaves whole rows. One gap is left: SIGKILL may stop Linux
/// between two pages of one write. So no write crosses a page but for a single row that does; if the kill hits just that,
/// the torn row is the last and lacks its line feed (1 in 1200 kills at 20 000 rows a second, 2 in 100 of a process that
/// does nothing but write). Nothing is allocated after the constructor.
class CsvWriter {
public:
    /// Creates the file and writes names and units; empties a file that is there. Throws Error(input_output).
    CsvWriter(const std::filesystem::path& path, const std::vector<Column>& columns);
    CsvWriter(const CsvWriter&) = delete;
    CsvWriter& operator=(const CsvWriter&) = delete;
    /// Writes the rows that wait, without complaint if that fails.
    ~CsvWriter();

    /// values: one per column. Throws Error(input_output); the file is then cut to its last whole row.
    void write_row(std::span<const double> values);
    /// Brings all rows to the disk and closes the file. Throws Error(input_output).
    void finish();

    /// Writes the whole rows that wait, for a process that ends without its destructors: of the writer made last, if it is
    /// still there. Does nothing while that writer is at work on them. Async-signal-safe.
    static void rescue_rows() noexcept;

private:
    using Clock = std::chrono::steady_clock;
    class AtWork;

    void write_waiting_rows();
    std::size_t size_of_next_write(std::string_view rest) const;
    [[noreturn]] void fail(std::string_view written);

    File file_;
    std::string waiting_;           ///< whole rows not yet written
    std::uintmax_t file_size_ = 0;  ///< bytes written, all whole rows
    Clock::time_point last_write_;
    volatile std::sig_atomic_t is_at_work_ = 0;  ///< on the waiting rows: a signal must leave them alone
};

}  // namespace dttmm::host
