// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::plugin {

/// What a law says of a straight path from one deformation to another.
struct LawOnPath {
    double force;         ///< at its end, positive in tension [N, N m]
    double tangent;       ///< ∂force/∂end [N/m, N m/rad]
    double mean;          ///< of the force along the path, (stored energy at its end − at its start)/(end − start)
    double mean_tangent;  ///< ∂mean/∂end
    double stored;        ///< energy at its end; zero undeformed [J]
};

/// The force of one direction of a joint by its deformation [m, rad]: elastic, smooth, zero undeformed. Immutable and pure:
/// everything that works with a law gets it from this one function.
class Law {
public:
    virtual ~Law() = default;
    virtual LawOnPath along(double from, double to) const = 0;
    /// Whether the force is the tangent at rest times the deformation: joints are then worked out four at a time.
    virtual bool is_linear() const { return false; }

    LawOnPath at(double deformation) const { return along(deformation, deformation); }
};

}  // namespace dttmm::plugin
