// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "measured/measurement.h"

namespace dttmm::host {

/// Reads measured data, in whatever format the file is by its content; its suffix does not matter:
///     MAT file         by the mark of its head; levels 5, 7 and 7.3: see read_mat()
///     universal file   its first line that is not blank is "    -1": see read_universal()
///     CSV              any other text: see read_measured_csv()
/// Throws Error(input_output) for a file that cannot be read, for formats that are known but not read, and as the readers
/// named here do.
Measurement read_measurement(const std::filesystem::path& file);

}  // namespace dttmm::host
