// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/attachments.h"
#include "model/name_registry.h"

namespace dttmm::host {

/// The [[joint]] entries of the file; `others` are names that a joint cannot have. Joints with faults, which are reported,
/// are left out.
std::vector<Joint> read_joints(const TableReader& file, const Attachments& attachments, const std::vector<Body>& bodies,
                               const std::vector<const NameRegistry*>& others);

/// As the model file writes it, e.g. "hinge".
const std::string& joint_type_name(JointType type);

}  // namespace dttmm::host
