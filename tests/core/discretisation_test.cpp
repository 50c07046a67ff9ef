// SPDX-License-Identifier: BSD-3-Clause
#include "core/discretisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace dttmm::plugin {
namespace {

/// x = s (t/τ)^p in six directions of different size s, with exact derivatives. A scheme that is exact for it must return
/// the exact velocity and acceleration at t from the exact history: only rounding separates them.
struct Power {
    int p;
    double tau = 0.37;
    Vector6 size() const { return (Vector6() << 1, -2, 0.5, 3, -0.1, 7).finished(); }
    Vector6 x(double t) const { return size() * std::pow(t / tau, p); }
    Vector6 v(double t) const { return p < 1 ? Vector6::Zero() : Vector6(size() * p / tau * std::pow(t / tau, p - 1)); }
    Vector6 a(double t) const {
        return p < 2 ? Vector6::Zero() : Vector6(size() * p * (p - 1) / (tau * tau) * std::pow(t / tau, p - 2));
    }
    History past(double t, double h) const {
        History past;
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<size_t>(i);
            past.x[k] = x(t - (i + 1) * h);
            past.v[k] = v(t - (i + 1) * h);
            past.a[k] = a(t - (i + 1) * h);
        }
        return past;
    }
};

struct Scheme {
    std::string name;
    std::function<AffineMotion(const History&, double)> rule;
    int velocity_order, acceleration_order;  ///< highest power for which each is exact
};

class Schemes : public ::testing::TestWithParam<Scheme> {};

double velocity_error(const Scheme& scheme, const Power& motion, double t, double h) {
    return (scheme.rule(motion.past(t, h), h).velocity(motion.x(t)) - motion.v(t)).norm() * h;
}
double acceleration_error(const Scheme& scheme, const Power& motion, double t, double h) {
    return (scheme.rule(motion.past(t, h), h).acceleration(motion.x(t)) - motion.a(t)).norm() * h * h;
}

TEST_P(Schemes, AreExactForPolynomialsUpToTheirOrderAndNoFurther) {
    const double t = 0.9, h = 0.083;
    for (int p = 0; p <= 4; ++p) {
        const Power motion{p};
        const double rounding = 1e-13 * motion.x(t).norm();
        const double v = velocity_error(GetParam(), motion, t, h), a = acceleration_error(GetParam(), motion, t, h);
        if (p <= GetParam().velocity_order) {
            EXPECT_LT(v, rounding) << "velocity, t^" << p;
        }
        if (p <= GetParam().acceleration_order) {
            EXPECT_LT(a, rounding) << "acceleration, t^" << p;
        }
        if (p == GetParam().velocity_order + 1) {
            EXPECT_GT(v, 1e6 * rounding) << "velocity, t^" << p;
        }
        if (p == GetParam().acceleration_order + 1) {
            EXPECT_GT(a, 1e6 * rounding) << "acceleration, t^" << p;
        }
    }
}

AffineMotion average_acceleration(const History& past, double h) { return newmark(past, h, 0.25, 0.5); }
AffineMotion linear_acceleration(const History& past, double h) { return newmark(past, h, 1.0 / 6, 0.5); }
AffineMotion fox_goodwin(const History& past, double h) { return newmark(past, h, 1.0 / 12, 0.5); }
AffineMotion damped_newmark(const History& past, double h) { return newmark(past, h, 0.3025, 0.6); }

// Orders by Taylor's series: Newmark's position formula is exact to t² (t³ for β = 1/6), his velocity formula to t² (t³
// never, but the acceleration's error cancels in it where γ = 1/2 and β = 1/6); backward formulas to the number of points
// less one.
INSTANTIATE_TEST_SUITE_P(
    Discretisation, Schemes,
    ::testing::Values(Scheme{"fox_euler", fox_euler, 2, 2}, Scheme{"average_acceleration", average_acceleration, 2, 2},
                      Scheme{"linear_acceleration", linear_acceleration, 3, 3}, Scheme{"fox_goodwin", fox_goodwin, 2, 2},
                      Scheme{"damped_newmark", damped_newmark, 2, 2}, Scheme{"houbolt", houbolt, 3, 3},
                      Scheme{"houbolt_second_step", houbolt_second_step, 3, 3}, Scheme{"park", park, 2, 2},
                      Scheme{"bdf1", bdf1, 1, 1}, Scheme{"bdf2", bdf2, 2, 2}),
    [](const auto& scheme) { return scheme.param.name; });

// Oracle: the linear-acceleration motion itself, x = t³, for which Wilson's extrapolation and its way back are exact.
TEST(Discretisation, WilsonThetaReturnsToTheEndOfTheStep) {
    const double t = 0.9, h = 0.083, theta = 1.4;
    const Power motion{3};
    const History past = motion.past(t, h);
    const Motion end = wilson_end_of_step(past, h, theta, motion.x(t - h + theta * h));
    EXPECT_LT((end.x - motion.x(t)).norm(), 1e-12);
    EXPECT_LT((end.v - motion.v(t)).norm(), 1e-12);
    EXPECT_LT((end.a - motion.a(t)).norm(), 1e-10);
}

