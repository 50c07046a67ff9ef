// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/run.h"
#include "analysis/sweep_plan.h"

namespace dttmm {

/// What the command line asks of `dttmm modes` beyond what it asks of a run.
struct ModesRequest : RunRequest {
    bool is_verbose = false;  ///< print how the overall transfer equation is laid out
    bool as_json = false;     ///< one JSON object on the standard output instead of the table
};

/// Finds the natural frequencies of a model, prints a table (frequency, multiplicity, modal mass, where it moves most, which
/// elements hold the strain energy) or one JSON object, and writes modes.csv (the shape at every body, marker and node),
/// shapes.csv (along beams) and summary.json into the results folder. A range without a frequency gives an empty list.
/// Throws Error: model_invalid for a model in which nothing vibrates, numerical_failure where the count cannot prove the
/// list, resource_limit for frequencies too high to count.
ExitCode find_modes(const ModesRequest& request);

/// The same for every case of a sweep, into one table: frequencies against the parameters, each curve followed through
/// crossings by the likeness of its shapes (MAC). Prints it and writes sweep.csv.
ExitCode sweep_modes(const ModesRequest& request, const std::vector<SweepAxis>& axes);

/// What is moved and what is looked at: "plate.corner1.z"; from, to and number of the frequencies.
struct FrfRequest : RunRequest {
    std::string input, output_place;  ///< "body.marker.direction"
    std::string from, to;             ///< frequencies, as texts with units
    int points = 0;
    bool is_logarithmic = false;
};

/// Frequency response between two places and directions, damping as the elements have it: receptance [m/N], mobility and
/// accelerance as frf.csv in the results folder, its peaks on the terminal.
ExitCode find_response(const FrfRequest& request);

}  // namespace dttmm
