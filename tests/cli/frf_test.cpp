// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm frf` against closed forms and against the same machine in time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "cli/modes_run.h"
#include "support/random_machine.h"

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;
using Rows = std::vector<std::vector<double>>;
constexpr double kPi = std::numbers::pi;

/// Columns of frf.csv.
enum : size_t { kFrequency, kRe, kIm, kSize, kPhase, kMobilityRe, kMobilityIm, kAcceleranceRe, kAcceleranceIm };

Rows response_of(const std::string& text, std::vector<std::string> words) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    words.insert(words.begin(), {"frf", "model.toml", "-o", "out", "-q"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, "");
    if (ended.err.find("too far apart for the peak") == std::string::npos) {
        EXPECT_EQ(ended.err, "");
    }
    if (ended.code != 0) return {};
    return read_history(folder / "out/frf.csv");
}

/// Two masses along x: ground, k1 c1, m1, k2 c2, m2; the second is a body whose place lies off its centre.
const char* kTwoMasses = R"(format = "dttmm/1"
dofs = ["x"]
[nodes]
one = [1, 0, 0]
[[body]]
name = "two"
mass = 3
inertia = [1, 1, 1]
markers.end = [0.2, 0, 0]
[[element]]
name = "first"
type = "spring_damper"
from = "ground"
to = "one"
stiffness = 800
damping = 3
[[element]]
name = "second"
type = "spring_damper"
from = "one"
to = "two"
stiffness = 500
damping = 0.7
[[element]]
name = "mass"
type = "point_mass"
at = "one"
mass = 2
)";

// Oracle: of a lightly damped resonance f0 with 2 ζ f0 between its half-power points, points a quarter of that apart miss
// less than 1 % of the peak, points as far apart as that 6 % or more.
TEST(Frf, APeakBetweenPointsIsTold) {
    const TemporaryFolder folder;
    const double f0 = 20, zeta = 0.005, k = 2 * std::pow(2 * kPi * f0, 2);
    write_text(folder / "model.toml", fmt::format(R"(format = "dttmm/1"
dofs = ["x"]
body = [{{ name = "m", mass = 2, sphere = 0.1 }}]
element = [{{ name = "k", type = "spring_damper", from = "ground", to = "m", stiffness = {}, damping = {} }}]
)",
                                                  k, 2 * zeta * std::sqrt(2 * k)));
    for (const char* points : {"41", "161"}) {
        const Ended ended =
            run_dttmm(folder.path(), {"frf", "model.toml", "--in", "m.x", "--out", "m.x", "--from", "16.03 Hz", "--to",
                                      "24.03 Hz", "--points", points, "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        const bool is_told = ended.err.find("too far apart for the peak near 20.03 Hz") != std::string::npos;
        EXPECT_EQ(is_told, points == std::string_view("41")) << ended.err;
    }
}

// Oracle: (K + iωC − ω²M) u = f of two by two, by Cramer's rule. Both sides are exact but for rounding; the CSV has all
// digits.
TEST(Frf, TwoMassesOnDampersFollowTheirClosedForm) {
    const Rows rows = response_of(
        kTwoMasses, {"--in", "one.x", "--out", "two.end.x", "--from", "0.2 Hz", "--to", "20 Hz", "--points", "37", "--log"});
    ASSERT_EQ(rows.size(), 37u);
    EXPECT_NEAR(rows.front()[kFrequency], 0.2, 1e-15);
    EXPECT_NEAR(rows.back()[kFrequency], 20, 1e-13);
    EXPECT_NEAR(rows[1][kFrequency] / rows[0][kFrequency], std::pow(100, 1. / 36), 1e-12) << "by equal factors";
    for (const auto& row : rows) {
        const double w = 2 * kPi * row[kFrequency];
        const Complex k1(800, 3 * w), k2(500, 0.7 * w), A = k1 + k2 - 2 * w * w, B = k2 - 3 * w * w;
        const Complex H = k2 / (A * B - k2 * k2), V = Complex(0, w) * H, a = -w * w * H;
        const double size = std::abs(H);
        EXPECT_NEAR(row[kRe], H.real(), 1e-12 * size);
        EXPECT_NEAR(row[kIm], H.imag(), 1e-12 * size);
        EXPECT_NEAR(row[kSize], size, 1e-12 * size);
        EXPECT_NEAR(row[kPhase], std::arg(H) * 180 / kPi, 1e-9);
        EXPECT_NEAR(row[kMobilityRe], V.real(), 1e-12 * size * w);
        EXPECT_NEAR(row[kMobilityIm], V.imag(), 1e-12 * size * w);
        EXPECT_NEAR(row[kAcceleranceRe], a.real(), 1e-12 * size * w * w);
        EXPECT_NEAR(row[kAcceleranceIm], a.imag(), 1e-12 * size * w * w);
    }
    // The force on the body: B takes the place of the coupling; equal steps
    const Rows point =
        response_of(kTwoMasses, {"--in", "two.x", "--out", "two.x", "--from", "0 Hz", "--to", "4 Hz", "--points", "5"});
    ASSERT_EQ(point.size(), 5u);
    EXPECT_NEAR(point[0][kRe], 1. / 800 + 1. / 500, 1e-15) << "at rest: springs in series";
    EXPECT_EQ(point[3][kFrequency], 3);
    const double w = 6 * kPi;
    const Complex k1(800, 3 * w), k2(500, 0.7 * w), A = k1 + k2 - 2 * w * w, B = k2 - 3 * w * w, H = A / (A * B - k2 * k2);
    EXPECT_NEAR(point[3][kRe], H.real(), 1e-12 * std::abs(H));
    EXPECT_NEAR(point[3][kIm], H.imag(), 1e-12 * std::abs(H));
}

/// A clamped bar, its tip a node, with material damping η.
std::string cantilever(double damping, const std::string& beams = "exact", const std::string& rest = "") {
    return fmt::format(R"(format = "dttmm/1"
[modes]
beams = "{}"
{}
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [1.5, 0, 0]
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "tip"
segments = 20
section = {{ rectangle = [0.02, 0.03] }}
material = {{ E = 70e9, poisson = 0.33, density = 2700, stiffness_damping = {} }}
)",
                       beams, rest, damping);
}

