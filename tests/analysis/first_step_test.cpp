// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/first_step.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "model/signal_shapes.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

using std::numbers::pi;

/// The plate on four bolts without a step; its fastest vibration, rocking, has 109.84 Hz with bolts of 5e5 N/m.
Model plate(const Plugins& plugins, double duration, double k = 5e5) {
    Model model = test::plate_stack(plugins, 1, k, 100, 0, Coupling::implicit);
    model.simulation.duration = duration;
    model.simulation.tolerance = 0.01;
    return model;
}

void expect_step(const Model& model, const Plugins& plugins, double step, int every) {
    const Model chosen = choose_step(model, plugins);
    EXPECT_NEAR(chosen.simulation.step, step, 1e-9 * step);
    EXPECT_EQ(chosen.output.every, every);
}

// Oracle: the rules of the header by hand.
TEST(FirstStep, IsAThousandthOfTheDurationIfNothingAsksForLess) {
    const Plugins plugins;
    expect_step(plate(plugins, 1), plugins, 1e-3, 1);      // 1/omega = 1.449 ms
    expect_step(plate(plugins, 1.3), plugins, 1.3e-3, 1);  // divides the duration
    expect_step(plate(plugins, 1e-6), plugins, 1e-9, 1);   // the shortest step there is
}

TEST(FirstStep, ResolvesTheFastestVibrationButNotAtAnyPrice) {
    const Plugins plugins;
    expect_step(plate(plugins, 2), plugins, 2. / 2000, 1);        // 2 ms is more than 1.449 ms
    expect_step(plate(plugins, 1, 5e9), plugins, 1. / 10000, 1);  // 1/omega = 14.5 us, 1e-4 of 1 s is longer
    expect_step(plate(plugins, 0.01, 5e9), plugins, 0.01 / 1000, 1);
}

// Oracle: 10 % of the motion under a harmonic load are lost where a/tan a = sqrt(0.9), a = omega h/2 = 0.3903: 8.05 steps
// per period.
TEST(FirstStep, ResolvesTheLoads) {
    const Plugins plugins;
    Model model = plate(plugins, 1);
    const auto sine = [&](double f) {
        model.loads[0].signal = Signal(std::make_shared<const SineSignal>(10, f, 0, 0, 0));
        return choose_step(model, plugins).simulation.step;
    };
    EXPECT_NEAR(sine(124), 1e-3, 1e-12);  // 8.06 steps per period
    EXPECT_NEAR(sine(125), 5e-4, 1e-12);  // would be 8.00 steps per period
    EXPECT_NEAR(sine(1e7), 1e-6, 1e-15);
    Expression formula("100*cos(2*pi*500*t)", {}, "t");
    model.loads[0].signal = Signal(std::make_shared<const ExpressionSignal>(std::move(formula)));
    EXPECT_NEAR(choose_step(model, plugins).simulation.step, 2e-4, 1e-12);
}

TEST(FirstStep, DividesTheOutputStepAndLimitsTheRows) {
    const Plugins plugins;
    Model model = plate(plugins, 1);
    model.output.step = 0.01;
    expect_step(model, plugins, 1e-3, 10);
    model.output.step = 0.3e-3;
    expect_step(model, plugins, 0.3e-3, 1);
    model.output.step = 0;
    model.loads[0].signal = Signal(std::make_shared<const SineSignal>(10, 8000, 0, 0, 0));
    expect_step(model, plugins, 12.5e-6, 8);  // 9.76 steps per period are 12.8 us; 80 000 steps, 10 000 rows
}

TEST(FirstStep, AStepThatIsGivenStays) {
    const Plugins plugins;
    Model model = plate(plugins, 1);
    model.simulation.step = 0.2;
    model.output.every = 5;
    expect_step(model, plugins, 0.2, 5);
}

}  // namespace
}  // namespace dttmm::host
