// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/element.h"

namespace dttmm::plugin {

/// An element that is one massless joint in the axes of its `from` end, its force acting at the `to` end.
class SingleJoint : public Element {
public:
    const JointLaw& law() const { return law_; }
    Parts discretise(std::span<const Pose> ends) const override {
        return {{}, {{0, 1, std::make_shared<const JointLaw>(law_), {ends[1].position, ends[0].rotation}}}, {}};
    }

protected:
    JointLaw law_;
};

}  // namespace dttmm::plugin
