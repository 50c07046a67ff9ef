// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes --damped` against the quadratic eigenproblem and closed forms.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <sstream>

#include "cli/modes_run.h"
#include "support/linear_algebra.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using DampedRows = std::vector<std::vector<double>>;

/// shapes: along x, of every mode and place.
DampedRows damped_modes(const std::string& text, std::vector<std::string> words, std::string* out = nullptr,
                        std::vector<std::complex<double>>* shapes = nullptr) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    words.insert(words.begin(), {"modes", "model.toml", "--damped", "-o", "out"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    if (ended.code != 0) return {};
    if (out) *out = ended.out + ended.err;
    std::istringstream lines(read_text(folder / "out/damped_shapes.csv"));
    std::string line;
    for (int i = 0; shapes && std::getline(lines, line); ++i) {
        if (i < 2) continue;
        std::istringstream fields(line);
        std::vector<std::string> cells;
        for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
        shapes->emplace_back(std::stod(cells[3]), std::stod(cells[4]));
    }
    return read_history(folder / "out/damped.csv");
}

// Oracle: all eigenvalues of the companion matrix of a random net of masses, springs and dampers along x, some dampers so
// strong that motions decay without vibration. Every one up to the bound is there, and no other.
TEST(DampedModes, ARandomMachineHasTheEigenvaluesOfItsEquations) {
    constexpr int kMasses = 5;
    constexpr double kHighest = 25;  // [Hz]
    std::mt19937 random(11);
    const auto between = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
    for (int machine = 0; machine < 4; ++machine) {
        std::string text = "format = \"dttmm/1\"\ndofs = [\"x\"]\n[nodes]\n";
        Eigen::MatrixXd K = Eigen::MatrixXd::Zero(kMasses, kMasses), C = K, M = K;
        for (int i = 0; i < kMasses; ++i) text += fmt::format("n{} = [{}, 0, 0]\n", i, i);
        for (int i = 0; i < kMasses; ++i) {
            M(i, i) = between(0.5, 3);
            text += fmt::format("[[element]]\nname = \"m{0}\"\ntype = \"point_mass\"\nat = \"n{0}\"\nmass = {1:.17g}\n", i,
                                M(i, i));
        }
        int springs = 0;
        const auto spring = [&](int from, int to, double k, double c) {
            text += fmt::format(
                "[[element]]\nname = \"s{}\"\ntype = \"spring_damper\"\nfrom = \"{}\"\nto = \"n{}\"\nstiffness = "
                "[{:.17g}, 0, 0]\ndamping = [{:.17g}, 0, 0]\n",
                springs++, from < 0 ? "ground" : fmt::format("n{}", from), to, k, c);
            for (const auto& [matrix, value] : {std::pair(&K, k), {&C, c}}) {
                (*matrix)(to, to) += value;
                if (from < 0) continue;
                (*matrix)(from, from) += value;
                (*matrix)(from, to) -= value;
                (*matrix)(to, from) -= value;
            }
        };
        for (int i = 0; i < kMasses; ++i) spring(i - 1, i, between(300, 3000), i == 2 ? between(100, 300) : between(0, 9));
        spring(0, 3, between(300, 3000), between(0, 60));
        spring(-1, 4, between(300, 3000), machine % 2 == 0 ? between(300, 500) : 0);
        Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(2 * kMasses, 2 * kMasses);
        companion.topRightCorner(kMasses, kMasses).setIdentity();
        companion.bottomLeftCorner(kMasses, kMasses) = -M.inverse() * K;
        companion.bottomRightCorner(kMasses, kMasses) = -M.inverse() * C;
        std::vector<std::complex<double>> exact;
        for (const std::complex<double>& s : test::eigenvalues(companion))
            if (s.imag() >= 0 && std::abs(s) <= 2 * M_PI * kHighest) exact.push_back(s);
        std::ranges::sort(exact, {}, [](const auto& s) { return std::abs(s); });
        std::string said;
        std::vector<std::complex<double>> shapes;
        const DampedRows rows = damped_modes(text, {"--below", fmt::format("{} Hz", kHighest)}, &said, &shapes);
        EXPECT_THAT(said, ::testing::HasSubstr("complete: all eigenvalues"));
        ASSERT_EQ(rows.size(), exact.size());
        for (size_t m = 0; m < rows.size(); ++m) {
            EXPECT_NEAR(rows[m][1], exact[m].imag() / (2 * M_PI), 1e-8 * std::abs(exact[m])) << m;
            EXPECT_NEAR(rows[m][4], -exact[m].real(), 1e-8 * std::abs(exact[m])) << m;
            EXPECT_NEAR(rows[m][3], -exact[m].real() / std::abs(exact[m]), 1e-8) << m;
        }
        for (size_t m = 0; m < rows.size(); ++m) {  // and its shape solves the equations
            const std::complex<double> s(-rows[m][4], 2 * M_PI * rows[m][1]);
            Eigen::VectorXcd u(kMasses);
            for (int i = 0; i < kMasses; ++i) u(i) = shapes[m * kMasses + static_cast<size_t>(i)];
            EXPECT_NEAR(u.cwiseAbs().maxCoeff(), 1, 1e-9);
            const Eigen::MatrixXcd A = K.cast<std::complex<double>>() + s * C + s * s * M;
            EXPECT_LT((A * u).norm(), 1e-7 * A.norm()) << m;
        }
        if (machine % 2 == 0) {
            EXPECT_TRUE(std::ranges::any_of(rows, [](const auto& row) { return row[1] == 0 && row[4] > 0; }));
        }
    }
}

// Oracle: closed form. Damping in proportion to stiffness, C = η K, leaves the shapes of a cantilever alone:
// s² + η ω² s + ω² = 0 with its exact frequencies ω. Its waves have these to 1e-7, whatever the pieces it is cut into.
TEST(DampedModes, ACantileverWithDampingLikeItsStiffness) {
    const std::string text = R"(format = "dttmm/1"
[modes]
count = 6
[nodes]
foot = { position = [0.3, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.5, 0.9, 0.4]
[[element]]
name = "beam"
type = "beam"
from = "foot"
to = "tip"
section = { tube = ["30 mm", "22 mm"] }
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3", stiffness_damping = "20 us" }
)";
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "-o", "out", "--damped", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto json = nlohmann::json::parse(ended.out);
    const auto& damped = json["damped"]["modes"];
    EXPECT_TRUE(json["damped"]["is_proved"]);
    std::vector<double> undamped;
    for (const auto& mode : json["modes"])
        for (int k = 0; k < mode["multiplicity"]; ++k) undamped.push_back(mode["frequency_hz"]);
    ASSERT_EQ(damped.size(), json["modes"].size());
    for (size_t m = 0; m < damped.size(); ++m) {
        const double f = json["modes"][m]["frequency_hz"], ratio = 20e-6 * M_PI * f;
        EXPECT_NEAR(damped[m]["frequency_hz"], f, 1e-7 * f);
        EXPECT_NEAR(damped[m]["damping_ratio"], ratio, 1e-7);
        EXPECT_NEAR(damped[m]["damped_frequency_hz"], f * std::sqrt(1 - ratio * ratio), 1e-7 * f);
    }
}

// Oracle: closed form. With one loss factor η everywhere s² = −ω² (1 + iη).
TEST(DampedModes, OneLossFactorLeavesTheShapes) {
    const std::string text = R"(format = "dttmm/1"
dofs = ["x"]
[nodes]
one = [1, 0, 0]
two = [2, 0, 0]
[[element]]
name = "first"
type = "spring_damper"
from = "ground"
to = "one"
stiffness = [900, 0, 0]
loss_factor = 0.2
[[element]]
name = "second"
type = "spring_damper"
from = "one"
to = "two"
stiffness = [500, 0, 0]
loss_factor = 0.2
[[element]]
name = "m1"
type = "point_mass"
at = "one"
mass = 2
[[element]]
name = "m2"
type = "point_mass"
at = "two"
mass = 1.5
)";
    const DampedRows rows = damped_modes(text, {"--below", "20 Hz"});
    Eigen::Matrix2d K, M = Eigen::Vector2d(2, 1.5).asDiagonal();
    K << 1400, -500, -500, 500;
    const test::Pencil exact = test::solve_pencil(K, M);
    ASSERT_EQ(rows.size(), 2u);
    for (int m = 0; m < 2; ++m) {
        const std::complex<double> s =
            std::complex<double>(0, 1) * std::sqrt(exact.values(m) * std::complex<double>(1, 0.2));
        EXPECT_NEAR(rows[static_cast<size_t>(m)][4], -s.real(), 1e-9 * std::abs(s));
        EXPECT_NEAR(rows[static_cast<size_t>(m)][1], s.imag() / (2 * M_PI), 1e-9 * std::abs(s));
    }
}

