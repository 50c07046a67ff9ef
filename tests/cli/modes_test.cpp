// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes` against closed forms, published cases and finite elements that share no formula with it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>

#include "cli/modes_run.h"
#include "support/exact_timoshenko.h"
#include "support/finite_elements.h"
#include "support/hydroplane_finite_elements.h"
#include "support/linear_algebra.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using test::FiniteElements;
constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-9;  ///< what is asked of refinement to 1e-10 beside an oracle exact to rounding

/// A quantity of every mode.
std::vector<double> of_modes(const nlohmann::json& modes, const char* key) {
    std::vector<double> values;
    for (const auto& mode : modes["modes"]) values.push_back(mode[key].get<double>());
    return values;
}

// Oracle: two ways to the same frequencies. The overall transfer matrix knows nothing of the dynamic stiffness; where the
// count says that there is a frequency, its last pivot is 1e-7 of that a thousandth beside: masses, springs,
// free directions, lines both ways, several inputs, and in the gun two loops that are cut.
TEST(ModesCases, TheOverallTransferMatrixIsSingularAtEveryFrequency) {
    for (const char* name : {"hydroplane", "gun", "four_bolt_plate", "beam_and_body"}) {
        const auto modes = modes_of_file(test::paths::source_dir() + "/examples/" + std::string(name) + "/model.toml");
        const std::vector<double> residuals = of_modes(modes, "residual");
        EXPECT_GE(residuals.size(), 6u) << name;
        for (double residual : residuals) EXPECT_LT(residual, 1e-7) << name;
    }
}

// A rod of which nothing but EA and mass is given has no inertia about its axis: its matrix was full of what is not given,
// and every residual 1. The stiff springs hold what a rod leaves free.
TEST(ModesCases, ARodNeedsNoInertiaOfItsOwn) {
    const auto modes = modes_of(R"(format = "dttmm/1"
[simulation]
duration = 1
step = "1 ms"
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [1.3, 0, 0]
[[element]]
name = "tie"
type = "rod"
from = "root"
to = "tip"
section = { EA = 3e8, mass = 4.1 }
[[element]]
name = "mount"
type = "elastic_hinge"
from = "tip"
to = "ground"
stiffness = { x = 1e7, y = 2e6, z = 3e6, rx = 4e4, ry = 5e4, rz = 6e4 }
[[element]]
name = "disc"
type = "rigid_body"
at = ["tip"]
mass = 2.7
inertia = { xx = 0.03, yy = 0.02, zz = 0.025 }
)",
                                {"--count", "5"});
    const std::vector<double> residuals = of_modes(modes, "residual");
    EXPECT_GE(residuals.size(), 4u);
    for (double residual : residuals) EXPECT_LT(residual, 1e-7);
}

