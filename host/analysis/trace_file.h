// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "record/file.h"
#include "step/simulation.h"

namespace dttmm::host {

/// A CSV file with a row per time step: how its end was found. Names, units, rows, as history.csv has them. What is there
/// stays if the run fails, the row of the failing step included.
class TraceFile {
public:
    /// Throws Error(input_output).
    explicit TraceFile(const std::filesystem::path& path);
    TraceFile(const TraceFile&) = delete;
    TraceFile& operator=(const TraceFile&) = delete;
    /// Writes the rows that wait, without complaint if that fails.
    ~TraceFile();

    void write(const Simulation& simulation, const StepReport& report);

private:
    File file_;
    std::string waiting_;
};

}  // namespace dttmm::host
