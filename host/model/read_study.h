// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "model/table_reader.h"

namespace dttmm::host {

/// [study] as options of `dttmm study` with their values: "--vary", "k1 ~ normal(500 N/mm, 10 %)". What the values say is
/// not looked at here. Faults are reported.
std::vector<std::pair<std::string, std::string>> read_study(const TableReader& file);

}  // namespace dttmm::host
