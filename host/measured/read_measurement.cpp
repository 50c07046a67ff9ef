// SPDX-License-Identifier: BSD-3-Clause
#include "measured/read_measurement.h"

#include "measured/csv_reader.h"

namespace dttmm::host {

Measurement read_measurement(const std::filesystem::path& file) { return read_measured_csv(file); }

}  // namespace dttmm::host
