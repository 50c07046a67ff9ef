// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "analysis/run.h"
#include "model/model.h"
#include "record/recorder.h"
#include "step/simulation.h"

namespace dttmm {

/// Key order is as written.
using Json = nlohmann::ordered_json;

/// How a run ended.
struct Outcome {
    std::string status = "completed";  ///< "completed", "stopped", "failed"
    std::string reason;                ///< of a stop or failure
    double wall_time = 0;              ///< [s]
};

/// What determines a run's result: the text of the model, the files it names, the plugins and all that the command line
/// changed. A sweep reuses a case whose
/// inputs are equal.
Json describe_inputs(const Model& model, const RunRequest& request);

/// summary.json: status, inputs, versions, step count and time per step, coupling, omega*h, energy, peak and final values of
/// every element and marker, the resolved model.
Json describe_run(const Model& model, const RunRequest& request, const Plugins& plugins, const Simulation& simulation,
                  const Recorder& recorder, const Outcome& outcome);

}  // namespace dttmm
