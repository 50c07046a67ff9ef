// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "record/column.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Channels of a recorded run in a window of time: equally spaced rows, every value finite.
class RecordedRun {
public:
    /// results: folder of a run or its history.csv. Throws Error(input_output) for anything else, and says what it is.
    RecordedRun(const std::filesystem::path& results, Warnings& warnings);

    /// patterns: globs as in --channels, several in one text parted by commas; none: all that are not energies or
    /// quaternions. always: one more channel by its full name, or empty. from, to: texts with units, or empty. Throws
    /// Error(usage) for a pattern without a channel, a window outside of the record and one of fewer than two rows;
    /// Error(input_output) for rows that are not equally spaced.
    void read(const std::vector<std::string>& patterns, const std::string& always, const std::string& from,
              const std::string& to);

    const std::vector<Column>& channels() const { return channels_; }
    /// Of each channel, one per row of the window.
    const std::vector<std::vector<double>>& values() const { return values_; }
    /// The values of `always`, and its unit.
    const std::vector<double>& always() const { return always_; }
    const std::string& always_unit() const { return always_unit_; }
    std::size_t rows() const { return rows_; }
    double start() const { return start_; }                                     ///< of the window [s]
    double interval() const { return interval_; }                               ///< between rows [s]
    double duration() const { return static_cast<double>(rows_) * interval_; }  ///< rows times interval: 1/resolution
    /// summary.json of the run; null where there is none.
    const Json& summary() const { return summary_; }
    const std::filesystem::path& history() const { return history_; }

private:
    void check_spacing(const std::vector<double>& times);

    Warnings& warnings_;
    std::filesystem::path history_;
    Json summary_;
    std::vector<Column> channels_;
    std::vector<std::vector<double>> values_;
    std::vector<double> always_;
    std::string always_unit_;
    std::size_t rows_ = 0;
    double start_ = 0, interval_ = 0;
};

/// Patterns parted by commas, each on its own.
std::vector<std::string> split_at_commas(const std::vector<std::string>& texts);

/// A JSON file; null if it is not there or cannot be read as JSON.
Json read_json_file(const std::filesystem::path& file);

}  // namespace dttmm::host
