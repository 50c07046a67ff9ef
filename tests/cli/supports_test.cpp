// SPDX-License-Identifier: BSD-3-Clause
//
// Fixed nodes that supports move: at rest, in time, and vibrations about the state that they make.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <map>
#include <sstream>

#include "cli/modes_run.h"
#include "cli/process.h"
#include "cli/static_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// Axes of a frame that no axis of the world lies in.
const Eigen::Matrix3d kAxes = Eigen::AngleAxisd(0.83, Vector3d(1, -2, 0.7).normalized()).toRotationMatrix();

std::string list_of(const Vector3d& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z()); }

Vector3d vector_of(std::map<std::string, double>& row, const std::string& name) {
    return {row.at(name + ".x"), row.at(name + ".y"), row.at(name + ".z")};
}

constexpr double kLength = 1.7, kEIy = 310, kEIz = 190;

/// A beam along x of kAxes, clamped at both ends; `motion` is that of its `to` end.
std::string clamped_beam(const std::string& motion) {
    return fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {} }}
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
segments = 7
up = {}
theory = "euler-bernoulli"
section = {{ EA = 4e5, EIy = 310, EIz = 190, GJ = 120, mass = 0.3, inertia = 1e-4 }}
)",
                       list_of(Vector3d(0.3, -0.2, 0.9)), list_of(Vector3d(0.3, -0.2, 0.9) + kLength * kAxes.col(0)), motion,
                       list_of(kAxes.col(2)));
}

std::string motion_of(const Vector3d& shift, const Vector3d& turn) {
    return fmt::format("{{ x = {:.17g}, y = {:.17g}, z = {:.17g}, rx = {:.17g}, ry = {:.17g}, rz = {:.17g} }}", shift.x(),
                       shift.y(), shift.z(), turn.x(), turn.y(), turn.z());
}

// Oracle: slope deflection of a beam clamped at both ends, one of which goes off by (v, w) and turns by (φy, φz) in its
// axes: 12 EI d/L³, 6 EI d/L², 6 EI φ/L², 4 EI φ/L, 2 EI φ/L. The tension of larger motions counts, of smaller ones the
// rounding of places: 2e-7 each.
TEST(Supports, SettlementAndTurnOfAClampedEnd) {
    constexpr double v = 7e-6, w = -3.4e-6, turn_y = 2.7e-6, turn_z = 5.1e-6, L = kLength;
    AtRest rest = rest_of(clamped_beam(motion_of(kAxes * Vector3d(0, v, w), kAxes * Vector3d(0, turn_y, turn_z))));
    const Vector3d force_b(0, 12 * kEIz * v / std::pow(L, 3) - 6 * kEIz * turn_z / (L * L),
                           12 * kEIy * w / std::pow(L, 3) + 6 * kEIy * turn_y / (L * L));
    const Vector3d moment_b(0, 6 * kEIy * w / (L * L) + 4 * kEIy * turn_y / L,
                            -6 * kEIz * v / (L * L) + 4 * kEIz * turn_z / L);
    const Vector3d moment_a(0, 6 * kEIy * w / (L * L) + 2 * kEIy * turn_y / L,
                            -6 * kEIz * v / (L * L) + 2 * kEIz * turn_z / L);
    const auto in_axes = [&](const std::string& name) { return Vector3d(kAxes.transpose() * vector_of(rest.row, name)); };
    const double force = force_b.norm(), moment = moment_a.norm();
    EXPECT_LT((in_axes("b.reaction") - force_b).tail<2>().norm(), 1e-6 * force);
    EXPECT_LT((in_axes("a.reaction") + force_b).tail<2>().norm(), 1e-6 * force);
    EXPECT_LT((in_axes("b.reaction_moment") - moment_b).norm(), 1e-6 * moment);
    EXPECT_LT((in_axes("a.reaction_moment") - moment_a).norm(), 1e-6 * moment);
}

