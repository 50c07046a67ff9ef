// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm response` against closed forms and against the same machine in time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <numbers>
#include <sstream>

#include "cli/modes_run.h"
#include "cli/steady_vibration.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Oracle: closed form, x = F/(k + iωc − mω²) with F = A e^(iφ); the spring carries (k + iωc) x.
TEST_F(SteadyVibration, OneMassUnderAHarmonicLoad) {
    const Table table = response(kMassOnSpring + "harmonic = { amplitude = \"=2*F\", phase = \"25 deg\" }\n",
                                 {"--from", "2Hz", "--to", "40Hz", "--points", "13", "--out", "m", "--out", "spring", "-q"});
    ASSERT_EQ(table.rows.size(), 13u);
    for (size_t i = 0; i < table.rows.size(); ++i) {
        const double f = table.value(i, "frequency"), w = 2 * kHalfTurn * f;
        const Complex F = std::polar(14.0, 25 * kHalfTurn / 180), x = F * receptance(f),
                      force = Complex(kSpring, w * kDamper) * x;
        EXPECT_NEAR(f, 2 + 38.0 * static_cast<double>(i) / 12, 1e-12);
        EXPECT_LT(std::abs(table.amplitude(i, "m.position.x") - x), 1e-10 * std::abs(x));
        EXPECT_LT(std::abs(table.amplitude(i, "m.velocity.x") - Complex(0, w) * x), 1e-10 * std::abs(w * x));
        EXPECT_LT(std::abs(table.amplitude(i, "m.acceleration.x") + w * w * x), 1e-10 * std::abs(w * w * x));
        EXPECT_LT(std::abs(table.amplitude(i, "spring.force.x") - force), 1e-10 * std::abs(force));
        EXPECT_LT(std::abs(table.amplitude(i, "spring.deflection.x") - x), 1e-10 * std::abs(x));
    }
}

// Oracle: closed form. Adaptive points hold the true peak to 1e-4, and straight lines between them are good to 1 %.
TEST_F(SteadyVibration, PointsGoWhereTheCurveBends) {
    const Table table = response(kMassOnSpring + "harmonic = { amplitude = \"1 N\" }\n",
                                 {"--from", "0.5Hz", "--to", "60Hz", "--out", "m.position.x", "-q"});
    const double z = kDamper / (2 * std::sqrt(kSpring * kOwnMass)), peak = 1 / (2 * z * std::sqrt(1 - z * z) * kSpring);
    double largest = 0;
    for (size_t i = 0; i < table.rows.size(); ++i) {
        const Complex x = table.amplitude(i, "m.position.x");
        largest = std::max(largest, std::abs(x));
        if (i == 0) continue;
        const double f0 = table.value(i - 1, "frequency"), f2 = table.value(i, "frequency");
        ASSERT_GT(f2, f0);
        for (const double s : {0.25, 0.5, 0.75}) {
            const double straight = (1 - s) * std::abs(table.amplitude(i - 1, "m.position.x")) + s * std::abs(x);
            const double true_size = std::abs(receptance((1 - s) * f0 + s * f2));
            EXPECT_NEAR(straight, true_size, 0.011 * true_size) << f0 << " " << f2;
        }
    }
    EXPECT_NEAR(largest, peak, 1e-4 * peak);
    EXPECT_LT(table.rows.size(), 200u);
}

// Oracle: closed form. An order acts at order Ω/2π with the amplitude of its speed; derived parameters go with it, and one
// order leaves the rows of another alone. An unbalance acts with u Ω² cos(Ωt + φ) across its axis.
TEST_F(SteadyVibration, OrdersAndUnbalanceOverSpeed) {
    std::string text = kMassOnSpring + R"(harmonic = { amplitude = "=2*g2 + F", phase = "1 rad", order = 2 }
[[load]]
on = "m"
direction = [0, 0, 1]
unbalance = "30 g*m"
phase = "20 deg"
)";
    text.replace(text.find("F = "), 0, "g2 = \"=0.01*Omega^2\"\n");
    const Table table = response(text, {"--rpm", "200..1500:9", "--out", "m.position", "-q"});
    ASSERT_EQ(table.rows.size(), 18u);
    for (size_t i = 0; i < 18; ++i) {
        const double rpm = table.value(i, "rpm"), speed = rpm * kHalfTurn / 30, order = table.value(i, "order"),
                     f = table.value(i, "frequency");
        EXPECT_EQ(order, i < 9 ? 1 : 2);
        EXPECT_NEAR(rpm, 200 + 1300.0 / 8 * static_cast<double>(i % 9), 1e-9);
        EXPECT_NEAR(f, order * rpm / 60, 1e-9);
        const Complex F = order == 1 ? 0.03 * speed * speed * std::polar(1.0, 20 * kHalfTurn / 180)
                                     : (0.02 * speed * speed + 7) * std::polar(1.0, 1.0);
        const Complex x = F * receptance(f);
        EXPECT_LT(std::abs(table.amplitude(i, "m.position.x") - x), 1e-9 * std::abs(x)) << i;
    }
    // Without --rpm: at the speed of the model
    const Table own = response(text, {"--out", "m.position", "-q"});
    ASSERT_EQ(own.rows.size(), 2u);
    const double speed = 10 * kHalfTurn;
    EXPECT_NEAR(own.value(0, "frequency"), 5, 1e-12);
    const Complex x = 0.03 * speed * speed * std::polar(1.0, 20 * kHalfTurn / 180) * receptance(5);
    EXPECT_LT(std::abs(own.amplitude(0, "m.position.x") - x), 1e-9 * std::abs(x));
}

