// SPDX-License-Identifier: BSD-3-Clause
//
// Damping of modes and of masses, [damping], against dense equations and closed forms.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>
#include <numbers>
#include <vector>

#include "cli/modes_run.h"
#include "cli/results_table.h"
#include "support/linear_algebra.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;
using Complex = std::complex<double>;
constexpr double kTurn = 2 * std::numbers::pi;

/// Masses in a row along x on springs, one with a damper, and their matrices.
constexpr double kMasses[] = {1.3, 0.7, 2.1, 0.4}, kStiffness[] = {5200, 3100, 8800, 1700}, kDamping = 3.7;

std::string masses_in_a_row(const std::string& damping) {
    std::string text = "format = \"dttmm/1\"\ndofs = [\"x\"]\n[modes]\ncount = 4\n" + damping + "[nodes]\n";
    for (int i = 0; i < 4; ++i) text += fmt::format("n{} = [{}, 0.2, 0]\n", i, 0.3 * i);
    for (int i = 0; i < 4; ++i)
        text +=
            fmt::format(R"([[element]]
name = "m{0}"
type = "point_mass"
at = "n{0}"
mass = {1}
[[element]]
name = "s{0}"
type = "spring_damper"
from = "{2}"
to = "n{0}"
stiffness = [{3}, 0, 0]
damping = [{4}, 0, 0]
)",
                        i, kMasses[i], i == 0 ? "ground" : fmt::format("n{}", i - 1), kStiffness[i], i == 2 ? kDamping : 0);
    return text;
}

struct Matrices {
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero(), C = M, K = M, shapes;
    Eigen::Vector4d omega;

    Matrices() {
        for (int i = 0; i < 4; ++i) {
            M(i, i) = kMasses[i];
            Eigen::Vector4d pull = Eigen::Vector4d::Unit(i);
            if (i > 0) pull(i - 1) = -1;
            K += kStiffness[i] * pull * pull.transpose();
            if (i == 2) C += kDamping * pull * pull.transpose();
        }
        const test::Pencil pencil = test::solve_pencil(K, M);
        omega = pencil.values.cwiseSqrt();
        shapes = pencil.vectors;  // of modal mass 1
    }
    /// C = Σ M φ 2 ζ ω φᵀ M
    void damp(const std::vector<double>& ratios) {
        for (size_t m = 0; m < ratios.size(); ++m) {
            const auto i = static_cast<Eigen::Index>(m);
            const Eigen::Vector4d p = M * shapes.col(i);
            C += 2 * ratios[m] * omega(i) * p * p.transpose();
        }
    }
    Complex receptance(double f, int at, int to) const {
        const Complex s(0, kTurn * f);
        const Eigen::Matrix4cd D = K.cast<Complex>() + s * C + s * s * M;
        return D.inverse()(at, to);
    }
};

/// Damped modes: damped frequency [Hz], |s|/2π, damping ratio, decay rate.
std::vector<std::vector<double>> damped_modes(const std::string& text, std::string* said = nullptr) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "--damped", "-o", "out"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    if (said) *said = ended.out + ended.err;
    return read_history(folder / "out/damped.csv");
}

