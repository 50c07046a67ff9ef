// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/types.h"

namespace dttmm::plugin {

/// The linearisation of DT-TMM: at the wanted instant every motion obeys two affine relations,
///     x'' = A x + B,   x' = C x + D         x: 6×1;  A [1/s²] and C [1/s] are scalars, B and D are known from the past.
struct AffineMotion {
    double A = 0, C = 0;
    Vector6 B = Vector6::Zero(), D = Vector6::Zero();
    Vector6 acceleration(const Vector6& x) const { return A * x + B; }
    Vector6 velocity(const Vector6& x) const { return C * x + D; }
};

/// The past of one motion: index 0 is one step before the wanted instant (the papers' index 1), 1 two steps, 2 three steps.
struct History {
    std::array<Vector6, 3> x, v, a;
};

/// Fox-Euler, the paper's choice: constant acceleration equal to that at the end of the step (Newmark β = 1/2, γ = 1).
///     x'' = (2/h²)(x − x₁ − h v₁),   x' = (2/h)(x − x₁) − v₁
/// First order, A-stable, numerical damping about ωh/4.
/// Source: Krauss and Okasha (2011), public DT-TMM code; consistent with the hybrid-algorithm paper, eq. (5).
AffineMotion fox_euler(const History& past, double h);

/// Newmark's rule. Second order for γ = 1/2; unconditionally stable for 2β ≥ γ ≥ 1/2. β > 0.
/// (1/4, 1/2) average acceleration, (1/6, 1/2) linear acceleration, (1/12, 1/2) Fox-Goodwin.
/// Source: Newmark (1959), J. Eng. Mech. Div. ASCE 85(3), 67–94.
AffineMotion newmark(const History& past, double h, double beta, double gamma);

/// Wilson-θ: the linear-acceleration rule over the longer step θh; the unknown is x(t₁ + θh). Stable for θ ≥ 1.366.
AffineMotion wilson_theta(const History& past, double h, double theta);

/// Motion at t₁ + h from the solved x(t₁ + θh) of wilson_theta.
struct Motion {
    Vector6 x, v, a;
};
Motion wilson_end_of_step(const History& past, double h, double theta, const Vector6& x_theta);

/// Houbolt: cubic through four instants. Second order. The first two steps of a run lack history: the first one is the
/// linear-acceleration rule, the second houbolt_second_step, which fits the cubic to x, x₁, x₂ and a₂.
AffineMotion houbolt(const History& past, double h);
AffineMotion houbolt_second_step(const History& past, double h);

/// Park's stiffly stable rule, x' = (10x − 15x₁ + 6x₂ − x₃)/(6h), the acceleration by the same formula from the velocities.
/// Source: Park (1975), J. Appl. Mech. 42, 464–470.
AffineMotion park(const History& past, double h);

/// Backward differences of first and second order, the acceleration by the same formula from the velocities.
AffineMotion bdf1(const History& past, double h);
AffineMotion bdf2(const History& past, double h);

/// Generalised-α: a Newmark rule whose equations of motion stand at a weighted instant,
///     a → (1 − α_m) a + α_m a₁,   x, v, loads → (1 − α_f) (.) + α_f (.)₁
/// ρ: spectral radius at infinite frequency, 0 (strongest damping) to 1 (none). Second order, unconditionally stable.
/// Source: Chung and Hulbert (1993), J. Appl. Mech. 60, 371–375.
struct GeneralisedAlpha {
    explicit GeneralisedAlpha(double rho);
    double alpha_m, alpha_f, beta, gamma;
};

/// The centred scheme: every quantity stands at t_n, in the middle of three instants; the unknown is x₊ = x(t_{n+1}).
///     x'' = (x₊ − 2x + x₋)/h²,   x' = (γ x₊ + (1 − 2γ) x + (γ − 1) x₋)/h
/// Elastic forces and loads are weighted  w₊ (.)₊ + w₀ (.) + w₋ (.)₋  with w₊ = β, w₀ = 1/2 + γ − 2β, w₋ = 1/2 − γ + β.
/// With a leap-frog host (ODE) this is Newmark's family in its three-level form: β = 1/4, γ = 1/2 is second order,
/// unconditionally stable and free of numerical damping. Its memory is two positions, so nothing can ring.
struct Centred {
    double beta = 0.25, gamma = 0.5;
    double weight_after() const { return beta; }
    double weight_now() const { return 0.5 + gamma - 2 * beta; }
    double weight_before() const { return 0.5 - gamma + beta; }
    AffineMotion motion(const Vector6& x_now, const Vector6& x_before, double h) const;
};

}  // namespace dttmm::plugin