// Oracle: closed forms under white noise of density S: x² = S/(4 k c) of the whole axis, here cut at 40 times the natural
// frequency, and the rate of crossings ω0/2π.
TEST_F(SteadyVibration, WhiteNoiseOnOneMass) {
    const double f0 = std::sqrt(kSpring / kOwnMass) / (2 * kHalfTurn);
    const std::string text =
        kMassOnSpring + fmt::format("psd = {{ frequencies = [0, {}], values = [\"3 N^2/Hz\", \"3 N^2/Hz\"] }}\n", 40 * f0);
    const Ended ended = ask(text, {"--out", "m.position.x", "--out", "spring.force.x", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const std::string rms = read_text(folder_ / "out1/rms.csv");
    std::istringstream lines(rms);
    std::string line;
    std::vector<std::vector<std::string>> cells;
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::vector<std::string>& row = cells.emplace_back();
        for (std::string cell; std::getline(fields, cell, ',');) row.push_back(cell);
    }
    ASSERT_EQ(cells.size(), 4u);
    EXPECT_EQ(cells[0][0], "channel");
    const size_t position = cells[2][0] == "m.position.x" ? 2 : 3;
    EXPECT_EQ(cells[position][0], "m.position.x");
    EXPECT_EQ(cells[position][1], "m");
    const double expected = std::sqrt(3 / (4 * kSpring * kDamper)), got = std::stod(cells[position][2]);
    EXPECT_NEAR(got, expected, 2e-4 * expected);
    EXPECT_NEAR(std::stod(cells[position][3]), 3 * got, 1e-9 * got);
    EXPECT_NEAR(std::stod(cells[position][4]), f0, 0.02 * f0);  // of ω² |H|², cut off at 40 f0
    const double force = std::sqrt(3 * (kSpring / (4 * kDamper) + kDamper / (4 * kOwnMass)));  // k² + ω² c²
    EXPECT_NEAR(std::stod(cells[5 - position][2]), force, 2e-3 * force);
}

// Oracle: the lines of psd.csv but the two of its head.
TEST_F(SteadyVibration, TheRowsOfADensityAreCounted) {
    const Ended ended = ask(kMassOnSpring + "psd = { frequencies = [2, 40], values = [3, 1] }\n", {"--out", "m.position.x"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const std::string text = read_text(folder_ / "out1/psd.csv");
    const auto rows = std::ranges::count(text, '\n') - 2;
    EXPECT_GT(rows, 10);
    EXPECT_THAT(ended.out, HasSubstr(fmt::format("{} rows; results in", rows)));
    EXPECT_EQ(read_json(folder_ / "out1/summary.json")["rows"], rows);
}

// A density of motion that begins, touches and ends at 0 is no lack of damping.
TEST_F(SteadyVibration, ADensityThatIsZeroSomewhereHasABound) {
    for (const char* of : {"acceleration", "velocity", "displacement"}) {
        const Ended ended = ask(fmt::format(R"(format = "dttmm/1"
[[body]]
name = "b"
mass = 10
inertia = [0.1, 0.1, 0.1]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 4e5
rotational_stiffness = 4e4
damping = 100
rotational_damping = 10
motion = {{ z = {{ type = "psd", of = "{}", frequencies = [8, 20, 27, 60, 120], values = [0, 1, 0, 0.2, 0] }} }}
)",
                                            of),
                                {"--out", "b.acceleration.z", "-q"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.err, Not(HasSubstr("nothing damps"))) << of;
    }
}

// Oracle: the integral of |H|² S by 400 000 rectangles of equal ratio. Two loads have densities with corners, steep flanks
// and ranges of their own that begin and end where the other one goes on.
TEST_F(SteadyVibration, DensitiesWithCornersAndRangesOfTheirOwn) {
    const auto text =
        kMassOnSpring + R"(psd = { frequencies = [3, 8, 9.2, 40], values = [0.5, 6, 0.3, 0.01], interpolation = "log" }
[[load]]
on = "m"
direction = [1, 0, 0]
psd = { frequencies = [25, 25.4], values = [10, 20] }
)";
    const Ended ended = ask(text, {"--out", "m.position.x", "--out", "m.acceleration.x", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");  // a jump inside a panel would be an unbounded peak
    const auto first = [](double f) {
        const double at[] = {3, 8, 9.2, 40}, value[] = {0.5, 6, 0.3, 0.01};
        for (int i = 0; i < 3; ++i)
            if (f >= at[i] && f <= at[i + 1])
                return value[i] * std::pow(value[i + 1] / value[i], std::log(f / at[i]) / std::log(at[i + 1] / at[i]));
        return 0.0;
    };
    const auto second = [](double f) { return f >= 25 && f <= 25.4 ? 10 + (f - 25) * 25 : 0.0; };
    double position = 0, acceleration = 0;
    constexpr int kCount = 400000;
    const double ratio = std::pow(40.0 / 3, 1.0 / kCount);
    double f = 3 * std::sqrt(ratio);
    for (int i = 0; i < kCount; ++i, f *= ratio) {
        const double own = std::norm(receptance(f)) * (first(f) + second(f)) * f * std::log(ratio);
        position += own;
        acceleration += own * std::pow(2 * kHalfTurn * f, 4);
    }
    const std::string rms = read_text(folder_ / "out1/rms.csv");
    for (const auto& [name, square] : {std::pair("m.position.x,m,", position), {"m.acceleration.x,m/s^2,", acceleration}}) {
        const size_t at = rms.find(name);
        ASSERT_NE(at, rms.npos) << rms;
        EXPECT_NEAR(std::stod(rms.substr(at + std::string(name).size())), std::sqrt(square), 2e-4 * std::sqrt(square))
            << name;
    }
}

// Oracle: the integral of |H|² up to the resonance by 200 000 rectangles. --to cuts a density there, which a note says.
TEST_F(SteadyVibration, ARangeCutsADensity) {
    const double f0 = std::sqrt(kSpring / kOwnMass) / (2 * kHalfTurn);
    const std::string text = kMassOnSpring + fmt::format("psd = {{ frequencies = [0, {}], values = [3, 3] }}\n", 40 * f0);
    const auto rms_of = [&](const std::vector<std::string>& words) {
        const Ended ended = ask(text, words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        err_ = ended.err;
        const std::string rms = read_text(folder_ / fmt::format("out{}/rms.csv", count_));
        return std::stod(rms.substr(rms.find("m.position.x,m,") + 15));
    };
    const double whole = rms_of({"--out", "m.position.x", "-q"});
    EXPECT_EQ(err_, "");
    const double half = rms_of({"--out", "m.position.x", "-q", "--from", "0Hz", "--to", fmt::format("{} Hz", f0)});
    EXPECT_THAT(err_, HasSubstr("random loads count from 0 to"));
    double square = 0;
    constexpr int kCount = 200000;
    for (int i = 0; i < kCount; ++i) square += 3 * std::norm(receptance((i + 0.5) * f0 / kCount)) * f0 / kCount;
    EXPECT_NEAR(half, std::sqrt(square), 2e-4 * half);
    EXPECT_GT(whole, 1.2 * half);
}

// Oracle: closed form. Beside a load that acts everywhere one acts at its own frequency alone: that row has both, no other
// has it, and its jump draws no points.
TEST_F(SteadyVibration, ALoadOfItsOwnFrequencyIsOneRow) {
    const std::string text = kMassOnSpring +
                             "harmonic = { amplitude = 1 }\n[[load]]\non = \"m\"\ndirection = [1, 0, 0]\n"
                             "harmonic = { amplitude = 4, phase = 1, frequency = 7.3 }\n";
    const Table table = response(text, {"--from", "2Hz", "--to", "30Hz", "--out", "m.position.x", "-q"});
    EXPECT_EQ(err_, "");
    EXPECT_LT(table.rows.size(), 150u);
    size_t found = 0;
    for (size_t i = 0; i < table.rows.size(); ++i) {
        const double f = table.value(i, "frequency");
        const Complex x = (1.0 + (f == 7.3 ? std::polar(4.0, 1.0) : 0)) * receptance(f);
        found += f == 7.3;
        EXPECT_LT(std::abs(table.amplitude(i, "m.position.x") - x), 1e-9 * std::abs(x)) << f;
        if (i > 0) {
            EXPECT_GT(f, table.value(i - 1, "frequency"));
        }
    }
    EXPECT_EQ(found, 1u);
}

// Oracle: the same rows in whichever sequence orders are asked for; peaks of the high order are not missed.
TEST_F(SteadyVibration, OrdersInAnySequence) {
    const std::string text = kMassOnSpring +
                             "harmonic = { amplitude = 1, order = 0.5 }\n[[load]]\non = \"m\"\ndirection = [1, 0, 0]\n"
                             "harmonic = { amplitude = 1, order = 3 }\n";
    const std::vector<std::string> words = {"--rpm", "100..400", "--out", "m.position.x", "-q"};
    auto down = words, twice = words;
    for (const char* order : {"3", "0.5"}) down.insert(down.end(), {"--order", order});
    for (const char* order : {"3", "0.5", "3"}) twice.insert(twice.end(), {"--order", order});
    const Table all = response(text, words);
    EXPECT_EQ(all.rows, response(text, down).rows);
    EXPECT_EQ(all.rows, response(text, twice).rows);
}

// Oracle: closed form. A foot shaken by white acceleration S below a mass: relative displacement z² = S m²/(4 c k), here
// m/(k ...) of the whole axis, x'' + 2 ζ ω0 z' + ω0² z = 0; and one of a harmonic acceleration a, z = −a m H.
TEST_F(SteadyVibration, AFootIsShakenByAcceleration) {
    const auto text = [](const std::string& motion) {
        std::string shaken = kMassOnSpring.substr(0, kMassOnSpring.find("[[load]]"));
        shaken.replace(
            shaken.find("m = [0.3, 0, 0]"), 15,
            "m = [0.3, 0, 0]\nfoot = { position = [0.3, 0, 0], fixed = [\"x\"], motion = { x = " + motion + " } }");
        return shaken.replace(shaken.find("\"ground\""), 8, "\"foot\"");
    };
    const Table table =
        response(text("{ type = \"harmonic\", amplitude = \"3 m/s^2\", of = \"acceleration\" }"),
                 {"--from", "2Hz", "--to", "30Hz", "--points", "7", "--out", "spring", "--out", "foot", "-q"});
    ASSERT_EQ(table.rows.size(), 7u);
    for (size_t i = 0; i < 7; ++i) {
        const Complex z = -3.0 * kOwnMass * receptance(table.value(i, "frequency"));
        EXPECT_LT(std::abs(table.amplitude(i, "spring.deflection.x") - z), 1e-9 * std::abs(z));
        EXPECT_LT(std::abs(table.amplitude(i, "foot.acceleration.x") - 3.0), 1e-9);
    }
    const double f0 = std::sqrt(kSpring / kOwnMass) / (2 * kHalfTurn);
    const Ended ended =
        ask(text(fmt::format("{{ type = \"psd\", of = \"acceleration\", frequencies = [0.01, {}], values = [2, "
                             "\"2 (m/s^2)^2/Hz\"] }}",
                             40 * f0)),
            {"--out", "spring.deflection.x", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const std::string rms = read_text(folder_ / "out2/rms.csv");
    const size_t at = rms.find("spring.deflection.x,m,");
    ASSERT_NE(at, rms.npos) << rms;
    const double expected = kOwnMass * std::sqrt(2 / (4 * kSpring * kDamper));
    EXPECT_NEAR(std::stod(rms.substr(at + 22)), expected, 5e-4 * expected);
}

// Oracle: closed form with k (1 + iη), and of a free tip of a rod with E (1 + iη): x = F tan(κL)/(EA κ), κ = ω √(ρ/E).
TEST_F(SteadyVibration, ALossFactorTurnsStiffnessComplex) {
    constexpr double kLoss = 0.13;
    std::string text = kMassOnSpring + "harmonic = { amplitude = \"1 N\" }\n";
    text.replace(text.find("damping = 11"), 12, "damping = 11\nloss_factor = 0.13");
    const std::vector<std::string> words = {"--from", "2Hz", "--to",  "30Hz",   "--points", "5",
                                            "--out",  "m",   "--out", "spring", "-q"};
    const Table table = response(text, words);
    ASSERT_EQ(table.rows.size(), 5u);
    for (size_t i = 0; i < 5; ++i) {
        const double w = 2 * kHalfTurn * table.value(i, "frequency");
        const Complex k(kSpring, kSpring * kLoss + w * kDamper), x = 1.0 / (k - kOwnMass * w * w);
        EXPECT_LT(std::abs(table.amplitude(i, "m.position.x") - x), 1e-10 * std::abs(x));
        EXPECT_LT(std::abs(table.amplitude(i, "spring.force.x") - k * x), 1e-10 * std::abs(k * x));
    }
    const std::string rod = R"(format = "dttmm/1"
dofs = ["x"]
[nodes]
wall = { position = [0, 0, 0], fixed = ["x"] }
tip = [1.7, 0, 0]
[[element]]
name = "rod"
type = "rod"
from = "wall"
to = "tip"
section = { EA = 3e6, mass = 0.8 }
material = { loss_factor = 0.04 }
[[load]]
on = "tip"
direction = [1, 0, 0]
harmonic = { amplitude = "1 N" }
)";
    const Table waves = response(rod, {"--from", "20Hz", "--to", "900Hz", "--points", "7", "--out", "tip", "-q"});
    ASSERT_EQ(waves.rows.size(), 7u);
    for (size_t i = 0; i < 7; ++i) {
        const Complex EA = 3e6 * Complex(1, 0.04), kappa = 2 * kHalfTurn * waves.value(i, "frequency") * std::sqrt(0.8 / EA);
        const Complex x = std::tan(1.7 * kappa) / (EA * kappa);
        EXPECT_LT(std::abs(waves.amplitude(i, "tip.position.x") - x), 1e-9 * std::abs(x));
    }

    write_text(folder_ / "run.toml", text + "[simulation]\nduration = \"1 s\"\nstep = \"1 ms\"\n");
    const Ended run = run_dttmm(folder_.path(), {"run", "run.toml", "-o", "run"});
    EXPECT_EQ(run.code, 3);
}

// Oracle: the same machine driven in time until it is steady; the step shifts it by (ωh)²/6 or less. Order loads, an
// unbalance and a force in body axes act together; forces, deflections and accelerations agree with their phases.
TEST_F(SteadyVibration, ARunBecomesTheResponse) {
    const char* kLoads = R"([[load]]
on = "block.top"
direction = [0.3, -0.2, 1]
harmonic = { amplitude = "=0.001*Omega^2", phase = "35 deg", order = 1 }
[[load]]
on = "block.three"
axes = "body"
direction = [0, 0.6, 0.8]
harmonic = { amplitude = "0.8 N", phase = "-70 deg", order = 1 }
[[load]]
on = "block.top"
direction = [1, 0.5, 0]
harmonic = { amplitude = "0.05 N*m", order = 1 }
[[load]]
on = "block.two"
direction = [0.1, 1, 0.3]
unbalance = "0.4 g*m"
zero = [1, 0, 0]
)";
    constexpr double kStep = 5e-4;
    const std::string text = turned_block(kLoads, 3, kStep);
    const std::vector<std::string> channels = {"mount1.force", "mount4.force", "mount2.deflection", "block.acceleration",
                                               "block.top.acceleration"};
    std::vector<std::string> words = {"-q"};
    for (const std::string& channel : channels) words.insert(words.end(), {"--out", channel});
    const Table steady = response(text, words), run = history(text);
    ASSERT_EQ(steady.rows.size(), 1u);
    const double w = 14 * kHalfTurn;
    for (const std::string& channel : channels)
        for (const char* axis : {".x", ".y", ".z"}) {
            const std::string name = channel + axis;
            const Complex expected = steady.amplitude(0, name), got = amplitude_of(run, name, w, 3 - 6.0 / 7);
            EXPECT_LT(std::abs(got - expected), 2e-3 * std::abs(expected)) << name << " " << got << " " << expected;
        }
}

/// A cart on a rail, an arm on a hinge on it, springs.
const std::string kJoints = R"(
[[body]]
name = "cart"
mass = 2.1
inertia = [0.04, 0.05, 0.06]
position = [0.1, 0.2, -0.1]
rotation = { axis = [1, 0.4, -0.3], angle = "50 deg" }
markers.side = [0.05, 0.1, -0.04]
[[body]]
name = "arm"
mass = 0.9
inertia = [0.01, 0.02, 0.015]
position = [0.3, 0.5, 0.1]
rotation = { axis = [0.2, -1, 0.5], angle = "-70 deg" }
center_of_mass = [0.01, 0.03, -0.02]
markers.end = [0.12, -0.05, 0.08]
[[joint]]
name = "rail"
type = "slider"
between = ["ground", "cart"]
anchor = [0.1, 0.2, -0.1]
axis = [0.6, 0.64, 0.48]
[[joint]]
name = "pin"
type = "hinge"
between = ["cart", "arm"]
anchor = [0.25, 0.3, 0.02]
axis = [0.3, -0.2, 1]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "cart.side"
stiffness = [2000, 3000, 2500]
damping = [30, 40, 20]
[[element]]
name = "hinge_spring"
type = "spring_damper"
from = "cart"
to = "arm"
rotational_stiffness = [30, 30, 30]
rotational_damping = [0.4, 0.4, 0.4]
[nodes]
wall = { position = [0.9, 0.1, 0.6], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[element]]
name = "rod"
type = "axial_spring"
from = "arm.end"
to = "wall"
stiffness = 700
damping = 6
[[load]]
on = "arm.end"
direction = [0.2, 1, -0.7]
harmonic = { amplitude = "0.02 N", phase = "15 deg", frequency = "5 Hz" }
)";

// Oracle: the same machine in time: forces, moments and coordinates of a hinge between two turned bodies and of a slider to
// the ground, with their signs and axes; force and length of an axial spring; angular velocities; a marker off the centre.
// About its equilibrium under gravity its forces turn with the bodies that they are told in.
TEST_F(SteadyVibration, JointsVibrateAsInARun) {
    for (const bool is_at_rest : {false, true}) {
        const std::string text = fmt::format("format = \"dttmm/1\"\n[simulation]\nduration = \"3 s\"\nstep = \"0.5 ms\"\n{}",
                                             is_at_rest ? "gravity = [4.1, -5.3, -6.2]\nstart = \"equilibrium\"\n" : "") +
                                 kJoints;
        const std::vector<std::string> channels = {"rail.force.",         "rail.moment.",          "pin.force.",
                                                   "pin.moment.",         "arm.angular_velocity.", "arm.end.position.",
                                                   "arm.position.",       "arm.velocity.",         "hinge_spring.rotation.",
                                                   "hinge_spring.moment."};
        const std::vector<std::string> scalars = {"rail.travel", "pin.angle", "rod.force", "rod.length"};
        const Table steady = response(text, {"-q", "--out", "*"});
        const Table run = history(text + "[output]\nchannels = [\"*\"]\n");
        ASSERT_EQ(steady.rows.size(), 1u);
        const double w = 10 * kHalfTurn;
        const auto compare = [&](const std::string& name, double size) {
            const Complex expected = steady.amplitude(0, name), got = amplitude_of(run, name, w, 3 - 1.0);
            EXPECT_LT(std::abs(got - expected), 3e-3 * size) << name << " " << got << " " << expected << is_at_rest;
        };
        for (const std::string& name : scalars) {
            EXPECT_GT(std::abs(steady.amplitude(0, name)), 0) << name;
            compare(name, std::abs(steady.amplitude(0, name)));
        }
        for (const std::string& channel : channels) {
            double largest = 0;
            for (const char* axis : {"x", "y", "z"})
                largest = std::max(largest, std::abs(steady.amplitude(0, channel + axis)));
            EXPECT_GT(largest, 0) << channel;
            for (const char* axis : {"x", "y", "z"}) compare(channel + axis, largest);
        }
    }
}

/// A body on a soft mount that leans under its weight. A beam on it carries a mass and is pressed, sheared and twisted at
/// rest, but hardly bent; a rod stands out from it with a mass at its end.
std::string leaning(int segments) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
duration = "8 s"
step = "0.5 ms"
start = "equilibrium"
gravity = [0.5, -1.3, -9.4]
[nodes]
tip = [0.14, 0.33, 0.95]
knob = [-0.45, 0.2, 0.3]
[[body]]
name = "block"
mass = 14
inertia = [0.5, 0.4, 0.6]
position = [0.1, 0.2, 0.3]
rotation = {{ axis = [0.3, 1, -0.4], angle = "35 deg" }}
markers.top = [0.05, 0.04, 0.1]
markers.side = [-0.12, 0.02, 0.03]
[[element]]
name = "foot"
type = "spring_damper"
from = "ground"
to = "block"
axes = {{ axis = [1, 0.5, -1], angle = "50 deg" }}
stiffness = [9e3, 7e3, 8e3]
rotational_stiffness = [350, 400, 450]
damping = [200, 160, 180]
rotational_damping = [30, 35, 32]
[[element]]
name = "mast"
type = "beam"
from = "block.top"
to = "tip"
segments = {}
up = [1, 0.2, 0]
section = {{ EA = 2e4, EIy = 200, EIz = 170, GJ = 140, GAy = 2e4, GAz = 2e4, mass = 0.8, inertia = 2e-3 }}
material = {{ stiffness_damping = "2 ms" }}
[[element]]
name = "head"
type = "rigid_body"
at = "tip"
mass = 1.3
center_of_mass = [0.05, -0.03, 0.02]
inertia = {{ xx = 0.004, yy = 0.003, zz = 0.005 }}
[[element]]
name = "arm"
type = "rod"
from = "block.side"
to = "knob"
segments = 24
section = {{ EA = 4e4, mass = 1.5, inertia = 1e-3 }}
material = {{ stiffness_damping = "2 ms" }}
[[element]]
name = "ball"
type = "rigid_body"
at = "knob"
mass = 0.9
inertia = {{ xx = 0.002, yy = 0.001, zz = 0.003 }}
[[load]]
on = "tip"
direction = [0, -0.1, -1]
force = 25
[[load]]
on = "tip"
direction = [1, 0.4, -0.3]
harmonic = {{ amplitude = "2 mN", phase = "35 deg", frequency = "1.3 Hz" }}
[[load]]
on = "block.side"
direction = [0.2, 1, 0.7]
harmonic = {{ amplitude = "9 mN", phase = "-60 deg", frequency = "1.3 Hz" }}
)",
                       segments);
}

// Oracle: a run that starts in equilibrium and vibrates about it: forces that are there at rest turn with their elements. Of
// a rod that carries a force across itself at rest the elongation is not compared: it lacks the turning of that force.
TEST_F(SteadyVibration, ForcesAboutAnEquilibriumAreThoseOfARun) {
    const std::vector<std::string> channels = {"mast.force",    "mast.moment", "mast.deflection", "mast.rotation",
                                               "arm.force",     "arm.moment",  "foot.force",      "foot.moment",
                                               "foot.rotation", "tip.position"};
    std::string patterns;
    for (const std::string& channel : channels) patterns += fmt::format("\"{}\", ", channel);
    const Table run = history(leaning(24) + fmt::format("[output]\nchannels = [{}]\n", patterns));
    for (const char* beams : {"exact", "lumped"}) {
        std::vector<std::string> words = {"-q", "--beams", beams};
        for (const std::string& channel : channels) words.insert(words.end(), {"--out", channel});
        const Table steady = response(leaning(24), words);
        ASSERT_EQ(steady.rows.size(), 1u);
        EXPECT_THAT(err_, Not(HasSubstr("bent-beam")));
        const double w = 2.6 * kHalfTurn;
        for (const std::string& channel : channels) {
            double largest = 0;
            for (const char* axis : {".x", ".y", ".z"})
                largest = std::max(largest, std::abs(steady.amplitude(0, channel + axis)));
            EXPECT_GT(largest, 0) << channel;
            for (const char* axis : {".x", ".y", ".z"}) {
                const std::string name = channel + axis;
                const Complex expected = steady.amplitude(0, name), got = amplitude_of(run, name, w, 8 - 2 / 1.3);
                EXPECT_LT(std::abs(got - expected), 2e-3 * largest) << beams << " " << name << " " << got << " " << expected;
            }
        }
    }
}

// Oracle: a bar between pins whose far end vibrates across it: its near pin has a sixth of its mass times the acceleration,
// m w² y/6 on the pin.
TEST_F(SteadyVibration, ABarBetweenPinsPullsAcross) {
    const Table table = response(R"(format = "dttmm/1"
dofs = ["x", "y"]
[nodes]
a = { position = [0, 0, 0], fixed = ["x", "y"] }
b = [0.8, 0, 0]
[[element]]
name = "bar"
type = "rod"
from = "a"
to = "b"
section = { EA = 3e6, mass = 1.7 }
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 4e3
[[load]]
on = "b"
direction = [0, 1, 0]
harmonic = { amplitude = "1 N" }
)",
                                 {"--from", "2Hz", "--to", "5Hz", "--points", "2", "--out", "bar", "--out", "b", "-q"});
    ASSERT_EQ(table.rows.size(), 2u);
    for (size_t i : {0u, 1u}) {
        const double w = 2 * kHalfTurn * table.value(i, "frequency"), m = 1.7 * 0.8;
        const Complex y = 1.0 / (4e3 - w * w * m / 3);
        EXPECT_LT(std::abs(table.amplitude(i, "b.position.y") - y), 1e-9 * std::abs(y));
        EXPECT_LT(std::abs(table.amplitude(i, "bar.force.y") - w * w * m / 6 * y), 1e-9 * std::abs(w * w * m * y));
    }
}