ResultsTable response(const std::string& text, std::vector<std::string> words, std::string* said = nullptr) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    words.insert(words.begin(), {"response", "model.toml", "-o", "out", "-q"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    if (said) *said = ended.err;
    return ended.code == 0 ? read_table(folder / "out/response.csv") : ResultsTable();
}

void expect_receptances(const ResultsTable& table, const Matrices& exact, double relative) {
    ASSERT_GT(table.rows.size(), 4u);
    for (size_t i = 0; i < table.rows.size(); ++i)
        for (int to = 0; to < 4; ++to) {
            const Complex x = exact.receptance(table.value(i, "frequency"), 1, to);
            EXPECT_LT(std::abs(table.amplitude(i, fmt::format("n{}.position.x", to)) - x), relative * std::abs(x));
        }
}

const std::vector<std::string> kSweep = {"--in", "n1.x", "--from", "0.3Hz", "--to", "29Hz", "--points", "17", "--out", "n*"};

// Oracle: dense equations with C of the damper and of all modes. The frequencies and shapes are those of an eigensolver.
TEST(ModalDamping, OneRatioDampsAllModes) {
    const std::string text = masses_in_a_row("[damping]\nmodal = \"2.5 %\"\n");
    Matrices exact;
    exact.damp({0.025, 0.025, 0.025, 0.025});
    expect_receptances(response(text, kSweep), exact, 1e-8);
}

// Oracle: the same, with the first two modes damped alone. The note says so.
TEST(ModalDamping, AListDampsTheFirstModes) {
    std::string said;
    const std::string text = masses_in_a_row("[damping]\nmodal = [\"4 %\", \"1 %\"]\n");
    Matrices exact;
    exact.damp({0.04, 0.01});
    expect_receptances(response(text, kSweep, &said), exact, 1e-8);
    EXPECT_THAT(said, HasSubstr("the first 2 vibrations only"));
}

// Oracle: closed form. Without other damping the ratios of the modes are those given; a mass rate α gives α/(2ω) more.
TEST(ModalDamping, DampedModesHaveTheRatiosGiven) {
    std::string text = masses_in_a_row("[damping]\nmodal = [0.04, 0.3, 0, 0.02]\nmass_rate = \"1.9 1/s\"\n");
    text.replace(text.find("damping = [3.7"), 14, "damping = [0.0");
    const Matrices exact;
    const auto modes = damped_modes(text);
    ASSERT_EQ(modes.size(), 4u);
    const double given[] = {0.04, 0.3, 0, 0.02};
    for (int m = 0; m < 4; ++m) {
        const double omega = exact.omega(m);
        EXPECT_NEAR(modes[static_cast<size_t>(m)][2], omega / kTurn, 1e-9 * omega);
        EXPECT_NEAR(modes[static_cast<size_t>(m)][3], given[m] + 1.9 / (2 * omega), 1e-9);
    }
}

// Oracle: dense equations. A force in proportion to momentum is C = α M.
TEST(ModalDamping, MassesAreDampedByTheirRate) {
    const std::string text = masses_in_a_row("[damping]\nmass_rate = \"4.2 1/s\"\n");
    Matrices exact;
    exact.C += 4.2 * exact.M;
    expect_receptances(response(text, kSweep), exact, 1e-10);
}

/// A body on three inclined springs, turned in the world, with a beam on it that carries a mass.
std::string block_with_a_mast(const std::string& damping) {
    std::string text = "format = \"dttmm/1\"\n" + damping + R"([[body]]
name = "block"
mass = 12.5
inertia = [0.21, 0.35, 0.28]
center_of_mass = [0.02, -0.01, 0.03]
rotation = { axis = [0.3, 1, -0.4], angle = "35 deg" }
markers.one = [0.2, 0.15, -0.1]
markers.two = [-0.22, 0.14, -0.12]
markers.three = [-0.18, -0.16, -0.09]
markers.top = [0.05, 0.04, 0.2]
[nodes]
tip = [0.31, 0.24, 0.9]
[[element]]
name = "mast"
type = "beam"
from = "block.top"
to = "tip"
section = { tube = ["20 mm", "15 mm"] }
material = { E = "70 GPa", poisson = 0.33, density = "2700 kg/m^3" }
[[element]]
name = "head"
type = "point_mass"
at = "tip"
mass = 0.35
)";
    for (int i = 0; i < 3; ++i)
        text += fmt::format(
            "[[element]]\nname = \"mount{0}\"\ntype = \"spring_damper\"\nfrom = \"block.{1}\"\nto = \"ground\"\n"
            "stiffness = [{2}, {3}, {4}]\nrotational_stiffness = {5}\n",
            i,
            i == 0   ? "one"
            : i == 1 ? "two"
                     : "three",
            41000 + 3000 * i, 52000 - 7000 * i, 90000 + 5000 * i, 30 + 4 * i);
    return text;
}

