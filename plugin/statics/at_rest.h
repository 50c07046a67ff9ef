// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// A network at rest: where its frames have come to, and the forces of its joints there.
struct AtRest {
    /// A joint: its frames, the elastic forces along its deformations, the forces in its rigid directions.
    struct Link {
        Frame from, to;
        Vector6 force, rigid;
    };
    std::vector<std::vector<Link>> elements;  ///< by element of the description: its joints in order
    /// Joints that hold the fixed directions of nodes.
    struct Held {
        Vector3 position;  ///< in the assembled machine [m]
        Link link;
    };
    std::vector<Held> held;
    std::vector<Vector6>
        loads;  ///< as dttmm_plugin.h has them: on the inner nodes, at the node, world axes; then line loads
};

}  // namespace dttmm::plugin
