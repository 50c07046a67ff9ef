// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "cli/process.h"
#include "cli/results_table.h"

/// Machines in steady vibration that several tests ask `dttmm response` for.
namespace dttmm::host {

using Complex = std::complex<double>;
using Table = ResultsTable;
inline constexpr double kHalfTurn = std::numbers::pi;

class SteadyVibration : public ::testing::Test {
protected:
    Ended ask(const std::string& text, std::vector<std::string> words) {
        write_text(folder_ / "model.toml", text);
        words.insert(words.begin(), {"response", "model.toml", "-o", fmt::format("out{}", ++count_)});
        return run_dttmm(folder_.path(), words);
    }
    Table response(const std::string& text, const std::vector<std::string>& words,
                   const std::string& file = "response.csv") {
        const Ended ended = ask(text, words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        err_ = ended.err;
        if (ended.code != 0) return {};
        return read_table(folder_ / fmt::format("out{}/{}", count_, file));
    }
    Table history(const std::string& text) {
        write_text(folder_ / "model.toml", text);
        const Ended ended = run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "history"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return read_table(folder_ / "history/history.csv");
    }
    std::string fault(const std::string& text, const std::vector<std::string>& words, int code = 3) {
        const Ended ended = ask(text, words);
        EXPECT_EQ(ended.code, code) << ended.err;
        return ended.err;
    }

    const TemporaryFolder folder_;
    int count_ = 0;
    std::string err_;
};

/// One mass along x on a spring with a damper.
inline constexpr double kOwnMass = 2.5, kSpring = 9100, kDamper = 11;
inline const std::string kMassOnSpring = R"(format = "dttmm/1"
dofs = ["x"]
[parameters]
Omega = "300 rpm"
F = "7 N"
[nodes]
m = [0.3, 0, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "m"
stiffness = 9100
damping = 11
[[element]]
name = "mass"
type = "point_mass"
at = "m"
mass = 2.5
[[load]]
on = "m"
direction = [1, 0, 0]
)";

inline Complex receptance(double f) {
    const double w = 2 * kHalfTurn * f;
    return 1.0 / Complex(kSpring - kOwnMass * w * w, kDamper * w);
}

/// A body on four inclined springs, turned in the world, that starts where it is at rest.
inline std::string turned_block(const std::string& loads, double duration, double step) {
    std::string text = fmt::format(R"(format = "dttmm/1"
[parameters]
Omega = "420 rpm"
[simulation]
duration = "{} s"
step = "{} s"
[[body]]
name = "block"
mass = 12.5
inertia = [0.21, 0.35, 0.28]
center_of_mass = [0.02, -0.01, 0.03]
rotation = {{ axis = [0.3, 1, -0.4], angle = "35 deg" }}
markers.one = [0.2, 0.15, -0.1]
markers.two = [-0.22, 0.14, -0.12]
markers.three = [-0.18, -0.16, -0.09]
markers.four = [0.21, -0.13, -0.11]
markers.top = [0.05, 0.04, 0.2]
)",
                                   duration, step);
    const char* marker[] = {"one", "two", "three", "four"};
    for (int i = 0; i < 4; ++i)
        text += fmt::format(R"([[element]]
name = "mount{0}"
type = "spring_damper"
from = "ground"
to = "block.{1}"
axes = {{ axis = [{2}, 1, 0.2], angle = "{3} deg" }}
stiffness = ["{4} N/mm", "21 N/mm", "35 N/mm"]
damping = ["{5} N*s/m", "110 N*s/m", "140 N*s/m"]
)",
                            i + 1, marker[i], 0.3 * i - 0.4, 25 + 13 * i, 18 + 3 * i, 90 + 15 * i);
    return text + loads;
}

/// Amplitude of a channel at w from an instant on, by least squares beside a constant.
inline Complex amplitude_of(const Table& run, const std::string& name, double w, double from) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    const size_t time = run.column("time"), column = run.column(name);
    for (const std::vector<double>& row : run.rows) {
        if (row[time] < from) continue;
        const Eigen::Vector3d base(1, std::cos(w * row[time]), -std::sin(w * row[time]));
        A += base * base.transpose();
        b += base * row[column];
    }
    const Eigen::Vector3d fit = A.ldlt().solve(b);
    return {fit(1), fit(2)};
}

/// A mass on two springs from two feet, a beam from the first foot that carries a mass at its free end, which slides along x
/// in a guide that moves too.
inline std::string on_feet(const std::string& motion1, const std::string& motion2, const std::string& guide) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
duration = "4 s"
step = "0.4 ms"
start = "equilibrium"
[nodes]
foot1 = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"]{} }}
foot2 = {{ position = [0.5, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"]{} }}
tip = {{ position = [0.1, 0.2, 0.7], fixed = ["y", "rx"]{} }}
[[body]]
name = "mass"
mass = 3.1
inertia = [0.02, 0.03, 0.04]
position = [0.25, 0.1, 0.2]
markers.left = [-0.1, 0.02, -0.03]
markers.right = [0.12, -0.03, -0.02]
[[element]]
name = "one"
type = "spring_damper"
from = "foot1"
to = "mass.left"
stiffness = [9e3, 12e3, 15e3]
rotational_stiffness = [40, 50, 60]
damping = [60, 70, 80]
rotational_damping = [0.4, 0.5, 0.6]
[[element]]
name = "two"
type = "spring_damper"
from = "foot2"
to = "mass.right"
stiffness = [8e3, 13e3, 11e3]
damping = [50, 90, 80]
[[element]]
name = "mast"
type = "beam"
from = "foot1"
to = "tip"
section = {{ EA = 2e5, EIy = 60, EIz = 50, GJ = 40, GAy = 1e5, GAz = 1e5, mass = 0.05, inertia = 1e-4 }}
material = {{ stiffness_damping = "6 ms" }}
segments = 4
[[element]]
name = "head"
type = "rigid_body"
at = "tip"
mass = 0.4
inertia = {{ xx = 0.001, yy = 0.002, zz = 0.0015 }}
)",
                       motion1, motion2, guide);
}

}  // namespace dttmm::host
