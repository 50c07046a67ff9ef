// SPDX-License-Identifier: BSD-3-Clause
#include "statics/frame_links.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

std::vector<Link> links_of(const Mechanism& mechanism) {
    const int driven = mechanism.assembly.driven_count;
    std::vector<Link> links;
    for (const Joint& joint : mechanism.joints)
        links.push_back(
            {std::max(joint.from() - driven, -1), std::max(joint.to() - driven, -1), as_int(joint.rigid().count())});
    return links;
}

/// Levers shorter than this are rounding of places [m].
double least_lever(const Mechanism& mechanism) {
    constexpr double kRounding = 1e-14;  // 45 epsilon: sums and turns of a handful of places
    double size = 1;
    for (const FrameSpec& frame : mechanism.assembly.frames) size = std::max(size, frame.pose.position.norm());
    return kRounding * size;
}

Matrix6 rigid_rows(const Vector3& theta, const Matrix6& columns) {
    Matrix6 rows = columns;
    rows.bottomRows<3>() = rotation_vector_rate(theta) * columns.bottomRows<3>();
    return rows;
}

void refuse_singular(const Mechanism& mechanism, const Elimination::Fault& fault, dttmm_status status) {
    const FrameSpec& frame = mechanism.assembly.frames[as_size(mechanism.assembly.driven_count + fault.frame)];
    if (fault.direction >= 0) {
        const bool is_massless = fault.direction < 3 ? frame.mass == 0 : frame.inertia.isZero(0);
        throw Error(
            status,
            fmt::format("{}: nothing determines its motion in {} (its own axes): {}no element holds it there; give "
                        "it a stiffness, a mass or "
                        "a `fixed` direction",
                        frame.name(), kDirectionNames[as_size(fault.direction)], is_massless ? "it has no mass, and " : ""),
            frame.element);
    }
    const Joint& joint = mechanism.joints[as_size(fault.link)];
    int direction = 0;
    for_each_rigid(joint, [&](int i, int d) {
        if (i == fault.rigid) direction = d;
    });
    throw Error(status,
                fmt::format("its rigid direction {} is driven from both ends: what it joins is held there by other rigid "
                            "directions too; give one of them a stiffness",
                            kDirectionNames[as_size(direction)]),
                joint.element());
}

}  // namespace dttmm::plugin