// Oracle: closed form in both directions across the axis: u Ω² turns about it by the right hand, so that its part along
// y = z × x lags by 90 degrees.
TEST_F(SteadyVibration, AnUnbalanceTurnsByTheRightHand) {
    std::string text = kMassOnSpring.substr(0, kMassOnSpring.find("[[load]]"));
    text.replace(text.find("dofs = [\"x\"]"), 12, "dofs = [\"x\", \"y\"]");
    text.replace(text.find("stiffness = 9100"), 16, "stiffness = [9100, 9100, 9100]");
    text.replace(text.find("damping = 11"), 12, "damping = [11, 11, 11]");
    const Table table = response(text + "[[load]]\non = \"m\"\ndirection = [0, 0, 2]\nunbalance = \"30 g*m\"\n",
                                 {"--rpm", "300", "--out", "m.position", "-q"});
    ASSERT_EQ(table.rows.size(), 1u);
    const double speed = 10 * kHalfTurn;
    const Complex x = 0.03 * speed * speed * receptance(5);
    EXPECT_LT(std::abs(table.amplitude(0, "m.position.x") - x), 1e-9 * std::abs(x));
    EXPECT_LT(std::abs(table.amplitude(0, "m.position.y") - Complex(0, -1) * x), 1e-9 * std::abs(x));
}