// Oracle: the proved count without damping, whose frequencies these are. Candidates of the beam's pieces lie beyond them: a
// bound a millionth above a mode has it, one as far below has it not. Double modes of round beams are two.
TEST(DampedModes, TheBoundIsThatOfTheExactModes) {
    const auto text = [](const std::string& more) {
        return R"(format = "dttmm/1"
[nodes]
foot = { position = [0.3, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.5, 0.9, 0.4]
[[element]]
name = "beam"
type = "beam"
from = "foot"
to = "tip"
section = { tube = ["30 mm", "22 mm"] }
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3")" +
               more + " }\n";
    };
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text(""));
    const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "-o", "out", "--count", "14", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto json = nlohmann::json::parse(ended.out);
    const std::vector<double> exact = json["frequencies_hz"];
    for (const size_t last : {1u, 6u, 11u}) {
        for (const double share : {1e-6, -1e-6}) {
            const double below = exact[last] * (1 + share);
            std::string said;
            const DampedRows rows = damped_modes(text(""), {"--below", fmt::format("{:.17g} Hz", below)}, &said);
            EXPECT_EQ(rows.size(), static_cast<size_t>(std::ranges::count_if(exact, [&](double f) { return f <= below; })));
            EXPECT_THAT(said, ::testing::HasSubstr("complete: all eigenvalues"));
            for (size_t m = 0; m < rows.size(); ++m) EXPECT_NEAR(rows[m][1], exact[m], 1e-9 * exact[m]) << m;
        }
    }
}

