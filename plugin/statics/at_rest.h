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
    /// As dttmm_plugin.h has them: on the inner nodes, at the node, world axes; then line loads.
    std::vector<Vector6> loads;

    /// All forces so many times.
    void scale_forces(double factor) {
        const auto scale = [&](Link& link) {
            link.force *= factor;
            link.rigid *= factor;
        };
        for (std::vector<Link>& links : elements)
            for (Link& link : links) scale(link);
        for (Held& one : held) scale(one.link);
        for (Vector6& load : loads) load *= factor;
    }
};

}  // namespace dttmm::plugin
