// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "model/element_catalogue.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// Beams and rods that one table describes and that are several elements with nodes between.
///
/// `sections = [{ length, ... }, ...]` of element "spindle": elements "spindle1", "spindle2", ..., with the keys of the
/// element and those of the section, which count first; nodes "spindle_1", ... where one section meets the next.
/// [[probe]] "mid" on line "spindle": a node "mid" at a distance from its `from` end; what is behind it is element
/// "spindle_mid".
/// Forces per length on a line of several parts act on all of them.
/// [[probe]] on a body: a marker of the body.
///
/// Replaces them in the document. Faults are reported. Returns the markers that are probes, as "body.marker".
std::vector<std::string> cut_lines(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue);

}  // namespace dttmm::host