/// Shapes at all places, of every mode, of unit length; the model's modes must be said to be complete.
std::vector<Eigen::VectorXcd> shapes_of_example(const std::string& example) {
    const TemporaryFolder folder;
    const std::string file = std::string(test::paths::source_dir()) + "/examples/" + example + "/model.toml";
    const Ended ended = run_dttmm(folder.path(), {"modes", file, "--damped", "-o", "out"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, ::testing::HasSubstr("complete: all eigenvalues"));
    std::vector<std::vector<std::complex<double>>> lists;
    std::istringstream lines(read_text(folder / "out/damped_shapes.csv"));
    std::string line;
    for (int i = 0; std::getline(lines, line); ++i) {
        if (i < 2) continue;
        std::istringstream fields(line);
        std::vector<std::string> cells;
        for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
        lists.resize(std::stoul(cells[0]));
        for (size_t c = 3; c < 15; c += 2) lists.back().emplace_back(std::stod(cells[c]), std::stod(cells[c + 1]));
    }
    std::vector<Eigen::VectorXcd> shapes;
    for (const auto& list : lists)
        shapes.push_back(
            Eigen::Map<const Eigen::VectorXcd>(list.data(), static_cast<Eigen::Index>(list.size())).normalized());
    return shapes;
}

// Oracle: the statement itself, which a candidate far from its mode would take away, and shapes: no two are one. Round beams
// have double modes, whose candidates may have one shape; the double cross has the coarsest pieces.
TEST(DampedModes, DoubleModesAndCoarsePiecesAreProved) {
    for (const char* example : {"headstock", "free_tube", "double_cross", "hydroplane", "gun"}) {
        const std::vector<Eigen::VectorXcd> shapes = shapes_of_example(example);
        EXPECT_GT(shapes.size(), 5u);
        for (size_t a = 0; a < shapes.size(); ++a)
            for (size_t b = 0; b < a; ++b) EXPECT_LT(std::abs(shapes[a].dot(shapes[b])), 0.9999) << example << a << " " << b;
    }
}

/// A column between pins that a force presses along an oblique axis; its material has a loss factor.
std::string pressed_column(double share) {
    constexpr double kEI = 40, kLength = 1.3, kEuler = M_PI * M_PI * kEI / (kLength * kLength);
    return fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }}
