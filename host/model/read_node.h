// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/name_registry.h"

namespace dttmm::host {

/// The [nodes] of the file, each `name = [x, y, z]` or a table with `position`; their names go to `names` and must not be
/// those of `others`. Faults are reported.
std::vector<Node> read_nodes(const TableReader& file, const std::vector<const NameRegistry*>& others, NameRegistry& names);

/// `motion = { z = "-5 mm" }` of a node, in its fixed directions only. label: what messages call the node. Faults are
/// reported.
void read_motion(const ReadContext& context, const TomlMember& member, const std::string& label, Node& node);

}  // namespace dttmm::host
