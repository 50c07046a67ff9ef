// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/single_joint.h"

namespace dttmm::plugin {

/// A spring and a damper side by side in three translations and three rotations: the joint of the hybrid-algorithm paper,
/// where one of them stands for a bolt.
///     f = k ∘ d + c ∘ d',   k, c ≥ 0
/// A direction without stiffness or damping is free. In place of k d a direction may have a law of its own. Its ends may be
/// apart; the force acts at the `to` end.
class SpringDamper : public SingleJoint {
public:
    /// values: those of the parameters. Throws Error(DTTMM_ERROR_MODEL).
    explicit SpringDamper(std::span<const double> values);

    /// Name, parameters, units and ranges, as the model file gives them. Of each direction: its law and what laws need.
    static const dttmm_element_type& type();
};

}  // namespace dttmm::plugin