// Oracle: closed form. Every mode of a machine with bodies and exact beams, as found without damping, has the ratio given;
// damped modes take it to 1e-4 of itself, as the mass of a beam counts at the ends of its pieces.
TEST(ModalDamping, ATurnedBodyAndABeamVibrateWithTheRatioGiven) {
    const auto undamped = frequencies_of(modes_of(block_with_a_mast("[modes]\ncount = 12\n")));
    ASSERT_EQ(undamped.size(), 12u);
    std::string said;
    const auto modes = damped_modes(block_with_a_mast("[modes]\ncount = 9\n[damping]\nmodal = \"3 %\"\n"), &said);
    ASSERT_GE(modes.size(), 9u);  // those up to 2 % beyond the ninth
    EXPECT_THAT(said, HasSubstr("complete: all eigenvalues"));
    for (size_t m = 0; m < modes.size(); ++m) {
        EXPECT_NEAR(modes[m][2], undamped[m], 1e-5 * undamped[m]) << m;
        EXPECT_NEAR(modes[m][3], 0.03, 3e-6) << m;
    }
}

// Oracle: closed form. A free end of a rod: x = Σ F 2/(ρAL) / (ω_n² − ω² + 2 i ζ ω_n ω), ω_n = (2n − 1) π c/(2 L). Modes far
// above count by their stiffness, which is that of the series without damping: tan(κ L)/(EA κ). The waves of the highest
// damped modes have two pieces each, which makes their damping inexact by some percent.
TEST(ModalDamping, ARodFollowsItsModalSeries) {
    constexpr double kEA = 3e6, kPerLength = 0.8, kLength = 1.7, kRatio = 0.03;
    const std::string text = R"(format = "dttmm/1"
dofs = ["x"]
[damping]
modal = "3 %"
[nodes]
wall = { position = [0, 0, 0], fixed = ["x"] }
tip = [1.7, 0, 0]
[[element]]
name = "rod"
type = "rod"
from = "wall"
to = "tip"
section = { EA = 3e6, mass = 0.8 }
)";
    const ResultsTable table =
        response(text, {"--in", "tip.x", "--from", "20Hz", "--to", "900Hz", "--points", "23", "--out", "tip"});
    ASSERT_EQ(table.rows.size(), 23u);
    const double c = std::sqrt(kEA / kPerLength);
    for (size_t i = 0; i < table.rows.size(); ++i) {
        const double omega = kTurn * table.value(i, "frequency"), kappa = omega / c;
        Complex x = std::tan(kappa * kLength) / (kEA * kappa);
        for (int n = 1; n <= 400; ++n) {
            const double own = (2 * n - 1) * std::numbers::pi / 2 * c / kLength, squares = own * own - omega * omega;
            if (own > kTurn * 9000) break;
            x += 2 / (kPerLength * kLength) * (1.0 / Complex(squares, 2 * kRatio * own * omega) - 1 / squares);
        }
        EXPECT_LT(std::abs(table.amplitude(i, "tip.position.x") - x), 1e-4 * std::abs(x) + 1e-4 / (kEA * kappa))
            << omega / kTurn;
    }
}

