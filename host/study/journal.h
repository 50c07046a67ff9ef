// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "record/file.h"

namespace dttmm::host {

/// What became of a case of a study.
struct CaseOutcome {
    std::string status = "missing";  ///< "completed", "failed", "missing"
    std::string reason = {};         ///< of a failure
    size_t warnings = 0;
    std::vector<double> figures = {};  ///< in the order of the study; NaN: the case has none of this name
    int attempt = 0;                   ///< that it came from
    bool unlisted = false;             ///< it has figures that the study has no column for
};

/// Where a worker notes its cases, a line each, in a file of its own: when it begins one and when it ends one. A line is
/// there whole or not at all: what a killed worker or a full disk left of one is passed over by readers. Nobody rewrites a
/// journal.
class Journal {
public:
    /// Makes the file `name`, which must be new. Throws Error(input_output).
    Journal(const std::filesystem::path& folder, const std::string& name);

    /// index: of the case, from 0. Throw Error(input_output) where the line did not reach the file.
    void begin(size_t index);
    void end(size_t index, const CaseOutcome& outcome);

    /// A name that no other worker has: host, process, instant.
    static std::string make_name();

private:
    void write_line(const std::string& line);
    File file_;
    std::uintmax_t size_ = 0;
};

/// All journals of a study as they stand. Reading goes on where it stopped, so that it can be done again and again while
/// workers write.
class Journals {
public:
    explicit Journals(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Reads what has come since; calls take(index, outcome) for every case that ended. Throws Error(input_output) for a
    /// journal that cannot be read: what it holds would be taken for not done.
    void read(const std::function<void(size_t index, CaseOutcome&& outcome)>& take);
    /// The case that the worker with this journal has begun and not ended.
    std::optional<size_t> open_case(const std::string& name) const;

private:
    struct Reading {
        std::uintmax_t done = 0;  ///< bytes
        std::optional<size_t> open;
    };
    void read_file(const std::filesystem::path& file, Reading& reading,
                   const std::function<void(size_t index, CaseOutcome&& outcome)>& take) const;

    std::filesystem::path folder_;
    std::map<std::string, Reading> readings_;  ///< by the name of the file
};

/// Of two outcomes of one case the one that counts: one that completed, else the one of the later attempt.
bool counts_more(const CaseOutcome& one, const CaseOutcome& other);

}  // namespace dttmm::host
