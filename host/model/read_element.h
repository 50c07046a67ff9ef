// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/attachments.h"
#include "model/element_catalogue.h"
#include "model/name_registry.h"

namespace dttmm::host {

/// The [[element]] entries of the file, checked against what the plugins declare; their names go to `names` and must not
/// be those of `others`. Elements with faults, which are reported, are left out. A ground end that moves becomes a fixed
/// node
/// "<element>.ground", which is added to `nodes`, those of `attachments`.
std::vector<Element> read_elements(const TableReader& file, const ElementCatalogue& catalogue,
                                   const Attachments& attachments, const std::vector<const NameRegistry*>& others,
                                   NameRegistry& names, std::vector<Node>& nodes);

}  // namespace dttmm::host
