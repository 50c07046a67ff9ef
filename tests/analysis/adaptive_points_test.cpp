// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/adaptive_points.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;

constexpr double kZeta = 0.004;
Complex resonance(double x) { return 1.0 / Complex(1 - x * x, 2 * kZeta * x); }
bool goes_on() { return false; }

// Oracle: closed form. The peak 1/(2 ζ √(1 − ζ²)) to 2e-5, and straight lines between the points are good to 1 %.
TEST(AdaptivePoints, AResonanceIsDrawn) {
    AdaptivePoints adaptive([](double x) { return AdaptivePoints::Values{resonance(x)}; }, {{}});
    ASSERT_TRUE(adaptive.find(std::array{0.1, 1.0, 4.0}, 1000, goes_on));
    double peak = 0, last = 0;
    Complex last_value;
    for (const auto& [x, values] : adaptive.points()) {
        const Complex middle = resonance(0.5 * (last + x));
        const double size = std::abs(values[0]);
        if (last > 0) {
            EXPECT_NEAR(0.5 * (std::abs(last_value) + size), std::abs(middle), 0.0101 * std::abs(middle)) << x;
            const double turn = std::arg(values[0] / last_value);
            EXPECT_LT(std::abs(std::arg(middle / (last_value * std::polar(1.0, 0.5 * turn)))), 0.0101) << x;
        }
        last = x;
        last_value = values[0];
        peak = std::max(peak, size);
    }
    const double exact = 1 / (2 * kZeta * std::sqrt(1 - kZeta * kZeta));
    EXPECT_NEAR(peak, exact, 2e-5 * exact);
    EXPECT_TRUE(adaptive.unbounded().empty());
}

// Two peaks of nearly the same height, as at every optimum of the larger one. Oracle: 200 000 points across each.
TEST(AdaptivePoints, TheHigherOfTwoPeaksIsFound) {
    for (int i = -20; i <= 20; ++i) {
        const double share = 1 + 2e-4 * i;
        const auto curve = [&](double x) { return resonance(x) + share * resonance(x / 3); };
        AdaptivePoints adaptive([&](double x) { return AdaptivePoints::Values{curve(x)}; }, {{}});
        ASSERT_TRUE(adaptive.find(std::array{0.2, 1.013, 2.97, 7.0}, 1000, goes_on));
        double peak = 0, exact = 0;
        for (const auto& [x, values] : adaptive.points()) peak = std::max(peak, std::abs(values[0]));
        for (int k = -100000; k <= 100000; ++k)
            for (const double centre : {1.0, 3.0}) exact = std::max(exact, std::abs(curve(centre * (1 + 1e-7 * k))));
        EXPECT_NEAR(peak, exact, 2e-5 * exact) << share;
    }
}

// Equal natural frequencies differ by rounding: the points between them are no peak without bound.
TEST(AdaptivePoints, EqualFrequenciesAreOnePlace) {
    AdaptivePoints adaptive([](double x) { return AdaptivePoints::Values{resonance(x)}; }, {{}});
    ASSERT_TRUE(adaptive.find(std::array{0.1, 1.0, 1.0 + 1e-15, 1.0 + 3e-15, 4.0}, 1000, goes_on));
    EXPECT_TRUE(adaptive.unbounded().empty());
}

// What is rounding beside curves of its kind asks for no points: without the floor of a kind there would be 100 000.
TEST(AdaptivePoints, RoundingIsNotDrawn) {
    const auto curves = [](double x) { return AdaptivePoints::Values{resonance(x), 1e-11 * std::sin(1e9 * x)}; };
    AdaptivePoints both(curves, {{}, {}}), alone([](double x) { return AdaptivePoints::Values{resonance(x)}; }, {{}});
    ASSERT_TRUE(both.find(std::array{0.1, 1.0, 4.0}, 100000, goes_on));
    ASSERT_TRUE(alone.find(std::array{0.1, 1.0, 4.0}, 100000, goes_on));
    EXPECT_EQ(both.points().size(), alone.points().size());
}

