// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/driven_ends.h"
#include "core/types.h"

namespace dttmm {

/// How the wanted instant enters the force law of an element, whatever the scheme:
///     elastic force  weight · K d + (known),   damping force  c (C d + D),   d: the unknown deformation
struct StepCoefficients {
    double weight =
        1;         ///< of the elastic force at the unknown instant; 1 for schemes that stand there, β for the centred one
    double C = 0;  ///< [1/s] of x' = C x + D
};

/// A massless element between two ends. Immutable. Its deformation d (6×1: m, rad) is the motion of the `to` end relative to
/// the `from` end, in the axes of the `from` end; its force f (6×1: N, N m) is positive in tension, i.e. it pulls the `to`
/// end against d and the `from` end along d. In the letters of the state vector f = [−q; m].
class Element {
public:
    virtual ~Element() = default;

    /// Directions with a stiffness or damping; in the others the ends move freely.
    virtual Directions carried() const = 0;

    /// f = stiffness ∘ d + damping ∘ d'            [N/m, N m/rad; N s/m, N m s/rad]
    virtual const Vector6& stiffness() const = 0;
    virtual const Vector6& damping() const = 0;

    /// z_O = U z_I at a time step: 13×13, axes of the `from` end. `known` (6×1) is the part of f that does not depend on the
    /// unknown d. In a direction that is not carried the compliance, and with it the entry of U, is infinite.
    virtual Matrix13 transfer(const StepCoefficients& step, const Vector6& known) const = 0;
};

}  // namespace dttmm