// Oracle: the force that bends a beam on two supports by d at the distances a and b from them, 3 EI (a + b) d/(a² b²).
TEST(Supports, SettlementOfAMiddleSupport) {
    constexpr double a = 1.3, b = 0.8, d = 3e-7, EI = 310;
    AtRest rest = rest_of(fmt::format(R"(format = "dttmm/1"
[nodes]
left = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }}
middle = {{ position = [{}, 0, 0], fixed = ["y", "z"], motion = {{ z = "-0.3 um" }} }}
right = {{ position = [{}, 0, 0], fixed = ["y", "z"] }}
[[element]]
name = "one"
type = "beam"
from = "left"
to = "middle"
segments = 5
theory = "euler-bernoulli"
section = {{ EA = 4e5, EIy = 310, EIz = 190, GJ = 120, mass = 0.3, inertia = 1e-4 }}
[[element]]
name = "two"
type = "beam"
from = "middle"
to = "right"
segments = 3
theory = "euler-bernoulli"
section = {{ EA = 4e5, EIy = 310, EIz = 190, GJ = 120, mass = 0.3, inertia = 1e-4 }}
)",
                                      a, a + b));
    const double exact = 3 * EI * (a + b) * d / (a * a * b * b);
    EXPECT_NEAR(rest.row["middle.reaction.z"], -exact, 1e-9 * exact);
    EXPECT_NEAR(rest.row["left.reaction.z"], -rest.row["middle.reaction.z"] * b / (a + b), 1e-7 * exact);
    EXPECT_NEAR(rest.row["right.reaction.z"], -rest.row["middle.reaction.z"] * a / (a + b), 1e-7 * exact);
    EXPECT_NEAR(rest.row["middle.position.z"], -d, 1e-16);
    EXPECT_EQ(rest.row.count("left.reaction_moment.x"), 1u);
    EXPECT_EQ(rest.row.count("middle.reaction_moment.x"), 0u) << "it is free to turn";
}

// Oracle: a rigid rotation. The tip of a free bar goes round with its root, by any angle, and nothing is strained.
TEST(Supports, AFreeBarGoesRoundWithItsRoot) {
    const Vector3d turn = 2.1 * Vector3d(0.4, -1, 0.55).normalized(), shift(0.7, -3, 1.1), root(0.3, -0.2, 0.9);
    std::string text = clamped_beam(motion_of(shift, turn));
    const std::string fixed = "[\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]";
    text.replace(text.find(fixed), fixed.size(), "[]");
    AtRest rest = rest_of(text);
    const Vector3d from_b = -kLength * kAxes.col(0), b = root - from_b;
    const Vector3d tip = b + shift + Eigen::AngleAxisd(turn.norm(), turn.normalized()) * from_b;
    EXPECT_LT((vector_of(rest.row, "a.position") - tip).norm(), 1e-9);
    EXPECT_LT((vector_of(rest.row, "a.rotation") - turn).norm(), 1e-9);
    EXPECT_LT(vector_of(rest.row, "b.reaction").norm(), 1e-4) << "of EA = 4e5 N";
}

/// A mass on a spring along x of kAxes, whose other end a support moves by X sin(w t).
std::string moved_spring(double h, const std::string& damping) {
    return fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = "2.4 s"
step = {}
[nodes]
base = {{ position = [0.1, 0.2, 0.3], rotation = {{ axis = [1, -2, 0.7], angle = 0.83 }}, fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {{ x = "={:.17g}*0.013*sin(8*t)", y = "={:.17g}*0.013*sin(8*t)", z = "={:.17g}*0.013*sin(8*t)" }} }}
[[body]]
name = "mass"
mass = 4
inertia = [1, 2, 3]
position = [0.1, 0.2, 0.3]
velocity = {}
[[element]]
name = "k"
type = "spring_damper"
from = "base"
to = "mass"
stiffness = [900, 1100, 700]
rotational_stiffness = 10
{}
)toml",
                       h, kAxes(0, 0), kAxes(1, 0), kAxes(2, 0), list_of(0.05 * kAxes.col(0)), damping);
}

