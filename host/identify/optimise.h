// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// "min FIGURE", "max FIGURE" or "FIGURE = VALUE".
struct Goal {
    enum class Kind : unsigned char { least, most, value };
    Kind kind = Kind::least;
    std::string figure;
    std::string value;  ///< a text with unit
};

/// Throws Error(usage) for another form.
Goal parse_goal(const std::string& text);

/// `dttmm optimise`: values of parameters within ranges that make a figure least, most or a value: sequential quadratic
/// programming (NLopt's SLSQP, after Kraft 1988) from many starting points of a Sobol sequence. Prints the best and writes
/// optimise.json and optimise.csv, a row per starting point. Throws Error(usage) for a goal that is no single figure.
ExitCode optimise(const Request& request);

}  // namespace dttmm::host
