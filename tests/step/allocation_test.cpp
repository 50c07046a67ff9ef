// SPDX-License-Identifier: BSD-3-Clause
//
// Nothing is allocated in the step loop. Every malloc of this executable is counted while a step runs, the plugin's, ODE's
// and the recorder's included. Under the address sanitizer, which has a malloc of its own, the test has nothing to count and
// is left out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "model/read_model.h"
#include "record/recorder.h"
#include "step/simulation.h"
#include "support/count_allocations.h"
#include "support/models.h"

#ifndef __SANITIZE_ADDRESS__

namespace dttmm::host {
namespace {

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
        Simulation simulation(model, plugins);
        Recorder recorder(simulation.channels());
        simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
        for (int n = 0; n < 3; ++n) simulation.step();  // the first steps fill the working memory
        const long before = allocations;
        ASSERT_GT(before, 0) << "malloc is not counted";
        for (int n = 0; n < 500; ++n) simulation.step();
        EXPECT_EQ(allocations - before, 0);
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
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < 3; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 2000; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0);
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
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < 3; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 2000; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0);
}

// The same with a linkage in a plane: its hinges say the same several times, and which of their equations does changes.
TEST(Allocation, ARedundantLinkageAllocatesNothing) {
    const Plugins plugins;
    std::string text = "format = \"dttmm/1\"\n[simulation]\nstep = 1e-3\nduration = 10\ngravity = [0, -9.81, 0]\n";
    const auto bar = [&](const char* name, double x0, double y0, double x1, double y1) {
        text += fmt::format("[[body]]\nname = \"{}\"\nmass = 1.3\ninertia = [0.1, 0.1, 0.1]\nposition = [{}, {}, 0]\n", name,
                            0.5 * (x0 + x1), 0.5 * (y0 + y1));
    };
    const auto hinge = [&](const char* name, const char* from, const char* to, double x, double y) {
        text += fmt::format(
            "[[joint]]\nname = \"{}\"\ntype = \"hinge\"\nbetween = [\"{}\", \"{}\"]\nanchor = [{}, {}, 0]\naxis = [0, 0, "
            "1]\n",
            name, from, to, x, y);
    };
    // A rocker that never comes near a singular position
    bar("crank", 0, 0, 0.1, 0.4);
    bar("coupler", 0.1, 0.4, 1.3, 0.9);
    bar("rocker", 1.3, 0.9, 1.2, 0);
    hinge("a", "ground", "crank", 0, 0);
    hinge("b", "crank", "coupler", 0.1, 0.4);
    hinge("c", "coupler", "rocker", 1.3, 0.9);
    hinge("d", "rocker", "ground", 1.2, 0);
    const Model model = parse_model(text, "linkage.toml", plugins.catalogue());
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < 100; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 2000; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0);
}

// The same with a motor in a joint.
TEST(Allocation, MotorsAllocateNothing) {
    const Plugins plugins;
    std::string text = kLeg;
    text.replace(text.find("axis = [0, 0, 1]"), 16, "axis = [0, 0, 1]\nangle = \"=-6*t + 0.2*sin(20*t)*t\"");
    const Model model = parse_model(text, "leg.toml", plugins.catalogue());
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < 3; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 500; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0);
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
    Simulation simulation(model, plugins);
    Recorder recorder(simulation.channels());
    simulation.record_to([&](std::span<const double> row) { recorder.close_row(row); });
    for (int n = 0; n < 3; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 300; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace dttmm::host

#endif
