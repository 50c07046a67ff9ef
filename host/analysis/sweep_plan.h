// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "model/parameters.h"

namespace dttmm::host {

/// One --sweep: a parameter and the values it takes, as texts for --set.
struct SweepAxis {
    std::string name;
    std::vector<std::string> values;
};

/// One case of a sweep: name = value for every axis.
using SweepCase = std::vector<std::pair<std::string, std::string>>;

inline constexpr long kMostCases = 100000;

/// "k1=300N/mm..500N/mm:9" (both ends included, evenly spaced) or "k1=400N/mm,450N/mm". Both ends must have the same
/// dimension. Throws Error(usage) for the wrong form, Error(model_invalid) for a count below 1 or beyond kMostCases, a count
/// of 1 between ends that differ, an empty list, or a value that is no quantity.
SweepAxis parse_sweep_axis(const std::string& text);

/// The cases give a parameter its values: throws Error(usage) where --set gives it one too. option: what makes the cases.
void refuse_set_beside(const std::string& option, const std::string& name, const Parameters::Overrides& set);

/// Every axis must name one of the parameters of the model that --set does not name, and give a unit where the parameter has
/// one. Throws Error(usage), or Error(model_invalid) for a value of another dimension.
void check_axes(const std::vector<SweepAxis>& axes, const std::vector<Parameter>& parameters,
                const Parameters::Overrides& set);

/// All combinations, the last axis fastest. Throws Error(model_invalid) beyond kMostCases, Error(usage) if two axes have one
/// name.
std::vector<SweepCase> make_grid(const std::vector<SweepAxis>& axes);

}  // namespace dttmm::host
