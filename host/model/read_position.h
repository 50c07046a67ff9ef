// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "model/table_reader.h"

namespace dttmm::host {

/// Reports a position in the world [m] that is farther away, and warns of one on the way there; `label` names whose it is.
void check_position(const ReadContext& context, Place place, const std::string& label, const Eigen::Vector3d& position);

}  // namespace dttmm::host
