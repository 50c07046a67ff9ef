// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/single_joint.h"

namespace dttmm::plugin {

/// A spring and a damper side by side in three translations and three rotations: the joint of the hybrid-algorithm paper,
/// where one of them stands for a bolt.
///     f = k ∘ d + c ∘ d',   k, c ≥ 0
/// A direction without stiffness or damping is free. Its ends may be apart; the force acts at the `to` end.
class SpringDamper : public SingleJoint {
public:
    /// values: stiffness x y z [N/m], damping x y z [N s/m], rotational stiffness [N m/rad], rotational damping [N m s/rad].
    explicit SpringDamper(std::span<const double, 12> values);

    /// Name, parameters, units and ranges, as the model file gives them.
    static const dttmm_element_type kType;
};

}  // namespace dttmm::plugin
