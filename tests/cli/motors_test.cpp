// SPDX-License-Identifier: BSD-3-Clause
//
// Joints whose angle or travel a motor keeps, against closed forms and equivalent models.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "cli/modes_run.h"
#include "cli/results_table.h"

namespace dttmm::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

class Motors : public ::testing::Test {
protected:
    Ended ask(const std::string& text, std::vector<std::string> words) {
        write_text(folder_ / "model.toml", text);
        words.insert(words.begin() + 1, {"model.toml", "-o", "out"});
        return run_dttmm(folder_.path(), words);
    }
    ResultsTable history(const std::string& text) {
        const Ended ended = ask(text, {"run", "-q"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.code == 0 ? read_table(folder_ / "out/history.csv") : ResultsTable();
    }
    void expect_fault(const std::string& text, const std::string& message, const std::string& command = "run") {
        const Ended ended = ask(text, {command});
        EXPECT_EQ(ended.code, 3) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(message));
    }
    const TemporaryFolder folder_;
};

/// A body with its centre of mass beside a skew axis, which a motor turns faster and faster.
std::string eccentric(double step) {
    return fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = "1.6 s"
step = {}
gravity = [1.3, -2.1, -9.2]
[output]
step = "40 ms"
[[body]]
name = "rotor"
mass = 2.7
inertia = [0.031, 0.052, 0.044]
position = [0.3, -0.2, 0.5]
rotation = {{ axis = [1, 2, -0.5], angle = "40 deg" }}
center_of_mass = [0.04, 0.01, -0.02]
[[joint]]
name = "motor"
type = "hinge"
between = ["ground", "rotor"]
anchor = [0.25, -0.15, 0.62]
axis = [0.4, -0.3, 0.8]
angle = "=2.5*t^2 + 0.4*(1 - cos(9*t))"
)toml",
                       step);
}

// Oracle: closed form. With r from the anchor to the centre of mass, θ = 5/2 t² + 0.4 (1 − cos 9t), ω = θ' n: the force on
// the body is m (θ'' n × r + ω × (ω × r) − g), the moment about the anchor d(I ω)/dt − r × m g. The first body is the
// ground, which gets the opposite. Errors fall fourfold as the step is halved, and so does what the energy lacks.
TEST_F(Motors, TurnAnEccentricBodyAboutASkewAxis) {
    const Vector3d n = Vector3d(0.4, -0.3, 0.8).normalized(), g(1.3, -2.1, -9.2);
    const double mass = 2.7;
    const Matrix3d R0 = Eigen::AngleAxisd(40 * M_PI / 180, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
    const Vector3d r0 = Vector3d(0.3, -0.2, 0.5) + R0 * Vector3d(0.04, 0.01, -0.02) - Vector3d(0.25, -0.15, 0.62);
    const Matrix3d I0 = R0 * Vector3d(0.031, 0.052, 0.044).asDiagonal() * R0.transpose() +
                        mass * (r0.squaredNorm() * Matrix3d::Identity() - r0 * r0.transpose());
    double error[2], lacking[2];
    for (int k = 0; k < 2; ++k) {
        const ResultsTable table = history(eccentric(k == 0 ? 0.001 : 0.0005));
        ASSERT_EQ(table.rows.size(), 41u);
        error[k] = lacking[k] = 0;
        for (size_t i = 0; i < table.rows.size(); ++i) {
            const double t = table.value(i, "time"), theta = 2.5 * t * t + 0.4 * (1 - std::cos(9 * t));
            const double rate = 5 * t + 3.6 * std::sin(9 * t), second = 5 + 32.4 * std::cos(9 * t);
            const Matrix3d R = Eigen::AngleAxisd(theta, n).toRotationMatrix();
            const Vector3d r = R * r0, w = rate * n;
            const Matrix3d I = R * I0 * R.transpose();
            const Vector3d force = mass * (second * n.cross(r) + w.cross(w.cross(r)) - g);
            const Vector3d moment = I * second * n + w.cross(I * w) - r.cross(mass * g);
            const Vector3d found(table.value(i, "motor.force.x"), table.value(i, "motor.force.y"),
                                 table.value(i, "motor.force.z"));
            const Vector3d turned(table.value(i, "motor.moment.x"), table.value(i, "motor.moment.y"),
                                  table.value(i, "motor.moment.z"));
            EXPECT_NEAR(std::remainder(table.value(i, "motor.angle") - theta, 2 * M_PI), 0, 1e-11);
            error[k] = std::max({error[k], (found + force).norm() / 60, (turned + moment).norm() / 4});
            lacking[k] = std::max(lacking[k], std::abs(table.value(i, "energy.residual")));
        }
    }
    EXPECT_LT(error[0], 2e-4);
    EXPECT_NEAR(error[0] / error[1], 4, 0.4);
    EXPECT_LT(lacking[0], 1e-3);
    EXPECT_GT(lacking[0] / lacking[1], 3.5);
}

/// A mass on a spring and damper, on a table that moves along a skew direction.
std::string shaken(bool by_motor) {
    const std::string motion = R"({ type = "haversine", peak = "3 mm", start = "5 ms", width = "60 ms" })";
    std::string text = R"(format = "dttmm/1"
[simulation]
duration = "0.2 s"
step = "0.5 ms"
[output]
step = "2 ms"
[[body]]
name = "part"
mass = 3.1
inertia = [0.02, 0.03, 0.025]
position = [0.2, 0.1, 0]
[[element]]
name = "mount"
type = "spring_damper"
from = ")" + std::string(by_motor ? "table.top" : "foot") +
                       R"("
to = "part"
stiffness = [12e3, 15e3, 21e3]
damping = [9, 12, 20]
rotational_stiffness = 40
)";
    if (!by_motor)
        return text +
               "[nodes]\nfoot = { position = [0.2, 0.1, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"], motion = "
               "{ x = " +
               motion + " } }\n";
    return text + R"([[body]]
