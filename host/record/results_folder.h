// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "record/file.h"

namespace dttmm::host {

enum class Claim {
    replace,  ///< the old results of a run are removed; those of a sweep, sweep.csv and case-*, stay
    keep,     ///< old results stay: a sweep goes on where it stopped
};

/// A folder that belongs to one run for as long as this lives; what the run has written stays.
/// It is ours when it holds the file `.dttmm-results` and beside it nothing but names that runs write: history.csv,
/// history.h5, summary.json, modes.csv, shapes.csv, frf.csv, static.csv, members.csv, spectrum.csv, sweep.csv and so on,
/// each also as `.part`, and folders `case-*` that are ours in the same sense. The marker is locked while the run lives and
/// says on which host and in which process.
class ResultsFolder {
public:
    /// Claims `path`: a missing folder is made with its parents, an empty one taken, one of ours taken over. A study and
    /// anything else (a foreign entry, a file, no permission, another run in it) throws Error(input_output) and leaves it
    /// untouched. A symbolic link in the folder is removed as a link, never followed.
    explicit ResultsFolder(std::filesystem::path path, Claim claim = Claim::replace);

    /// As asked for.
    const std::filesystem::path& path() const { return path_; }
    /// Where the file `name` of the results is: absolute, seen from the folder in which the process started. A plugin may
    /// have changed the current one since.
    std::filesystem::path file(std::string_view name) const { return absolute_ / name; }
    /// For the terminal: "results/plate/frf.csv (those of 2026-11-22 12:41 are replaced)"; the time is local, and stands
    /// where there were results. name: empty for the folder itself.
    std::string describe(std::string_view name = {}) const;

private:
    std::filesystem::path path_, absolute_;
    std::string replaced_;
    File marker_;  ///< open and locked
};

/// Results that were there before a command began.
class EarlierResults {
public:
    EarlierResults() = default;
    explicit EarlierResults(std::filesystem::path folder);

    /// For the terminal, where the command failed: "results/plate still has the results of 2026-11-22 12:41". Empty where
    /// there were none, or where they are gone.
    std::string left() const;

private:
    std::filesystem::path folder_;
    std::optional<std::filesystem::file_time_type> written_;
};

/// `path` seen from the folder in which the process started.
std::filesystem::path from_start(const std::filesystem::path& path);

/// results/<model name>, seen from the current folder; results/model for the standard input. The model name is the file's,
/// without its ending, or that of the file's folder when the file is called "model": examples/four_bolt_plate/model.toml ->
/// results/four_bolt_plate.
std::filesystem::path default_results_path(const std::filesystem::path& model_path);

}  // namespace dttmm::host