// Oracle: where the damping is given. Elements have the forces of their own damping only.
TEST(ModalDamping, ItsForcesAreInNoElement) {
    for (const char* damping : {"[damping]\nmodal = \"2 %\"\n", "[damping]\nmass_rate = \"2 1/s\"\n", ""}) {
        const TemporaryFolder folder;
        write_text(folder / "model.toml", masses_in_a_row(damping));
        const Ended ended = run_dttmm(folder.path(), {"response", "model.toml", "--in", "n3.x", "--from", "5Hz", "--to",
                                                      "9Hz", "--points", "3", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        if (*damping == 0) {
            EXPECT_THAT(ended.err, testing::Not(HasSubstr("in no element")));
        } else {
            EXPECT_THAT(ended.err, HasSubstr("act on the masses and are in no element"));
        }
    }
}

/// The row of masses between two feet that move.
std::string row_between_feet(const std::string& damping) {
    std::string text = masses_in_a_row(damping);
    text.replace(
        text.find("n0 = [0, 0.2, 0]"), 16,
        "left = { position = [-0.2, 0.2, 0], fixed = [\"x\"] }\nright = { position = [1.4, 0.2, 0], fixed = [\"x\"] }\n"
        "n0 = [0, 0.2, 0]");
    text.replace(text.find("from = \"ground\""), 15, "from = \"left\"");
    return text +
           "[[element]]\nname = \"last\"\ntype = \"spring_damper\"\nfrom = \"right\"\nto = \"n3\"\n"
           "stiffness = [2600, 0, 0]\ndamping = [0, 0, 0]\n";
}

// Oracle: dense equations: modes damp the motion against the place at rest, M u" + C_e u' + C (u' - u_s') + K u = k s, with
// K u_s = k s. Each foot alone, all modes and the first two.
TEST(ModalDamping, MovingSupportsAreFollowed) {
    for (const auto& [given, ratios] :
         {std::pair("[damping]\nmodal = \"6 %\"\n", std::vector<double>{0.06, 0.06, 0.06, 0.06}),
          {"[damping]\nmodal = [0.2, 0.05]\n", {0.2, 0.05}}}) {
        Matrices exact;
        exact.K(3, 3) += 2600;
        const test::Pencil pencil = test::solve_pencil(exact.K, exact.M);
        exact.omega = pencil.values.cwiseSqrt();
        exact.shapes = pencil.vectors;
        const Eigen::Matrix4d of_elements = exact.C;
        exact.damp(ratios);
        const Eigen::Matrix4d of_modes = exact.C - of_elements;
        for (const auto& [foot, pull] : {std::pair("left.x", Eigen::Vector4d(kStiffness[0] * Eigen::Vector4d::Unit(0))),
                                         {"right.x", Eigen::Vector4d(2600 * Eigen::Vector4d::Unit(3))}}) {
            const ResultsTable table = response(row_between_feet(given), {"--in", foot, "--from", "0Hz", "--to", "29Hz",
                                                                          "--points", "18", "--out", "n*.position"});
            ASSERT_EQ(table.rows.size(), 18u);
            for (size_t i = 0; i < 18; ++i) {
                const Complex w(0, kTurn * table.value(i, "frequency"));
                const Eigen::Matrix4cd D = exact.K.cast<Complex>() + w * exact.C + w * w * exact.M;
                const Eigen::Vector4d at_rest = exact.K.inverse() * pull;
                const Eigen::Vector4cd u = D.inverse() * (pull.cast<Complex>() + w * (of_modes * at_rest));
                for (int to = 0; to < 4; ++to)
                    EXPECT_LT(std::abs(table.amplitude(i, fmt::format("n{}.position.x", to)) - u(to)),
                              1e-8 * std::abs(u(to)))
                        << foot << " " << w.imag() / kTurn;
            }
        }
    }
}

// Oracle: on a foot that moves as a rigid body the machine moves against it as under the load -M a of that foot at rest:
// with exact beams, a turned body and modes damped, u = s + the response to forces on its two masses of which the beam has
// next to none. The beam's own mass is 1e-9 of theirs.
TEST(ModalDamping, ARigidFootIsALoadOfInertia) {
    const std::string base = R"(format = "dttmm/1"
[damping]
modal = "5 %"
[nodes]
foot = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
mid = [0.1, 0.2, 0.5]
tip = [0.3, 0.2, 0.9]
[[element]]
name = "lower"
type = "beam"
from = "foot"
to = "mid"
section = { EA = 4e6, EIy = 900, EIz = 700, GJ = 500, mass = 1e-9, inertia = 1e-12 }
theory = "euler-bernoulli"
[[element]]
name = "upper"
type = "beam"
from = "mid"
to = "tip"
section = { EA = 3e6, EIy = 400, EIz = 600, GJ = 300, mass = 1e-9, inertia = 1e-12 }
theory = "euler-bernoulli"
[[element]]
name = "one"
type = "point_mass"
at = "mid"
mass = 2.1
[[element]]
name = "two"
type = "point_mass"
at = "tip"
mass = 1.4
)";
    const std::vector<std::string> sweep = {"--from", "3Hz",   "--to",         "43Hz",  "--points",
                                            "9",      "--out", "tip.position", "--out", "mid.position"};
    const auto with = [&](std::vector<std::string> inputs) {
        inputs.insert(inputs.end(), sweep.begin(), sweep.end());
        return response(base, inputs);
    };
    const ResultsTable moved = with({"--in", "foot.y"}), loaded = with({"--in", "mid.y", "--in", "tip.y"});
    ASSERT_EQ(moved.rows.size(), 9u);
    for (size_t i = 0; i < 9; ++i) {
        const double w = kTurn * moved.value(i, "frequency");
        for (const char* place : {"mid.position.", "tip.position."})
            for (const char* axis : {"x", "y", "z"}) {
                const std::string name = std::string(place) + axis;
                const Complex relative =
                    w * w * (2.1 * loaded.amplitude(i, name + "/mid.y") + 1.4 * loaded.amplitude(i, name + "/tip.y"));
                const Complex wanted = (*axis == 'y' ? 1.0 : 0.0) + relative;
                EXPECT_LT(std::abs(moved.amplitude(i, name) - wanted), 1e-6 * (1 + std::abs(wanted))) << name << " " << w;
            }
    }
}

/// Fault of a command on a model.
void expect_fault(const std::string& text, const std::vector<std::string>& words, const std::string& message) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 3) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(message));
}

