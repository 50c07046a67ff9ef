// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/pose.h"
#include "element/joint_law.h"
#include "element/section.h"

namespace dttmm::plugin {

/// A rigid mass of an element.
struct Lump {
    double mass = 0;                    ///< [kg]
    Matrix3 inertia = Matrix3::Zero();  ///< about its centre of mass, in the axes of `pose` [kg m²]; zero for a point
    Pose pose;                          ///< centre of mass and axes at the start, world
};

/// A massless joint of an element between two stations. Stations 0, 1, … are the element's ends, after them come its lumps.
struct JointPart {
    int from = 0, to = 1;
    std::shared_ptr<const JointLaw> law;  ///< one for all joints that are alike
    Pose pose;                            ///< the point at which its ends meet at the start, and its axes, world
};

/// What an element is made of in time.
struct Parts {
    std::vector<Lump> lumps;
    std::vector<JointPart> joints;
    std::vector<int> mounted;  ///< lump that each end is part of, −1: it is not. Empty: none is
    /// Of an even division of a line into its lumps, in the order of these: what a force per length on the line needs.
    struct Segments {
        double length = 0;  ///< of each [m]
        Vector3 arm;        ///< from the centre of a lump to the middle of its segment on the axis, local axes [m]
        SectionModuli moduli = {};
    };
    std::optional<Segments> segments = {};
};

/// A uniform element between its two ends in the frequency domain, where its waves are known exactly.
struct Line {
    Matrix3 axes;  ///< local, world: x from the `from` end to the `to` end
    Section section;
    bool stretches_only = false;  ///< a rod: rigid but for its axial waves
};

/// What stands between nodes: the library of the transfer matrix method. Immutable.
class Element {
public:
    virtual ~Element() = default;

    /// Its joints and lumps when its ends are at `ends` at the start, undeformed. The number of ends is that of the model:
    /// two, or any for an element with the key `at`. Throws Error(DTTMM_ERROR_MODEL) if it cannot stand there.
    virtual Parts discretise(std::span<const Pose> ends) const = 0;

    /// The element between the same ends as a line with its mass spread along it; none where its parts are all there is.
    virtual std::optional<Line> line(std::span<const Pose> /*ends*/) const { return std::nullopt; }
};

}  // namespace dttmm::plugin
