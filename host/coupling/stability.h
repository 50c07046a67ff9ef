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

/// Largest ω of K u = ω² M u from the networks' stiffness and the bodies' inertia in the motion `at`, by power iteration: a
/// lower bound, 1e-4 below for one body and 2e-4 for a chain of a thousand. Cost linear in the number of elements.
FastestMode find_fastest_mode(const Model& model, Networks& networks, const std::vector<BodyState>& at);

/// Largest ω h at which an explicit scheme is stable without damping under a leap-frog host (theory: exactly 2). Damping in
/// the joints lowers it: 1.92 at 2 % of critical, 1.35 at 20 %.
inline constexpr double kExplicitLimit = 2.0;

}  // namespace dttmm