// Oracle: the size of the hydroplane paper's equation (36).
TEST(ModesCases, TheHydroplanesOverallTransferEquationIsThatOfThePaper) {
    const TemporaryFolder folder;
    const Ended ended = run_dttmm(
        folder.path(), {"modes", "-v", test::paths::source_dir() + "/examples/hydroplane/model.toml", "-o", "out"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.out, testing::HasSubstr("overall transfer equation: 24 x 48, 4 directions per state; known boundary "
                                              "entries struck out: 24 x 24\n"));
    EXPECT_THAT(ended.out, testing::HasSubstr("body \"tiller\": 3 inputs, 8 geometric equations"));
}

// ---- The cases ----------------------------------------------------------------------------------------------------------

// Oracle: theory.md V2, by exact dynamic stiffness, printed to seven digits: half of the last one is 3e-7 at most.
TEST(ModesCases, TheDoubleCrossHasItsFrequenciesOneTwoAndFiveFold) {
    const nlohmann::json modes = modes_of_file(modes_model("double_cross"));
    expect_frequencies(frequencies_of(modes),
                       {11.33625, 17.68077, 17.68077, 17.70938, 17.70938, 17.70938, 17.70938, 17.70938, 45.34498, 57.07456,
                        57.07456, 57.38973, 57.38973, 57.38973, 57.38973, 57.38973},
                       4.5e-7);
    EXPECT_THAT(of_modes(modes, "multiplicity"), testing::ElementsAre(1, 2, 2, 5, 5, 5, 5, 5, 1, 2, 2, 5, 5, 5, 5, 5));
    // The count brackets each, to a relative 1e-10. The overall transfer matrix is singular there: a frequency within 1e-11
    // leaves a last pivot of 1e-8 of that 1e-3 beside
    for (double bracket : of_modes(modes, "bracket")) EXPECT_LT(bracket, 1.001e-10);
    for (double residual : of_modes(modes, "residual")) EXPECT_LT(residual, 1e-8);
}

// Oracle: a pinned arm alone sounds with sin(kl) = 0 for bending, and a clamped-pinned arm with tan kl = tanh kl: the
// one-fold frequencies and the five-fold ones are those of a single arm.
TEST(ModesCases, TheDoubleCrossHasFrequenciesOfOneArm) {
    const double E = 200e9, rho = 8000, b = 0.125, l = 5;
    const auto arm = [&](double kl) { return kl * kl / (2 * kPi * l * l) * std::sqrt(E * b * b / (12 * rho)); };
    const std::vector<double> found = frequencies_of(modes_of_file(modes_model("double_cross")));
    ASSERT_EQ(found.size(), 16u);
    EXPECT_NEAR(found[0] / arm(kPi), 1, kRounding);
    EXPECT_NEAR(found[8] / arm(2 * kPi), 1, kRounding);
    EXPECT_NEAR(found[5] / arm(3.9266023120479188), 1, kRounding);
    EXPECT_NEAR(found[13] / arm(7.0685827456287321), 1, kRounding);
}

/// The free tube: six zeros, bending twice, twist and stretch.
struct FreeTube {
    static constexpr double l = 1.2, E = 204e9, nu = 0.26, rho = 7800;
    static double axial(int n) { return n / (2 * l) * std::sqrt(E / rho); }
    static double torsion(int n) { return n / (2 * l) * std::sqrt(E / (2 * (1 + nu)) / rho); }  // a circle: J = Ip
};

const std::vector<double> kTubeBending = {182.9656, 497.0200, 954.2453, 1536.2971, 2225.2393, 3003.2814};

// Oracle: theory.md 3.4, exact Timoshenko, printed to a tenth of a millihertz with Cowper's coefficient, which the case
// rounds to six digits (1.6e-4 Hz of the sixth); the same beam in extended precision; closed forms of bars.
TEST(ModesCases, TheFreeTubeHasSixZerosPairsTwistAndStretch) {
    const nlohmann::json modes = modes_of_file(modes_model("free_tube"));
    const std::vector<double> found = frequencies_of(modes);
    EXPECT_THAT(of_modes(modes, "multiplicity"),
                testing::ElementsAre(6, 6, 6, 6, 6, 6, 2, 2, 2, 2, 2, 2, 1, 2, 2, 1, 2, 2, 1, 2, 2));
    ASSERT_EQ(found.size(), 21u);
    const double A = kPi / 4 * (0.05 * 0.05 - 0.03 * 0.03), I = kPi / 64 * (std::pow(0.05, 4) - std::pow(0.03, 4)),
                 E = FreeTube::E, rho = FreeTube::rho;
    const test::ExactTimoshenko beam{E * I, 0.578867 * A * E / (2 * (1 + FreeTube::nu)), rho * A, rho * I, FreeTube::l};
    const std::vector<double> bending = beam.free_frequencies(6, 300);
    std::vector<double> expected(6, 0.0);
    for (size_t i = 0; i < 6; ++i) {
        expected.insert(expected.end(), 2, bending[i] / (2 * kPi));
        EXPECT_NEAR(bending[i] / (2 * kPi), kTubeBending[i], 2.2e-4) << i;
    }
    expected.insert(expected.end(), {FreeTube::torsion(1), FreeTube::torsion(2), FreeTube::axial(1)});
    expect_frequencies(found, sorted(expected), kRounding);
    EXPECT_NEAR(FreeTube::torsion(1), 1342.32, 5e-3);
    EXPECT_NEAR(FreeTube::axial(1), 2130.87, 5e-3);
}

// Oracle: theory.md 3.4, errors of the paper's lumped beam in percent, printed to four figures.
TEST(ModesCases, TheLumpedFreeTubeErrsAsThePaperSays) {
    std::string text = read_text(modes_model("free_tube"));
    text.replace(text.find("\"exact\""), 7, "\"lumped\"");
    const std::vector<std::pair<int, std::vector<double>>> rows = {
        {10, {-0.504, -1.815, -3.690, -6.015, -8.678, -11.624}},
        {20, {-0.126, -0.458, -0.945, -1.563, -2.290, -3.114}},
        {40, {-0.0315, -0.1149, -0.2376, -0.3947, -0.5808, -0.7931}},
        {80, {-0.0079, -0.0287, -0.0595, -0.0989, -0.1457, -0.1992}}};
    for (const auto& [segments, errors] : rows) {
        std::string own = text;
        own.replace(own.find("segments = 40"), 13, fmt::format("segments = {}", segments));
        const nlohmann::json modes = modes_of(own);
        EXPECT_EQ(modes["beams"], "lumped");
        std::vector<double> bending;
        const std::vector<double> found = frequencies_of(modes);
        ASSERT_GT(found.size(), 6u);
        for (size_t i = 0; i < 6; ++i) EXPECT_EQ(found[i], 0);
        for (const auto& mode : modes["modes"])
            if (mode["multiplicity"] == 2) bending.push_back(mode["frequency_hz"]);
        ASSERT_GE(bending.size(), 12u);
        // The printed exact frequencies carry 5e-5 Hz, which is 3e-5 % of the lowest
        for (size_t i = 0; i < 6; ++i) {
            const double digit = segments < 40 ? 5.1e-4 : 8e-5;
            EXPECT_NEAR(100 * (bending[2 * i] / kTubeBending[i] - 1), errors[i], digit) << segments << ", mode " << i + 1;
            EXPECT_EQ(bending[2 * i], bending[2 * i + 1]);
        }
    }
}

// Oracle: finite elements of 3, 6 and 12 per member, extrapolated: their own limit to 1e-6 (finite_elements_test.cpp).
TEST(ModesCases, TheHydroplaneAgreesWithFiniteElements) {
    for (const double kh : {5e6, 20e6, 160e6}) {
        const std::vector<double> found =
            frequencies_of(modes_of_file(modes_model("hydroplane"), {"--set", fmt::format("kh={} MN/m", kh / 1e6)}));
        std::vector<double> expected = test::extrapolate(
            [&](int n) { return test::hydroplane(kh, n, FiniteElements::Across::unchanged).frequencies(); }, 3);
        expected.resize(8);
        expect_frequencies(found, expected, 1e-6);
    }
}

/// The plate's matrices by hand: 9.42 kg of 300 × 200 × 20 mm on springs k at (±0.13, ±0.08, 0).
TEST(ModesCases, TheFourBoltPlateHasTheEigenvaluesOfItsMatrices) {
    const double m = 7850 * 0.3 * 0.2 * 0.02;
    const Eigen::Vector3d I =
        m / 12 * Eigen::Vector3d(0.2 * 0.2 + 0.02 * 0.02, 0.3 * 0.3 + 0.02 * 0.02, 0.3 * 0.3 + 0.2 * 0.2);
    const double k[] = {4e5, 5e5, 5e5, 5e5};
    const double x[] = {0.13, -0.13, -0.13, 0.13}, y[] = {0.08, 0.08, -0.08, -0.08};
    Eigen::Matrix<double, 6, 6> K = Eigen::Matrix<double, 6, 6>::Zero(), M = K;
    M.diagonal() << m, m, m, I;
    for (int i = 0; i < 4; ++i) {
        Eigen::Matrix<double, 3, 6> by;  // u + θ × r
        by << 1, 0, 0, 0, 0, -y[i], 0, 1, 0, 0, 0, x[i], 0, 0, 1, y[i], -x[i], 0;
        K += k[i] * by.transpose() * by;
    }
    const Eigen::VectorXd lambda = test::solve_pencil(K, M).values;
    std::vector<double> expected;
    for (double l : lambda) expected.push_back(std::sqrt(l) / (2 * kPi));
    const nlohmann::json modes = modes_of_file(test::paths::source_dir() + "/examples/four_bolt_plate/model.toml",
                                               {"--set", "k1=400 N/mm", "--count", "6"});
    expect_frequencies(frequencies_of(modes), expected, kRounding);
}

// Oracle: theory.md V6, nine frequencies of the paper's transfer matrices, corrected, printed to a tenth of a millihertz,
// and its sweep of the hydraulic stiffness by finite elements, whose own error is 1e-5 and more.
TEST(ModesCases, TheHydroplaneOfThePaper) {
    const std::vector<double> printed{55.1826, 61.9625, 67.3843, 142.5924, 184.1910, 199.7435, 274.4468, 275.3788, 383.7306};
    const std::vector<double> found = frequencies_of(modes_of_file(modes_model("hydroplane_of_the_paper")));
    ASSERT_EQ(found.size(), printed.size());
    for (size_t i = 0; i < printed.size(); ++i) EXPECT_NEAR(found[i], printed[i], 5.1e-5) << i + 1;
    const std::vector<std::pair<const char*, std::vector<double>>> sweep{
        {"1e7", {42.803, 61.963, 64.475, 142.598, 179.446}},
        {"4e7", {60.540, 61.963, 79.387, 142.598, 193.333}},
        {"8e7", {61.542, 61.963, 94.671, 142.598, 199.744}}};
    for (const auto& [kh, row] : sweep)
        expect_frequencies(frequencies_of(modes_of_file(modes_model("hydroplane_of_the_paper"),
                                                        {"--set", fmt::format("kh={} N/m", kh), "--count", "5"})),
                           row, 5e-5);
}

// ---- Cases of theory.md -------------------------------------------------------------------------------------------------

// Oracle: theory.md V1, the torsional chain of a classification society. A flexibility of zero is a rigid hinge.
TEST(ModesCases, TorsionalChain) {
    const std::vector<double> inertia{3.16, 0.305, 1.2511, 0.0609, 0.0527, 0.018, 0.018, 0.0273, 0.0438, 0.6593};
    const std::vector<double> give{5128.2051, 277777.7778, 7352.9412, 0, 1142.8571, 0, 0, 23596.0359, 621118.0124};
    std::string text = "format = \"dttmm/1\"\ndofs = [\"rx\"]\n[modes]\nbelow = \"1 kHz\"\n[nodes]\n";
    for (size_t i = 0; i < inertia.size(); ++i) text += fmt::format("n{} = [{}, 0, 0]\n", i, i);
    for (size_t i = 0; i < inertia.size(); ++i) {
        text += fmt::format(
            "[[element]]\nname = \"J{0}\"\ntype = \"rigid_body\"\nat = \"n{0}\"\nmass = 1\ninertia = {{ xx = {1}, yy = {1}, "
            "zz "
            "= {1} }}\n",
            i, inertia[i]);
        if (i == 0) continue;
        text += fmt::format("[[element]]\nname = \"k{1}\"\ntype = \"elastic_hinge\"\nfrom = \"n{0}\"\nto = \"n{1}\"\n",
                            i - 1, i);
        text += give[i - 1] > 0 ? fmt::format("stiffness = {{ rx = {} }}\n", 1 / (give[i - 1] * 1e-10))
                                : std::string("stiffness = { rx = \"rigid\" }\n");
    }
    const std::vector<double> found = frequencies_of(modes_of(text));
    ASSERT_EQ(found.size(), 6u) << "the seventh lies above 1 kHz";
    EXPECT_EQ(found[0], 0);
    expect_frequencies({found.begin() + 1, found.begin() + 6}, {21.418, 35.628, 383.40, 424.65, 619.74}, 2e-5);
}

// Oracle: theory.md V3 (NAFEMS FV4), printed to five decimals without shear; with it the last of four is off by up to one.
TEST(ModesCases, CantileverWithMassesBesideItsTip) {
    const auto found = [](const std::string& section) {
        return frequencies_of(modes_of(R"(format = "dttmm/1"
[modes]
count = 6
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip  = ["10 m", 0, 0]
heavy = [10, 2, 0]
light = [10, -2, 0]
[[element]]
name = "masses"
type = "rigid_body"
at = ["heavy", "tip"]
mass = 10000
[[element]]
name = "second"
type = "rigid_body"
at = ["light", "tip"]
mass = 1000
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "tip"
)" + section));
    };
    const std::string steel = "material = { E = \"200 GPa\", poisson = 0.3, density = 8000 }\n";
    const double d = 0.5, A = kPi / 4 * d * d, I = kPi / 64 * std::pow(d, 4), E = 200e9, G = E / 2.6;
    const std::string numbers =
        fmt::format("EA = {}, EIy = {}, EIz = {}, GJ = {}, mass = {}", E * A, E * I, E * I, 2 * G * I, 8000 * A);
    expect_frequencies(found("section = { " + numbers + ", GAy = 1e18, GAz = 1e18 }\n"),
                       {1.72312, 1.72669, 7.41275, 9.97148, 18.15513, 26.95717}, 3.2e-6);
    const std::vector<double> shear = found("section = { circle = 0.5, shear_coefficient = 0.886 }\n" + steel);
    expect_frequencies(shear, {1.72198, 1.72548, 7.40979, 9.94680, 18.0430, 26.6870}, 4e-6);
    // The same by its numbers; Euler-Bernoulli is neither shear nor rotary inertia
    const std::string sheared = fmt::format("{}, GAy = {}, GAz = {}", numbers, 0.886 * G * A, 0.886 * G * A);
    expect_frequencies(found("section = { " + sheared + " }\n"), shear, kRounding);
    const std::vector<double> euler = found("theory = \"euler-bernoulli\"\nsection = { circle = 0.5 }\n" + steel);
    expect_frequencies(euler, found("theory = \"euler-bernoulli\"\nsection = { " + numbers + " }\n"), kRounding);
    EXPECT_GT(euler[0], 1.72312);
    EXPECT_LT(euler[0], 1.7233);
}

/// A beam of a square section on supports that hold what `fixed` says at both ends.
std::vector<double> deep_beam(double length, double side, double E, double rho, double kappa, const std::string& dofs,
                              const std::string& left, const std::string& right, double below) {
    return frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
dofs = {}
[modes]
below = {}
[nodes]
a = {{ position = [0, 0, 0], fixed = {} }}
b = {{ position = [{}, 0, 0], fixed = {} }}
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
section = {{ rectangle = [{}, {}], shear_coefficient = {} }}
material = {{ E = {}, poisson = 0.3, density = {} }}
)",
                                               dofs, below, left, length, right, side, side, kappa, E, rho)));
}

