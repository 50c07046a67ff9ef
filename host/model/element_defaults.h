// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/element_catalogue.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// Gives every body, joint and load of the document the keys of [defaults.body], [defaults.joint] and [defaults.load] that
/// it has not itself; a key that it has counts whole. Faults of all defaults are reported; those of what the model has not
/// are warned of.
void apply_defaults(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue);

/// The same of elements, by [defaults.<element type>]. Takes [defaults] out of the document.
void apply_element_defaults(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue);

}  // namespace dttmm::host
