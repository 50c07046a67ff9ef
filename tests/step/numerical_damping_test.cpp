// SPDX-License-Identifier: BSD-3-Clause
//
// The implicit coupling with a spectral radius below one, against the closed form of its scheme for one mass.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <complex>

#include "step/simulation.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

constexpr double kOscillatorMass = 3.7, kStepSize = 1.3e-3;

/// One mass on a spring, pushed off at 0.7 m/s; omega_h and zeta: of the spring and its damper at kStepSize.
Model oscillator(const Plugins& plugins, double omega_h, double zeta, double rho) {
    const double omega = omega_h / kStepSize;
    Model model;
    model.simulation.step = kStepSize;
    model.simulation.duration = 1;
    model.simulation.spectral_radius = rho;
    Body body = test::box("mass", kOscillatorMass, {0.1, 0.2, 0.3}, {0, 0, 0});
    body.velocity = {0.7, 0, 0};
    model.bodies.push_back(body);
    model.elements.push_back(
        test::spring("spring", plugins, {}, {0, -1}, kOscillatorMass * omega * omega, 2 * zeta * omega * kOscillatorMass));
    return model;
}

std::vector<double> ring_down(const Model& model, const Plugins& plugins, int steps) {
    Simulation simulation(model, plugins);
    std::vector<double> x = {0};
    for (int n = 0; n < steps; ++n) {
        simulation.step();
        x.push_back(simulation.bodies()[0].position.x());
    }
    return x;
}

/// A vibration by the roots r of r² − trace r + determinant = 0 that carry it from step to step.
struct Roots {
    double trace, determinant;
    std::complex<double> larger() const {
        return 0.5 * (trace + std::sqrt(std::complex<double>(trace * trace - 4 * determinant)));
    }
    double damping_ratio() const { return -std::log(larger()).real() / std::abs(std::log(larger())); }
    double period() const { return 2 * M_PI * kStepSize / std::log(larger()).imag(); }
};

/// The roots that fit a record best, as a signal analysis would find them.
Roots identify(const std::vector<double>& x) {
    const auto rows = static_cast<Eigen::Index>(x.size() - 2);
    Eigen::MatrixXd before(rows, 2);
    Eigen::VectorXd after(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
        const auto n = static_cast<size_t>(i);
        before.row(i) << x[n + 1], -x[n];
        after(i) = x[n + 2];
    }
    const Eigen::Vector2d fit = before.colPivHouseholderQr().solve(after);
    return {fit(0), fit(1)};
}

/// The amplification polynomial of x'' + 2 ζ ω x' + ω² x = 0 in the centred scheme by hand, with b = ω²h², c = 2 ζ ω h.
Roots roots_of(double omega_h, double zeta, double rho) {
    const double gamma = (3 - rho) / (2 * (1 + rho)), beta = (gamma + 0.5) * (gamma + 0.5) / 4;
    const double b = omega_h * omega_h, c = 2 * zeta * omega_h;
    const double after = 1 + b * beta + c * gamma;
    const double now = -2 + b * (0.5 + gamma - 2 * beta) + c * (1 - 2 * gamma);
    const double before = 1 + b * (0.5 - gamma + beta) + c * (gamma - 1);
    return {-now / after, before / after};
}

// Oracle: the roots of the amplification polynomial. Both sides are the same discrete equations; what is left is how well
// the roots can be read from 300 rows that die away.
TEST(NumericalDamping, RingDownHasTheRootsOfTheScheme) {
    const Plugins plugins;
    for (double rho : {1.0, 0.8, 0.3, 0.0})
        for (double omega_h : {0.05, 0.4, 1.7})
            for (double zeta : {0.0, 0.03}) {
                const Roots found = identify(ring_down(oscillator(plugins, omega_h, zeta, rho), plugins, 300));
                const Roots expected = roots_of(omega_h, zeta, rho);
                EXPECT_NEAR(found.damping_ratio(), expected.damping_ratio(), 1e-8) << rho << ", " << omega_h;
                EXPECT_NEAR(found.period(), expected.period(), 1e-8 * expected.period()) << rho << ", " << omega_h;
            }
}

// Oracle: the leading term, worked out from x'' + ω² x(t + (γ − 1/2) h) = 0: ζ = (γ − 1/2) ω h/2, the rest of third order.
TEST(NumericalDamping, DampsSlowVibrationsByTheRatioOfTheManual) {
    const Plugins plugins;
    for (double rho : {0.9, 0.5, 0.0}) {
        const double gamma = (3 - rho) / (2 * (1 + rho)), omega_h = 0.05;
        const double zeta = identify(ring_down(oscillator(plugins, omega_h, 0, rho), plugins, 300)).damping_ratio();
        EXPECT_NEAR(zeta, 0.5 * (gamma - 0.5) * omega_h, 2 * std::pow(omega_h, 3)) << rho;
    }
}

// Oracle: the limit ωh → ∞, a double root at −ρ; what is left of it at ωh = 1e4 is of the order 1/(ωh)².
TEST(NumericalDamping, WhatTheStepCannotResolveKeepsTheSpectralRadiusPerStep) {
    const Plugins plugins;
    for (double rho : {1.0, 0.7, 0.4}) {
        const Roots found = identify(ring_down(oscillator(plugins, 1e4, 0, rho), plugins, 8));
        EXPECT_NEAR(found.trace, -2 * rho, 1e-6);
        EXPECT_NEAR(found.determinant, rho * rho, 1e-6);
    }
}

// Oracle: x = v0/ω sin ωt with the damper's decay, in closed form. First order below ρ = 1, second at 1.
TEST(NumericalDamping, CostsAnOrder) {
    const Plugins plugins;
    const double omega = 300, zeta = 0.05, damped = omega * std::sqrt(1 - zeta * zeta), end = 0.0445;
    const auto error = [&](double rho, int steps) {
        Model model = oscillator(plugins, omega * kStepSize, zeta, rho);
        model.simulation.step = end / steps;
        const double exact = 0.7 / damped * std::exp(-zeta * omega * end) * std::sin(damped * end);
        return std::abs(ring_down(model, plugins, steps).back() - exact);
    };
    EXPECT_NEAR(error(1, 1000) / error(1, 2000), 4, 0.02);
    for (double rho : {0.9, 0.2}) EXPECT_NEAR(error(rho, 2000) / error(rho, 4000), 2, 0.1) << rho;
}

// Oracle: statics. Where the load comes to rest, so does the mass, at f/k whatever the spectral radius: loads are weighted
// as the springs are.
TEST(NumericalDamping, LeavesTheStaticDeflectionAlone) {
    const Plugins plugins;
    Model model = oscillator(plugins, 50, 0, 0.5);
    Load load;
    load.on = {0, -1};
    load.direction = Eigen::Vector3d::UnitX();
    load.signal = test::smooth_rise(250, 8e-3);
    model.loads.push_back(load);
    const double k = model.elements[0].values[0];
    EXPECT_NEAR(ring_down(model, plugins, 400).back(), 250 / k, 1e-12 * 250 / k);
}

}  // namespace
}  // namespace dttmm::host