// Oracle: Euler's cantilever with a complex modulus E (1 + iωη): (C s − S c)/(β³ E I (1 + c C)); undamped it is real.
TEST(Frf, ACantileverFollowsItsClosedForm) {
    const auto closed = [](double hertz, double damping) {
        const double w = 2 * kPi * hertz, l = 1.5;
        const Complex EI = 70e9 * 0.03 * std::pow(0.02, 3) / 12 * Complex(1, w * damping);
        const Complex beta = std::pow(2700 * 0.02 * 0.03 * w * w / EI, 0.25), L = beta * l;
        return (std::cosh(L) * std::sin(L) - std::sinh(L) * std::cos(L)) /
               (beta * beta * beta * EI * (1.0 + std::cos(L) * std::cosh(L)));
    };
    for (const double damping : {0.0, 1e-4}) {
        std::string text = cantilever(damping);
        text.replace(text.find("segments"), 0, "theory = \"euler-bernoulli\"\n");
        const Rows rows =
            response_of(text, {"--in", "tip.y", "--out", "tip.y", "--from", "3 Hz", "--to", "803 Hz", "--points", "11"});
        ASSERT_EQ(rows.size(), 11u);
        for (const auto& row : rows) {
            const Complex H = closed(row[kFrequency], damping);
            EXPECT_NEAR(row[kRe], H.real(), 1e-8 * std::abs(H)) << row[kFrequency];
            EXPECT_NEAR(row[kIm], H.imag(), 1e-8 * std::abs(H)) << row[kFrequency];
            if (damping == 0) {
                EXPECT_EQ(row[kIm], 0);
            }
        }
    }
}

// Oracle: statics, l³/3EI + l/κGA and l²/2EI.
TEST(Frf, AtLowFrequencyItIsTheStaticDeflection) {
    const double E = 70e9, G = E / 2.66, A = 0.02 * 0.03, I = 0.02 * std::pow(0.03, 3) / 12, l = 1.5,
                 kappa = 10 * 1.33 / (12 + 11 * 0.33);
    const auto at = [&](const char* in, const char* out) {
        const Rows rows =
            response_of(cantilever(0), {"--in", in, "--out", out, "--from", "0 Hz", "--to", "0.001 Hz", "--points", "2"});
        EXPECT_EQ(rows.size(), 2u);
        EXPECT_NEAR(rows[1][kRe], rows[0][kRe], 1e-7 * std::abs(rows[0][kRe]));
        return rows[0][kRe];
    };
    EXPECT_NEAR(at("tip.z", "tip.z") / (l * l * l / (3 * E * I) + l / (kappa * G * A)), 1, 1e-9);
    EXPECT_NEAR(at("tip.z", "tip.ry") / (-l * l / (2 * E * I)), 1, 1e-9) << "w' = -ry";
    EXPECT_NEAR(at("tip.ry", "tip.z") / (-l * l / (2 * E * I)), 1, 1e-9);
    EXPECT_NEAR(at("tip.x", "tip.x") / (l / (E * A)), 1, 1e-9);
    EXPECT_NEAR(at("tip.ry", "tip.ry") / (l / (E * I)), 1, 1e-9);
}

