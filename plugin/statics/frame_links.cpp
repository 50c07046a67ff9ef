// SPDX-License-Identifier: BSD-3-Clause
#include "statics/frame_links.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/index.h"
#include "core/loose_motion.h"
#include "core/rotation.h"
#include "core/rounding.h"
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
    double size = 1;
    for (const FrameSpec& frame : mechanism.assembly.frames) size = std::max(size, frame.pose.position.norm());
    return kRoundingOfSums * size;
}

Matrix6 rigid_rows(const Joint& joint, const Vector3& theta, const Matrix6& columns) {
    Matrix6 rows = columns;
    rows.bottomRows<3>() = joint.opening_of_turn(theta) * columns.bottomRows<3>();
    return rows;
}

namespace {

std::pair<int, int> frame_ends(const Joint& joint) { return {joint.from(), joint.to()}; }

/// A joint of an element at one of these frames that are no ground, rigid in that direction if there is one, or in another.
const Joint* rigid_beside(const Mechanism& mechanism, std::pair<int, int> frames, int direction) {
    const Joint* found = nullptr;
    for (int j = 0; j < mechanism.assembly.first_joint.back(); ++j) {
        const Joint& joint = mechanism.joints[as_size(j)];
        const auto touches = [&](int frame) {
            return frame >= mechanism.assembly.driven_count && (joint.from() == frame || joint.to() == frame);
        };
        if (joint.rigid().none() || (!touches(frames.first) && !touches(frames.second))) continue;
        if (joint.rigid()[as_size(direction)]) return &joint;
        if (!found) found = &joint;
    }
    return found;
}

}  // namespace

void refuse_singular(const Mechanism& mechanism, const Elimination::Fault& fault, dttmm_status status) {
    const FrameSpec& frame = mechanism.assembly.frames[as_size(mechanism.assembly.driven_count + fault.frame)];
    if (fault.direction >= 0) {
        const bool lacks = fault.direction < 3 ? frame.mass == 0 : frame.inertia.isZero(0);
        throw Error(status, fmt::format("{}: {}", frame.name(), nothing_determines(fault.direction, "its own", lacks)),
                    frame.element);
    }
    const std::vector<int>& first_joint = mechanism.assembly.first_joint;
    const Joint& joint = mechanism.joints[as_size(fault.link)];
    if (fault.too_many)
        throw Error(status,
                    fmt::format("{}: more than {} rigid directions meet there; give some of them a stiffness", frame.name(),
                                Elimination::kMostRows),
                    joint.element());
    int direction = 0;
    for_each_rigid(joint, [&](int i, int d) {
        if (i == fault.rigid) direction = d;
    });
    const char* const name = kDirectionNames[as_size(direction)];
    if (fault.link >= first_joint.back()) {  // of a node with fixed directions: what is rigid beside it is at fault
        if (const Joint* const rigid = rigid_beside(mechanism, frame_ends(joint), direction))
            throw Error(
                status,
                fmt::format("it is rigid, and {} at an end of it is fixed in {} where rigid directions or fixed ones "
                            "hold it already: a direction is driven from both ends; give one of them a stiffness, or "
                            "leave it out of `fixed`",
                            frame.name(), name),
                rigid->element());
        throw Error(
            status,
            fmt::format("{} is fixed in {}, where other rigid directions hold it: it is driven from both ends; leave "
                        "that direction out of `fixed`",
                        frame.name(), name),
            frame.element);
    }
    const auto next = std::ranges::upper_bound(first_joint, fault.link);
    const bool is_rod = *next - *(next - 1) > 1;  // of lines rods alone have rigid directions
    throw Error(status,
                fmt::format("its rigid direction {} is driven from both ends: what it joins is held there by other rigid "
                            "directions too; {}",
                            name,
                            is_rod ? "a rod is rigid in all but x: take an axial_spring (stiffness EA/length), which joins "
                                     "points that may turn, or a beam"
                                   : "give one of them a stiffness"),
                joint.element());
}

}  // namespace dttmm::plugin
