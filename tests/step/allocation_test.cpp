// SPDX-License-Identifier: BSD-3-Clause
//
// Nothing is allocated in the step loop. Every malloc of this executable is counted while a step runs, the plugin's, ODE's
// and the recorder's included. Under the address sanitizer, which has a malloc of its own, the test has nothing to count and
// is left out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <string>

#include "model/read_model.h"
#include "record/recorder.h"
#include "step/simulation.h"
#include "support/count_allocations.h"
#include "support/models.h"
#include "support/paths.h"

#ifndef __SANITIZE_ADDRESS__

namespace dttmm::host {
namespace {

/// Mallocs of so many steps, after the first ones, which fill the working memory.
long allocations_of(const Model& model, const Plugins& plugins, int first, int steps) {
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < first; ++n) simulation.step();
    const long before = allocations;
    EXPECT_GT(before, 0) << "malloc is not counted";
    for (int n = 0; n < steps; ++n) simulation.step();
    return allocations - before;
}

TEST(Allocation, NothingIsAllocatedInTheStepLoop) {
    const Plugins plugins;
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        Model model = test::plate_stack(plugins, 5, 5e5, 100, 1e-3, coupling);
        model.elements[7].values.change()[0] *= 0.8;  // tilts the plates: more than one pass per step
        Body lever = test::box("lever", 1, {0.2, 0.02, 0.02}, {1, 0, 0});
        lever.angular_velocity = {0, 0, 4};
        model.bodies.push_back(lever);
        model.joints.push_back(test::pin("pin", -1, 5, {1, 0, 0}, {0, 0, 1}));
        model.joints[0].limits = {-0.5, 0.2};  // reached on the way
        EXPECT_EQ(allocations_of(model, plugins, 3, 500), 0);
    }
}

constexpr const char* kLeg = R"(
format = "dttmm/1"
[simulation]
duration = 10
step = "1 ms"
[nodes]
knee = [0.5, 0, 0]
ankle = [0.5, 0, 0]
tip = [0.5, 0.6, 0.1]
[[body]]
name = "hub"
mass = 2
inertia = [0.1, 0.1, 0.1]
angular_velocity = [0, 0, 6]
markers.rim = [0.1, 0, 0]
[[joint]]
name = "axle"
type = "hinge"
between = ["hub", "ground"]
anchor = [0, 0, 0]
axis = [0, 0, 1]
[[load]]
on = "tip"
direction = [0, 0, 1]
force = "=20*sin(30*t) "
[[load]]
element = "leg"
axes = "element"
direction = [0, 1, 0]
force_per_length = ["=5*sin(20*t) ", "2 N/m"]
[[element]]
name = "arm"
type = "beam"
from = "hub.rim"
to = "knee"
segments = 4
section = { tube = ["30 mm", "26 mm"] }
material = { E = "70 GPa", poisson = 0.3, density = "2700 kg/m^3" }
[[element]]
name = "hinge"
type = "elastic_hinge"
from = "knee"
to = "ankle"
stiffness = { rz = 40, ry = 1e4 }
damping = { rz = 0.1 }
[[element]]
name = "leg"
type = "beam"
from = "ankle"
to = "tip"
segments = 3
section = { tube = ["30 mm", "26 mm"] }
material = { E = "70 GPa", poisson = 0.3, density = "2700 kg/m^3" }
[[element]]
name = "foot"
type = "point_mass"
at = "tip"
mass = 0.3
)";

// A body on a joint, so that the stiffness of the network is wanted at every step; hinges with rigid directions, a mass and
// a load on a node; far and fast enough that the matrix of the network is factored anew.
TEST(Allocation, NothingIsAllocatedInsideANetwork) {
    const Plugins plugins;
    const Model model = parse_model(kLeg, "leg.toml", plugins.catalogue());
    EXPECT_EQ(allocations_of(model, plugins, 3, 2000), 0);
}