// Oracle: the lumped beam in time. A haversine pulse, Fourier's integrals of force and deflection by sums over the steps:
// their ratio is the receptance. The run decays to 1e-5 of its peak (η = 2e-3 s: 7 % damping of the first mode at 11 Hz);
// with 0.1 ms steps the scheme's error (ωh)²/12 at 100 Hz is 3e-4.
TEST(Frf, TheLumpedBeamInTimeSaysTheSame) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", cantilever(2e-3, "lumped", R"([simulation]
duration = "2.5 s"
step = "0.1 ms"
[output]
channels = ["tip.position.z"]
[[load]]
on = "tip"
direction = [0, 0, 1]
force = { type = "haversine", peak = 1, start = 0, width = "6 ms" }
)"));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const Rows history = read_history(folder / "out/history.csv");
    ASSERT_EQ(history.size(), 25001u);
    const Ended asked = run_dttmm(folder.path(), {"frf", "model.toml", "-o", "frf", "-q", "--in", "tip.z", "--out", "tip.z",
                                                  "--from", "2 Hz", "--to", "102 Hz", "--points", "26"});
    ASSERT_EQ(asked.code, 0) << asked.err;
    for (const auto& row : read_history(folder / "frf/frf.csv")) {
        const double w = 2 * kPi * row[kFrequency];
        Complex force = 0, motion = 0;
        for (const auto& line : history) {
            const double t = line[0];
            const Complex e = std::exp(Complex(0, -w * t));
            force += (t < 6e-3 ? 0.5 * (1 - std::cos(2 * kPi * t / 6e-3)) : 0) * e;
            motion += (line[1] - history[0][1]) * e;
        }
        const Complex H(row[kRe], row[kIm]);
        EXPECT_LT(std::abs(motion / force - H), 0.01 * std::abs(H)) << row[kFrequency];
    }
}