// Oracle: statics. Far below all frequencies a machine whose supports all move alike goes with them as a rigid body, in
// displacement and in rotation, and nothing carries a force. A support alone strains it.
TEST_F(SteadyVibration, SupportsCarryTheMachineAlong) {
    const std::string text = on_feet("", "", "");
    const Table table = response(
        text, {"--in", "foot1.y", "--in", "foot2.y", "--in", "tip.y", "--from", "0.001Hz", "--to", "0.002Hz", "--points",
               "2",    "--out",   "mass", "--out",   "one",  "--out", "mast",   "--out",   "tip",  "-q"});
    ASSERT_EQ(table.rows.size(), 2u);
    for (const auto& [channel, along] : {std::pair("mass.position.y", 1.0),
                                         {"mass.position.x", 0.0},
                                         {"tip.position.y", 1.0},
                                         {"mass.rotation.x", 0.0},
                                         {"one.force.y", 0.0},
                                         {"mast.moment.x", 0.0}}) {
        Complex sum = 0;
        double size = 0;
        for (const char* input : {"foot1.y", "foot2.y", "tip.y"}) {
            const Complex own = {table.value(0, fmt::format("{}/{}.re", channel, input)),
                                 table.value(0, fmt::format("{}/{}.im", channel, input))};
            sum += own;
            size = std::max(size, std::abs(own));
        }
        EXPECT_LT(std::abs(sum - along), 1e-6 * std::max(1.0, size)) << channel << sum;
    }
    EXPECT_EQ(table.names[1], "one.force.x/foot1.y.re");
}