name = "table"
mass = 11
inertia = [0.5, 0.4, 0.6]
position = [0.1, -0.2, -0.3]
markers.top = [0.1, 0.3, 0.3]
[[joint]]
name = "shaker"
type = "slider"
between = ["table", "ground"]
axis = [-1, 0, 0]
travel = )" +
           motion + "\n";
}

// Oracle: an equivalent model. The foot of the mount is a support that moves as the table does. Positions are those of the
// same discrete equations. Dampers have the velocity of the instant on a support, and the mean of two steps on a motor.
TEST_F(Motors, ATableOnASliderShakesLikeASupport) {
    const ResultsTable motor = history(shaken(true)), support = history(shaken(false));
    ASSERT_EQ(motor.rows.size(), 101u);
    ASSERT_EQ(support.rows.size(), 101u);
    double largest = 0;
    for (size_t i = 0; i < support.rows.size(); ++i)
        largest = std::max(largest, std::abs(support.value(i, "mount.force.x")));
    EXPECT_GT(largest, 10);
    for (size_t i = 0; i < motor.rows.size(); ++i) {
        EXPECT_NEAR(motor.value(i, "part.position.x"), support.value(i, "part.position.x"), 1e-11) << i;
        EXPECT_NEAR(motor.value(i, "mount.force.x"), support.value(i, "mount.force.x"), 2e-5 * largest) << i;
    }
}

// Oracle: the modes of the part on a fixed table: √(k/m).
TEST_F(Motors, HoldTheirJointInModes) {
    std::string text = shaken(true);
    text.replace(text.find("[simulation]"), 12, "dofs = [\"x\"]\n[modes]\ncount = 3\n[simulation]");
    const auto frequencies = frequencies_of(modes_of(text));
    ASSERT_EQ(frequencies.size(), 1u);
    EXPECT_NEAR(frequencies[0], std::sqrt(12e3 / 3.1) / (2 * M_PI), 1e-9 * frequencies[0]);
}

/// A lever that a motor holds at an angle against its weight.
const std::string kLever = R"(format = "dttmm/1"
[simulation]
duration = "50 ms"
step = "1 ms"
gravity = [0, 0, -9.81]
start = "equilibrium"
[[body]]
name = "lever"
mass = 3
inertia = [0.01, 0.2, 0.2]
position = [0.4, 0, 0]
[[joint]]
name = "motor"
type = "hinge"
between = ["lever", "ground"]
anchor = [0, 0, 0]
axis = [0, 1, 0]
angle = "30 deg"
)";

