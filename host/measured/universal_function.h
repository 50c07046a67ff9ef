// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>

#include "measured/measurement.h"
#include "measured/remarks.h"
#include "measured/universal_text.h"

namespace dttmm::host {

/// What data set 164 says: numbers of the file are divided by these to get SI. Of length and of force.
struct UniversalFactors {
    double length = 1, force = 1;
};

/// Reads data set 58, a function at discrete abscissae, and its end line. number_line, "    58" or "    58b ...", is taken
/// already. factors: of data set 164; none: the unit texts of the file stand.
///     kind          type 1 is a history, 4 a response, 6 a coherence, each over its own abscissa; others are `other`
///     name          "12.z" of node and direction, "12" of direction 0. Node 0 is no place: the first line of the set
///                   gives the name if it reads "name [unit]", or else the entity, the label of the ordinate, that line
///     is_reversed   a negative direction; of a response either of its two
///     abscissa      [s] or [Hz] where its type code or its unit text says so; otherwise as it is, with a remark
/// A complex history without imaginary parts is real. One with them is `other`. Points without a finite value are left out.
/// None: the function is of no use, and remarks say why. Throws Error(input_output) for a set that is cut off, for a head
/// that breaks the rules, for a field that is no number, and for floating-point formats of VAX and IBM. What the head
/// promises is compared with the size of the file before memory is taken.
/// Source: SDRC, Universal File Formats, data set 58.
std::optional<MeasuredSignal> read_universal_function(UniversalText& text, std::string_view number_line,
                                                      const std::optional<UniversalFactors>& factors, Remarks& remarks);

}  // namespace dttmm::host