// Oracle: theory.md V4, closed form of the simply supported Timoshenko beam, beside its digits as printed. The second branch
// of the closed form (shear) lies above the range.
TEST(ModesCases, DeepBeams) {
    const auto closed = [](int n, double l, double b, double E, double rho, double kappa) {
        const double A = b * b, I = b * b * b * b / 12, G = E / 2.6, L2 = std::pow(n * kPi, 2), j = I / (A * l * l),
                     g = E * I / (kappa * A * G * l * l), s = (g + j) * L2 + 1;
        const double Omega = (s - std::sqrt(std::pow(g - j, 2) * L2 * L2 + 2 * (g + j) * L2 + 1)) / (2 * g * j);
        return std::sqrt(Omega * E * I / (rho * A * std::pow(l, 4))) / (2 * kPi);
    };
    const std::string plane = R"(["x", "y", "rz"])";
    const std::vector<double> a = deep_beam(2, 0.2, 210e9, 7800, 5. / 6, plane, R"(["x", "y"])", R"(["y"])", 1600);
    expect_frequencies(a, {115.709, 442.172, 648.593, 931.574, 1533.648}, 4.5e-6);
    for (const auto& [at, n] : {std::pair(0, 1), std::pair(1, 2), std::pair(3, 3), std::pair(4, 4)})
        EXPECT_NEAR(a[static_cast<size_t>(at)] / closed(n, 2, 0.2, 210e9, 7800, 5. / 6), 1, kRounding) << n;

    const std::vector<double> b = deep_beam(10, 2, 200e9, 8000, 0.85, plane, R"(["x", "y"])", R"(["y"])", 284);
    expect_frequencies(b, {42.6456, 125.000, 148.156, 283.490}, 3.5e-6);
    EXPECT_NEAR(b[2] / closed(2, 10, 2, 200e9, 8000, 0.85), 1, kRounding);
}

