// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/attachments.h"
#include "model/element_catalogue.h"
#include "model/name_registry.h"

namespace dttmm::host {

/// The [[element]] entries of the file, checked against what the plugins declare; their names go to `names` and must not
/// be those of `others`. Elements with faults, which are reported, are left out.
std::vector<Element> read_elements(const TableReader& file, const ElementCatalogue& catalogue,
                                   const Attachments& attachments, const std::vector<const NameRegistry*>& others,
                                   NameRegistry& names);

}  // namespace dttmm::host