// The same with supports that move: one that shifts and turns, one that lifts a mass.
TEST(Allocation, SupportsThatMoveAllocateNothing) {
    const Plugins plugins;
    std::string text = kLeg;
    text.replace(
        text.find("tip = [0.5, 0.6, 0.1]"), 21,
        "tip = { position = [0.5, 0.6, 0.1], fixed = [\"y\"], motion = { y = \"=0.01*sin(40*t)\" } }\n"
        "wall = { position = [0.9, 0.6, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"], motion = { x = { type = "
        "\"sine\", amplitude = 0.02, frequency = 5 }, ry = \"=0.3*sin(9*t)\" } }");
    text +=
        "[[element]]\nname = \"tie\"\ntype = \"spring_damper\"\nfrom = \"wall\"\nto = \"tip\"\nstiffness = 300\n"
        "rotational_stiffness = 2\n";
    const Model model = parse_model(text, "leg.toml", plugins.catalogue());
    EXPECT_EQ(allocations_of(model, plugins, 3, 2000), 0);
}

/// A linkage of three bars between two points of the ground, hinged about z; x and y of its four hinges.
std::string linkage(const std::array<double, 8>& at) {
    std::string text = "format = \"dttmm/1\"\n[simulation]\nstep = 1e-3\nduration = 10\ngravity = [0, -9.81, 0]\n";
    for (size_t i = 0; i < 3; ++i)
        text += fmt::format("[[body]]\nname = \"bar{}\"\nmass = 1.3\ninertia = [0.1, 0.1, 0.1]\nposition = [{}, {}, 0]\n", i,
                            0.5 * (at[2 * i] + at[2 * i + 2]), 0.5 * (at[2 * i + 1] + at[2 * i + 3]));
    for (size_t i = 0; i < 4; ++i)
        text += fmt::format(
            "[[joint]]\nname = \"hinge{}\"\ntype = \"hinge\"\nbetween = [\"{}\", \"{}\"]\nanchor = [{}, {}, 0]\naxis = [0, "
            "0, "
            "1]\n",
            i, i == 0 ? "ground" : fmt::format("bar{}", i - 1), i == 3 ? "ground" : fmt::format("bar{}", i), at[2 * i],
            at[2 * i + 1]);
    return text;
}

// The same with a linkage in a plane: its hinges say the same several times, and which of their equations does changes.
// The rocker never comes near a singular position; the parallelogram, which falls, passes one in each of its swings.
TEST(Allocation, LinkagesAllocateNothing) {
    const Plugins plugins;
    for (const auto& at :
         {std::array{0.0, 0.0, 0.1, 0.4, 1.3, 0.9, 1.2, 0.0}, std::array{0.0, 0.0, 0.1, 0.4, 1.3, 0.4, 1.2, 0.0}})
        EXPECT_EQ(allocations_of(parse_model(linkage(at), "linkage.toml", plugins.catalogue()), plugins, 100, 2000), 0);
}

// The same with a motor in a joint.
TEST(Allocation, MotorsAllocateNothing) {
    const Plugins plugins;
    std::string text = kLeg;
    text.replace(text.find("axis = [0, 0, 1]"), 16, "axis = [0, 0, 1]\nangle = \"=-6*t + 0.2*sin(20*t)*t\"");
    const Model model = parse_model(text, "leg.toml", plugins.catalogue());
    EXPECT_EQ(allocations_of(model, plugins, 3, 500), 0);
}

// The same with springs that are not linear, between bodies and at the end of a beam.
TEST(Allocation, LawsAllocateNothing) {
    const Plugins plugins;
    const Model model = parse_model(R"(format = "dttmm/1"
[simulation]
step = 0.001
duration = 1
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [1, 0, 0]
[[body]]
name = "block"
mass = 5
inertia = [0.1, 0.2, 0.3]
position = [1, 0, 0]
velocity = [0.3, 1, -2]
[[element]]
name = "strip"
type = "beam"
from = "root"
to = "tip"
segments = 5
section = { circle = 0.03 }
material = { E = 2.1e11, poisson = 0.3, density = 7850 }
[[element]]
name = "pad"
type = "spring_damper"
from = "tip"
to = "block"
rotational_stiffness = 1e3
x = { law = "cubic", stiffness = 1e5, cubic = 1e11 }
y = { law = "cubic", stiffness = 1e4, cubic = 1e9 }
z = { law = "cubic", stiffness = 1e4, cubic = 1e9 }
[[element]]
name = "stop"
type = "spring_damper"
from = "ground"
to = "block"
y = { law = "cubic", stiffness = 0, cubic = 1e7 }
)",
                                    "model.toml", plugins.catalogue());
    EXPECT_EQ(allocations_of(model, plugins, 3, 300), 0);
}

// The same with laws that have kinks, one of them in a library of its own; where tangents lead from one side to the other,
// half of a correction is taken.
TEST(Allocation, LawsWithKinksAllocateNothing) {
    const Plugins plugins({test::paths::jenkins()});
    const Model model = parse_model(R"(format = "dttmm/1"
[simulation]
step = 0.002
duration = 10
gravity = [0, 0, -9.81]
[[body]]
name = "block"
mass = 5
inertia = [0.1, 0.2, 0.3]
velocity = [0.3, 1, -2]
markers.foot = [0.2, 0.1, -0.1]
[[body]]
name = "arm"
mass = 1
inertia = [0.1, 0.2, 0.3]
position = [1, 0, 0]
velocity = [0.3, 1, -2]
[[joint]]
name = "pin"
type = "hinge"
between = ["block", "arm"]
anchor = [0.5, 0, 0]
axis = [0, 1, 0]
[[element]]
name = "pad"
type = "spring_damper"
from = "ground"
to = "block.foot"
stiffness = 1e3
rotational_stiffness = 1e3
[[element]]
name = "floor"
type = "spring_damper"
from = "ground"
to = "arm"
x = { law = "jenkins", stiffness = 1e7, slip = 20 }
z = { law = "jenkins", stiffness = 1e8, slip = 2 }
)",
                                    "model.toml", plugins.catalogue());
    EXPECT_EQ(allocations_of(model, plugins, 3, 2000), 0);
}

}  // namespace
}  // namespace dttmm::host

#endif