// Oracle: theory.md V4 b, torsion with J = Ip: of a circle of any size, f = (2k − 1)/4l √(G/ρ), clamped at one end.
TEST(ModesCases, TorsionOfADeepBeam) {
    const std::string text = R"(format = "dttmm/1"
dofs = ["rx"]
[modes]
count = 2
[nodes]
a = { position = [0, 0, 0], fixed = ["rx"] }
b = [10, 0, 0]
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
section = { circle = 2 }
material = { E = 200e9, poisson = 0.3, density = 8000 }
)";
    const std::vector<double> found = frequencies_of(modes_of(text));
    const double c = std::sqrt(200e9 / 2.6 / 8000);
    expect_frequencies(found, {c / 40, 3 * c / 40}, kRounding);
    expect_frequencies(found, {77.522, 232.565}, 7e-6);
}

// A lumped beam whose mass is beside its elastic axis, which `dofs` keep straight: its segments turn about the axis with all
// of their inertia. Oracle: the chain in closed form, f_k = 1/π √(GJ/I) n/L sin((2k − 1)π/4n), for half a spring at the
// clamped end and none at the free one.
TEST(ModesCases, ALumpedBeamTurnsAboutItsElasticAxis) {
    const double GJ = 800, inertia = 2e-3, length = 1.3;
    const int segments = 7;
    const nlohmann::json found = modes_of(fmt::format(R"(format = "dttmm/1"
dofs = ["x", "rx"]
[modes]
count = 3
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "rx"] }}
b = [{}, 0, 0]
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
segments = {}
section = {{ EA = 2e9, EIy = 1e3, EIz = 1.5e3, GJ = {}, GAy = 6e6, GAz = 7e6, mass = 0.6, mass_offset = [0.02, 0.03], inertia = {} }}
)",
                                                      length, segments, GJ, inertia),
                                          {"--beams", "lumped"});
    std::vector<double> expected;
    for (int k = 1; k <= 3; ++k)
        expected.push_back(std::sqrt(GJ / inertia) * segments / length * std::sin((2 * k - 1) * kPi / (4 * segments)) / kPi);
    expect_frequencies(frequencies_of(found), expected, kRounding);
}

/// Wall, spring, mass, spring, mass along x, all equal but what is told.
std::string two_masses(const std::string& extra = "") {
    return R"(format = "dttmm/1"
dofs = ["x"]
[nodes]
a = [1, 0, 0]
b = [2, 0, 0]
[[element]]
name = "first"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = 12
[[element]]
name = "second"
type = "spring_damper"
from = "a"
to = "b"
stiffness = 12
[[element]]
name = "one"
type = "point_mass"
at = "a"
mass = 3
[[element]]
name = "two"
type = "point_mass"
at = "b"
mass = 3
)" + extra;
}

