// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// Numbers with units, e.g. "500 N/mm", "300N/mm", "1e-3". Units are those of UDUNITS-2 (and "deg"), as products of powers
/// only: nothing with an offset (degC), a logarithm or a date passes. A plain number is SI and fits every dimension.
/// Decimal point and digits are the same in every locale. All functions throw Error(model_invalid) with a text that names
/// the fault and the cure, not the place. Thread-safe.

struct Quantity {
    double value = 0;        ///< SI
    std::string unit = "1";  ///< the SI unit as text; "1" for a pure number
};

/// A number with its unit, of whatever dimension.
Quantity parse_quantity(std::string_view text);

/// The SI value of `text`, which must measure what the SI unit `wanted` measures.
double parse_quantity(std::string_view text, std::string_view wanted);

/// The unit of a quantity as it is written: "N/mm" of "500 N/mm"; empty for a plain number.
std::string unit_text(std::string_view text);

/// Whether a value in `unit` may stand where `wanted` is asked for. The radian counts: "N*m" may stand for "N*m/rad" and
/// "1/s" for "rad/s", but "rad/s" not for "Hz", nor "Hz" or "1/min" for "rad/s", between which 2 pi would be lost.
bool measures(std::string_view unit, std::string_view wanted);

/// Usual units by dimension, the SI unit of each row first. Of rows of one dimension the first names it.
const std::vector<std::vector<std::string>>& usual_units();

/// The usual units of the dimension of `wanted`, that one first.
std::vector<std::string> accepted_units(std::string_view wanted);

}  // namespace dttmm::host
