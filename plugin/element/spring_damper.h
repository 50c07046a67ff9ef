// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm {

/// A spring and a damper side by side in three translations and three rotations: the joint of the hybrid-algorithm paper,
/// where one of them stands for a bolt.
///     f = k ∘ d + c ∘ d',   k, c ≥ 0
/// A direction without stiffness or damping is free.
class SpringDamper : public Element {
public:
    /// values: stiffness x y z [N/m], damping x y z [N s/m], rotational stiffness [N m/rad], rotational damping [N m s/rad].
    explicit SpringDamper(std::span<const double, 12> values);

    /// Name, parameters, units and ranges, as the model file gives them.
    static const dttmm_element_type kType;

    Directions carried() const override;
    const Vector6& stiffness() const override { return k_; }
    const Vector6& damping() const override { return c_; }
    Matrix13 transfer(const StepCoefficients& step, const Vector6& known) const override;

private:
    Vector6 k_, c_;
};

}  // namespace dttmm