// Oracle: the paper's (10) with its misprint corrected, J_xx + m (c2² + c3²) about the input, though z is left out of the
// state: a body on a torsion spring, its centre off in y and in z.
TEST(ModesCases, ABodyTurnsAboutItsInputWithAllOfItsMass) {
    const std::vector<double> found = frequencies_of(modes_of(R"(
format = "dttmm/1"
dofs = ["x", "y", "rz", "rx"]
[modes]
below = "100 Hz"
[nodes]
input = { position = [0.2, -0.1, 0.3], fixed = ["x", "y", "rz"] }
[[element]]
name = "body"
type = "rigid_body"
at = "input"
mass = 7
center_of_mass = [0, 0.3, 0.2]
inertia = { xx = 2, yy = 3, zz = 4 }
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "input"
rotational_stiffness = [1e5, 0, 0]
)"));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0], std::sqrt(1e5 / (2 + 7 * (0.3 * 0.3 + 0.2 * 0.2))) / (2 * M_PI), 1e-9 * found[0]);
}

// A spring beside the centre of a body that turns: its end moves in y too, which is left out. What the frequencies are of is
// told. On the axis of the rotation nothing is left out.
TEST(ModesCases, AMotionThatDofsLeaveOutIsTold) {
    const auto warnings_of = [](const std::string& marker, const std::string& position = "[0.7, 0.2, -0.4]") {
        return modes_of(R"(format = "dttmm/1"
dofs = ["x", "rz"]
[[body]]
name = "wheel"
mass = 2
inertia = [0.03, 0.02, 0.05]
position = )" + position +
                        R"(
markers = { rim = )" + marker +
                        R"( }
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "wheel.rim"
stiffness = [1000, 2000, 0]
rotational_stiffness = [0, 0, 30]
)")["warnings"];
    };
    const nlohmann::json beside = warnings_of("[0.4, 0.1, 0]");
    ASSERT_EQ(beside.size(), 1u);
    EXPECT_EQ(beside[0]["code"], "dofs-lever");
    EXPECT_THAT(beside[0]["text"],
                testing::HasSubstr("dofs keep rz and leave out y, in which rz moves points of body \"wheel\""));
    EXPECT_TRUE(warnings_of("[0, 0.1, 0.3]").empty());
    EXPECT_TRUE(warnings_of("[6e-17, 0, 0.3]", "[-5e-17, 0, 0]").empty()) << "rounding at the origin";
}

// Oracle: theory.md V7, ω = √5 ∓ 1. A model of two masses has two frequencies, however many are asked for.
TEST(ModesCases, TwoMasses) {
    const std::vector<double> expected{(std::sqrt(5.) - 1) / (2 * kPi), (std::sqrt(5.) + 1) / (2 * kPi)};
    expect_frequencies(frequencies_of(modes_of(two_masses())), expected, kRounding);
    expect_frequencies(frequencies_of(modes_of(two_masses(), {"--count", "7"})), expected, kRounding);
    expect_frequencies(frequencies_of(modes_of(two_masses(), {"--count", "1"})), {expected[0]}, kRounding);
    expect_frequencies(frequencies_of(modes_of(two_masses(), {"--below", "0.3 Hz"})), {expected[0]}, kRounding);
}

// ---- What it writes -----------------------------------------------------------------------------------------------------

TEST(Modes, WritesATableShapesAndASummary) {
    const TemporaryFolder folder;
    write_text(folder / "two.toml", two_masses());
    const Ended ended = run_dttmm(folder.path(), {"modes", "two.toml", "--count", "2"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, testing::AllOf(testing::HasSubstr("0.19672"), testing::HasSubstr("0.51503"),
                                          testing::HasSubstr("results/two-modes"), testing::HasSubstr("first 72 %")));
    const nlohmann::json summary = read_json(folder / "results/two-modes/summary.json");
    EXPECT_EQ(summary["frequencies_hz"].size(), 2u);
    EXPECT_EQ(summary["command_line"], "dttmm modes two.toml --count 2");
    std::istringstream lines(read_text(folder / "results/two-modes/modes.csv"));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "mode,frequency,multiplicity,modal_mass,place,x,y,z,ux,uy,uz,urx,ury,urz");
    std::getline(lines, line);
    size_t count = 0;
    while (std::getline(lines, line)) ++count;
    EXPECT_EQ(count, 4u) << "two modes at two nodes";
    // The shape of the printed object is that of the closed form: u1/u2 = (√5 − 1)/2
    const nlohmann::json modes = modes_of(two_masses(), {"--count", "1"});
    EXPECT_NEAR(modes["modes"][0]["shape"]["a"][0].get<double>() / modes["modes"][0]["shape"]["b"][0].get<double>(),
                (std::sqrt(5.) - 1) / 2, kRounding);
    EXPECT_EQ(run_dttmm(folder.path(), {"modes", "two.toml", "-q"}).out, "");
}

// Oracle: v + w x r from the listed row of the body. A marker without an element does not scale the shape.
TEST(Modes, AShapeIsScaledByCentresOfMassAndWhereElementsHold) {
    const nlohmann::json found = modes_of(R"(format = "dttmm/1"
[[body]]
name = "b"
mass = 2
inertia = [0.02, 0.03, 0.04]
center_of_mass = [0.5, 0.1, 0.2]
markers = { left = [-0.1, 0, 0], right = [0.6, 0, 0], far = [5, 0, 0] }
[[element]]
name = "one"
type = "spring_damper"
from = "ground"
to = "b.left"
stiffness = 9000
[[element]]
name = "two"
type = "spring_damper"
from = "ground"
to = "b.right"
stiffness = [6000, 7000, 5000]
rotational_stiffness = [100, 110, 120]
)");
    const nlohmann::json& modes = found["modes"];
    ASSERT_EQ(modes.size(), 6u);
    double farthest = 0;
    for (const nlohmann::json& mode : modes) {
        const nlohmann::json& shape = mode["shape"];
        const auto moved = [&](const char* place, const Eigen::Vector3d& arm) {
            const auto u = shape[place].get<std::vector<double>>();
            return (Eigen::Vector3d(u[0], u[1], u[2]) + Eigen::Vector3d(u[3], u[4], u[5]).cross(arm)).norm();
        };
        const Eigen::Vector3d none = Eigen::Vector3d::Zero();
        EXPECT_NEAR(std::max({moved("b", {0.5, 0.1, 0.2}), moved("b.left", none), moved("b.right", none)}), 1, 1e-12);
        farthest = std::max(farthest, moved("b.far", none));
    }
    EXPECT_GT(farthest, 3);
}

// ---- Joints and bodies --------------------------------------------------------------------------------------------------

