// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "measured/measurement.h"

namespace dttmm::host {

Measurement read_measurement(const std::filesystem::path& file);

}  // namespace dttmm::host
