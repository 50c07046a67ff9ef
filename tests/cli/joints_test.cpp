// SPDX-License-Identifier: BSD-3-Clause
//
// Ideal joints, as a user models them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "cli/process.h"
#include "cli/small_model.h"
#include "cli/static_run.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A lever on a hinge with stops, held by a spring, pulled up by a constant force until it lies on its upper stop.
const std::string kLever = R"(format = "dttmm/1"
title = "lever"

[simulation]
duration = "0.5 s"
step = "1 ms"

[[body]]
name = "lever"
mass = "3 kg"
inertia = [0.01, 0.2, 0.2]
position = ["0.4 m", 0, 0]
markers.end = ["0.4 m", 0, 0]

[[joint]]
name = "pin"
type = "hinge"
between = ["ground", "lever"]
anchor = [0, 0, 0]
axis = [0, -1, 0]
limits = ["-1 deg", "2 deg"]

[[load]]
on = "lever"
direction = [0, 0, 1]
force = "120 N"

[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "lever.end"
stiffness = [0, 0, "1 N/mm"]
damping = [0, 0, "20 N*s/m"]
)";

class JointsOfAUser : public testing::Test {
protected:
    Ended run(const std::string& model, std::vector<std::string> words = {}) {
        write_text(folder_ / "model.toml", model);
        words.insert(words.begin(), {"run", "model.toml", "-o", "out"});
        return run_dttmm(folder_.path(), words);
    }
    static std::string with(std::string model, const std::string& what, const std::string& instead) {
        return model.replace(model.find(what), what.size(), instead);
    }
    const TemporaryFolder folder_;
};

// Oracle: statics on the stop. The spring, 0.8 m from the pin, is stretched by 0.8 sin 2 deg and pulls with 1 N/mm times
// that; load and spring are vertical, so the pin carries the rest: its force on the ground, in tension, is load − spring
// upwards.
TEST_F(JointsOfAUser, ForcesAngleAndStopsAreReported) {
    const Ended ended = run(kLever);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("element, joint"), HasSubstr("pin")));
    const auto summary = read_json(folder_ / "out/summary.json");
    const double spring = 1000 * 0.8 * std::sin(2 * M_PI / 180);
    EXPECT_NEAR(summary["elements"]["spring"]["force"]["z"]["final"].get<double>(), spring, 1e-6);
    EXPECT_NEAR(summary["joints"]["pin"]["force"]["z"]["final"].get<double>(), 120 - spring, 1e-5);
    EXPECT_FALSE(summary["elements"].contains("pin"));
    EXPECT_NEAR(summary["joints"]["pin"]["angle"]["final"].get<double>(), 2 * M_PI / 180, 1e-11);
    EXPECT_EQ(summary["model"]["joints"]["pin"]["type"], "hinge");
    EXPECT_LT(summary["coupling"]["passes_per_step"].get<double>(), 5);
    std::ifstream history(folder_ / "out/history.csv");
    std::string names;
    std::getline(history, names);
    EXPECT_THAT(names,
                AllOf(HasSubstr(",pin.force.x,pin.force.y,pin.force.z,pin.moment.x,pin.moment.y,pin.moment.z,pin.angle,")));
}

TEST_F(JointsOfAUser, CheckCountsTheirEquations) {
    write_text(folder_ / "model.toml", kLever);
    const Ended ended = run_dttmm(folder_.path(), {"check", "model.toml"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.out, HasSubstr("1 joint (5 equations)"));
}

TEST_F(JointsOfAUser, VelocitiesThatOpenAJointAreFaultsOfTheModel) {
    const Ended ended = run(with(kLever, "markers.end", "velocity = [0, 0.3, 0]\nmarkers.end"));
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("model.toml:16:1: joint \"pin\""), HasSubstr("0.3 m/s")));
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

// A motion that no step of this size can follow ends the run in order: code 4, the time, the body, what to do; the rows
// stay.
TEST_F(JointsOfAUser, AMotionTooFastForTheStepEndsInOrder) {
    const std::string model = with(with(kLever, "120 N", "3e6 N"), "limits = [\"-1 deg\", \"2 deg\"]\n", "");
    const Ended ended = run(model);
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("body \"lever\""), HasSubstr("t = 0.0"), HasSubstr("rows recorded")));
    for (const auto& row : read_history(folder_ / "out/history.csv"))
        for (const double value : row) EXPECT_TRUE(std::isfinite(value));
}