/// A bar on a joint to the ground, on a rotational spring; told in [[joint]] and a spring beside it.
std::string on_a_joint(const std::string& joint, const std::string& spring) {
    return R"(format = "dttmm/1"
[modes]
count = 6
[[body]]
name = "bar"
mass = 3
inertia = [0.1, 0.2, 0.25]
position = [0.4, 0, 0]
markers.foot = [-0.4, 0, 0]
[[joint]]
name = "pin"
between = ["ground", "bar"]
anchor = [0, 0, 0]
)" + joint +
           R"(
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "bar.foot"
)" + spring +
           "\n";
}

// Oracle: one degree of freedom each: k over the inertia about the joint, I + m l², or the mass.
TEST(Modes, AJointLeavesItsDirections) {
    const double k = 500, about_y = 0.2 + 3 * 0.4 * 0.4, about_z = 0.25 + 3 * 0.4 * 0.4;
    const auto f = [](double stiffness, double inertia) { return std::sqrt(stiffness / inertia) / (2 * kPi); };
    const std::string turn = "rotational_stiffness = 500";
    expect_frequencies(frequencies_of(modes_of(on_a_joint("type = \"hinge\"\naxis = [0, 1, 0]", turn))), {f(k, about_y)},
                       kRounding);
    expect_frequencies(frequencies_of(modes_of(on_a_joint("type = \"slider\"\naxis = [1, 0, 0]", "stiffness = 500"))),
                       {f(k, 3)}, kRounding);
    expect_frequencies(
        frequencies_of(modes_of(on_a_joint("type = \"universal\"\naxis = [0, 1, 0]\naxis2 = [0, 0, 1]", turn))),
        {f(k, about_z), f(k, about_y)}, kRounding);
    expect_frequencies(frequencies_of(modes_of(on_a_joint("type = \"ball\"", turn))),
                       {f(k, about_z), f(k, about_y), f(k, 0.1)}, kRounding);
}

// ---- Sweeps -------------------------------------------------------------------------------------------------------------

/// Rows of a sweep.csv: without its two lines of names and units, and without the likenesses; an empty cell is NaN.
std::vector<std::vector<double>> read_named_rows(const fs::path& file, std::string& names, std::string& units);
std::vector<std::vector<double>> read_curves(const fs::path& file, std::string& names, std::string& units) {
    std::vector<std::vector<double>> rows = read_named_rows(file, names, units);
    const size_t mac = names.find(",mac1");
    const auto columns = std::count(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(mac), ',') + 1;
    for (std::vector<double>& row : rows) row.resize(static_cast<size_t>(columns));
    names.resize(mac);
    return rows;
}

/// The same with the likenesses.
std::vector<std::vector<double>> read_named_rows(const fs::path& file, std::string& names, std::string& units) {
    std::istringstream lines(read_text(file));
    std::getline(lines, names);
    std::getline(lines, units);
    std::vector<std::vector<double>> rows;
    for (std::string line; std::getline(lines, line);) {
        std::vector<double> row;
        std::istringstream cells(line + ",");
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(cell.empty()                ? std::nan("")
                          : cell.starts_with("case-") ? std::stod(cell.substr(5))
                                                      : std::stod(cell));
        rows.push_back(row);
    }
    return rows;
}

// Oracle: two masses that know nothing of each other: one on 100 N/m, one on k: √(k/m)/2π crosses the other's √(100/m)/2π at
// k = 100. Followed by their shapes, one curve stays and the other rises through it.
TEST(ModesSweep, CurvesGoThroughACrossing) {
    const std::string text = R"(format = "dttmm/1"
dofs = ["x"]
[parameters]
k = "50 N/m"
[modes]
count = 2
[nodes]
a = [1, 0, 0]
b = [2, 0, 0]
[[element]]
name = "fixed"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = 100
[[element]]
name = "swept"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = ["=k", 0, 0]
[[element]]
name = "one"
type = "point_mass"
at = "a"
mass = 1
[[element]]
name = "two"
type = "point_mass"
at = "b"
mass = 1
)";
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--sweep", "k=40N/m..190N/m:6"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::string names, units;
    const auto rows = read_named_rows(folder / "results/m-modes/sweep.csv", names, units);
    EXPECT_EQ(names, "case,k,curve1,curve2,mac1,mac2");
    EXPECT_EQ(units, ",N/m,Hz,Hz,1,1");
    ASSERT_EQ(rows.size(), 6u);
    for (size_t c = 0; c < 6; ++c) {
        const double k = 40 + 30 * static_cast<double>(c);
        ASSERT_EQ(rows[c].size(), 6u);
        EXPECT_EQ(rows[c][0], static_cast<double>(c + 1));
        EXPECT_NEAR(rows[c][1], k, 1e-9);
        EXPECT_NEAR(rows[c][2], std::sqrt(k) / (2 * kPi), 1e-9) << "the swept one began lower";
        EXPECT_NEAR(rows[c][3], 10 / (2 * kPi), 1e-9);
        for (size_t mac : {4u, 5u}) {
            if (c == 0)
                EXPECT_TRUE(std::isnan(rows[c][mac]));
            else
                EXPECT_NEAR(rows[c][mac], 1, 1e-12) << "the shapes do not change";
        }
    }
    EXPECT_THAT(ended.out, testing::StartsWith("case              k [N/m] curve1 [Hz] curve2 [Hz] lowest mac\n"));
    EXPECT_EQ(ended.err, "");
    // Where both have one frequency there are two modes, elsewhere one: the lower
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", "m.toml", "--sweep", "k=70N/m,100N/m,130N/m", "--count", "1"}).err,
                HasSubstr("note: 2 curves have no frequency in some cases, curve1 in 1 of 3: a mode is not among those"));
    // The same as an object, in the same order
    const Ended json = run_dttmm(folder.path(), {"modes", "m.toml", "--sweep", "k=40N/m,190N/m", "--json"});
    ASSERT_EQ(json.code, 0) << json.err;
    const nlohmann::json cases = nlohmann::json::parse(json.out)["cases"];
    ASSERT_EQ(cases.size(), 2u);
    EXPECT_EQ(cases[1]["parameters"]["k"], 190);
    EXPECT_NEAR(cases[1]["frequencies_hz"][0].get<double>(), std::sqrt(190.) / (2 * kPi), 1e-9);
}

