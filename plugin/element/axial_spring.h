// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm::plugin {

/// A spring and a damper along the line between two points, wherever these go: a strut, a gas spring, a rope under tension.
///     F = f(L − L0) + c L',   c ≥ 0
/// F [N] is positive in tension and pulls the points together, L [m] is their distance, f the law. The spring is undeformed
/// at the natural length L0, or at that by which it has a given force at the start; without either it is so at the start.
class AxialSpring : public Element {
public:
    /// values: those of the parameters. Throws Error(DTTMM_ERROR_MODEL).
    explicit AxialSpring(std::span<const double> values);

    /// Name, parameters, units and ranges, as the model file gives them.
    static const dttmm_element_type& type();

    /// Throws Error(DTTMM_ERROR_MODEL) where its ends are nearly at one point.
    Parts discretise(std::span<const Pose> ends) const override;

private:
    JointLaw law_;
    std::optional<double> natural_length_;  ///< [m]
    double elongation_ = 0;                 ///< L − L0 at the start, where no natural length is given [m]
};

}  // namespace dttmm::plugin
