// SPDX-License-Identifier: BSD-3-Clause
//
// Mounts whose stiffness and loss angle are rows over frequency, against closed forms and in time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "cli/process.h"
#include "cli/results_table.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;
using Complex = std::complex<double>;
constexpr double kWholeTurn = 2 * std::numbers::pi, kMassOnRubber = 2.3;

/// k (iω)^0.06: rubber.
Complex measured(double f) { return 9000.0 * std::pow(Complex(0, kWholeTurn * f), 0.06); }

/// A file of rows [Hz, N/mm, deg].
std::string rows_file() {
    std::string text = "# mount A, 20 degC\nfrequency [Hz],stiffness [N/mm],loss angle [deg]\n";
    for (double f = 1; f < 110; f *= 1.25)
        text += fmt::format("{:.17g},{:.17g},{:.17g}\n", f, std::abs(measured(f)) / 1000,
                            std::arg(measured(f)) * 360 / kWholeTurn);
    return text;
}

/// A mass on one mount along its turned axis z.
std::string mass_on_rubber(const std::string& rows, const std::string& rest = "") {
    return fmt::format(R"(format = "dttmm/1"
[[body]]
name = "block"
mass = {}
inertia = [0.02, 0.03, 0.025]
rotation = {{ axis = [0.2, 1, 0.3], angle = "35 deg" }}
[[joint]]
name = "guide"
type = "slider"
between = ["ground", "block"]
axis = [0, 0.6, 0.8]
[[element]]
name = "mount"
type = "rubber_mount"
from = "ground"
to = "block"
axes = {{ axis = [1, 0, 0], angle = "{:.17g} rad" }}
z = {}
{})",
                       kMassOnRubber, -std::asin(0.6), rows, rest);
}

class Rubber : public ::testing::Test {
protected:
    Ended ask(const std::string& text, std::vector<std::string> words) {
        write_text(folder_ / "model.toml", text);
        write_text(folder_ / "a.csv", rows_file());
        words.insert(words.begin() + 1, {"model.toml", "-o", "out"});
        return run_dttmm(folder_.path(), words);
    }
    ResultsTable table(const std::string& text, const std::vector<std::string>& words, const std::string& file,
                       std::string* said = nullptr) {
        const Ended ended = ask(text, words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        if (said) *said = ended.err;
        return ended.code == 0 ? read_table(folder_ / "out" / file) : ResultsTable();
    }
    void expect_fault(const std::string& text, const std::vector<std::string>& words, const std::string& message) {
        const Ended ended = ask(text, words);
        EXPECT_EQ(ended.code, 3) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(message));
    }
    const TemporaryFolder folder_;
};

const std::string kLoadOnRubber = R"([[load]]
on = "block"
direction = [0, 0.6, 0.8]
)";

// Oracle: closed form, x = F/(K(f) − m ω²) with K by straight lines of magnitude and angle between the rows.
TEST_F(Rubber, VibratesWithItsRows) {
    const std::string rows = R"([[2, "9 N/mm", "4 deg"], ["10 Hz", 9900, 0.09], [40, 11e3, "7 deg"]])";
    const ResultsTable found = table(mass_on_rubber(rows, kLoadOnRubber + "harmonic = { amplitude = \"5 N\" }\n"),
                                     {"response", "--from", "1Hz", "--to", "40Hz", "--points", "14", "-q"}, "response.csv");
    ASSERT_EQ(found.rows.size(), 14u);
    for (size_t i = 0; i < found.rows.size(); ++i) {
        const double f = found.value(i, "frequency"), deg = kWholeTurn / 360;
        const double share = f < 10 ? (f - 2) / 8 : (f - 10) / 30;
        const Complex K = f < 2    ? std::polar(9000.0, 4 * deg * f / 2)
                          : f < 10 ? std::polar(9000 + 900 * share, 4 * deg + share * (0.09 - 4 * deg))
                                   : std::polar(9900 + 1100 * share, 0.09 + share * (7 * deg - 0.09));
        const Complex x = 5.0 / (K - kMassOnRubber * std::pow(kWholeTurn * f, 2));
        EXPECT_LT(std::abs(found.amplitude(i, "guide.travel") - x), 1e-9 * std::abs(x)) << f;
        EXPECT_LT(std::abs(found.amplitude(i, "mount.force.z") - K * x), 1e-9 * std::abs(K * x)) << f;
    }
}

// Oracle: the closed form with the measured stiffness. A run to steady state agrees within what the series that stands for
// the rows is off, which the run reports, and (ω h)²/6.
TEST_F(Rubber, ARunBecomesTheVibration) {
    for (const double f : {4.0, 25.0}) {
        const double step = 1 / f / 200;
        std::string said;
        const ResultsTable found = table(
            mass_on_rubber("\"a.csv\"", kLoadOnRubber + fmt::format("harmonic = {{ amplitude = \"5 N\", frequency = {} }}\n"
                                                                    "[simulation]\nduration = {}\nstep = {:.17g}\n",
                                                                    f, 4.0 + 1 / f, step)),
            {"run", "-q"}, "history.csv", &said);
        ASSERT_GT(found.rows.size(), 200u);
        EXPECT_THAT(said, HasSubstr("a Maxwell series of"));
        EXPECT_THAT(said, HasSubstr("element \"mount\": in z"));
        const Complex x = 5.0 / (measured(f) - kMassOnRubber * std::pow(kWholeTurn * f, 2)), force = measured(f) * x;
        // The amplitude over the last period, by its Fourier coefficient
        Complex way = 0, pull = 0;
        for (size_t i = found.rows.size() - 200; i < found.rows.size(); ++i) {
            const Complex turn = std::polar(1.0 / 100, -kWholeTurn * f * found.value(i, "time"));
            way += found.value(i, "guide.travel") * turn;
            pull += found.value(i, "mount.force.z") * turn;
        }
        EXPECT_LT(std::abs(way - x), 0.02 * std::abs(x)) << f;
        EXPECT_LT(std::abs(pull - force), 0.02 * std::abs(force)) << f;
        double lacking = 0, work = 0;
        for (size_t i = 0; i < found.rows.size(); ++i) {
            lacking = std::max(lacking, std::abs(found.value(i, "energy.residual")));
            work = std::max(work, std::abs(found.value(i, "energy.work")));
        }
        EXPECT_LT(lacking, 2e-3 * work) << f;
    }
}

