// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "coupling/networks.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// An element's part in a vibration.
struct ElementShare {
    std::string element;
    double share = 0;  ///< of the energy of the vibration, 0 … 1
};

/// A vibration of the bodies on their networks and joints, and what makes it.
struct FastestMode {
    double omega = 0;                    ///< [rad/s]; 0 where nothing is elastic
    std::string body;                    ///< the body that moves most in it (by kinetic energy)
    std::vector<ElementShare> elements;  ///< all of them, with their parts in it, largest first
};

/// "10.5 Hz at body "plate", made by bolt1 (62 %), bolt2 (31 %), bolt3 (3 %) and 1 more": the largest share, up to two more
/// of 1 %, and how many others have 1 %.
std::string describe(const FastestMode& mode);

/// The fastest undamped vibration: largest ω of K u = ω² M u from the networks' stiffness and the bodies' inertia, among
/// the motions that the joints allow, at `at`, by power iteration: a lower bound, 1e-4 below for one body and 2e-4 for a
/// chain of a thousand; the shares are of its strain energy. Cost linear in the number of elements.
FastestMode find_fastest_mode(const Model& model, Networks& networks, const std::vector<BodyState>& at);

/// How near an explicit coupling is to its limit. The velocity formula v = Σ w_i x_{n−i} makes the discrete equation
///     M (x₊ − 2x + x₋)/h² + K x + C Σ w_i x_{n−i} = 0,
/// which loses its stability at the root −1. K and C are symmetric and positive semidefinite, so that every root of the
/// machine is that of one mass with its Rayleigh quotients: stable if and only if
///     λ = largest eigenvalue of M⁻¹ (h² K + W h C) < 4,   W = h Σ (−1)^i w_i,
/// however the damping is distributed. Without damping, √λ = ω h < 2.
struct ExplicitLimit {
    double load = 0;                                                ///< √λ; stable below kExplicitLimit
    double damping_share = 0;                                       ///< part of λ that the dampers make, 0 … 1
    double longest_step = std::numeric_limits<double>::infinity();  ///< at which √λ is kExplicitLimit [s]
    FastestMode mode;  ///< that reaches the limit first at the present step: its ω by stiffness alone, shares of λ
};

inline constexpr double kExplicitLimit = 2.0;

/// W of the scheme: 2 for bdf1, 4 for bdf2 and for fox-euler (which coincides with it here), 16/3 for park, 20/3 for
/// houbolt.
double alternating_weight(ExplicitScheme scheme);

/// λ by power iteration as above.
ExplicitLimit find_explicit_limit(const Model& model, Networks& networks, const std::vector<BodyState>& at, double step,
                                  ExplicitScheme scheme);

}  // namespace dttmm::host