TEST(Frf, TellsWhatItDidAndWhere) {
    const TemporaryFolder folder;
    write_text(folder / "two.toml", kTwoMasses);
    const Ended ended = run_dttmm(folder.path(), {"frf", "two.toml", "--in", "one.x", "--out", "one.x", "--from", "1 Hz",
                                                  "--to", "2 Hz", "--points", "3"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, testing::AllOf(testing::HasSubstr("3 points from 1 to 2 Hz"),
                                          testing::HasSubstr("results/two-frf/frf.csv")));
    const std::string text = read_text(folder / "results/two-frf/frf.csv");
    EXPECT_THAT(text, testing::StartsWith("frequency,receptance.re,receptance.im,receptance,phase,mobility.re,mobility.im,"
                                          "accelerance.re,accelerance.im\nHz,m/N,"));
}

// ---- What it refuses ----------------------------------------------------------------------------------------------------

/// Code and text of a `frf` of the two masses with these words.
void expect_refused(std::vector<std::string> words, int code, const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "two.toml", kTwoMasses);
    words.insert(words.begin(), {"frf", "two.toml"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, code) << ended.err;
    EXPECT_THAT(ended.err, testing::HasSubstr(text));
    EXPECT_FALSE(fs::exists(folder / "results"));
}

TEST(Frf, RefusesPlacesDirectionsAndRangesThatAreNotThere) {
    const auto with = [](std::vector<std::string> places,
                         std::vector<std::string> range = {"--from", "1 Hz", "--to", "9 Hz", "--points", "5"}) {
        places.insert(places.end(), range.begin(), range.end());
        return places;
    };
    expect_refused(with({"--in", "onw.x", "--out", "two.x"}), 2,
                   "--in \"onw.x\": no body, marker or node \"onw\"; did you mean \"one\"?");
    expect_refused(with({"--in", "one.x", "--out", "two.ent.x"}), 2, "did you mean \"two.end\"?");
    expect_refused(with({"--in", "one.x", "--out", "two"}), 2, "--out \"two\": write place.direction");
    expect_refused(with({"--in", "one.xx", "--out", "two.x"}), 2, "\"xx\" is none of the directions");
    expect_refused(with({"--in", "one.x", "--out", "two.x"}, {"--from", "9 Hz", "--to", "1 Hz", "--points", "5"}), 2,
                   "--to must be more than --from");
    expect_refused(with({"--in", "one.x", "--out", "two.x"}, {"--from", "0", "--to", "1 Hz", "--points", "5", "--log"}), 2,
                   "--from must be more than zero");
    expect_refused(with({"--in", "one.x", "--out", "two.x"}, {"--from", "1 kg", "--to", "2 Hz", "--points", "5"}), 2,
                   "--from");
    expect_refused(with({"--in", "one.x", "--out", "two.x"}, {"--from", "1 Hz", "--to", "2 Hz", "--points", "1"}), 2,
                   "--points");
}

// A direction that the model does not leave has no response: asking for it is a slip, not a zero.
TEST(Frf, RefusesDirectionsThatTheModelDoesNotLeave) {
    const std::vector<std::string> range = {"--from", "1 Hz", "--to", "9 Hz", "--points", "5"};
    for (const auto& [in, out, option] : {std::tuple("one.y", "two.x", "--in"), std::tuple("one.x", "two.rz", "--out")}) {
        std::vector<std::string> words = {"--in", in, "--out", out};
        words.insert(words.end(), range.begin(), range.end());
        expect_refused(words, 2, option);
    }
}

TEST(Frf, AnUndampedFrequencyHasNoResponse) {
    const TemporaryFolder folder;
    std::string text = cantilever(0);
    text.replace(text.find("fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]"), 41, "fixed = [\"x\"]");
    write_text(folder / "free.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"frf", "free.toml", "--in", "tip.z", "--out", "tip.z", "--from", "0 Hz",
                                                  "--to", "9 Hz", "--points", "5"});
    EXPECT_EQ(ended.code, 4) << ended.err;
    EXPECT_THAT(ended.err, testing::HasSubstr("0 Hz: the machine is free to move in"));
    EXPECT_THAT(ended.err, testing::HasSubstr("and the force moves it ("));
}

// ---- Free machines, held directions, symmetry ----------------------------------------------------------------------------

/// A shaft on two bearings that nothing keeps from turning, unless `node` holds it.
std::string spindle(const std::string& node = "") {
    return "format = \"dttmm/1\"\n[nodes]\nrear = { position = [0, 0, 0]" + node + R"( }
front = [0.3, 0, 0]
tip = [0.5, 0, 0]
[[element]]
name = "shaft"
type = "beam"
from = "rear"
to = "front"
section = { circle = "60 mm" }
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3" }
[[element]]
name = "overhang"
type = "beam"
from = "front"
to = "tip"
section = { circle = "60 mm" }
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3" }
[[element]]
name = "bearing1"
type = "spring_damper"
from = "rear"
to = "ground"
stiffness = [1e8, 2e8, 2e8]
[[element]]
name = "bearing2"
type = "spring_damper"
from = "front"
to = "ground"
stiffness = [0, 3e8, 3e8]
)";
}

Ended spindle_response(const fs::path& folder, const std::string& in, const std::string& out, const std::string& node = "") {
    write_text(folder / "spindle.toml", spindle(node));
    return run_dttmm(folder, {"frf", "spindle.toml", "--in", in, "--out", out, "--from", "0 Hz", "--to", "1 Hz", "--points",
                              "2", "-o", "out"});
}

// Oracle: the same shaft held against turning, which a force through its axis does not ask for; refined twice, the response
// stands to 1e-9.
TEST(Frf, AFreeMachineThatTheForceDoesNotMoveHasAStaticResponse) {
    const TemporaryFolder folder;
    for (const char* direction : {"tip.x", "tip.y", "tip.z", "tip.ry"}) {
        double compliance[2];
        for (int held : {0, 1}) {
            const Ended ended = spindle_response(folder.path(), "tip.z", direction, held ? ", fixed = [\"rx\"]" : "");
            ASSERT_EQ(ended.code, 0) << ended.err;
            compliance[held] = read_history(folder / "out/frf.csv")[0][1];
        }
        EXPECT_NEAR(compliance[0], compliance[1], 1e-9 * std::abs(compliance[1]) + 1e-20) << direction;
    }
}