// Oracle: the closed form s² m + K(s) = 0 with K(s) = 9000 s^0.06, by Newton's method.
TEST_F(Rubber, DampedModesHaveTheStiffnessOfTheirFrequency) {
    Complex s(0, 70);
    for (int i = 0; i < 60; ++i) {
        const Complex f = kMassOnRubber * s * s + 9000.0 * std::pow(s, 0.06),
                      slope = 2 * kMassOnRubber * s + 540.0 * std::pow(s, 0.06 - 1);
        s -= f / slope;
    }
    std::string said;
    const ResultsTable found =
        table(mass_on_rubber("\"a.csv\""), {"modes", "--damped", "--below", "30 Hz"}, "damped.csv", &said);
    EXPECT_THAT(said, HasSubstr("have the stiffness of its rows at rest"));
    EXPECT_THAT(said, HasSubstr("a Maxwell series of"));
    const auto vibrates = std::ranges::find_if(found.rows, [](const auto& row) { return row[1] > 0; });
    ASSERT_NE(vibrates, found.rows.end());
    EXPECT_EQ(std::ranges::count_if(found.rows, [](const auto& row) { return row[1] > 0; }), 1);
    EXPECT_NEAR((*vibrates)[2], std::abs(s) / kWholeTurn, 0.005 * std::abs(s) / kWholeTurn);
    EXPECT_NEAR((*vibrates)[3], -s.real() / std::abs(s), 0.003);
}

// Oracle: statics. At rest all terms have relaxed: a weight is carried by the spring of the series, and a run that starts
// there stays.
TEST_F(Rubber, RestsOnItsSpring) {
    const std::string text = mass_on_rubber("\"a.csv\"",
                                            "[simulation]\nduration = 0.2\nstep = 1e-3\ngravity = [0, 0, -9.81]\n"
                                            "start = \"equilibrium\"\n");
    const ResultsTable rest = table(text, {"static", "-q"}, "static.csv");
    EXPECT_NEAR(std::abs(rest.value(0, "mount.force.z")), kMassOnRubber * 9.81 * 0.8, 1e-8);
    const ResultsTable found = table(text, {"run", "-q"}, "history.csv");
    for (size_t i = 0; i < found.rows.size(); ++i)
        EXPECT_NEAR(found.value(i, "guide.travel"), rest.value(0, "guide.travel"), 1e-11);
}

TEST_F(Rubber, WhatIsWrongIsRefused) {
    const auto fault = [&](const std::string& rows, const std::string& message) {
        write_text(folder_ / "model.toml", mass_on_rubber(rows, "[simulation]\nduration = 0.1\nstep = 1e-3\n"));
        const Ended ended = run_dttmm(folder_.path(), {"check", "model.toml"});
        EXPECT_EQ(ended.code, 3) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(message));
    };
    fault("[[10, 9e3, 0.1]]", "model.toml:18:5: element \"mount\": z: one row: two or more are needed");
    fault("[[10, 9e3, 0.1], [5, 9e3, 0.1]]", "the frequencies must increase from row to row");
    fault("[[10, 9e3], [20, 9e3]]", "z must be the name of a file, or rows [[frequency, stiffness, loss angle], ..]");
    fault("[[10, -9e3, 0.1], [20, 9e3, 0.1]]", "stiffness must be");
    fault("[[10, 9e3, 0.1], [20, 9e3, \"95 deg\"]]", "the loss angle must be less than 90 degrees");
    fault("[[0, 9e3, 0.1], [20, 9e3, 0.1]]", "the frequency must be more than zero");
    fault("9e3", "z must be the name of a file, or rows");
    fault("\"none.csv\"", "table file \"none.csv\"");
    expect_fault(mass_on_rubber("\"a.csv\"", kLoadOnRubber + "harmonic = { amplitude = \"5 N\" }\n"),
                 {"response", "--from", "1Hz", "--to", "400Hz"}, "add rows up to there");
}

// Oracle: what no material does is warned of.
TEST_F(Rubber, APoorFitIsAWarning) {
    std::string said;
    (void)table(mass_on_rubber("[[1, 20e3, 0.3], [10, 12e3, 0.3], [100, 5e3, 0.3]]",
                               "[simulation]\nduration = 0.01\nstep = 1e-3\n[[load]]\non = \"block\"\ndirection = [0, 0.6, "
                               "0.8]\nforce = 1\n"),
                {"run", "-q"}, "history.csv", &said);
    EXPECT_THAT(said, HasSubstr("warning: "));
    EXPECT_THAT(said, HasSubstr("no material behaves like these rows in time"));
}

}  // namespace
}  // namespace dttmm::host
