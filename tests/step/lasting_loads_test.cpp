// SPDX-License-Identifier: BSD-3-Clause
//
// Loads that last, on nodes without mass: what is at rest stays at rest, whatever the step and the number of segments, and
// what is damped comes to rest.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using test::RecordedRun;

struct Pull {
    const char* load;
    const char* direction;
    int segments;
    const char* theory;
    const char* step;
    double calm;  ///< what the push aside leaves, from its impulse and the lowest frequency [m]
};

std::ostream& operator<<(std::ostream& out, const Pull& pull) {
    return out << pull.load << " along " << pull.direction << ", " << pull.segments << " " << pull.theory << ", "
               << pull.step;
}

/// A steel bar of 10 mm, 1 m, clamped, turned in space; its end is pulled, slowly enough to follow at rest, and pushed aside
/// once by 1 mN.
std::string pulled_bar(const Pull& pull, double rise) {
    constexpr double rest = 20;
    return fmt::format(R"(
[simulation]
duration = "{} s"
step = "{}"
[output]
step = "10 ms"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = [0, 0.6, 0.8]
[[load]]
on = "b"
direction = {}
force = {{ type = "step", from = 0, to = "{}", start = 0, end = "{} s" }}
[[load]]
on = "b"
direction = [0.6, 0.64, -0.48]
force = {{ type = "haversine", peak = "1 mN", start = "{} s", width = "50 ms" }}
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = {}
theory = "{}"
section = {{ circle = "10 mm" }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850 }}
)",
                       rise + rest, pull.step, pull.direction, pull.load, rise, rise + 0.1, pull.segments, pull.theory);
}

class PulledBar : public testing::TestWithParam<Pull> {};

// Oracle: statics. The bar rests but for what the push leaves, which neither grows nor falls: nothing damps it.
TEST_P(PulledBar, Rests) {
    const RecordedRun rows(pulled_bar(GetParam(), std::string(GetParam().direction) == "[0, 0.6, 0.8]" ? 0.5 : 20));
    const double start = rows.spread("b.position", 0.55, 0.65), end = rows.spread("b.position", 0.9, 1);
    EXPECT_LT(end, GetParam().calm);
    EXPECT_NEAR(end, start, 0.02 * start);
}

const char* const kAlong = "[0, 0.6, 0.8]";
const char* const kAcross = "[0.6, 0.64, -0.48]";
INSTANTIATE_TEST_SUITE_P(All, PulledBar,
                         testing::Values(Pull{"5 kN", kAlong, 1, "timoshenko", "1 ms", 1e-6},
                                         Pull{"5 kN", kAlong, 4, "timoshenko", "1 ms", 1e-6},
                                         Pull{"5 kN", kAlong, 10, "timoshenko", "1 ms", 1e-6},
                                         Pull{"5 kN", kAlong, 10, "euler-bernoulli", "0.1 ms", 1e-6},
                                         Pull{"5 kN", kAlong, 40, "euler-bernoulli", "1 ms", 1e-6},
                                         Pull{"1 kN", kAlong, 2, "timoshenko", "1 ms", 4e-6},
                                         Pull{"200 N", kAlong, 10, "euler-bernoulli", "1 ms", 1e-5},
                                         Pull{"500 N", kAcross, 3, "timoshenko", "1 ms", 4e-5},
                                         Pull{"500 N", kAcross, 10, "euler-bernoulli", "1 ms", 4e-5},
                                         Pull{"200 N", kAcross, 40, "timoshenko", "1 ms", 4e-5}));

// Oracle: the same of a chain: nodes without mass between the beams and at hinges of 1e8 N/m at both ends, and of a string,
// which hardly bends, without numerical damping.
TEST(LastingLoads, MasslessNodesInsideAChainRest) {
    const auto chain = [](const char* step, const char* section, const char* pull, int segments) {
        return fmt::format(R"(
[simulation]
duration = "10 s"
step = "{0}"
[output]
step = "10 ms"
[nodes]
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
a = [0, 0, 0]
n = ["0.4 m", 0, 0]
b = ["1 m", 0, 0]
end = {{ position = ["1 m", 0, 0], fixed = ["y", "z", "rx", "ry", "rz"] }}
[[load]]
on = "end"
direction = [1, 0, 0]
force = {{ type = "step", from = 0, to = "{2}", start = 0, end = "0.5 s" }}
[[load]]
on = "n"
direction = [0, 0.6, 0.8]
force = {{ type = "haversine", peak = "1 mN", start = "0.6 s", width = "50 ms" }}
[[element]]
name = "left"
type = "elastic_hinge"
from = "wall"
to = "a"
stiffness = {{ x = 1e8, y = 1e8, z = 1e8 }}
[[element]]
name = "right"
type = "elastic_hinge"
from = "b"
to = "end"
stiffness = {{ x = 1e8, y = 1e8, z = 1e8 }}
[[element]]
name = "one"
type = "beam"
from = "a"
to = "n"
segments = {3}
{1}
[[element]]
name = "two"
type = "beam"
from = "n"
to = "b"
segments = {3}
{1}
)",
                           step, section, pull, segments);
    };
    const char* bar = "section = { circle = \"20 mm\" }\nmaterial = { E = \"210 GPa\", poisson = 0.3, density = 7850 }";
    const char* string =
        "theory = \"euler-bernoulli\"\nsection = { EA = 1e6, EIy = 1e-3, EIz = 1e-3, GJ = 1e-3, mass = 0.01 }";
    for (const std::string& text :
         {chain("1 ms", bar, "20 kN", 8), chain("5 ms", bar, "20 kN", 8), chain("1 ms", string, "100 N", 80)}) {
        EXPECT_LT(RecordedRun(text).spread("n.position", 0.3, 1), 1e-6) << text;
    }
}

// Oracle: the elastica, P L²/EI = 10: 0.81061 L aside, 0.55500 L along. What is left is the division into segments. The
// dampers over a step are far stiffer than the beam bends: 10 times its axial stiffness, which is 160 times that of a
// segment's bending. A sudden load turns the end by up to a rad within a step.
TEST(LastingLoads, AFineAndDampedBeamComesToRestAtLongSteps) {
    const char *slow = R"({ type = "step", from = 0, to = "10 N", start = 0, end = "0.5 s" })", *sudden = R"("10 N")";
    for (const auto& [step, load] : {std::pair("1 ms", slow), std::pair("2 ms", sudden), std::pair("5 ms", slow),
                                     std::pair("5 ms", sudden), std::pair("4 ms", sudden)}) {
        const RecordedRun rows(fmt::format(R"(
[simulation]
duration = "2 s"
step = "{}"
[output]
step = "20 ms"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = [0, 0.6, 0.8]
[[load]]
on = "b"
direction = [0.6, 0.64, -0.48]
force = {}
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = 80
theory = "euler-bernoulli"
section = {{ EA = 1e6, EIy = 1, EIz = 1, GJ = 1, mass = 0.01 }}
material = {{ stiffness_damping = "0.05 s" }}
)",
                                           step, load));
        EXPECT_NEAR(rows.last("b.position").dot(Eigen::Vector3d(0.6, 0.64, -0.48)), 0.81061, 5e-5) << step << load;
        EXPECT_NEAR(rows.last("b.position").dot(Eigen::Vector3d(0, 0.6, 0.8)), 1 - 0.55500, 5e-5) << step << load;
        EXPECT_LT(rows.spread("b.position", 0.9, 1), 1e-6) << step << load;
    }
}

}  // namespace
}  // namespace dttmm::host
