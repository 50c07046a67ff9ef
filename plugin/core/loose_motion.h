// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <string>

#include "core/index.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

/// The rule and the cure where nothing determines a motion. axes: in which its direction counts; lacks: it has no mass or
/// inertia of its own there.
inline std::string nothing_determines(int direction, const char* axes, bool lacks) {
    const bool shifts = direction < 3;
    return fmt::format(
        "nothing determines its motion in {} ({} axes): {}no element holds it there; give it a stiffness, {} or "
        "a `fixed` direction",
        kDirectionNames[as_size(direction)], axes,
        !lacks   ? ""
        : shifts ? "it has no mass, and "
                 : "it has no inertia, and ",
        shifts ? "a mass" : "an inertia");
}

}  // namespace dttmm::plugin
