// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm::plugin {

/// A point mass at a node, or at several that it makes one.
class PointMass : public Element {
public:
    /// values: mass [kg].
    explicit PointMass(std::span<const double, 1> values) : mass_(values[0]) {}

    static const dttmm_element_type kType;

    Parts discretise(std::span<const Pose> ends) const override;

private:
    double mass_;
};

}  // namespace dttmm::plugin