// Oracle: the same machine in time: supports that vibrate, with their phases, one in rotation too, a guide in the direction
// that a node is fixed in.
TEST_F(SteadyVibration, ARunOnMovingSupportsBecomesTheResponse) {
    const std::string motion = "{{ type = \"harmonic\", amplitude = {}, phase = \"{} deg\", frequency = \"6 Hz\" }}";
    const auto vibrates = [&](double amplitude, double phase) {
        return fmt::format(fmt::runtime(motion), amplitude, phase);
    };
    const std::string text = on_feet(fmt::format(", motion = {{ x = {}, ry = {} }}", vibrates(2e-5, 20), vibrates(1e-4, 50)),
                                     fmt::format(", motion = {{ z = {} }}", vibrates(3e-5, -70)),
                                     fmt::format(", motion = {{ y = {} }}", vibrates(-2e-5, 10)));
    const std::vector<std::string> channels = {"one.force",   "two.force",         "mast.force",
                                               "mast.moment", "mass.acceleration", "tip.acceleration"};
    std::vector<std::string> words = {"-q", "--beams", "lumped"};
    for (const std::string& channel : channels) words.insert(words.end(), {"--out", channel});
    const Table steady = response(text, words), run = history(text);
    ASSERT_EQ(steady.rows.size(), 1u);
    const double w = 12 * kHalfTurn;
    for (const std::string& channel : channels) {
        double largest = 0;
        for (const char* axis : {".x", ".y", ".z"})
            largest = std::max(largest, std::abs(steady.amplitude(0, channel + axis)));
        EXPECT_GT(largest, 0) << channel;
        for (const char* axis : {".x", ".y", ".z"}) {
            const std::string name = channel + axis;
            const Complex expected = steady.amplitude(0, name), got = amplitude_of(run, name, w, 4 - 1.0);
            EXPECT_LT(std::abs(got - expected), 2e-3 * largest) << name << " " << got << " " << expected;
        }
    }
}