struct Errors {
    double position = 0, reaction = 0, residual = 0;
};

// Oracle: x = A sin wt + B sin w0 t, A = X w0²/(w0² − w²), of an undamped mass whose support moves by X sin wt; the support
// pushes with k (X sin wt − x). Newmark's rule makes both right to h².
Errors errors_of(double h) {
    constexpr double k = 900, m = 4, w = 8, X = 0.013, v0 = 0.05;
    const double w0 = std::sqrt(k / m), A = X * w0 * w0 / (w0 * w0 - w * w), B = (v0 - A * w) / w0;
    const TemporaryFolder folder;
    write_text(folder / "model.toml", moved_spring(h, ""));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    std::istringstream lines(read_text(folder / "out/history.csv"));
    std::string names, line;
    std::getline(lines, names);
    std::getline(lines, line);
    Errors errors;
    while (std::getline(lines, line)) {
        std::istringstream all_names(names), numbers(line);
        std::map<std::string, double> row;
        for (std::string name, number; std::getline(all_names, name, ',') && std::getline(numbers, number, ',');)
            row[name] = std::stod(number);
        const double t = row["time"], base = X * std::sin(w * t), x = A * std::sin(w * t) + B * std::sin(w0 * t);
        const Vector3d place = Vector3d(0.1, 0.2, 0.3) + x * kAxes.col(0);
        errors.position = std::max(errors.position, (vector_of(row, "mass.position") - place).norm());
        errors.reaction =
            std::max(errors.reaction, (vector_of(row, "base.reaction") - k * (base - x) * kAxes.col(0)).norm());
        errors.residual = std::max(errors.residual, std::abs(row["energy.residual"]));
    }
    return errors;
}

TEST(Supports, AMassOnAMovingBase) {
    const Errors coarse = errors_of(8e-3), fine = errors_of(4e-3);
    EXPECT_LT(fine.position, 2e-4);
    EXPECT_NEAR(coarse.position / fine.position, 4, 0.1);
    EXPECT_NEAR(coarse.reaction / fine.reaction, 4, 0.1);
    EXPECT_LT(fine.residual, 1e-13) << "[J] of 0.1 J: the work of the support is in the balance";
}

// Oracle: steady motion of a damped mass under a base that moves, x/X = (k + i w c)/(k − m w² + i w c).
TEST(Supports, ADampedMassOnAMovingBase) {
    constexpr double k = 900, m = 4, w = 8, c = 60, X = 0.013;
    std::map<std::string, double> row = final_row(moved_spring(2e-3, "damping = 60"));
    const double t = 2.4;
    const std::complex<double> i(0, 1), ratio = (k + i * w * c) / (k - m * w * w + i * w * c);
    const double x = X * std::imag(ratio * std::exp(i * w * t));
    // exp(−c t/2m) = 1.5e-8 remains of the start; Newmark's rule shifts the rest by (w h)²
    EXPECT_LT((vector_of(row, "mass.position") - Vector3d(0.1, 0.2, 0.3) - x * kAxes.col(0)).norm(), 1e-3 * X);
    const double force = -m * w * w * x;  // what moves the mass comes from the support
    EXPECT_LT((vector_of(row, "base.reaction") - force * kAxes.col(0)).norm(), 1e-3 * m * w * w * X);
}

struct Roller {
    double reaction = 0, residual = 0;
};

