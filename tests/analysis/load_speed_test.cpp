// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/load_speed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "analysis/first_step.h"
#include "model/read_model.h"
#include "model/signal_shapes.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

using std::numbers::pi;

template <class Shape, class... Arguments>
Signal signal_of(Arguments... arguments) {
    return Signal(std::make_shared<const Shape>(arguments...));
}

Signal expression(const std::string& text) {
    return Signal(std::make_shared<const ExpressionSignal>(Expression(text, {}, "t")));
}

constexpr double kImplicit[3] = {0.25, 0.5, 0.25}, kExplicit[3] = {0, 1, 0};

/// The part that costs most at the step, with its cost.
std::pair<double, double> worst(const std::vector<SignalPart>& parts, double step) {
    std::pair<double, double> result = {0, 0};
    for (const SignalPart& part : parts) {
        const double error = part.share * compute_load_error(kImplicit, 2 * pi * part.frequency * step);
        if (std::abs(error) > std::abs(result.second)) result = {part.frequency, error};
    }
    return result;
}

// Oracle: the recurrence of a free mass, x+ − 2x + x− = h² (w+ f+ + w0 f + w− f−)/m, has for f = cos(ωt) the solution
// x = −W cos(ωt) (h/2)²/(m sin²a).
TEST(LoadSpeed, TheErrorIsThatOfTheRecurrence) {
    for (double omega_h : {0.01, 0.3, 1.2566, 2.5}) {
        const double a = omega_h / 2;
        EXPECT_NEAR(compute_load_error(kImplicit, omega_h), std::pow(a / std::tan(a), 2) - 1, 1e-14) << omega_h;
        EXPECT_NEAR(compute_load_error(kExplicit, omega_h), std::pow(a / std::sin(a), 2) - 1, 1e-14) << omega_h;
    }
    EXPECT_EQ(compute_load_error(kImplicit, 0), 0);
    EXPECT_EQ(compute_load_error(kImplicit, pi), -1);  // two steps per period
    EXPECT_EQ(compute_load_error(kExplicit, 7), -1);
}

// Oracle: the weights applied to the signal itself, (f+ + 2f + f−)/4, at its peak or at its fastest bend, lose share sin²a;
// of the displacement the share of the part loses 1 − (a/tan a)².
TEST(LoadSpeed, TheClosedFormsLoseWhatTheWeightsTakeOff) {
    const double h = 1e-3;
    const auto loss_at = [&](const Signal& signal, double t, double scale) {
        return (signal.value(t) - (signal.value(t + h) + 2 * signal.value(t) + signal.value(t - h)) / 4) / scale;
    };
    const auto of_displacement = [&](double frequency) {
        const double a = pi * frequency * h;
        return (1 - std::pow(a / std::tan(a), 2)) / std::pow(std::sin(a), 2);
    };
    const Signal sine = signal_of<SineSignal>(7.0, 90.0, 0.0, 100.0, 0.0);
    EXPECT_NEAR(-worst(find_parts(sine, 1, h), h).second, of_displacement(90) * loss_at(sine, 0.25 / 90 + 1. / 90, 7),
                1e-12);
    const Signal pulse = signal_of<PulseSignal>(9.0, 0.1, 0.011);
    EXPECT_NEAR(-worst(find_parts(pulse, 1, h), h).second, of_displacement(1 / 0.011) * loss_at(pulse, 0.1055, 9), 1e-12);
    const Signal ramp = signal_of<StepSignal>(3.0, 8.0, 0.2, 0.23);
    const double bend = of_displacement(find_parts(ramp, 1, h).front().frequency) * std::abs(loss_at(ramp, 0.2 + h, 5)) /
                        (1 - 2 * h / 0.03);  // of its start, where it bends most
    EXPECT_NEAR(-worst(find_parts(ramp, 1, h), h).second, bend, 0.01 * bend);
}

TEST(LoadSpeed, WhatDoesNotChangeOrJumpsHasNoPart) {
    for (const Signal& signal : {Signal(), signal_of<ConstantSignal>(5.0), signal_of<StepSignal>(0.0, 3.0, 0.1, 0.1),
                                 signal_of<StepSignal>(3.0, 3.0, 0.1, 0.2), signal_of<SineSignal>(0.0, 90.0, 0.0, 1.0, 0.0),
                                 signal_of<PulseSignal>(0.0, 0.1, 0.2), expression("t-t+5"), expression("1/(t-0.5)")})
        EXPECT_TRUE(find_parts(signal, 1, 1e-3).empty());
}

