// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/json.h"
#include "model/read_element.h"

namespace dttmm::host {

/// The JSON schema (draft 7) of the model file, from the tables of keys and the element types of a catalogue. Quantities and
/// expressions are texts in it: their units are for `dttmm check`. An object of `[[element]]` has the keys of all types, and
/// beside them one condition per type that closes it, so that editors complete keys before the type is known and name the
/// key that is wrong after.
Json make_schema(const ElementCatalogue& catalogue);

}  // namespace dttmm::host
