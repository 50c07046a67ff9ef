// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "modal/frequency_model.h"

namespace dttmm::plugin {

/// Adds to a machine the stiffness of the forces that act at the start: of those of joints along lines, and of the reaction
/// forces with which rigid directions bear them, not of their moments. A force F that keeps its direction while its lever
/// arm a turns with the frame has the symmetric part of −∂(a × F)/∂θ. What F adds across its own line, F/L, is in the
/// bond. Throws what DynamicStiffness::cut() throws.
void add_geometric_stiffness(FrequencyModel& model);

}  // namespace dttmm::plugin