// The same where the end of a step is not found: the message says what the body hangs on.
TEST_F(JointsOfAUser, AStepThatIsNotFoundNamesWhatHoldsTheBody) {
    const std::string model =
        with(with(kLever, "markers.end", "velocity = [0, 0, 480]\nangular_velocity = [0, -1200, 0]\nmarkers.end"),
             "limits = [\"-1 deg\", \"2 deg\"]\n", "");
    const Ended ended = run(model);
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err, HasSubstr("body \"lever\" on joint \"pin\"; try a smaller step"));
}

// At rest on its joint nothing turns energy over; rounding is no reason to warn. Nor is the row of an impact on a stop,
// where the ledger stands between before and after.
TEST_F(JointsOfAUser, NeitherRestNorImpactIsAFaultOfTheEnergyBalance) {
    std::string rest = with(with(kLever, "limits = [\"-1 deg\", \"2 deg\"]\n", ""), "axis = [0, -1, 0]\n", "");
    rest = with(with(rest, "\"hinge\"", "\"fixed\""), "\"120 N\"", "0");
    const Ended at_rest = run(with(rest, "step = \"1 ms\"", "step = \"1 ms\"\ngravity = [0, 0, -9.81]"));
    EXPECT_EQ(at_rest.code, 0);
    EXPECT_EQ(at_rest.err, "");
    const Ended impact = run(with(kLever, "\"120 N\"", "\"300 N\""));
    EXPECT_EQ(impact.code, 0);
    EXPECT_EQ(impact.err, "");
}

// ---- Singular positions --------------------------------------------------------------------------------------------------

/// A parallelogram on two cranks of 1 m that falls from upright; its bars lie in one line at 0.712 s, where it could go on
/// in two ways.
constexpr const char* kParallelogram = R"(format = "dttmm/1"
[simulation]
duration = "3 s"
step = "1 ms"
gravity = [0, -9.81, 0]
[[body]]
name = "left"
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [0, 0.5, 0]
angular_velocity = [0, 0, -1]
velocity = [0.5, 0, 0]
[[body]]
name = "right"
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [2, 0.5, 0]
angular_velocity = [0, 0, -1]
velocity = [0.5, 0, 0]
[[body]]
name = "coupler"
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [1, 1, 0]
velocity = [1, 0, 0]
[[joint]]
name = "a"
type = "hinge"
between = ["ground", "left"]
anchor = [0, 0, 0]
axis = [0, 0, 1]
[[joint]]
name = "b"
type = "hinge"
between = ["left", "coupler"]
anchor = [0, 1, 0]
axis = [0, 0, 1]
[[joint]]
name = "c"
type = "hinge"
between = ["coupler", "right"]
anchor = [2, 1, 0]
axis = [0, 0, 1]
[[joint]]
name = "d"
type = "hinge"
between = ["ground", "right"]
anchor = [2, 0, 0]
axis = [0, 0, 1]
)";

/// A carriage on a rail that goes to its stop, with a load on a spring.
std::string slider_on_its_stop(const char* anchor, const char* step) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [10, -2.9, -3.6]
duration = 0.5
step = {}
[[body]]
name = "carriage"
mass = 1.08
inertia = [0.01, 0.01, 0.01]
markers = {{ k = [-0.09, -0.12, 0.06] }}
[[body]]
name = "load"
mass = 0.3
inertia = [0.01, 0.01, 0.01]
position = [0.005, -0.19, 0.16]
[[joint]]
name = "rail"
type = "slider"
between = ["ground", "carriage"]
anchor = {}
axis = [-0.33, 0.92, 0.18]
limits = [-0.043, 0.096]
[[element]]
name = "spring"
type = "spring_damper"
from = "carriage.k"
to = "load"
stiffness = [5000, 5000, 5000]
)",
                       step, anchor);
}

