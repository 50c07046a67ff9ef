// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// What a model is made of, for the eye to check: mass, size and centre of mass of every body and of all bodies; length and
/// local x axis of every element. World axes at the start, SI units. At most 40 bodies and 40 elements, then "and N more".
/// The size of a body is that of the box with its mass and its inertia; for a box the box itself.
std::string describe_machine(const Model& model, const ElementCatalogue& catalogue);

}  // namespace dttmm::host
