// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "identify/unknowns.h"
#include "model/parameters.h"

namespace dttmm::host {

/// What is known of unknowns before: rows that are added to those of the data.
struct Prior {
    size_t unknown;
    double mean = 0, deviation = 0;  ///< of the value, or where it is lognormal of its logarithm
    bool is_of_logarithm = false;
};

/// Priors as --prior gives them. Throws Error(usage).
std::vector<Prior> read_priors(const std::vector<std::string>& texts, const Unknowns& unknowns,
                               const std::vector<Parameter>& parameters);

}  // namespace dttmm::host
