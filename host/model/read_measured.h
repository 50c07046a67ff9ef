// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// [measured]. Whether its file and its channels exist, and what the noise is, shows where they are used. Faults are
/// reported.
MeasuredSettings read_measured(const TableReader& file);

/// "-plate.corner1.acceleration.z" into the channel and its sign.
void set_channel(MeasuredChannel& channel, std::string_view text);

}  // namespace dttmm::host