// Oracle: the closed form of the same shape. A spectrum has its lines 1/(2 duration) apart.
TEST(LoadSpeed, ASampledSignalHasThePartsOfItsShape) {
    const double h = 1e-3, duration = 0.7;
    const auto [frequency, error] = worst(find_parts(expression("40 + 7*sin(2*pi*90*t)"), duration, h), h);
    EXPECT_NEAR(frequency, 90, 1 / duration);
    EXPECT_NEAR(error, compute_load_error(kImplicit, 2 * pi * 90 * h), 0.03 * std::abs(error));

    std::vector<double> times, values;
    const Signal pulse = signal_of<PulseSignal>(9.0, 0.1, 0.011);
    for (int i = 0; i <= 700; ++i) {
        times.push_back(i * 1e-3);
        values.push_back(pulse.value(times.back()));
    }
    const double as_pulse = worst(find_parts(pulse, duration, h), h).second;
    EXPECT_NEAR(worst(find_parts(signal_of<TableSignal>(times, values), duration, h), h).second, as_pulse,
                0.1 * std::abs(as_pulse));
}

// The part of 200 Hz decides, a fifth of the other as it is; the jump of a square wave of two periods does not.
TEST(LoadSpeed, ASmallFastPartDecidesAndAJumpDoesNot) {
    const double h = 1e-3;
    const auto [frequency, error] = worst(find_parts(expression("1000*cos(2*pi*10*t) + 200*cos(2*pi*200*t)"), 1, h), h);
    EXPECT_NEAR(frequency, 200, 1);
    EXPECT_NEAR(error, 0.2 * (std::pow(pi * 0.2 / std::tan(pi * 0.2), 2) - 1), 2e-3);
    EXPECT_LT(std::abs(worst(find_parts(expression("t < 0.5 ? 0 : 100"), 1, h), h).second), kTolerableLoadError);
}

// Oracle: at the step that is proposed, the error is 1 % at most, and more at the next longer one of the series.
TEST(LoadSpeed, TheStepThatIsProposedIsShortEnough) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 1, 5e5, 100, 1e-3, Coupling::implicit);
    model.loads[0].signal = signal_of<SineSignal>(10.0, 200.0, 0.0, 0.0, 0.0);
    const Simulation simulation(model, plugins);
    const std::vector<FastLoad> fast = find_fast_loads(model, simulation, kTolerableLoadError);
    ASSERT_EQ(fast.size(), 1u);
    EXPECT_EQ(fast[0].frequency, 200);
    EXPECT_NEAR(fast[0].error, std::pow(pi * 0.2 / std::tan(pi * 0.2), 2) - 1, 1e-12);
    EXPECT_EQ(fast[0].step, 1e-3 / 8);  // a/tan a = sqrt(0.99), a = 0.1224: 0.195 ms
    EXPECT_TRUE(find_fast_loads(model, simulation, 0.26).empty());
}

// Oracle: a soft spring between a mass and a support that moves by X sin wt acts as a load k X sin wt: the same loss, the
// same step.
TEST(LoadSpeed, AMotionOfASupportCountsAsALoadDoes) {
    const Plugins plugins;
    Model model = parse_model(R"(format = "dttmm/1"
[simulation]
duration = 1
step = "1 ms"
[nodes]
still = { position = [1, 0, 0], fixed = ["x", "y"] }
base = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = { z = { type = "sine", amplitude = 0.01, frequency = 200 }, rx = "=0.1*t" } }
[[element]]
name = "spring"
type = "spring_damper"
from = "base"
to = "still"
stiffness = 10
rotational_stiffness = 10
[[element]]
name = "mass"
type = "rigid_body"
at = "still"
mass = 3
inertia = { xx = 1, yy = 1, zz = 1 }
)",
                              "m.toml", plugins.catalogue());
    const Simulation simulation(model, plugins);
    const std::vector<FastLoad> fast = find_fast_loads(model, simulation, kTolerableLoadError);
    ASSERT_EQ(fast.size(), 1u) << "the slow rotation is not fast";
    EXPECT_EQ(fast[0].frequency, 200);
    EXPECT_EQ(fast[0].name, "the motion of node \"base\" in z");
    EXPECT_NEAR(fast[0].error, std::pow(pi * 0.2 / std::tan(pi * 0.2), 2) - 1, 1e-12);
    EXPECT_EQ(fast[0].step, 1e-3 / 8);
    // The first step of a run to a tolerance likewise: at most 10 %, a/tan a = sqrt(0.9), a = 0.387: 0.62 ms
    model.simulation.step = 0;
    model.simulation.tolerance = 0.01;
    const double first = choose_step(model, plugins).simulation.step;
    EXPECT_LE(first, 0.62e-3);
    EXPECT_GT(first, 0.3e-3);
}

}  // namespace
}  // namespace dttmm::host