b = {{ position = [1.3, 0, 0], fixed = ["y", "z", "rx"] }}
[[element]]
name = "column"
type = "beam"
from = "a"
to = "b"
segments = 20
theory = "euler-bernoulli"
section = {{ EA = 1e9, EIy = {0}, EIz = {0}, GJ = 30, mass = 0.7, inertia = 1e-3 }}
material = {{ loss_factor = 0.03 }}
[[load]]
on = "b"
direction = [-1, 0, 0]
force = {1}
)",
                       kEI, share * kEuler);
}

// Oracle: s² = −ω₀² (1 + iη − P/P_cr): the force is not damped. The damping ratio grows from η/2 without bound.
TEST(DampedModes, ALossFactorNearACriticalLoad) {
    const double unloaded = M_PI / (2 * 1.3 * 1.3) * std::sqrt(40 / 0.7);
    for (const char* beams : {"exact", "lumped"})
        for (const double share : {-1.0, 0.3, 0.9, 0.99}) {
            const TemporaryFolder folder;
            write_text(folder / "m.toml", pressed_column(share));
            const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--damped", "--beams", beams, "--below",
                                                          fmt::format("{} Hz", 2 * unloaded), "-o", "out"});
            ASSERT_EQ(ended.code, 0) << ended.err;
            EXPECT_EQ(ended.err.find("damped-not-proved"), std::string::npos);
            const auto damped = read_json(folder / "out/summary.json")["damped"]["modes"];
            ASSERT_EQ(damped.size(), 2u) << share;
            const std::complex<double> s = std::sqrt(-std::complex<double>(1 - share, 0.03));
            for (const auto& mode : damped) {
                EXPECT_NEAR(mode["frequency_hz"].get<double>(), std::abs(s) * unloaded, 3e-3 * std::abs(s) * unloaded);
                EXPECT_NEAR(mode["damping_ratio"].get<double>(), std::abs(s.real()) / std::abs(s), 5e-3);
            }
        }
    const TemporaryFolder folder;
    write_text(folder / "near.toml", pressed_column(0.97));
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", "near.toml", "--damped", "--count", "2"}).err,
                testing::HasSubstr("2 modes vibrate without damping up to"));
    write_text(folder / "beyond.toml", pressed_column(1.1));
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", "beyond.toml", "--damped", "--count", "2"}).err,
                testing::HasSubstr("without damping 2 motions grow, and the list with damping has none"));
}

// Oracle: by hand. A body on a hinge between joints: reactions and free directions cost nothing; a slider with a damper only
// has a rigid-body mode and one that decays, s = −c/m.
TEST(DampedModes, WhatNothingHoldsDecaysOrStays) {
    const std::string text = R"(format = "dttmm/1"
[[body]]
name = "cart"
mass = 4
inertia = [1, 1, 1]
[[body]]
name = "mass"
mass = 1.5
inertia = [1, 1, 1]
position = [1, 0, 0]
[[joint]]
name = "rail"
type = "slider"
between = ["ground", "cart"]
anchor = [0, 0, 0]
axis = [1, 0, 0]
[[joint]]
name = "guide"
type = "slider"
between = ["ground", "mass"]
anchor = [1, 0, 0]
axis = [1, 0, 0]
[[element]]
name = "damper"
type = "spring_damper"
from = "ground"
to = "cart"
damping = [10, 0, 0]
stiffness = [0, 0, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "mass"
damping = [2, 0, 0]
stiffness = [600, 0, 0]
)";
    std::string said;
    const DampedRows rows = damped_modes(text, {"--below", "20 Hz"}, &said);
    ASSERT_EQ(rows.size(), 3u) << said;
    EXPECT_EQ(rows[0][2], 0);
    EXPECT_NEAR(rows[1][4], 2.5, 1e-8);
    EXPECT_EQ(rows[1][1], 0);
    EXPECT_NEAR(rows[2][4], 2 / 3.0, 1e-8);
    EXPECT_NEAR(rows[2][2], 20 / (2 * M_PI), 1e-8);
    std::string free = text;  // the cart rolls on for ever: one rigid-body mode, though s = 0 is a double root
    free.replace(free.find("damping = [10, 0, 0]"), 20, "damping = [0, 0, 0]");
    const DampedRows without = damped_modes(free, {"--below", "20 Hz"}, &said);
    ASSERT_EQ(without.size(), 2u) << said;
    EXPECT_EQ(without[0][2], 0);
    EXPECT_THAT(said, ::testing::HasSubstr("rigid"));
}

}  // namespace
}  // namespace dttmm::host
