// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/model.h"
#include "model/name_registry.h"

namespace dttmm::host {

/// The [[body]] entries of the file. Bodies with faults, which are reported, are among them with what could be read, so that
/// what refers to them is not reported too.
std::vector<Body> read_bodies(const TableReader& file, NameRegistry& names);

}  // namespace dttmm::host
