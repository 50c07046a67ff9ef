// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/step_shift.h"
#include "support/linear_algebra.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;

constexpr double kStep = 0.0031, kOmega = 210, kZeta = 0.037;  // omega h = 0.65

/// The oscillating root z of the recurrence sum of c_i z^i.
Complex root_of(const std::vector<double>& c) {
    const auto n = static_cast<Eigen::Index>(c.size()) - 1;
    Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) companion(i, n - 1) = -c[static_cast<size_t>(i)] / c.back();
    for (Eigen::Index i = 1; i < n; ++i) companion(i, i - 1) = 1;
    Complex best = 0;
    for (const Complex z : test::eigenvalues(companion))
        if (z.imag() > 0 && std::abs(z) > std::abs(best)) best = z;
    return best;
}

void expect_true_rate(const StepShift& shift, Complex z, double tolerance) {
    const Complex found = shift.true_rate(std::log(z) / kStep);
    EXPECT_NEAR(std::abs(found) / kOmega, 1, tolerance);
    EXPECT_NEAR(-found.real() / std::abs(found), kZeta, tolerance);
}

// Oracle: Newmark's rule x+ = x + h v + h^2 ((1/2 - beta) a + beta a+), v+ = v + h ((1 - gamma) a + gamma a+), a = - 2 zeta
// omega v - omega^2 x as the 2x2 matrix of a step; its eigenvalue is the z of the history. At rho = 1 it is also (1 + s
// h/2)/(1 - s h/2).
TEST(StepShift, TheImplicitSchemeIsUndone) {
    for (const double rho : {1.0, 0.9, 0.4}) {
        const double gamma = (3 - rho) / (2 * (1 + rho)), beta = std::pow(gamma + 0.5, 2) / 4, h = kStep;
        const Eigen::RowVector2d a(-kOmega * kOmega, -2 * kZeta * kOmega);
        Eigen::Matrix2d before, after;
        before << 1, h, 0, 1;
        after.setIdentity();
        before.row(0) += h * h * (0.5 - beta) * a;
        before.row(1) += h * (1 - gamma) * a;
        after.row(0) -= h * h * beta * a;
        after.row(1) -= h * gamma * a;
        Complex z = test::eigenvalues(after.inverse() * before)(0);
        if (z.imag() < 0) z = std::conj(z);
        expect_true_rate(StepShift(kStep, "centred", rho), z, 1e-12);
        if (rho == 1) {
            const Complex s = kOmega * Complex(-kZeta, std::sqrt(1 - kZeta * kZeta));
            EXPECT_LT(std::abs(z - (1.0 + s * h / 2.0) / (1.0 - s * h / 2.0)), 1e-13);
        }
    }
}

// Oracle: omega h/2 = tan(omega_h h/2) without damping, and its leading term (omega h)^2/12, for a slow vibration too.
TEST(StepShift, AnUndampedVibrationIsSlowerByOmegaHSquaredOverTwelve) {
    const StepShift shift(kStep, "centred", 1);
    for (const double recorded : {0.02, 3.0, 170.0}) {
        const double omega = shift.true_rate({0, recorded}).imag();
        EXPECT_NEAR(omega, 2 / kStep * std::tan(recorded * kStep / 2), 1e-12 * omega);
        const double x = omega * kStep;
        EXPECT_NEAR(recorded / omega - 1, -x * x / 12, x * x * x * x / 70 + 1e-13);
    }
}

// Oracle: the recurrence of central differences with the velocity of each scheme as a polynomial; its roots.
TEST(StepShift, ExplicitSchemesAreUndone) {
    const double k = std::pow(kOmega * kStep, 2), c = 2 * kZeta * kOmega * kStep;
    // z^2 - 2 z + 1 + c z V + k z, times the powers of z that V divides by
    expect_true_rate(StepShift(kStep, "bdf1", 1), root_of({1 - c, -2 + c + k, 1}), 1e-12);
    for (const char* name : {"bdf2", "fox-euler"})
        expect_true_rate(StepShift(kStep, name, 1), root_of({c / 2, 1 - 2 * c, -2 + 1.5 * c + k, 1}), 1e-12);
    expect_true_rate(StepShift(kStep, "houbolt", 1), root_of({-c / 3, 1.5 * c, 1 - 3 * c, -2 + 11 * c / 6 + k, 1}), 1e-12);
    expect_true_rate(StepShift(kStep, "park", 1), root_of({-c / 6, c, 1 - 2.5 * c, -2 + 10 * c / 6 + k, 1}), 1e-12);
}

TEST(StepShift, TheStepsAreThoseOfTheRun) {
    EXPECT_TRUE(StepShift::of_run(nullptr).empty());
    EXPECT_TRUE(StepShift::of_run(Json::object()).empty());
    const Json run = {{"model", {{"simulation", {{"step", 0.25}, {"scheme", "centred"}, {"spectral_radius", 1.0}}}}}};
    ASSERT_EQ(StepShift::of_run(run).size(), 1u);
    EXPECT_EQ(StepShift::of_run(run)[0].step(), 0.25);
    Json extrapolated = run;
    extrapolated["tolerance"] = {{"step", 0.125}};
    ASSERT_EQ(StepShift::of_run(extrapolated).size(), 2u);
    EXPECT_EQ(StepShift::of_run(extrapolated)[0].step(), 0.125);
    EXPECT_EQ(StepShift::of_run(extrapolated)[1].step(), 0.25);
}

}  // namespace
}  // namespace dttmm::host