// A motion without damping elsewhere in the machine, and one of another unit: the curve is as good as alone.
TEST(AdaptivePoints, APeakElsewhereLeavesTheCurve) {
    const auto undamped = [](double x) { return 1.0 / std::abs(1 - x * x / 6.25 + 1e-12); };
    AdaptivePoints adaptive(
        [&](double x) {
            return AdaptivePoints::Values{resonance(x), undamped(x), 3000 * undamped(x)};
        },
        {{}, {0, 1, false}, {0, 1e-3, false}});
    ASSERT_TRUE(adaptive.find(std::array{0.1, 1.0, 2.5, 4.0}, 1000, goes_on));
    double last = 0;
    Complex last_value;
    for (const auto& [x, values] : adaptive.points()) {
        const double middle = std::abs(resonance(0.5 * (last + x)));
        if (last > 0) {
            EXPECT_NEAR(0.5 * (std::abs(last_value) + std::abs(values[0])), middle, 0.0101 * middle) << x;
        }
        last = x;
        last_value = values[0];
    }
}

// A free direction at 0 has another value than beside it: the search ends there all the same.
TEST(AdaptivePoints, AFreeDirectionAtZeroEnds) {
    AdaptivePoints adaptive([](double x) { return AdaptivePoints::Values{x == 0 ? 1.0 : 1.0 / (x * x)}; }, {{}});
    ASSERT_TRUE(adaptive.find(std::array{0.0, 2.0, 5.0}, 100000, goes_on));
    EXPECT_TRUE(adaptive.unbounded().empty());
    EXPECT_LT(adaptive.points().size(), 1000u);
}

// 1/|x − a| has no peak: the place is told once, and the search stops where it is asked to.
TEST(AdaptivePoints, WhatHasNoPeakIsTold) {
    const auto curve = [](double x) { return AdaptivePoints::Values{1 / (std::abs(x - 1.2345) + 1e-14)}; };
    AdaptivePoints adaptive(curve, {{}});
    ASSERT_TRUE(adaptive.find(std::array{0.5, 1.2345, 2.0}, 100000, goes_on));
    ASSERT_EQ(adaptive.unbounded().size(), 1u);
    EXPECT_NEAR(adaptive.unbounded().front(), 1.2345, 1e-6);
    AdaptivePoints few(curve, {{}});
    EXPECT_FALSE(few.find(std::array{0.5, 2.0}, 10, goes_on));
    EXPECT_EQ(few.points().size(), 10u);
}

// The root of a density that begins or ends at 0 is vertical there: no points make it straight, but it has a bound. Beside a
// pole without damping it has none, also where a density begins or ends.
TEST(AdaptivePoints, OnlyAPoleIsUnbounded) {
    using Curve = double (*)(double);
    const auto unbounded = [](Curve curve, const std::array<double, 3>& start) {
        AdaptivePoints adaptive([&](double x) { return AdaptivePoints::Values{curve(x)}; }, {{}});
        EXPECT_TRUE(adaptive.find(start, 1000, goes_on));
        return adaptive.unbounded();
    };
    EXPECT_TRUE(unbounded([](double x) { return std::sqrt(std::max(x - 8, 0.0)); }, {8, 9.3, 12}).empty());
    EXPECT_TRUE(unbounded([](double x) { return std::sqrt(std::max(12 - x, 0.0)); }, {8, 9.3, 12}).empty());
    const double at = 9.3 * (1 + 1e-12);
    const Curve pole = [](double x) { return std::sqrt(std::max(x - 8, 0.0)) / std::abs(x / (9.3 * (1 + 1e-12)) - 1); };
    for (const auto& start : {std::array{8.0, 9.3, 12.0}, {8.0, 9.0, 9.3}, {9.3, 11.0, 12.0}}) {
        const std::vector<double> found = unbounded(pole, start);
        ASSERT_FALSE(found.empty());
        for (const double x : found) EXPECT_NEAR(x, at, 2e-6) << start[0];
    }
}

}  // namespace
}  // namespace dttmm::host