// Oracle: a mass of 3 kg that a support moves by X sin wt in z, where a spring of 50 N/m holds it: m z'' + k z.
Roller roller_errors(double h) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = "1 s"
step = {}
[nodes]
n = {{ position = [0.1, 0.2, 0.3], fixed = ["z", "rx", "ry", "rz"], motion = {{ z = "=0.02*sin(9*t)" }} }}
g = {{ position = [0.6, 0.2, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[element]]
name = "m"
type = "point_mass"
at = "n"
mass = 3
[[element]]
name = "s"
type = "spring_damper"
from = "g"
to = "n"
stiffness = [100, 200, 50]
)toml",
                                                  h));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    std::istringstream lines(read_text(folder / "out/history.csv"));
    std::string names, line;
    std::getline(lines, names);
    std::getline(lines, line);
    Roller errors;
    while (std::getline(lines, line)) {
        std::istringstream all_names(names), numbers(line);
        std::map<std::string, double> row;
        for (std::string name, number; std::getline(all_names, name, ',') && std::getline(numbers, number, ',');)
            row[name] = std::stod(number);
        const double z = 0.02 * std::sin(9 * row["time"]);
        errors.reaction = std::max(errors.reaction, std::abs(row["n.reaction.z"] - (50 - 3 * 81) * z));
        errors.residual = std::max(errors.residual, std::abs(row["energy.residual"]));
    }
    return errors;
}

TEST(Supports, AMassThatARollerLifts) {
    const Roller coarse = roller_errors(4e-3), fine = roller_errors(2e-3);
    EXPECT_LT(fine.reaction, 1e-4) << "[N] of 3.9 N";
    EXPECT_GT(coarse.reaction / fine.reaction, 3.8);
    EXPECT_LT(fine.residual, 1e-4) << "[J] of 0.05 J";
    EXPECT_GT(coarse.residual / fine.residual, 3.8);
}

/// A damped bar whose root turns by an angle and rises, slowly, and a mass at its tip that weighs.
const char* const kSlow = R"(format = "dttmm/1"
[simulation]
duration = "7 s"
step = "5 ms"
spectral_radius = 0.8
gravity = [0, 0, -9.81]
[nodes]
root = { position = [0, 0, 0.2], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = { z = { type = "step", to = "70 mm", end = "2 s" }, ry = { type = "step", to = -0.6, end = "2 s" }, rx = { type = "step", to = 0.35, end = "2 s" } } }
tip = [0.9, 0.1, 0.2]
[[element]]
name = "bar"
type = "beam"
from = "root"
to = "tip"
segments = 6
section = { EA = 4e5, EIy = 31, EIz = 19, GJ = 12, GAy = 1e5, GAz = 1e5, mass = 0.3, inertia = 1e-4 }
material = { stiffness_damping = 0.2 }
[[element]]
name = "load"
type = "point_mass"
at = "tip"
mass = 1.9
)";

// Oracle: the equilibrium of the same machine with its support where it ends.
TEST(Supports, ASlowRunEndsWhereStaticIs) {
    AtRest rest = rest_of(kSlow, {"--at", "7 s"});
    std::map<std::string, double> row = final_row(kSlow);
    for (const char* name : {"tip.position", "tip.rotation"})
        EXPECT_LT((vector_of(row, name) - vector_of(rest.row, name)).norm(), 2e-6) << name;
    // Its dampers, 0.2 s times 5e6 N/m, make 1e-3 N of what an iteration leaves of the motion
    for (const char* name : {"root.reaction", "root.reaction_moment"})
        EXPECT_LT((vector_of(row, name) - vector_of(rest.row, name)).norm(), 2e-3) << name;
    EXPECT_NEAR(rest.row["root.reaction.z"], 9.81 * (1.9 + 0.3 * std::sqrt(0.82)), 1e-9) << "the whole weight";
}

// Oracle: a pinned beam under N = EA d/L has (n π/L)² √((EI + N L²/n²π²)/µ)/2π, its mass spread over the longer beam.
TEST(Supports, ATightenedStringRingsHigher) {
    constexpr double L = 1.3, EA = 2e6, EI = 0.4, mass = 0.05, d = 26e-6;
    const std::vector<double> found = frequencies_of(modes_of(R"(format = "dttmm/1"
[nodes]
left = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }
right = { position = [1.3, 0, 0], fixed = ["x", "y", "z"], motion = { x = "26 um" } }
[[element]]
name = "string"
type = "beam"
from = "left"
to = "right"
segments = 5
theory = "euler-bernoulli"
section = { EA = 2e6, EIy = 0.4, EIz = 0.4, GJ = 1e3, mass = 0.05, inertia = 1e-9 }
)",
                                                              {"--count", "6"}));
    ASSERT_EQ(found.size(), 6u);
    for (int n = 1; n <= 3; ++n) {
        const double q = n * M_PI / L, N = EA * d / L;
        const double exact = q * q * std::sqrt((EI + N / (q * q)) / mass) / (2 * M_PI);
        EXPECT_NEAR(found[static_cast<size_t>(2 * n - 2)], exact, 5e-5 * exact) << "the strain is 2e-5";
        EXPECT_NEAR(found[static_cast<size_t>(2 * n - 1)], exact, 5e-5 * exact);
    }
}