// Oracle: where along a rail its anchor lies is of no account. ODE's speeds hang on it in the ninth digit, so that they do
// not tell whether a stop has pushed when it is about to let go.
TEST(Joints, AStopBesideTheBodysCentreLetsGoAlike) {
    for (const char* step : {"0.0005", "0.00025", "0.0001"}) {
        const auto centred = final_row(slider_on_its_stop("[0, 0, 0]", step)),
                   aside = final_row(slider_on_its_stop("[-0.16, 0.25, 0.18]", step));
        ASSERT_FALSE(centred.empty());
        for (const auto& [channel, value] : centred) {
            if (channel.find("position") == std::string::npos) continue;
            EXPECT_NEAR(aside.at(channel), value, 1e-9) << channel << " " << step;
        }
    }
}

// Oracle: the same machine without the pendulum, at a tenth of the step. Rows have mean velocities of bodies where a joint
// turns; what a beam's damping makes of them must be of the same kind.
TEST(Joints, AHingeElsewhereLeavesTheForcesOfADampedBeam) {
    const TemporaryFolder folder;
    const auto largest_of = [&](const std::string& joints, const char* step) {
        write_text(folder / "model.toml", R"(format = "dttmm/1"
[simulation]
duration = 0.2
[output]
channels = ["arm.force", "b.acceleration"]
[nodes]
tip = [0.3, 0, 0]
[[body]]
name = "b"
mass = 3
inertia = [0.02, 0.03, 0.025]
[[element]]
name = "m"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 1e5
damping = 200
rotational_stiffness = 500
rotational_damping = 2
[[element]]
name = "arm"
type = "beam"
from = "b"
to = "tip"
segments = 2
section = { rectangle = [0.02, 0.03] }
material = { E = 200e9, poisson = 0.3, density = 7800, stiffness_damping = "0.5 ms" }
[[element]]
name = "weight"
type = "point_mass"
at = "tip"
mass = 0.5
[[load]]
on = "b"
direction = [1, 0, 0]
force = { type = "haversine", peak = "10 N", start = 0, width = "30 ms" }
)" + joints);
        const Ended ended =
            run_dttmm(folder.path(), {"run", "model.toml", "--step", step, "--output-step", "1 ms", "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        std::pair<double, double> most;
        for (const std::vector<double>& row : read_history(folder / "out/history.csv")) {
            most.first = std::max(most.first, std::abs(row[1]));
            most.second = std::max(most.second, std::abs(row[4]));
        }
        return most;
    };
    const std::string body = "[[body]]\nname = \"p\"\nmass = 1\ninertia = [0.01, 0.01, 0.01]\nposition = [5, 0, -0.3]\n";
    const auto [force, acceleration] = largest_of("", "0.05 ms");
    for (const char* joint : {"type = \"hinge\"\naxis = [0, 1, 0]", "type = \"ball\"",
                              "type = \"slider\"\naxis = [0, 1, 0]\nlimits = [-1, 1]"}) {
        const auto found = largest_of(
            body + "[[joint]]\nname = \"pin\"\nbetween = [\"ground\", \"p\"]\n" + "anchor = [5, 0, 0]\n" + joint + "\n",
            "0.5 ms");
        EXPECT_NEAR(found.first, force, 0.02 * force) << joint;
        EXPECT_NEAR(found.second, acceleration, 0.02 * acceleration) << joint;
    }
}

// The warning says at what time equations were let go: the closed form has the bars in one line at 0.712 s.
TEST(Joints, ASingularPositionIsPassedWithAWord) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", kParallelogram);
    for (const auto& [step, h] : {std::pair{"5 ms", 5e-3}, {"1 ms", 1e-3}}) {
        const Ended ended = run_dttmm(folder.path(), {"run", "m.toml", "--step", step, "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.err, AllOf(HasSubstr("warning: a linkage passes singular positions"), HasSubstr("joint \"")));
        const size_t at = ended.err.find("t = ");
        ASSERT_NE(at, std::string::npos);
        EXPECT_NEAR(std::stod(ended.err.substr(at + 4)), 0.712 - h, 1.5 * h);  // from the step before on
        EXPECT_EQ(read_json(folder / "out/summary.json")["warnings"][0]["code"], "singular-position");
    }
}

