// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "coupling/networks.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm {

/// The fastest undamped vibration of the bodies on their networks, which limits the step of an explicit coupling.
struct FastestMode {
    double omega = 0;  ///< [rad/s]; 0 where nothing is elastic
    std::string body;  ///< the body that moves most in it (by kinetic energy)
};

/// Largest ω of K u = ω² M u from the networks' stiffness and the bodies' inertia in the motion `at`, by power iteration to
/// about 1e-6 relative. Cost linear in the number of elements.
FastestMode find_fastest_mode(const Model& model, Networks& networks, const std::vector<BodyState>& at);

/// Largest ω h at which an explicit scheme is stable without damping under a leap-frog host (theory: exactly 2).
inline constexpr double kExplicitLimit = 2.0;

}  // namespace dttmm
