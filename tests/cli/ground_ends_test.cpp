// SPDX-License-Identifier: BSD-3-Clause
//
// Ground ends of elements that a support moves: `motion` of an element, against the same machine on nodes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "cli/process.h"
#include "cli/results_table.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

/// A turned body on two springs; the ground end of each moves in its own way. nodes: as fixed nodes.
std::string machine(bool nodes, const std::string& x, const std::string& ry) {
    std::string text = R"(format = "dttmm/1"
[simulation]
duration = "60 ms"
step = "0.5 ms"
[[body]]
name = "block"
mass = 2.4
inertia = [0.02, 0.03, 0.025]
position = [0.3, -0.1, 0.2]
rotation = { axis = [0.3, 1, -0.4], angle = "35 deg" }
markers.one = [0.2, 0.05, -0.1]
markers.two = { position = [-0.15, 0.1, 0.02], rotation = { axis = [0, 0, 1], angle = "50 deg" } }
)";
    const std::string motion_one = "{ x = " + x + ", ry = " + ry + " }", motion_two = "{ x = " + x + " }";
    if (nodes)
        text += fmt::format(R"([nodes]
g1 = {{ position = "block.one", fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {} }}
g2 = {{ position = "block.two", fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {} }}
)",
                            motion_one, motion_two);
    text += fmt::format(R"([[element]]
name = "spring1"
type = "spring_damper"
from = "{}"
to = "block.one"
{}stiffness = [12e3, 15e3, 21e3]
damping = [9, 12, 20]
rotational_stiffness = [300, 200, 150]
[[element]]
name = "spring2"
type = "spring_damper"
from = "block.two"
to = "{}"
{}stiffness = [8e3, 5e3, 11e3]
damping = [3, 6, 2]
)",
                        nodes ? "g1" : "ground",
                        nodes ? "" : "motion = " + motion_one + "\naxes = { axis = [1, 0.2, 0], angle = \"20 deg\" }\n",
                        nodes ? "g2" : "ground", nodes ? "" : "motion = " + motion_two + "\n");
    return text;
}

/// Positions of the markers and the axes of the first spring, as numbers in place of names.
std::string with_places(std::string text) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(35 * M_PI / 180, Eigen::Vector3d(0.3, 1, -0.4).normalized()).toRotationMatrix();
    const auto place = [&](const Eigen::Vector3d& arm) {
        const Eigen::Vector3d p = Eigen::Vector3d(0.3, -0.1, 0.2) + R * arm;
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", p.x(), p.y(), p.z());
    };
    const std::string one = "\"block.one\", fixed", two = "\"block.two\", fixed";
    text.replace(text.find(one), one.size(),
                 place({0.2, 0.05, -0.1}) + ", rotation = { axis = [1, 0.2, 0], angle = \"20 deg\" }, fixed");
    text.replace(text.find(two), two.size(), place({-0.15, 0.1, 0.02}) + ", fixed");
    return text;
}

