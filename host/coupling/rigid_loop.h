// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// Whether elements that are rigid in some direction close a loop of bodies, nodes and the ground. Where such a loop comes
/// to a singular position, no step is short enough for Newton's iteration.
bool form_rigid_loop(const Model& model, const ElementCatalogue& catalogue);

}  // namespace dttmm::host
