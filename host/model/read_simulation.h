// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// What the command line says instead of [simulation] and [output]: texts as in the file, e.g. "1 ms" or "0.1 %".
struct SimulationOverrides {
    std::optional<std::string> step, duration, coupling, tolerance, output_step;
    std::vector<std::string> channels;  ///< patterns; none: the file's
};

/// Shortest, longest and most steps of a run [s, s, 1].
inline constexpr double kMostSteps = 1e10;

/// Tolerance of a run that is given neither step nor tolerance. Loads and stiffness are seldom known better.
inline constexpr double kDefaultTolerance = 0.01;

/// The name of a velocity formula in the model file, e.g. "fox-euler".
const std::string& scheme_name(ExplicitScheme scheme);

/// [simulation]: step 1e-9 s to 1 s, a duration that is a whole number of steps, at most 1e10, and a tolerance of 1e-9 to
/// 0.5. Without a step the run is one to a tolerance, kDefaultTolerance unless given. The duration may be missing where it
/// is not for a run. Faults are reported.
SimulationSettings read_simulation(const TableReader& file, const SimulationOverrides& overrides, bool is_for_run);

/// [output]: its step is a whole number of time steps, where these are given, and divides the duration, so that the end is a
/// row. Faults are reported.
OutputSettings read_output(const TableReader& file, const SimulationSettings& simulation,
                           const SimulationOverrides& overrides);

}  // namespace dttmm::host