// Oracle: the same machine, assembled as its support has turned it, and the rotation of that by hand: a small change δθ of a
// rotation vector of the angle φ about y turns by δφ_x = (sin φ δθ_x + (1 − cos φ) δθ_z)/φ, δφ_z = (sin φ δθ_z −
// (1 − cos φ) δθ_x)/φ. The vectors of a run are those of the model.
TEST_F(SteadyVibration, ASupportThatStandsTurnedTurnsByItsRotationVector) {
    constexpr double kAngle = 0.6, kX = 1e-4, kZ = 5e-5;
    const double s = std::sin(kAngle) / kAngle, c = (1 - std::cos(kAngle)) / kAngle;
    const auto machine = [&](const std::string& turn, const std::string& place, double x, double z, const std::string& y) {
        const std::string harmonic = "{{ type = \"harmonic\", amplitude = {:.17g}, phase = 0.4 }}";
        return fmt::format(R"(format = "dttmm/1"
[nodes]
foot = {{ position = [0, 0, 0], {}fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {{ rx = {}, ry = {}, rz = {} }} }}
[[body]]
name = "head"
mass = 2
inertia = [0.1, 0.2, 0.15]
position = {}
{}markers = {{ m = [-0.5, 0.1, 0] }}
[[element]]
name = "neck"
type = "spring_damper"
from = "foot"
to = "head.m"
stiffness = [1e4, 2e4, 1.5e4]
damping = [100, 50, 70]
rotational_stiffness = [300, 400, 500]
rotational_damping = 6
)",
                           turn, fmt::format(fmt::runtime(harmonic), x), y, fmt::format(fmt::runtime(harmonic), z), place,
                           turn.empty() ? "" : "rotation = { axis = [0, 1, 0], angle = 0.6 }\n");
    };
    const std::vector<std::string> words = {"--from", "2 Hz", "--to", "9 Hz", "--points", "3", "-q"};
    const Table moved = response(machine("", "[0.5, -0.1, 0]", kX, kZ, "0.6"), words);
    const std::string place = fmt::format("[{:.17g}, -0.1, {:.17g}]", 0.5 * std::cos(kAngle), -0.5 * std::sin(kAngle));
    const Table placed = response(
        machine("rotation = { axis = [0, 1, 0], angle = 0.6 }, ", place, s * kX + c * kZ, s * kZ - c * kX, "0"), words);
    ASSERT_EQ(moved.rows.size(), 3u);
    ASSERT_EQ(moved.names, placed.names);
    for (size_t i = 0; i < 3; ++i)
        for (const char* channel : {"head.position", "neck.force", "neck.moment", "head.angular_velocity"}) {
            double largest = 0;
            for (const char* axis : {".x", ".y", ".z"})
                largest = std::max(largest, std::abs(placed.amplitude(i, std::string(channel) + axis)));
            EXPECT_GT(largest, 0);
            for (const char* axis : {".x", ".y", ".z"}) {
                const std::string name = std::string(channel) + axis;
                EXPECT_LT(std::abs(moved.amplitude(i, name) - placed.amplitude(i, name)), 1e-9 * largest) << name;
            }
        }
}

/// A body on a bent beam, on a rope and on two springs, one from its support and one to it, all of them strained at rest,
/// whose supports move together as one rigid body would: by u and by θ about the origin, slowly.
std::string strained_machine(const std::string& gravity, const Eigen::Vector3d& u, const Eigen::Vector3d& theta) {
    const auto motion = [&](const Eigen::Vector3d& place) {
        const Eigen::Vector3d shift = u + theta.cross(place);
        std::string list;
        for (Eigen::Index i = 0; i < 3; ++i)
            for (const auto& [axis, size] : {std::pair("", shift(i)), {"r", theta(i)}})
                list += fmt::format("{}{}{} = {{ type = \"harmonic\", amplitude = {:.17g} }}", list.empty() ? "" : ", ",
                                    axis, "xyz"[i], size);
        return "motion = { " + list + " }";
    };
    const auto node = [&](const char* name, const Eigen::Vector3d& at, const char* turn) {
        return fmt::format(
            "{} = {{ position = [{}, {}, {}], {} fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"], {} }}\n", name,
            at.x(), at.y(), at.z(), turn, motion(at));
    };
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = {}
[nodes]
{}{}{}
[[body]]
name = "b"
mass = 2
inertia = [0.02, 0.03, 0.025]
position = [0.5, 0.1, -0.2]
markers = {{ m = [0.1, 0, 0.05] }}
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "b"
segments = 5
section = {{ EA = 1e5, EIy = 30, EIz = 60, GJ = 20, GAy = 1e5, GAz = 1e5, mass = 0.1, inertia = 1e-4 }}
[[element]]
name = "rope"
type = "axial_spring"
from = "top"
to = "b.m"
stiffness = 3e4
preload = 80
[[element]]
name = "spring"
type = "spring_damper"
from = "side"
to = "b.m"
stiffness = [700, 400, 900]
rotational_stiffness = [3, 5, 4]
[[element]]
name = "back"
type = "spring_damper"
from = "b.m"
to = "side"
stiffness = [300, 800, 500]
rotational_stiffness = [2, 6, 5]
)",
                       gravity, node("root", {0.1, -0.2, 0}, ""), node("top", {0.4, 0.3, 0.7}, ""),
                       node("side", {0.6, 0.1, -0.15}, "rotation = { axis = [1, 2, -1], angle = 0.7 },"));
}

