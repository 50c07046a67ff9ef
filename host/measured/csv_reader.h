// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "measured/measurement.h"

namespace dttmm::host {

/// Reads a table of measured data: a line of names, perhaps a line of units, then numbers. Units may stand in brackets
/// behind the names instead, "ch1 [g]". Commas, semicolons or tabulators part the fields; between semicolons and tabulators
/// a number may have a decimal comma. Lines that begin with '#' are passed over. The first column says what the table is:
///     time        histories, a column each; times in s unless a unit says otherwise
///     frequency   responses: NAME.re and NAME.im, or NAME.magnitude and NAME.phase (deg unless a unit says rad); a column
///                 without such an ending is real; NAME.coherence belongs to NAME. NAME may be "OUTPUT/INPUT"
///     mode        a row per mode: frequency [Hz], perhaps frequency.deviation and damping_ratio, and the shape: a column
///                 for every place and direction, NAME.re and NAME.im of a complex one. The modes.csv of `dttmm modes`, with
///                 a row for every mode and place, too. A table of frequencies, deviations and damping ratios alone needs
///                 no column "mode"
/// Throws Error(input_output) with file:line for a table of another form, a row of another length, a field that is no
/// finite number, and for times or frequencies that do not ascend.
Measurement read_measured_csv(const std::filesystem::path& file);

}  // namespace dttmm::host
