// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/model.h"
#include "world/world.h"

namespace dttmm::test {

using namespace host;

/// Where a model's bodies start, as the engine has them.
inline std::vector<BodyState> start_states(const Model& model) {
    const World world(model.bodies);
    std::vector<BodyState> at(model.bodies.size());
    world.read_states(at);
    return at;
}

}  // namespace dttmm::test
