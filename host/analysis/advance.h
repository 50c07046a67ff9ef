// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "model/error.h"
#include "step/simulation.h"

namespace dttmm::host {

/// How a run ended.
struct Outcome {
    std::string status = "completed";  ///< "completed", "stopped", "failed"
    std::string reason;                ///< of a stop or failure
    double wall_time = 0;              ///< [s]
    uint64_t steps = 0;                ///< of the motion recorded, taken in that time; one more closes the last row
};

struct Ending {
    Outcome outcome;
    ExitCode code = ExitCode::ok;
    double time = 0;  ///< reached [s]
};

/// Steps to the end of the duration, or to a stop signal. A failure on the way is an outcome too: what was recorded is kept.
/// Shows progress unless `quiet`.
Ending advance_to_end(Simulation& simulation, bool quiet);

}  // namespace dttmm::host
