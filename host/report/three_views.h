// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// A machine at its start as one SVG picture for light and dark pages: front (seen along y), top and right view in
/// third-angle projection at one scale, and a view from a corner. Bodies are the boxes of their mass and inertia; elements
/// lines, or marks where they have no length, with their local axes; nodes, joints with their axes, loads as arrows, what
/// the ground holds. Names stand where they cover no other one; the picture says how many found no place.
std::string draw_three_views(const Model& model, const ElementCatalogue& catalogue);

}  // namespace dttmm::host
