// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/element.h"
#include "element/section.h"

namespace dttmm::plugin {

/// A bar that stretches and shortens; against every other deformation it is rigid.
class Rod : public Element {
public:
    /// values: segments, then those of make_section.
    explicit Rod(std::span<const double, 1 + kSectionValueCount> values);

    static const dttmm_element_type kType;

    const Section& section() const { return section_; }
    Parts discretise(std::span<const Pose> ends) const override;
    std::optional<Line> line(std::span<const Pose> ends) const override;

private:
    int segments_;
    Section section_;
};

}  // namespace dttmm::plugin
