// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/session.h"
#include "record/recorder.h"

namespace dttmm::host {

/// Warns of what the rows and the steps of a run tell against its numbers: energy made or lost, forces that alternate, loads
/// and vibrations that the step does not resolve, elements beyond what their laws hold for. simulation: the one whose rows
/// are recorded.
void warn_of_run(Session& session, const Simulation& simulation, const Recorder& recorder);

}  // namespace dttmm::host