// Oracle: two masses on springs of their own, joined by a weak spring, k from one side of the other spring to far beyond: in
// between the modes change places, and with two cases nothing shows how. In a grid with a second parameter that does
// nothing the same holds for each of its values: neighbours there are alike, wherever the listing goes back to the start.
TEST(ModesSweep, ShapesThatDifferTooMuchAreTold) {
    const std::string text = R"(format = "dttmm/1"
dofs = ["x"]
[parameters]
k = "50 N/m"
idle = 1
[modes]
count = 2
[nodes]
a = [1, 0, 0]
b = [2, 0, 0]
[[element]]
name = "left"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = 100
[[element]]
name = "right"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = ["=k", 0, 0]
[[element]]
name = "between"
type = "spring_damper"
from = "a"
to = "b"
stiffness = [10, 0, 0]
[[element]]
name = "one"
type = "point_mass"
at = "a"
mass = 1
[[element]]
name = "two"
type = "point_mass"
at = "b"
mass = 1
)";
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    const auto lowest = [&](const std::string& axis, const std::string& other) {
        const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--sweep", axis, "--sweep", other, "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        std::string names, units;
        double least = 1;
        for (const std::vector<double>& row : read_named_rows(folder / "out/sweep.csv", names, units))
            for (size_t k : {5u, 6u})
                if (row[k] < least) least = row[k];
        EXPECT_EQ(ended.err.empty(), least >= 0.8) << ended.err;
        if (least < 0.8) {
            EXPECT_THAT(ended.err,
                        testing::StartsWith("warning: in 2 places a curve goes on with a shape of a likeness (MAC) "
                                            "below 0.8, lowest 0.53 of curve"));
        }
        return least;
    };
    EXPECT_LT(lowest("k=70N/m,115N/m", "idle=1,2,3"), 0.8);
    EXPECT_GT(lowest("k=60N/m..140N/m:41", "idle=1,2,3"), 0.95);
}

// Oracle: sqrt(k/m)/(2 pi) of the cases that are sound. One that is not costs the others nothing; if all are unsound, its
// fault is the sweep's.
TEST(ModesSweep, ACaseThatFailsLeavesTheOthers) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
dofs = ["x"]
parameters = { m = 2 }
body = [{ name = "b", mass = "=m", sphere = 0.1 }]
element = [{ name = "s", type = "spring_damper", from = "ground", to = "b", stiffness = 1000 }]
)");
    const auto sweep = [&](const char* masses) {
        return run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out", "--sweep", masses});
    };
    const Ended ended = sweep("m=-1,3,7");
    EXPECT_EQ(ended.code, 9);
    EXPECT_THAT(ended.err, testing::StartsWith("case-000001 m=-1: model.toml:4:"));
    std::istringstream table(read_text(folder / "out/sweep.csv"));
    std::vector<std::string> lines;
    for (std::string line; std::getline(table, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 5u);
    EXPECT_EQ(lines[2], "case-000001,-1,,");
    EXPECT_NEAR(std::stod(lines[3].substr(14)), std::sqrt(1000. / 3) / (2 * M_PI), 1e-6);
    EXPECT_THAT(lines[4], testing::EndsWith(",1"));
    EXPECT_EQ(sweep("m=-1,-2").code, 3);
}

