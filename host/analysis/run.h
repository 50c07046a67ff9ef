// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>

#include "analysis/request.h"
#include "analysis/session.h"
#include "model/error.h"
#include "record/results_folder.h"

namespace dttmm::host {

/// Runs a model from 0 to its duration into its results folder and prints the table of peak and final forces; with a
/// tolerance, repeats that at half the step until it is reached. A run that fails or is stopped half way leaves what it has
/// recorded, with the reason in summary.json. Returns ok, or the stop signal's code; throws Error for everything else,
/// numerical_failure also when an explicit coupling would be unstable and force is not set (to a tolerance it starts from a
/// stable step), or when the tolerance is out of reach.
ExitCode run(const Request& request);

/// A row of a run: of all channels, or of a run to a tolerance of session.selection.
using TakeRow = std::function<void(std::span<const double> values)>;
/// The same of a session, for a command that has the stop signals; `take`, unless empty, gets every row too.
ExitCode run(const Request& request, Session& session, const ResultsFolder& folder, const TakeRow& take);

}  // namespace dttmm::host