// Oracle: the centred differences of t² are exact for γ = 1/2; for another γ the velocity is off by (γ − 1/2) h x''.
TEST(Discretisation, CentredSchemeIsExactForParabolas) {
    const double t = 0.9, h = 0.083;
    const Power motion{2};
    for (double gamma : {0.5, 0.6}) {
        const AffineMotion step = Centred{0.3, gamma}.motion(motion.x(t), motion.x(t - h), h);
        const Vector6 expected = motion.v(t) + (gamma - 0.5) * h * motion.a(t);
        EXPECT_LT((step.velocity(motion.x(t + h)) - expected).norm(), 1e-12);
        EXPECT_LT((step.acceleration(motion.x(t + h)) - motion.a(t)).norm(), 1e-10);
    }
}

// Oracle: weights of a weighted mean add up to one, and its instant is t_n + (γ − 1/2) h, so that it matches the velocity.
TEST(Discretisation, CentredWeightsAddUpAndStandAtTheVelocitysInstant) {
    const Centred scheme{0.31, 0.57};
    EXPECT_NEAR(scheme.weight_after() + scheme.weight_now() + scheme.weight_before(), 1.0, 1e-15);
    EXPECT_NEAR(scheme.weight_after() - scheme.weight_before(), scheme.gamma - 0.5, 1e-15);
}

/// An undamped oscillator x'' = −ω² x, run by a rule on its own memory from the exact start. Returns |x − cos ωt| at t = 1.
double oscillator_error(const std::function<AffineMotion(const History&, double)>& rule, int steps) {
    const double omega = 7, h = 1.0 / steps;
    History past;
    for (int i = 0; i < 3; ++i) {
        const double t = -i * h;
        const auto k = static_cast<size_t>(i);
        past.x[k] = Vector6::Constant(std::cos(omega * t));
        past.v[k] = Vector6::Constant(-omega * std::sin(omega * t));
        past.a[k] = -omega * omega * past.x[k];
    }
    for (int n = 0; n < steps; ++n) {
        const AffineMotion step = rule(past, h);
        const Vector6 x = -step.B / (step.A + omega * omega);  // A x + B = −ω² x
        past.x = {x, past.x[0], past.x[1]};
        past.v = {step.velocity(x), past.v[0], past.v[1]};
        past.a = {step.acceleration(x), past.a[0], past.a[1]};
    }
    return std::abs(past.x[0](0) - std::cos(omega));
}

// Oracle: the order printed in the theory. Halving the step divides the error by 2^order, within 15 % at ωh = 0.0175.
TEST(Discretisation, ConvergesWithTheOrderOfTheTheory) {
    const auto ratio = [](const auto& rule) { return oscillator_error(rule, 400) / oscillator_error(rule, 800); };
    EXPECT_NEAR(ratio(fox_euler), 2, 0.3);
    EXPECT_NEAR(ratio(bdf1), 2, 0.3);
    for (const auto& rule : {average_acceleration, linear_acceleration, houbolt, park, bdf2})
        EXPECT_NEAR(ratio(rule), 4, 0.6);
    EXPECT_NEAR(ratio(fox_goodwin), 16, 2.4);
}

// Oracle: Chung and Hulbert's conditions: second order, γ = 1/2 − α_m + α_f; ρ = 1 is the average acceleration at mid-step.
TEST(Discretisation, GeneralisedAlphaOfRhoOneIsTheTrapezoidalRuleAtMidStep) {
    const GeneralisedAlpha one(1.0);
    EXPECT_DOUBLE_EQ(one.alpha_m, 0.5);
    EXPECT_DOUBLE_EQ(one.alpha_f, 0.5);
    EXPECT_DOUBLE_EQ(one.beta, 0.25);
    EXPECT_DOUBLE_EQ(one.gamma, 0.5);
}

/// Largest modulus of the roots of x_{n+1} of generalised-α on an undamped oscillator at ωh → ∞, by running it.
TEST(Discretisation, GeneralisedAlphaDampsInfiniteFrequencyByRho) {
    const double rho = 0.6, omega = 1e6, h = 1;
    const GeneralisedAlpha scheme(rho);
    History past;
    for (auto* list : {&past.x, &past.v, &past.a}) list->fill(Vector6::Zero());
    past.x[0].setOnes();
    past.a[0] = -omega * omega * past.x[0];
    double size_before = 0, size = 0;
    for (int n = 0; n < 60; ++n) {
        // (1 − α_m)(A x + B) + α_m a₁ = −ω² ((1 − α_f) x + α_f x₁)
        const AffineMotion step = newmark(past, h, scheme.beta, scheme.gamma);
        const double lhs = (1 - scheme.alpha_m) * step.A + (1 - scheme.alpha_f) * omega * omega;
        const Vector6 x =
            -((1 - scheme.alpha_m) * step.B + scheme.alpha_m * past.a[0] + scheme.alpha_f * omega * omega * past.x[0]) / lhs;
        const Vector6 v = step.velocity(x), a = step.acceleration(x);
        past.x[0] = x;
        past.v[0] = v;
        past.a[0] = a;
        size_before = size;
        size = std::abs(a(0));
    }
    EXPECT_NEAR(size / size_before, rho, 0.05);  // a double root: the ratio approaches ρ as 1 + 1/n
}

}  // namespace
}  // namespace dttmm::plugin
