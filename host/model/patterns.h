// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "model/element_catalogue.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// Patterns are written out in the tree of the file before anything else reads it: no other reader knows of them. What a
/// copy holds keeps the place of the text it was made from.

/// Moves the parameters that [[repeat]] tables hold into [parameters]. Faults are left for expand_patterns.
void expand_parameters(TomlValue& document);

/// Replaces every [[repeat]], [[body.repeat]] and [[bolt_circle]] by the tables that it makes, behind those of the file.
/// Faults are reported. before_circles is called when all but the bolt circles is there, which need the markers of bodies.
void expand_patterns(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue,
                     const std::function<void(TomlValue&)>& before_circles);

}  // namespace dttmm::host
