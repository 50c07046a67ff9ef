// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/attachments.h"

namespace dttmm::host {

/// The [[load]] entries of the file. Loads with faults, which are reported, are left out.
std::vector<Load> read_loads(const TableReader& file, const Attachments& attachments);

}  // namespace dttmm::host