// Oracle: the machine moves as its supports do, and nothing is strained by it: the forces that it has at rest go along with
// the supports. By gravity that holds for shifts only.
TEST_F(SteadyVibration, AStrainedMachineGoesAlongWithItsSupports) {
    for (const auto& [gravity, u, theta] :
         {std::tuple("[0, 0, 0]", Eigen::Vector3d(1e-4, -2e-4, 3e-4), Eigen::Vector3d(4e-4, 1e-4, -2e-4)),
          std::tuple("[3, -2, -9]", Eigen::Vector3d(-3e-4, 1e-4, 2e-4), Eigen::Vector3d(0, 0, 0))})
        for (const char* beams : {"exact", "lumped"}) {
            const std::string text = strained_machine(gravity, u, theta);
            const Table table = response(text, {"--from", "1e-4 Hz", "--to", "1.1e-4 Hz", "--points", "2", "--about",
                                                "equilibrium", "--beams", beams, "-q"});
            ASSERT_EQ(table.rows.size(), 2u);
            write_text(folder_ / "model.toml", text);
            ASSERT_EQ(run_dttmm(folder_.path(), {"static", "model.toml", "-q", "-o", "rest"}).code, 0);
            const ResultsTable rest = read_table(folder_ / "rest/static.csv");
            const Eigen::Vector3d place(rest.value(0, "b.position.x"), rest.value(0, "b.position.y"),
                                        rest.value(0, "b.position.z"));
            const Eigen::Vector3d shift = u + theta.cross(place);
            const double bound = std::string(beams) == "exact" ? 1e-6 : 1e-8;  // an exact beam counts as straight
            for (Eigen::Index i = 0; i < 3; ++i) {
                const std::string axis = fmt::format(".{}", "xyz"[i]);
                EXPECT_LT(std::abs(table.amplitude(0, "b.position" + axis) - shift(i)), bound * shift.norm()) << beams;
                for (const char* channel : {"beam.force", "beam.moment", "rope.force", "spring.force", "spring.moment",
                                            "back.force", "back.moment"}) {
                    const std::string name = channel + axis;
                    if (std::ranges::find(table.names, name + ".re") == table.names.end()) continue;
                    EXPECT_LT(std::abs(table.amplitude(0, name)), 100 * bound) << name << ", " << beams;
                }
            }
        }
}

// Oracle: the same machine elsewhere, and the support's own place. A support that is not fixed in all directions turns about
// its node, not about the origin of the world.
TEST_F(SteadyVibration, ASupportTurnsAboutItsNode) {
    const auto at = [&](double place) {
        return response(fmt::format(R"(format = "dttmm/1"
[nodes]
foot = {{ position = [{0}, {0}, 0], fixed = ["x", "y", "z", "ry"], motion = {{ ry = {{ type = "harmonic", amplitude = 1e-4, frequency = 2, phase = "-90 deg" }} }} }}
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.014]
position = [{1}, {0}, 0]
[[element]]
name = "bar"
type = "beam"
from = "foot"
to = "b"
segments = 4
section = {{ circle = "12 mm" }}
material = {{ E = "70 GPa", poisson = 0.3, density = "2700 kg/m^3" }}
[[element]]
name = "k"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 2000
rotational_stiffness = 30
)",
                                    place, place + 0.5),
                        {"--about", "equilibrium", "--in", "foot.ry", "--out", "bar.force", "--out", "b.position", "--out",
                         "foot.position", "--from", "0.001 Hz", "--to", "0.002 Hz", "--points", "2", "-q"});
    };
    const Table here = at(0), there = at(1.25);
    EXPECT_GT(std::abs(here.value(0, "bar.force.z.re")), 100);
    for (const std::string channel : {"bar.force.x", "bar.force.z", "b.position.z", "foot.position.x", "foot.position.z"})
        EXPECT_NEAR(there.value(0, channel + ".re"), here.value(0, channel + ".re"), 1e-6) << channel;
    EXPECT_EQ(there.value(0, "foot.position.z.re"), 0);
}

/// A beam between a clamped node and a free one under a force along it, and further loads.
std::string loaded_beam(bool from_tip, double along, const std::string& loads) {
    return fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = [0.3, 0.4, 0]
[[element]]
name = "beam"
type = "beam"
from = "{}"
to = "{}"
segments = 6
section = {{ EA = 1e5, EIy = 1.7, EIz = 2.9, GJ = 1.1, mass = 1e-3, inertia = 1e-8, GAy = 300, GAz = 400 }}
[[load]]
on = "b"
direction = [0.6, 0.8, 0]
force = {}
{})",
                       from_tip ? "b" : "a", from_tip ? "a" : "b", along, loads);
}

std::string across_it(const std::string& force) {
    return fmt::format("[[load]]\non = \"b\"\ndirection = [0.08, -0.06, 1]\nforce = {}\n", force);
}

// Oracle: differences of `dttmm static`: under slow loads a machine goes through its equilibria. At the free end there is
// no moment, so that it does not change.
TEST_F(SteadyVibration, ABeamsMomentFollowsSlowLoads) {
    for (const bool from_tip : {false, true})
        for (const auto& [along, across] : {std::pair(30.0, 0.2), std::pair(-2.0, 6.0)}) {
            const double change = 1e-3 * across;
            std::vector<ResultsTable> rest;
            for (const double force : {across - change, across + change}) {
                write_text(folder_ / "m.toml", loaded_beam(from_tip, along, across_it(fmt::format("{:.17g}", force))));
                ASSERT_EQ(run_dttmm(folder_.path(), {"static", "m.toml", "-q", "-o", "rest"}).code, 0);
                rest.push_back(read_table(folder_ / "rest/static.csv"));
            }
            const std::string vibrates = across_it(fmt::format("{:.17g}", across)) +
                                         across_it("{ type = \"harmonic\", amplitude = 1, frequency = \"0.001 Hz\" }");
            const Table table =
                response(loaded_beam(from_tip, along, vibrates),
                         {"--from", "0.001 Hz", "--to", "0.0011 Hz", "--points", "2", "-q", "--beams", "lumped"});
            double largest = 0;
            for (const char axis : {'x', 'y', 'z'}) {
                const std::string channel = fmt::format("beam.moment.{}", axis);
                const double slope = (rest[1].value(0, channel) - rest[0].value(0, channel)) / (2 * change);
                largest = std::max(largest, std::abs(slope));
                EXPECT_NEAR(table.value(0, channel + ".re"), slope, 1e-6) << from_tip << along << axis;
            }
            if (from_tip) {
                EXPECT_LT(largest, 1e-9) << along;
            } else {
                EXPECT_GT(largest, 0.2) << along;
            }
        }
}

