// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace dttmm::plugin {

/// A straight path of a deformation [m, rad].
struct LawPath {
    double from, to;
    double time = 0;                 ///< that it takes [s]; 0 for a look at an instant
    const double* memory = nullptr;  ///< of a law that has one: what is left of the paths before; all zero at first
    double* after = nullptr;         ///< takes the memory at the end of the path; NULL: not wanted
};

/// What a law says of a path.
struct LawOnPath {
    double force;         ///< at its end, positive in tension [N, N m]
    double tangent;       ///< ∂force/∂to [N/m, N m/rad]; of a path of no length that of unloading
    double mean;          ///< of the force along the path: (stored at its end − at its start + dissipated)/(to − from)
    double mean_tangent;  ///< ∂mean/∂to
    double stored;        ///< energy at its end; zero undeformed [J]
    double dissipated;    ///< energy lost along the path, ≥ 0 [J]
};

/// The force of one direction of a joint by its deformation [m, rad], zero undeformed: elastic, or with a memory of its
/// past. Immutable and pure: everything that works with a law gets it from this one function. A path of no length and no
/// time changes neither force nor memory.
class Law {
public:
    virtual ~Law() = default;
    virtual LawOnPath along(const LawPath& path) const = 0;
    /// Numbers that it remembers; 0: it is elastic.
    virtual size_t memory_size() const { return 0; }
    /// Whether these numbers follow the deformation smoothly: half of two memories is then the memory half way.
    virtual bool remembers_smoothly() const { return memory_size() == 0; }
    /// Whether the force is the tangent at rest times the deformation: joints are then worked out four at a time.
    virtual bool is_linear() const { return false; }

    LawOnPath at(double deformation, const double* memory) const { return along({deformation, deformation, 0, memory}); }
    /// Of the first path, from the undeformed state.
    LawOnPath first(double to, double* after = nullptr) const { return along({0, to, 0, kNothing, after}); }

    static constexpr size_t kMostMemory = 256;

private:
    static constexpr double kNothing[kMostMemory] = {};
};

}  // namespace dttmm::plugin