class GroundEnds : public ::testing::Test {
protected:
    ResultsTable table(const std::string& text, std::vector<std::string> words, const std::string& file) {
        write_text(folder_ / "model.toml", text);
        words.insert(words.begin() + 1, {"model.toml", "-o", "out", "-q"});
        const Ended ended = run_dttmm(folder_.path(), words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.code == 0 ? read_table(folder_ / "out" / file) : ResultsTable();
    }
    const TemporaryFolder folder_;
};

const char* const kChannels[] = {"spring1.force.x", "spring1.force.y",  "spring1.moment.z",    "spring2.force.x",
                                 "spring2.force.z", "block.position.x", "block.acceleration.y"};

// Oracle: the same machine with a fixed node in place of each ground end: the same equations in time.
TEST_F(GroundEnds, MoveInTimeAsNodesDo) {
    const std::string x = R"({ type = "haversine", peak = "2 mm", start = "3 ms", width = "40 ms" })",
                      ry = R"({ type = "step", to = 0.01, end = "30 ms" })";
    const ResultsTable ends = table(machine(false, x, ry), {"run"}, "history.csv"),
                       nodes = table(with_places(machine(true, x, ry)), {"run"}, "history.csv");
    ASSERT_EQ(ends.rows.size(), 121u);
    ASSERT_EQ(nodes.rows.size(), 121u);
    for (size_t i = 0; i < ends.rows.size(); ++i)
        for (const char* channel : kChannels)
            EXPECT_NEAR(ends.value(i, channel), nodes.value(i, channel), 1e-9) << channel << " " << i;
    EXPECT_GT(std::abs(ends.value(40, "spring1.force.x")), 1);
}

// Oracle: the same in steady vibration; a ground end is a place for --in too.
TEST_F(GroundEnds, MoveInFrequencyAsNodesDo) {
    const std::string x = R"({ type = "harmonic", amplitude = "2 mm" })",
                      ry = R"({ type = "harmonic", amplitude = 0.01, phase = "70 deg" })";
    const std::vector<std::string> words = {"response", "--from", "3Hz", "--to", "60Hz", "--points", "9"};
    const ResultsTable ends = table(machine(false, x, ry), words, "response.csv"),
                       nodes = table(with_places(machine(true, x, ry)), words, "response.csv");
    ASSERT_EQ(ends.rows.size(), 9u);
    ASSERT_EQ(nodes.rows.size(), 9u);
    for (size_t i = 0; i < ends.rows.size(); ++i)
        for (const char* channel : kChannels)
            EXPECT_LT(std::abs(ends.amplitude(i, channel) - nodes.amplitude(i, channel)),
                      1e-9 * (1 + std::abs(nodes.amplitude(i, channel))))
                << channel << " " << i;
    EXPECT_GT(std::abs(ends.amplitude(4, "spring1.force.x")), 0.1);
    const ResultsTable unit =
        table(machine(false, "0", "0"),
              {"response", "--in", "spring2.ground.x", "--from", "3Hz", "--to", "60Hz", "--points", "3"}, "response.csv");
    EXPECT_EQ(unit.rows.size(), 3u);
}

// Oracle: the integral by hand. The acceleration of a haversine is a cosine; its points 0.05 ms apart move the feet as it
// does to (W dt)²/12 = 5e-6 of it.
TEST_F(GroundEnds, MoveByAnAcceleration) {
    std::string times, values;
    const double W = 2 * M_PI / 0.04, dt = 5e-5;
    for (int i = 0; i <= 800; ++i) {
        times += fmt::format("{}{:.17g}", i > 0 ? ", " : "", 0.003 + i * dt);
        values += fmt::format("{}{:.17g}", i > 0 ? ", " : "", 0.001 * W * W * std::cos(W * i * dt));
    }
    const std::string x = R"({ type = "haversine", peak = "2 mm", start = "3 ms", width = "40 ms" })",
                      a = "{ type = \"table\", of = \"acceleration\", times = [" + times + "], values = [" + values + "] }";
    const ResultsTable shaken = table(machine(false, a, "0"), {"run"}, "history.csv"),
                       moved = table(machine(false, x, "0"), {"run"}, "history.csv");
    ASSERT_EQ(shaken.rows.size(), 121u);
    double largest = 0;
    for (size_t i = 0; i < moved.rows.size(); ++i) largest = std::max(largest, std::abs(moved.value(i, "spring1.force.x")));
    for (size_t i = 0; i < moved.rows.size(); ++i)
        EXPECT_NEAR(shaken.value(i, "spring1.force.x"), moved.value(i, "spring1.force.x"), 2e-5 * largest) << i;
    write_text(
        folder_ / "model.toml",
        machine(false, "{ type = \"table\", of = \"acceleration\", times = [0, 0.01], values = [\"0 m/s^2\", 5] }", "0"));
    EXPECT_THAT(run_dttmm(folder_.path(), {"check", "model.toml"}).err, HasSubstr("goes on with 0.025 m/s for ever"));
}

TEST_F(GroundEnds, OthersDoNotMove) {
    std::string text = machine(false, "0", "0");
    text.replace(text.find("to = \"ground\""), 13, "to = \"foot\"");
    text.replace(text.find("[[body]]"), 8, "[nodes]\nfoot = { position = [0, 0, 0], fixed = [\"x\"] }\n[[body]]");
    write_text(folder_ / "model.toml", text);
    const Ended ended = run_dttmm(folder_.path(), {"check", "model.toml"});
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, HasSubstr("motion moves an end on the ground, and no end is \"ground\""));
}

}  // namespace
}  // namespace dttmm::host
