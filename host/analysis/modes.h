// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "analysis/sweep_plan.h"
#include "model/error.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Notes what of the model is not in its natural frequencies: gravity and lasting loads.
void warn_preload(const Model& model, Warnings& warnings);

/// Finds the natural frequencies of a model, prints a table (frequency, multiplicity, modal mass, where it moves most, which
/// elements hold the strain energy) or one JSON object, and writes modes.csv (the shape at every body, marker and node),
/// shapes.csv (along beams) and summary.json into the results folder. A range without a frequency gives an empty list.
/// Throws Error: model_invalid for a model in which nothing vibrates, numerical_failure where the count cannot prove the
/// list, resource_limit for frequencies too high to count.
ExitCode find_modes(const Request& request);

/// The same for every case of a sweep, into one table: frequencies against the parameters, each curve followed through
/// crossings by the likeness of its shapes (MAC). Prints it and writes sweep.csv.
ExitCode sweep_modes(const Request& request, const std::vector<SweepAxis>& axes);

/// Frequency response between two places and directions, damping as the elements have it: receptance [m/N], mobility and
/// accelerance as frf.csv in the results folder, its peaks on the terminal.
ExitCode find_response(const Request& request);

}  // namespace dttmm::host