// Oracle: statics. The angle of the ground seen from the lever is 30 degrees, so the lever has gone up; its motor carries
// m g a cos 30°. A run that starts there stays.
TEST_F(Motors, HoldAWeight) {
    const Ended ended = ask(kLever, {"static", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const ResultsTable rest = read_table(folder_ / "out/static.csv");
    EXPECT_NEAR(rest.value(0, "motor.angle"), M_PI / 6, 1e-10);
    EXPECT_NEAR(rest.value(0, "lever.position.z"), 0.4 * std::sin(M_PI / 6), 1e-9);
    EXPECT_NEAR(std::abs(rest.value(0, "motor.moment.y")), 3 * 9.81 * 0.4 * std::cos(M_PI / 6), 1e-7);
    const ResultsTable table = history(kLever);
    ASSERT_EQ(table.rows.size(), 51u);
    for (size_t i = 0; i < table.rows.size(); ++i) {
        EXPECT_NEAR(table.value(i, "lever.position.z"), 0.4 * std::sin(M_PI / 6), 1e-9);
        EXPECT_NEAR(table.value(i, "motor.moment.y"), rest.value(0, "motor.moment.y"), 1e-6);
    }
}

// One whose angle grows as t^3 begins at rest; the differences of the first step leave 1.9e-6 of its speed.
TEST_F(Motors, BeginAtRestAsACube) {
    std::string rotor = eccentric(0.001);
    const std::string angle = "\"=2.5*t^2 + 0.4*(1 - cos(9*t))\"";
    rotor.replace(rotor.find(angle), angle.size(), "\"=2.5*t^2*sin(2*t)\"");
    const Ended ended = ask(rotor, {"run", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    // A rate of 3e-6 of the speed over the first step of 1 ms is no rest
    const std::string cube = "=2.5*t^2*sin(2*t)";
    rotor.replace(rotor.find(cube), cube.size(), "=2.5*t^2 + 3e-6*2.5e-3*t");
    EXPECT_EQ(ask(rotor, {"run", "-q"}).code, 3);
}

// Oracle: the derivative of 1 - cos(w t) at t = 0 is zero. Differences over short steps have its rounding.
TEST_F(Motors, BeginAtRestByAnExpressionThatRounds) {
    for (const double w : {0.2, 1.0, 2.0, 6.28, 20.0})
        for (const double h : {1e-3, 2e-4, 2e-5, 2e-6}) {
            std::string rotor = eccentric(h);
            const std::string angle = "\"=2.5*t^2 + 0.4*(1 - cos(9*t))\"";
            rotor.replace(rotor.find(angle), angle.size(), fmt::format("\"=0.5*(1 - cos({}*t))\"", w));
            const std::string five = fmt::format("{} s", 5 * h);
            EXPECT_EQ(ask(rotor, {"run", "-q", "--duration", five, "--output-step", five}).code, 0) << w << ' ' << h;
            // What turns at 1e-5 rad/s does not begin at rest
            rotor.replace(rotor.find("*t))"), 4, "*t)) + 1e-5*t");
            EXPECT_EQ(ask(rotor, {"run", "-q", "--duration", five, "--output-step", five}).code, 3) << w << ' ' << h;
        }
}

// Oracle: the speed itself. Over a first step of h 1e-12 rad/h counts as rounding of a motor's values.
TEST_F(Motors, ASpeedBeyondRoundingIsNoRest) {
    constexpr double kStep = 2e-4;
    for (const auto& [angle, code] : {std::pair(0.6e-12, 0), {1.5e-12, 3}}) {
        std::string rotor = eccentric(kStep);
        const std::string given = "\"=2.5*t^2 + 0.4*(1 - cos(9*t))\"";
        rotor.replace(rotor.find(given), given.size(), fmt::format("\"=0.5*t^2 + {}*t\"", angle / kStep));
        EXPECT_EQ(ask(rotor, {"run", "-q", "--duration", "0.001 s", "--output-step", "0.001 s"}).code, code) << angle;
    }
}

// Oracle: a speed that moves a joint by less than its place rounds over a step does not open it.
TEST_F(Motors, VelocitiesOfRoundingOpenNoJoint) {
    const std::string pair = R"(format = "dttmm/1"
[simulation]
duration = 0.001
step = 0.0002
[[body]]
name = "one"
mass = 5
inertia = [0.2, 0.3, 0.4]
position = [1.2, 0.3, -0.4]
velocity = [V, 3e-14, -1e-14]
[[body]]
name = "two"
mass = 3
inertia = [0.1, 0.2, 0.2]
position = [1.9, 0.1, -0.2]
[[joint]]
name = "weld"
type = "fixed"
between = ["one", "two"]
)";
    for (const auto& [speed, code] : {std::pair("2e-14", 0), {"1e-10", 3}}) {
        std::string text = pair;
        text.replace(text.find('V'), 1, speed);
        EXPECT_EQ(ask(text, {"run", "-q"}).code, code) << speed;
    }
}

TEST_F(Motors, WhatIsWrongIsRefused) {
    const auto with = [](std::string text, const std::string& what, const std::string& instead) {
        return text.replace(text.find(what), what.size(), instead);
    };
    const std::string rotor = eccentric(0.001);
    expect_fault(with(rotor, "angle = \"=2.5", "travel = \"=2.5"), "a hinge joint has no travel; it belongs to a slider");
    expect_fault(with(shaken(true), "travel =", "angle ="), "a slider joint has no angle; it belongs to a hinge");
    expect_fault(with(rotor, "(9*t))\"", "(9*t))\"\nlimits = [-1, 1]"), "angle and limits exclude each other");
    expect_fault(with(rotor, "=2.5*t^2", "=1 + 2.5*t^2"), "model.toml:21:9: joint \"motor\": its angle is 1 rad at t = 0 s");
    expect_fault(with(rotor, "=2.5*t^2", "=4*t"), "or let its motor begin at rest");
    expect_fault(with(kLever, "\"30 deg\"", "\"=0.5 + t\""), "moves at 1 rad/s at t = 0 s, but start = \"equilibrium\"");
    expect_fault(with(rotor, "\"=2.5*t^2 + 0.4*(1 - cos(9*t))\"", "\"3 m\""), "model.toml:21:9: ");
    const Ended broken = ask(with(rotor, "=2.5*t^2", "=2.5*t^2 + 0*sqrt(0.5-t)"), {"run"});
    EXPECT_EQ(broken.code, 4) << broken.err;
    EXPECT_THAT(broken.err, HasSubstr("joint \"motor\": its angle at t = 0.501 s is"));
}

}  // namespace
}  // namespace dttmm::host