TEST(ModalDamping, WhatIsWrongIsRefused) {
    const std::vector<std::string> damped = {"modes", "model.toml", "--damped"};
    expect_fault(masses_in_a_row("[damping]\nmodal = \"120 %\"\n"), damped, "model.toml:6:9: ");
    expect_fault(masses_in_a_row("[damping]\nmodal = []\n"), damped, "model.toml:6:9: ");
    expect_fault(masses_in_a_row("[damping]\nmodal = [0.1, -0.2]\n"), damped, "model.toml:6:15: ");
    expect_fault(masses_in_a_row("[damping]\nmass_rate = \"-1 1/s\"\n"), damped, "model.toml:6:13: ");
    expect_fault(masses_in_a_row("[damping]\nstiffness_rate = 2\n"), damped, "unknown key");
    expect_fault(masses_in_a_row("[damping]\nmodal = \"1 %\"\n[simulation]\nduration = \"1 s\"\nstep = \"1 ms\"\n"),
                 {"run", "model.toml"}, "[damping] acts in modes --damped, frf and response only");
    // Nothing holds it in y
    std::string shaken = row_between_feet("[damping]\nmodal = \"1 %\"\n");
    shaken.replace(shaken.find("dofs = [\"x\"]"), 12, "dofs = [\"x\", \"y\"]");
    for (size_t at = shaken.find("fixed = [\"x\"]"); at != shaken.npos; at = shaken.find("fixed = [\"x\"]"))
        shaken.replace(at, 13, "fixed = [\"x\", \"y\"]");
    expect_fault(shaken, {"response", "model.toml", "--in", "left.x", "--from", "1Hz", "--to", "9Hz"},
                 "damping of modes is not defined where supports move a machine that they do not hold");
}

}  // namespace
}  // namespace dttmm::host
