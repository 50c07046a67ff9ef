// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// How a frame has moved from the assembled machine to where it rests. What goes with it may have other axes there: those of
/// a support are the world's, those of its node may be any.
struct MovedFrame {
    Vector3 start;  ///< its origin in the assembled machine [m]
    Vector3 now;    ///< the same at rest [m]
    Matrix3 turn;   ///< rotation from start to rest, world axes
    /// What goes with it, by where that is in the assembled machine.
    Vector3 point(const Vector3& at_start) const { return now + turn * (at_start - start); }
    Pose pose(const Pose& at_start) const { return {point(at_start.position), turn * at_start.rotation}; }
};

/// A network at rest: where its frames have come to, and the forces of its joints there.
struct AtRest {
    /// A joint: its frames, the elastic forces along its deformations, the forces in its rigid directions.
    struct Link {
        MovedFrame from, to;
        Vector6 force, rigid;
    };
    std::vector<std::vector<Link>> elements;  ///< by element of the description: its joints in order
    /// Joints that hold the fixed directions of nodes.
    struct Held {
        uint32_t node;  ///< of the description
        Link link;
    };
    std::vector<Held> held;
    /// As dttmm_plugin.h has them: on the inner nodes, at the node, world axes; then line loads.
    std::vector<Vector6> loads;
    Vector3 gravity = Vector3::Zero();  ///< on the masses of the network [m/s²]

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
        gravity *= factor;
    }
};

}  // namespace dttmm::plugin