// Oracle: the same frequencies one by one, in any order; and each curve goes its way in small steps: with 32 times the
// stiffness over ten cases none jumps by more than a third.
TEST(ModesSweep, TheHydroplanesCurvesAreItsFrequencies) {
    const TemporaryFolder folder;
    const Ended ended =
        run_dttmm(folder.path(), {"modes", modes_model("hydroplane"), "--sweep", "kh=5MN/m..160MN/m:11", "-o", "out", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::string names, units;
    const auto rows = read_curves(folder / "out/sweep.csv", names, units);
    EXPECT_THAT(names, testing::StartsWith("case,kh,curve1,"));
    ASSERT_EQ(rows.size(), 11u);
    for (size_t c = 0; c < rows.size(); ++c) {
        ASSERT_GE(rows[c].size(), 10u);
        std::vector<double> own;
        for (size_t k = 2; k < rows[c].size(); ++k)
            if (!std::isnan(rows[c][k])) own.push_back(rows[c][k]);
        if (c % 5 == 0)
            expect_frequencies(
                sorted(own),
                frequencies_of(modes_of_file(modes_model("hydroplane"), {"--set", fmt::format("kh={} N/m", rows[c][1])})),
                1e-9);
        for (size_t k = 2; c > 0 && k < rows[c].size(); ++k)
            if (!std::isnan(rows[c][k]) && !std::isnan(rows[c - 1][k])) {
                EXPECT_LT(std::abs(rows[c][k] / rows[c - 1][k] - 1), 0.34) << c << ", " << k;
            }
    }
}

// ---- Shapes of multiple frequencies -------------------------------------------------------------------------------------

/// The elements of a model file the other way round.
std::string with_elements_reversed(const std::string& text) {
    std::vector<std::string> parts;
    size_t begin = text.find("[[element]]");
    const std::string head = text.substr(0, begin);
    while (begin != text.npos) {
        const size_t end = text.find("[[element]]", begin + 1);
        parts.push_back(text.substr(begin, end - begin) + "\n");
        begin = end;
    }
    std::string reversed = head;
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) reversed += *part;
    return reversed;
}

/// Largest difference of two shapes at all places.
double shape_difference(const nlohmann::json& one, const nlohmann::json& other) {
    double largest = 0;
    for (const auto& [place, motion] : one["shape"].items())
        for (size_t d = 0; d < 6; ++d)
            largest = std::max(largest, std::abs(motion[d].get<double>() - other["shape"][place][d].get<double>()));
    return largest;
}

// Oracle: what vibrates at a frequency does not depend on how it is asked for, nor on the order in which the model lists its
// elements; so neither do the shapes listed, two- and five-fold, of a free machine six-fold. They are found to 1e-7.
TEST(ModesCases, ShapesOfMultipleFrequenciesDoNotDependOnTheQuestion) {
    for (const auto& [name, count, below] :
         {std::tuple{"double_cross", "16", "100 Hz"}, std::tuple{"free_tube", "14", "1600 Hz"}}) {
        const std::string text = read_text(modes_model(name));
        const nlohmann::json asked = modes_of(text, {"--count", count});
        for (const nlohmann::json& other :
             {modes_of(text, {"--below", below}), modes_of(with_elements_reversed(text), {"--count", count})}) {
            ASSERT_GE(other["modes"].size(), asked["modes"].size()) << name;
            for (size_t m = 0; m < asked["modes"].size(); ++m)
                EXPECT_LT(shape_difference(asked["modes"][m], other["modes"][m]), 1e-6) << name << ", mode " << m + 1;
        }
    }
}

// Oracle: the tube lies along x: its translations come first, its bending pairs move along y, then along z.
TEST(ModesCases, ShapesOfMultipleFrequenciesLieAlongTheAxes) {
    const nlohmann::json modes = modes_of_file(modes_model("free_tube"), {"--count", "8"});
    for (const auto& [mode, direction] : {std::pair{0u, 0u}, {1u, 1u}, {2u, 2u}, {6u, 1u}, {7u, 2u}})
        for (const auto& [place, motion] : modes["modes"][mode]["shape"].items())
            for (unsigned d = 0; d < 3; ++d) {
                if (d == direction)
                    EXPECT_GT(std::abs(motion[d].get<double>()), 0.1) << mode << place;
                else
                    EXPECT_NEAR(motion[d].get<double>(), 0, 1e-7) << mode << place;
            }
}

// A sweep below a frequency: curves that leave the range leave a gap, others begin.
TEST(ModesSweep, CurvesEndAndBegin) {
    const TemporaryFolder folder;
    write_text(folder / "two.toml", two_masses());
    std::string text = two_masses();
    text.replace(text.find("mass = 3"), 8, "mass = \"=m\"");
    text.replace(text.find("[nodes]"), 0, "[parameters]\nm = 3\n");
    write_text(folder / "m.toml", text);
    const Ended ended =
        run_dttmm(folder.path(), {"modes", "m.toml", "--below", "0.45 Hz", "--sweep", "m=2,3,6,9", "-o", "out", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::string names, units;
    const auto rows = read_curves(folder / "out/sweep.csv", names, units);
    ASSERT_EQ(rows.size(), 4u);
    for (size_t c = 0; c < 4; ++c) {
        const double m = rows[c][1];
        // det [24 − mλ, −12; −12, 12 − 3λ] = 0
        const double b = 24 * 3 + 12 * m, root = std::sqrt(b * b - 4 * 3 * m * 144);
        std::vector<double> expected, own;
        for (const double lambda : {(b - root) / (6 * m), (b + root) / (6 * m)})
            if (std::sqrt(lambda) / (2 * kPi) < 0.45) expected.push_back(std::sqrt(lambda) / (2 * kPi));
        for (size_t k = 2; k < rows[c].size(); ++k)
            if (!std::isnan(rows[c][k])) own.push_back(rows[c][k]);
        expect_frequencies(own, expected, kRounding);
        EXPECT_EQ(rows[c].size(), rows[0].size());
    }
}

// Oracle: dynamic stiffness of a plane truss of bars with axial waves, straight between their pins,
//     D = Σ EA κ cot(κ l) e eᵀ − ω² m l/3 (I − e eᵀ) − ω² m_tip I,   κ = ω √(m/EA):
// it is singular at every frequency; at 0 Hz its inverse is the receptance. Rods of three lengths at angles to the axes.
TEST(Modes, InclinedRodsAreATrussInItsPlane) {
    std::string text = "format = \"dttmm/1\"\ndofs = [\"x\", \"y\"]\n[nodes]\ntip = [1.0, 1.3, 0]\n", elements;
    const Eigen::Vector2d tip(1.0, 1.3), feet[] = {{0, 0}, {2.2, 0.1}, {0.3, -0.9}};
    for (int i = 0; i < 3; ++i) {
        text += fmt::format("w{} = {{ position = [{}, {}, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }}\n", i,
                            feet[i].x(), feet[i].y());
        elements += fmt::format(R"([[element]]
name = "bar{0}"
type = "rod"
from = "{1}"
to = "{2}"
section = {{ EA = 6e7, mass = 2.5 }}
)",
                                i, i == 1 ? "tip" : fmt::format("w{}", i), i == 1 ? "w1" : "tip");
    }
    text += elements + "[[element]]\nname = \"m\"\ntype = \"point_mass\"\nat = \"tip\"\nmass = 50\n";
    const auto stiffness = [&](double omega) {
        Eigen::Matrix2d D = -50 * omega * omega * Eigen::Matrix2d::Identity();
        for (const Eigen::Vector2d& foot : feet) {
            const double l = (tip - foot).norm(), wave = omega * std::sqrt(2.5 / 6e7);
            const Eigen::Vector2d e = (tip - foot) / l;
            const Eigen::Matrix2d along = e * e.transpose();
            D += 6e7 * (omega > 0 ? wave / std::tan(wave * l) : 1 / l) * along -
                 omega * omega * 2.5 * l / 3 * (Eigen::Matrix2d::Identity() - along);
        }
        return D;
    };
    const std::vector<double> found = frequencies_of(modes_of(text, {"--count", "5"}));
    ASSERT_EQ(found.size(), 5u);
    for (const double f : found) {
        const auto sign_at = [&](double share) { return stiffness(2 * kPi * f * share).determinant() > 0; };
        EXPECT_NE(sign_at(1 - 1e-8), sign_at(1 + 1e-8)) << f;
    }
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    for (const auto& [out, expected] :
         {std::pair("tip.x", stiffness(0).inverse()(0, 0)), {"tip.y", stiffness(0).inverse()(1, 0)}}) {
        ASSERT_EQ(run_dttmm(folder.path(), {"frf", "m.toml", "--in", "tip.x", "--out", out, "--from", "0 Hz", "--to", "9 Hz",
                                            "--points", "2", "-o", out})
                      .code,
                  0);
        EXPECT_NEAR(read_history(folder / out / "frf.csv").front()[1], expected, 1e-9 * std::abs(expected));
    }
}

}  // namespace
}  // namespace dttmm::host