/// A body on springs; `more` between it and a support that moves aside.
double residual_beside_a_moving_support(const std::string& more, const char* step) {
    const auto row = final_row(fmt::format(R"(format = "dttmm/1"
[simulation]
duration = 0.2
step = {}
[nodes]
f = {{ position = [0, 0, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {{ x = {{ type = "step", to = 0.3, start = 0, end = 0.12 }} }} }}
[[body]]
name = "n"
mass = 2
inertia = [0.02, 0.03, 0.025]
markers = {{ m = [0.1, 0.2, 0.1] }}
[[element]]
name = "under"
type = "spring_damper"
from = "ground"
to = "n"
stiffness = [8000, 8000, 8000]
rotational_stiffness = [100, 100, 100]
[[element]]
name = "across"
{})",
                                           step, more));
    EXPECT_GT(row.at("energy.work"), 40);
    return row.at("energy.residual") / row.at("energy.work");
}

// Oracle: energy is kept. The axes of these dampers turn with what they join.
TEST(Supports, WorkBesideDampersThatTurnIsOfSecondOrder) {
    for (const char* more : {R"(type = "axial_spring"
from = "f"
to = "n"
stiffness = 5000
damping = 500
)",
                             R"(type = "spring_damper"
from = "n.m"
to = "f"
stiffness = [5000, 4000, 3000]
damping = [300, 200, 100]
)"}) {
        const double coarse = residual_beside_a_moving_support(more, "0.002"),
                     fine = residual_beside_a_moving_support(more, "0.001");
        EXPECT_LT(std::abs(fine), 1e-4) << more;
        EXPECT_NEAR(coarse / fine, 4, 0.5) << more;
    }
}

TEST(Supports, WhatIsRefused) {
    const auto error_of = [](const std::string& text, const char* command) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", text);
        const Ended ended = run_dttmm(folder.path(), {command, "m.toml", "-o", "out"});
        EXPECT_NE(ended.code, 0) << command;
        return ended.err;
    };
    const std::string simulation = "[simulation]\nduration = 0.01\nstep = 1e-3\n";
    EXPECT_THAT(error_of(clamped_beam("{ rz = \"2 deg\" }") + simulation, "run"),
                HasSubstr("node \"b\": motion.rz is 0.0349066 rad at t = 0 s, but the run starts with the node where the "
                          "file places it: let it begin with 0"));
    EXPECT_THAT(error_of(clamped_beam("{ z = \"=1.5e-12+0*t\" }") + simulation, "run"),
                HasSubstr("motion.z is 1.5e-12 m at t = 0 s"));
    {
        const TemporaryFolder folder;  // rounding of an expression is no jump
        write_text(folder / "m.toml", clamped_beam("{ z = \"=0.7e-12+0*t\" }") + simulation);
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "m.toml", "-o", "out"}).code, 0);
    }
    EXPECT_THAT(error_of(clamped_beam("{ z = \"=1e-9/(t-0.004)\" }") + simulation + "start = \"equilibrium\"\n", "run"),
                HasSubstr("node \"b\": motion at t = 0.004 s: its value is"));
    EXPECT_THAT(error_of(clamped_beam("{ z = \"=sqrt(-1-t)\" }"), "static"),
                HasSubstr("node \"b\": motion: z: the value of \"=sqrt(-1-t)\" is not finite at t = 0"));
}

}  // namespace
}  // namespace dttmm::host
