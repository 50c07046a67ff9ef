// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "analysis/advance.h"
#include "analysis/halving.h"
#include "analysis/json.h"
#include "analysis/run.h"
#include "model/model.h"
#include "record/recorder.h"
#include "record/warnings.h"
#include "step/simulation.h"

namespace dttmm::host {

/// What determines a run's result: the text of the model, the files it names, the plugins and all that the command line
/// changed. A sweep reuses a case whose
/// inputs are equal.
Json describe_inputs(const Model& model, const Request& request);
/// The same as member "inputs".
void write_inputs(JsonWriter& out, const Model& model, const Request& request);

/// A number that tells whether a file has changed; of none that of an empty one.
std::string digest_of(const std::filesystem::path& path);

/// [{"code", "text"}, ...]
Json describe_warnings(const Warnings& warnings);

/// Member "model", as it was solved: parameters, bodies, nodes, loads, joints, elements, all in SI; settings of a run if the
/// file has them.
void write_model(JsonWriter& out, const Model& model, const ElementCatalogue& catalogue);

/// What write_run, warn_of_run and the table of a run need of a channel's statistics.
Recorder::Counts counts_in_summary(const Channel& channel);

/// Members of a run's summary.json: status, warnings, inputs, versions, step count and time per step, coupling, omega*h,
/// energy, peak and final values of every element, joint and marker, the resolved model. `simulation` is the run whose
/// results are kept; `halving`, of a run to a tolerance, says what stands behind them, else null.
void write_run(JsonWriter& out, const Model& model, const Request& request, const Plugins& plugins,
               const Simulation& simulation, const Recorder& recorder, const Outcome& outcome, const Halving* halving,
               const Warnings& warnings);

}  // namespace dttmm::host
