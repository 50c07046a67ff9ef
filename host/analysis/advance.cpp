// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/advance.h"

#include <algorithm>
#include <chrono>

#include "analysis/stop_signals.h"
#include "record/progress_bar.h"

namespace dttmm::host {

Ending advance_to_end(Simulation& simulation, bool quiet) {
    const auto start = std::chrono::steady_clock::now();
    Ending ending;
    ProgressBar progress(quiet ? -1 : 2);
    const uint64_t count = simulation.step_count();
    try {
        while (simulation.index() < count && !StopSignals::requested()) {
            simulation.step();
            if (simulation.index() % 64 == 0)
                progress.update(static_cast<double>(simulation.index()), static_cast<double>(count));
        }
        if (simulation.index() < count) ending = {{"stopped", StopSignals::reason()}, StopSignals::exit_code()};
    } catch (const Error& error) {
        ending = {{"failed", error.what()}, error.code()};
    }
    ending.outcome.wall_time = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ending.outcome.steps = std::max<uint64_t>(simulation.index(), 1) - 1;
    ending.time = simulation.time();
    return ending;
}

}  // namespace dttmm::host