// Two carriages on a rail: the first strikes its stop, and the second one soon draws it off. Oracle: momentum, 1.685 m/s.
TEST(Joints, ImpactsThatTheStepDoesNotPartAreTold) {
    const TemporaryFolder folder;
    const double later = 0.7e-3, first = 0.0104, stop = first - 10 * first * first,
                 reach = 3 * (first + later) + stop - 10 * later * later;
    std::string text = "format = \"dttmm/1\"\n[simulation]\nduration = \"20 ms\"\n";
    for (int i = 0; i < 2; ++i)
        text += fmt::format(
            "[[body]]\nname = \"c{0}\"\nmass = 1\ninertia = [0.1, 0.1, 0.1]\nposition = [{1}, 0, 0]\nvelocity = [{2}, 0, "
            "0]\n"
            "[[joint]]\nname = \"s{0}\"\ntype = \"slider\"\nbetween = [\"{3}\", \"c{0}\"]\nanchor = [{1}, 0, 0]\n"
            "axis = [1, 0, 0]\nlimits = [{4}, {5}]\n",
            i, 0.5 * i, i == 0 ? -1 : 3, i == 0 ? "ground" : "c0", i == 0 ? -stop : -0.3, i == 0 ? 0.5 : reach);
    write_text(folder / "m.toml", text + "[[load]]\non = \"c0\"\ndirection = [1, 0, 0]\nforce = 20\n");
    const auto run = [&](const char* step) {
        return run_dttmm(folder.path(), {"run", "m.toml", "--step", step, "-q", "-o", "out"});
    };
    const Ended coarse = run("1 ms"), fine = run("0.1 ms");
    EXPECT_EQ(coarse.code, 0) << coarse.err;
    EXPECT_THAT(coarse.err, AllOf(HasSubstr("warning: two stops are reached within two steps"), HasSubstr("joint \"s1\"")));
    EXPECT_EQ(fine.err, "");
}

// Two carriages that strike their stops at one instant, at any step; one alone is of second order.
TEST(Joints, StopsThatAreReachedTogetherHaveNoBoundOfErrors) {
    const TemporaryFolder folder;
    std::string text = "format = \"dttmm/1\"\n[simulation]\nduration = \"50 ms\"\n";
    for (int carriages : {1, 2}) {
        text += fmt::format(
            "[[body]]\nname = \"c{0}\"\nmass = 1\ninertia = [0.1, 0.1, 0.1]\nposition = [0, {0}, 0]\nvelocity = [1, 0, 0]\n"
            "[[joint]]\nname = \"s{0}\"\ntype = \"slider\"\nbetween = [\"ground\", \"c{0}\"]\nanchor = [0, {0}, 0]\n"
            "axis = [1, 0, 0]\nlimits = [-1, 0.0201]\n"
            "[[load]]\non = \"c{0}\"\ndirection = [1, 0, 0]\nforce = -9\n",
            carriages);
        write_text(folder / "m.toml", text);
        const Ended ended =
            run_dttmm(folder.path(), {"run", "m.toml", "--tolerance", "1 %", "--channels", "c*.position", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(ended.err.find("a stop is reached within two steps of another one") != ended.err.npos, carriages == 2)
            << ended.err;
    }
}

// Oracle: nothing moves. The turn of the bar leaves its angle off the stop by 1.6e-16; the play of the stop is no motion
// that steps must resolve.
TEST(Joints, AMachineAtRestOnItsStopRunsToATolerance) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", R"(format = "dttmm/1"
[simulation]
duration = "0.01 s"
gravity = [0, 0, -10]
[[body]]
name = "bar"
mass = 2
inertia = [0.01, 0.01, 0.01]
position = [0.3, 0, 0]
rotation = { axis = [0, 1, 0], angle = "90 deg" }
[[joint]]
name = "pin"
type = "hinge"
between = ["ground", "bar"]
anchor = [0, 0, 0]
axis = [0, 1, 0]
limits = ["-20 deg", 0]
)");
    const Ended ended = run_dttmm(folder.path(), {"run", "m.toml", "--tolerance", "1 %", "-q", "-o", "out"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_LT(read_json(folder / "out/summary.json")["tolerance"]["levels"].size(), 4u);
}

}  // namespace
}  // namespace dttmm::host