// Oracle: differences of `dttmm static`. A load along a line acts on its axis, beside the mass of its segments.
TEST_F(SteadyVibration, LoadsAlongABeamTurnWithItsSegments) {
    const auto model = [](const std::string& tip) {
        return fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = [0.3, 0.4, 0]
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
segments = 3
section = {{ EA = 3e4, EIy = 2.5, EIz = 5.6, GJ = 3, mass = 0.01, inertia = 4e-5, GAy = 2e4, GAz = 1e4, mass_offset = [0.01, 0.02] }}
[[load]]
element = "beam"
direction = [0.1, 0.2, -1]
force_per_length = [2, 3.5]
axes = "world"
[[load]]
on = "b"
direction = [-0.8, 0.6, 0.1]
force = {}
)",
                           tip);
    };
    constexpr double kChange = 1e-4;
    std::vector<ResultsTable> rest;
    for (const double force : {-kChange, kChange}) {
        write_text(folder_ / "m.toml", model(fmt::format("{:.17g}", force)));
        ASSERT_EQ(run_dttmm(folder_.path(), {"static", "m.toml", "-q", "-o", "rest"}).code, 0);
        rest.push_back(read_table(folder_ / "rest/static.csv"));
    }
    const Table table = response(model("{ type = \"harmonic\", amplitude = 1, frequency = \"0.001 Hz\" }"),
                                 {"--beams", "lumped", "--from", "0.001 Hz", "--to", "0.0011 Hz", "--points", "2", "-q"});
    for (const char axis : {'x', 'y', 'z'}) {
        const std::string channel = fmt::format("b.position.{}", axis);
        const double slope = (rest[1].value(0, channel) - rest[0].value(0, channel)) / (2 * kChange);
        EXPECT_NEAR(table.value(0, channel + ".re"), slope, 1e-8 * 0.007) << axis;
    }
}

// Oracle: the place of the load in the file, and the case that names it.
TEST_F(SteadyVibration, VibrationsOutsideTheCaseAreNamed) {
    const std::string key = "harmonic";
    const std::string cases = "[[case]]\nname = \"uls\"\nloads = []\n[[case]]\nname = \"hum\"\nloads = [\"fan\"]\n",
                      fan = kMassOnSpring + "name = \"fan\"\nharmonic = { amplitude = \"1 N\", order = 2 }\n" + cases;
    const auto line = 1 + std::count(fan.begin(), std::search(fan.begin(), fan.end(), key.begin(), key.end()), '\n');
    const std::string left_out = fmt::format(
        "; load \"fan\" (model.toml:{}:1) vibrates in case \"hum\"; choose a case with it, or leave --case out\n", line);
    EXPECT_EQ(fault(fan, {"--case", "uls"}),
              "dttmm: model.toml: nothing vibrates: case \"uls\" has no harmonic, psd or unbalance load" + left_out);
    EXPECT_THAT(fault(fan + "[[load]]\nname = \"psd\"\non = \"m\"\ndirection = [1, 0, 0]\npsd = { frequencies = [1, 2], "
                            "values = [1, 1] }\n[[case]]\nname = \"noise\"\nloads = [\"psd\"]\n",
                      {"--case", "noise", "--rpm", "100..200"}),
                testing::AllOf(HasSubstr("no load of case \"noise\" is an order of the speed"), HasSubstr(left_out)));
    EXPECT_EQ(ask(fan, {"--case", "hum", "--out", "m", "-q"}).code, 0);
}

// Oracle: the loads' absence and their cure.
TEST_F(SteadyVibration, WrongQuestionsAreRefused) {
    const std::string harmonic = kMassOnSpring + "harmonic = { amplitude = \"1 N\" }\n",
                      order = kMassOnSpring + "harmonic = { amplitude = \"1 N\", order = 2 }\n";
    EXPECT_THAT(fault(harmonic, {"--out", "sprig.force", "--from", "1Hz", "--to", "2Hz"}), HasSubstr("spring.force"));
    EXPECT_THAT(fault(harmonic, {"--rpm", "100..200"}), HasSubstr("no load is an order of the speed"));
    EXPECT_THAT(fault(order, {"--rpm", "800..600"}, 2), HasSubstr("must be more than the first"));
    EXPECT_THAT(fault(order, {"--rpm", "8oo..900"}, 2), HasSubstr("--rpm"));
    EXPECT_THAT(fault(order, {"--rpm", "800..900", "--order", "3"}, 2), HasSubstr("no load has this order; they have 2"));
    EXPECT_THAT(fault(order, {"--order", "2"}, 2), HasSubstr("of which speed"));
    for (const char* speed : {"300 1/min", "5 Hz", "4 mm"}) {
        std::string wrong = order;
        wrong.replace(wrong.find("300 rpm"), 7, speed);
        EXPECT_THAT(fault(wrong, {"--from", "1 Hz", "--to", "2 Hz"}), HasSubstr("the speed: expected a value in rad/s"));
    }
    EXPECT_THAT(fault(harmonic, {"--out", "m"}, 2), HasSubstr("which frequencies?"));
    EXPECT_THAT(fault(harmonic, {"--from", "3Hz"}, 2), HasSubstr("--from and --to go together"));
    EXPECT_THAT(fault(kMassOnSpring + "force = 3\n", {"--from", "1Hz", "--to", "2Hz"}),
                AllOf(HasSubstr("nothing vibrates"), HasSubstr("The load at "), HasSubstr("acts in runs and at rest")));
    EXPECT_THAT(fault(kMassOnSpring + "psd = { frequencies = [3, 2], values = [1, 1] }\n", {}), HasSubstr("must increase"));
    EXPECT_THAT(fault(kMassOnSpring + "psd = { frequencies = [1, 2], values = [1, -1] }\n", {}), HasSubstr("≥ 0"));
    EXPECT_THAT(fault(kMassOnSpring + "psd = { frequencies = [1], values = [1] }\n", {}), HasSubstr("two points or more"));
    EXPECT_THAT(fault(kMassOnSpring + "harmonic = { amplitude = 1, order = 2, frequency = 3 }\n", {}), HasSubstr("exclude"));
    EXPECT_THAT(fault(kMassOnSpring + "harmonic = { amplitude = \"=Omga\" }\n", {}), HasSubstr("Omega"));
    std::string no_speed = order;
    no_speed.replace(no_speed.find("Omega = \"300 rpm\""), 17, "");
    EXPECT_THAT(fault(no_speed, {"--out", "m"}), HasSubstr("--rpm"));
    std::string undamped = harmonic;
    undamped.replace(undamped.find("damping = 11"), 12, "");
    const Table table = response(undamped, {"--from", "1Hz", "--to", "20Hz", "--out", "m.position.x", "-q"});
    EXPECT_THAT(err_, HasSubstr("nothing damps"));
}

}  // namespace
}  // namespace dttmm::host