TEST(Frf, AFreeMachineThatTheForceMovesIsRefusedWithTheDirection) {
    const TemporaryFolder folder;
    const Ended ended = spindle_response(folder.path(), "tip.rx", "tip.rx");
    EXPECT_EQ(ended.code, 4);
    EXPECT_EQ(ended.err,
              "dttmm: spindle.toml: 0 Hz: the machine is free to move in 1 direction, and the force moves it (node "
              "\"rear\" in rx): it accelerates for ever; hold that direction by a joint, an element or fixed = "
              "[..], or begin above 0 Hz\n");
    EXPECT_FALSE(fs::exists(folder / "out"));
}

// Oracle: a held direction does not move at all.
TEST(Frf, AHeldDirectionIsStill) {
    const TemporaryFolder folder;
    for (const auto& [in, out] : {std::pair{"tip.z", "rear.z"}, {"rear.z", "tip.z"}}) {
        const Ended ended = spindle_response(folder.path(), in, out, ", fixed = [\"rx\", \"z\"]");
        EXPECT_EQ(ended.code, 0);
        for (const auto& row : read_history(folder / "out/frf.csv"))
            for (size_t column = 1; column < row.size(); ++column) EXPECT_EQ(row[column], 0);
        EXPECT_THAT(ended.err, testing::EndsWith(": rear is fixed in that direction\n"));
    }
}

// Oracle: a round shaft along x does not turn about its axis under a force across it; a body beside it is joined to nothing.
TEST(Frf, WhatDoesNotMoveSaysWhy) {
    const TemporaryFolder folder;
    Ended ended = spindle_response(folder.path(), "tip.x", "tip.rx", ", fixed = [\"rx\"]");
    EXPECT_EQ(ended.err,
              "warning: tip.rx does not move under tip.x: they are joined, but the symmetry of the machine keeps "
              "these directions apart\n");
    write_text(folder / "apart.toml", spindle(", fixed = [\"rx\"]") + R"([[body]]
name = "stone"
mass = 1
inertia = [1, 1, 1]
[[element]]
name = "string"
type = "spring_damper"
from = "stone"
to = "ground"
stiffness = 100
rotational_stiffness = 100
)");
    ended = run_dttmm(folder.path(), {"frf", "apart.toml", "--in", "tip.x", "--out", "stone.x", "--from", "1 Hz", "--to",
                                      "2 Hz", "--points", "2", "-o", "out"});
    EXPECT_EQ(ended.err, "warning: stone.x does not move under tip.x: no element or joint leads from one to the other\n");
}

// Oracle: similarity. A machine of stiff parts and rigid directions, 2^20 times as heavy and stiff or 2^10 times as large,
// answers alike in its own units. Elimination in the units of the file would differ by a percent.
TEST(Frf, OfStiffPartsInAnyUnits) {
    const auto receptances = [](const test::Units& units) {
        const test::RandomMachine machine(56, 40, {}, units);
        std::vector<Complex> all;
        const TemporaryFolder folder;
        write_text(folder / "model.toml", "format = \"dttmm/1\"\n" + machine.text());
        const Ended ended = run_dttmm(folder.path(), {"frf", "model.toml", "--in", "b0.x", "--out", "b0.x", "--from", "0.5",
                                                      "--to", "200", "--points", "60", "--log", "-o", "out", "-q"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        for (const std::vector<double>& row : read_history(folder / "out/frf.csv"))
            all.push_back(units.stiffness() * Complex(row[kRe], row[kIm]));
        return all;
    };
    const std::vector<Complex> one = receptances({});
    for (const test::Units& units : {test::Units{1, 0x1p20, 1}, test::Units{0x1p10, 1, 1}}) {
        const std::vector<Complex> other = receptances(units);
        ASSERT_EQ(other.size(), one.size());
        for (size_t i = 0; i < one.size(); ++i) EXPECT_LT(std::abs(other[i] - one[i]), 1e-6 * std::abs(one[i])) << i;
    }
}

}  // namespace
}  // namespace dttmm::host
