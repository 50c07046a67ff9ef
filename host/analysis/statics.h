// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// `dttmm static`: finds the equilibrium of a model under its weight and its loads at one instant; prints displacements and
/// forces, and writes the row that a run would record there to static.csv, and summary.json. Throws Error as read_model and
/// Equilibrium do.
ExitCode find_equilibrium(const Request& request);

}  // namespace dttmm::host
