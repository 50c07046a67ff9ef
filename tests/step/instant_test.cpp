// SPDX-License-Identifier: BSD-3-Clause
//
// Rows of results stand at their instant: in every one mass times acceleration is the sum of the loads and of the forces
// recorded there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "support/random_machine.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using test::RecordedRun;

// Oracle: Newmark's rule by hand, the table of Chopra's example 5.3: half a sine of 10 kip and 0.6 s on an oscillator of 1 s
// and 5 % damping at steps of 0.1 s. Recorded displacement, velocity, acceleration and force of the element are its own, and
// the energy ledger closes to rounding.
TEST(Instant, AnOscillatorsRowsAreNewmarksOwn) {
    const double m = 0.2533, c = 0.1592, k = 10, h = 0.1;
    const RecordedRun rows(R"toml(
[simulation]
duration = 1
step = 0.1
[[body]]
name = "b"
mass = 0.2533
inertia = [1, 1, 1]
[[load]]
on = "b"
direction = [1, 0, 0]
force = "=10*sin(pi*t/0.6)*(t<0.6)"
[[element]]
name = "k"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = [10, 0, 0]
damping = [0.1592, 0, 0]
)toml");
    const auto load = [](double t) { return t < 0.6 - 1e-9 ? 10 * std::sin(M_PI * t / 0.6) : 0; };
    double x = 0, v = 0, a = 0;
    for (size_t n = 0; n < rows.count(); ++n) {
        EXPECT_NEAR(rows(n, "b.position.x"), x, 1e-13) << n;
        EXPECT_NEAR(rows(n, "b.velocity.x"), v, 1e-12) << n;
        EXPECT_NEAR(rows(n, "b.acceleration.x"), a, 1e-11) << n;
        EXPECT_NEAR(rows(n, "k.force.x"), k * x + c * v, 1e-12) << n;
        EXPECT_NEAR(rows(n, "energy.residual"), 0, 1e-13) << n;
        const double t = static_cast<double>(n + 1) * h;
        const double next =
            (load(t) - c * (v + h / 2 * a) - k * (x + h * v + h * h / 4 * a)) / (m + h / 2 * c + h * h / 4 * k);
        x += h * v + h * h / 4 * (a + next);
        v += h / 2 * (a + next);
        a = next;
    }
    EXPECT_NEAR(rows(6, "b.acceleration.x"), -54.672, 1e-3);  // exact -56.54; the mean over two steps would be -45.30
}

/// Angular acceleration of a body by the accelerations of its origin and of its markers ex and ey, 0.3 m along its x and y.
Vector3d angular_acceleration(const RecordedRun& rows, size_t n, const std::string& body) {
    const Eigen::Matrix3d R = rows.attitude(n, body);
    const Vector3d w = R.transpose() * rows.vector(n, body + ".angular_velocity");
    const auto turning = [&](const char* marker, const Vector3d& arm) {  // α × arm, axes of the body
        const Vector3d of_arm =
            rows.vector(n, body + "." + marker + ".acceleration") - rows.vector(n, body + ".acceleration");
        return Vector3d(R.transpose() * of_arm - w.cross(w.cross(arm)));
    };
    const Vector3d by_x = turning("ex", {0.3, 0, 0}) / 0.3, by_y = turning("ey", {0, 0.3, 0}) / 0.3;
    return R * Vector3d(by_y.z(), -by_x.z(), by_x.y());
}

// Oracle: balance. A tumbling body on ugly mounts, one of which leads to a second body on a hinge, under a force and
// gravity; every force and moment that the row has, with its lever arm, makes the acceleration and the rate of the moment of
// momentum that it has, at the very coarse step too.
TEST(Instant, EveryRowIsInBalance) {
    for (const char* step : {"10 ms", "0.5 ms"}) {
        const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = "0.2 s"
step = "{}"
gravity = [0.3, -9.81, 1]
[[body]]
name = "a"
mass = 2.3
inertia = [0.02, 0.03, 0.035]
velocity = [0, 1, 0]
angular_velocity = [1, 2, 3]
markers = {{ m = [0.1, 0.05, -0.02], ex = [0.3, 0, 0], ey = [0, 0.3, 0] }}
[[body]]
name = "b"
mass = 1.1
inertia = [0.01, 0.013, 0.015]
position = [0.25, 0.1, 0]
markers = {{ m = [-0.1, -0.03, 0.04], ex = [0.3, 0, 0], ey = [0, 0.3, 0] }}
[[joint]]
name = "h"
type = "hinge"
between = ["ground", "b"]
anchor = [0.3, 0.2, 0.1]
axis = [1, 2, 3]
[[load]]
on = "a"
direction = [0.6, 0, 0.8]
force = "=40*sin(60*t)"
[[element]]
name = "s"
type = "spring_damper"
from = "b.m"
to = "a.m"
stiffness = [3000, 2000, 5000]
damping = [6, 3, 10]
rotational_stiffness = [10, 14, 20]
rotational_damping = [0.3, 0.5, 0.2]
[[element]]
name = "g"
type = "spring_damper"
from = "ground"
to = "a.m"
stiffness = [300, 200, 500]
damping = [6, 3, 10]
)toml",
                                           step));
        const Vector3d gravity(0.3, -9.81, 1), arm(0.1, 0.05, -0.02), anchor(0.3, 0.2, 0.1);
        for (size_t n = 0; n < rows.count(); ++n) {
            // Element forces are those on the `from` end, in its axes; the `to` end has the opposite
            const Vector3d s = rows.attitude(n, "b") * rows.vector(n, "s.force"), g = rows.vector(n, "g.force");
            const Vector3d load = 40 * std::sin(60 * rows(n, "time")) * Vector3d(0.6, 0, 0.8);
            const Vector3d left = 2.3 * rows.vector(n, "a.acceleration") - (2.3 * gravity + load - s - g);
            EXPECT_LT(left.norm(), 1e-9 * (s.norm() + g.norm() + load.norm() + 30)) << step << " row " << n;
            // Of the other body with what the hinge does to it: its channel is the force on the first body, the ground
            const Vector3d h = rows.vector(n, "h.force");
            const Vector3d other = 1.1 * rows.vector(n, "b.acceleration") - (1.1 * gravity + s - h);
            EXPECT_LT(other.norm(), 1e-9 * (s.norm() + h.norm() + 10)) << step << " row " << n;
            // Both mounts act at the marker of a, the hinge at its anchor
            const auto momentum_rate = [&](const std::string& body, const Vector3d& inertia) {
                const Eigen::Matrix3d I = rows.attitude(n, body) * inertia.asDiagonal() * rows.attitude(n, body).transpose();
                const Vector3d w = rows.vector(n, body + ".angular_velocity");
                return Vector3d(I * angular_acceleration(rows, n, body) + w.cross(I * w));
            };
            const Vector3d a_to_m = rows.attitude(n, "a") * arm, m = rows.vector(n, "a.position") + a_to_m,
                           b = rows.vector(n, "b.position"), of_s = rows.attitude(n, "b") * rows.vector(n, "s.moment");
            const Vector3d on_a = momentum_rate("a", {0.02, 0.03, 0.035}) - (-a_to_m.cross(s + g) - of_s);
            const Vector3d on_b = momentum_rate("b", {0.01, 0.013, 0.015}) -
                                  ((m - b).cross(s) + of_s - (anchor - b).cross(h) - rows.vector(n, "h.moment"));
            const double largest = of_s.norm() + 0.3 * (s.norm() + h.norm()) + 1;
            EXPECT_LT(on_a.norm(), 1e-9 * largest) << step << " row " << n;
            EXPECT_LT(on_b.norm(), 1e-9 * largest) << step << " row " << n;
        }
    }
}

// Oracle: balance, of nodes with mass inside a network and of the body at its end; between the nodes is a hinge with rigid
// directions, and everything is damped, by dampers or numerically too.
TEST(Instant, EveryRowOfANetworkIsInBalance) {
    for (const auto& [step, spectral_radius] : {std::pair{5e-4, 1.0}, {5e-3, 1.0}, {5e-4, 0.8}, {5e-3, 0.8}}) {
        const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 0.1
step = {}
spectral_radius = {}
gravity = [0.3, -9.81, 1]
[nodes]
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
one = {{ position = [0.1, 0.02, -0.03], velocity=[0.1,0.2,0.3] }}
two = [0.1, 0.02, -0.03]
[[body]]
name = "b"
mass = 1.1
inertia = [0.01, 0.013, 0.015]
position = [0.3, 0.1, 0]
markers.m = [-0.1, -0.03, 0.04]
[[element]]
name = "s"
type = "spring_damper"
from = "wall"
to = "one"
stiffness = [3000, 2000, 5000]
damping = [6, 3, 10]
rotational_stiffness = [10, 14, 20]
rotational_damping = [0.3, 0.5, 0.2]
[[element]]
name = "h"
type = "elastic_hinge"
from = "one"
to = "two"
stiffness = {{ rx = 30, ry = 40 }}
damping = {{ rx = 0.1, ry = 0.02 }}
[[element]]
name = "t"
type = "spring_damper"
from = "two"
to = "b.m"
stiffness = [2000, 1000, 3000]
damping = [4, 3, 2]
rotational_stiffness = [10, 14, 20]
[[element]]
name = "m1"
type = "rigid_body"
at = "one"
mass = 1.3
inertia = {{ xx = 0.01, yy = 0.012, zz = 0.017 }}
[[element]]
name = "m2"
type = "rigid_body"
at = "two"
mass = 0.7
inertia = {{ xx = 0.004, yy = 0.005, zz = 0.006 }}
[[load]]
on = "one"
direction = [0.6, 0, 0.8]
force = "=40*sin(60*t)"
)toml",
                                           step, spectral_radius));
        const Vector3d gravity(0.3, -9.81, 1);
        for (size_t n = 0; n < rows.count(); ++n) {
            const Vector3d s = rows.vector(n, "s.force"), h = rows.turned(n, "one") * rows.vector(n, "h.force"),
                           t = rows.turned(n, "two") * rows.vector(n, "t.force");
            const Vector3d load = 40 * std::sin(60 * rows(n, "time")) * Vector3d(0.6, 0, 0.8);
            const double largest = std::max({s.norm(), h.norm(), t.norm(), load.norm(), 13.});
            const auto left = [&](const char* name, double mass, const Vector3d& force) {
                return (mass * (rows.vector(n, std::string(name) + ".acceleration") - gravity) - force).norm() / largest;
            };
            EXPECT_LT(left("one", 1.3, load - s + h), 1e-9) << step << " " << spectral_radius << " row " << n;
            EXPECT_LT(left("two", 0.7, t - h), 1e-9) << step << " " << spectral_radius << " row " << n;
            EXPECT_LT(left("b", 1.1, -t), 1e-9) << step << " " << spectral_radius << " row " << n;
        }
    }
}

/// A massless node between two springs with dampers in other ratios, and a body that starts to move.
std::string damped_node(double step) {
    return fmt::format(R"toml(
[simulation]
duration = 0.01
step = {}
[nodes]
mid = [0, 0, 0]
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.015]
velocity = [0, 0.3, 0]
[[element]]
name = "s1"
type = "spring_damper"
from = "wall"
to = "mid"
stiffness = 20000
damping = 5
rotational_stiffness = 200
[[element]]
name = "s2"
type = "spring_damper"
from = "mid"
to = "b"
stiffness = 10000
damping = 9
rotational_stiffness = 100
)toml",
                       step);
}

// Oracle: c1 v = c2 (0.3 − v) at the start; the acceleration there is finite, whatever the step; forces on the node balance
// in every row.
TEST(Instant, AMasslessNodeStartsAsItsDampersBalance) {
    double largest = 0;
    for (const double step : {1e-4, 1e-5}) {
        const RecordedRun rows(damped_node(step));
        EXPECT_NEAR(rows(0, "mid.velocity.y"), 0.3 * 9 / 14, 1e-12);
        if (largest == 0) largest = std::abs(rows(0, "mid.acceleration.y"));
        EXPECT_LT(std::abs(rows(0, "mid.acceleration.y")), 1.1 * largest) << "no 1/h";
        for (size_t n = 0; n < rows.count(); ++n) EXPECT_NEAR(rows(n, "s1.force.y"), rows(n, "s2.force.y"), 1e-9 * 3) << n;
    }
}

// Oracle: the derivative of the balance, (c1 + c2) a = c2 a_b + k2 (0.3 − v) − k1 v + dF/dt, with a_b = −c2 (0.3 − v)/m; the
// load on the node rises at 400 N/s. It is that of the start at every step, though the node relaxes in 0.5 ms.
TEST(Instant, AMasslessNodeAcceleratesFromTheStartAsItsDampersDo) {
    const double v = 0.3 * 9 / 14, body = -9 * (0.3 - v) / 2;
    const double expected = (9 * body + 10000 * (0.3 - v) - 20000 * v + 400) / 14;
    for (const double step : {1e-3, 1e-4, 1e-5}) {
        const RecordedRun rows(damped_node(step) + R"toml(
[[load]]
on = "mid"
direction = [0, 1, 0]
force = "=400*t"
)toml");
        EXPECT_NEAR(rows(0, "mid.acceleration.y"), expected, 1e-9 * std::abs(expected)) << step;
        EXPECT_NEAR(rows(0, "b.acceleration.y"), body, 1e-9) << step;
    }
}

// Oracle: two nodes that a joint holds together rigidly, but for a rotation, balance and accelerate as one; and so does a
// node held rigidly to the body go on with it.
TEST(Instant, NodesJoinedRigidlyAccelerateFromTheStartAsOne) {
    const double v = 0.3 * 9 / 14, body = -9 * (0.3 - v) / 2;
    const double expected = (9 * body + 10000 * (0.3 - v) - 20000 * v) / 14;
    for (const double step : {1e-3, 1e-4, 1e-5}) {
        std::string model = damped_node(step);
        const auto replace = [&](const std::string& what, const std::string& by) {
            model.replace(model.find(what), what.size(), by);
        };
        replace("from = \"mid\"\nto = \"b\"", "from = \"other\"\nto = \"tip\"");
        replace("mid = [0, 0, 0]",
                "mid = [0, 0, 0]\nother = { position = [0, 0, 0], rotation = { axis = [1, 2, 2], angle = \"40 deg\" } "
                "}\ntip = [0, 0, 0]");
        const RecordedRun rows(model + R"toml(
[[element]]
name = "pin"
type = "elastic_hinge"
from = "mid"
to = "other"
stiffness = { rz = 30 }
damping = { rz = 0.2 }
[[element]]
name = "end"
type = "elastic_hinge"
from = "tip"
to = "b"
stiffness = { rx = 50 }
)toml");
        for (const char* node : {"mid", "other"})
            EXPECT_NEAR(rows(0, node + std::string(".acceleration.y")), expected, 1e-9 * std::abs(expected)) << step << node;
        for (const char* moving : {"tip", "b"})
            EXPECT_NEAR(rows(0, moving + std::string(".acceleration.y")), body, 1e-9) << step << moving;
    }
}

/// A massless node between dampers that leave it without damping in y, or a turned one beside an undamped spring.
std::string partly_damped(const char* turn, const char* first, const char* second, double step) {
    return fmt::format(R"toml(
[simulation]
duration = 0.02
step = {}
[nodes]
mid = {{ position = [0, 0, 0]{} }}
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.015]
velocity = [0.2, 0.3, -0.1]
[[load]]
on = "b"
direction = [0, 0, 1]
force = 50
[[element]]
name = "s1"
type = "spring_damper"
from = "wall"
to = "mid"
stiffness = 20000
damping = {}
rotational_stiffness = 200
[[element]]
name = "s2"
type = "spring_damper"
from = "mid"
to = "b"
stiffness = [10000, 20000, 30000]
damping = {}
rotational_stiffness = 100
)toml",
                       step, turn, first, second);
}

// Oracle: springs in series share the velocity as they share a deflection, 0.3 k2/(k1 + k2) in y; no row has a velocity of
// its own for a direction that is damped by the tiny turns of the node alone.
TEST(Instant, WhereNoDamperActsAMasslessNodeFollowsItsSprings) {
    for (const double step : {1e-3, 1e-4}) {
        const RecordedRun rows(partly_damped("", "[5, 0, 3]", "[9, 0, 2]", step));
        for (size_t n = 0; n < rows.count(); ++n)
            EXPECT_NEAR(rows(n, "mid.velocity.y"), rows(n, "b.velocity.y") / 2, 2e-3) << step << " row " << n;
    }
}

// Oracle: balance of a node whose dampers relax in a small part of a step in y, as in the directions of larger ones.
TEST(Instant, WeakDampersBalanceToo) {
    for (const double share : {2e-4, 3e-2}) {
        std::string text = damped_node(1e-3);
        for (const auto& [what, part] : {std::pair("damping = 5", 5. / 14), std::pair("damping = 9", 9. / 14)})
            text.replace(text.find(what), std::string(what).size(),
                         fmt::format("damping = [900, {}, 800]", part * share * 1e-3 * 30000));
        const RecordedRun rows(text);
        for (size_t n = 0; n < rows.count(); ++n)
            EXPECT_NEAR(rows(n, "s1.force.y"), rows(n, "s2.force.y"), 1e-9 * 3) << share << " row " << n;
    }
}

// Oracle: continuity; at 1 us the rows resolve how the node relaxes (0.3 ms). The node is turned, one damper acts on it.
TEST(Instant, TheFirstAccelerationBesideUndampedDirectionsIsThatOfTheNext) {
    const char* turned = ", rotation = { axis = [1, 2, 3], angle = 1.1 }";
    double first = 0;
    for (const double step : {1e-6, 1e-4, 1e-3}) {
        std::string text = partly_damped(turned, "0", "[5, 0, 0]", step);
        if (step == 1e-6) text.replace(text.find("0.02"), 4, "1e-5");
        const RecordedRun rows(text);
        if (step == 1e-6) {
            first = rows(0, "mid.acceleration.x");
            const double next = 2 * rows(1, "mid.acceleration.x") - rows(2, "mid.acceleration.x");
            EXPECT_NEAR(first, next, 1e-3 * std::abs(first));
        }
        EXPECT_NEAR(rows(0, "mid.acceleration.x"), first, 1e-3 * std::abs(first)) << step;
    }
}

// Oracle: continuity. A beam whose damping is proportional to its stiffness relaxes under a load that is there at once;
// every row of its tip goes on from those before, from the first on.
TEST(Instant, ADampedTipRelaxesFromTheFirstRowOn) {
    const RecordedRun rows(R"toml(
[simulation]
duration = 2e-6
step = 1e-7
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.73, 0.2, 0]
[[element]]
name = "arm"
type = "beam"
from = "root"
to = "tip"
section = { rectangle = ["13 mm", "21 mm"] }
material = { E = "71 GPa", poisson = 0.33, density = 2710, stiffness_damping = 2e-5 }
[[load]]
on = "tip"
direction = [0.1, 0.3, -1]
force = 37
)toml");
    const double first = rows(0, "tip.acceleration.z");
    const double mean = (first + rows(1, "tip.acceleration.z")) / 2;
    EXPECT_NEAR(rows(0, "tip.velocity.z") + 1e-7 * mean, rows(1, "tip.velocity.z"), 1e-8);
    for (size_t n = 0; n + 2 < rows.count(); ++n)
        EXPECT_NEAR(2 * rows(n + 1, "tip.acceleration.z") - rows(n, "tip.acceleration.z"), rows(n + 2, "tip.acceleration.z"),
                    1e-3 * std::abs(first))
            << n;
}

// Oracle: what falls on a damper that stops it within 1 us pulls with its weight. Numerical damping leaves an alternating
// part of up to 27 %: it must not be made a thousand times larger by the damper, for a body or for a mass inside a network.
TEST(Instant, NumericalDampingLeavesForcesOfStiffDampersAlone) {
    static constexpr const char* kSprings = R"(stiffness = [4e8, 5.7e8, 8.7e8]
rotational_stiffness = [1.77e7, 1.38e7, 2.06e7]
damping = [2.4e5, 3.4e5, 5.2e5]
rotational_damping = [1.05e4, 8.2e3, 1.23e4]
)";
    const auto text = [](bool is_body, double radius) {
        std::string part = R"([[body]]
name = "b"
mass = 0.24
inertia = [0.003, 0.004, 0.005]
)";
        if (!is_body)
            part = R"([nodes]
b = [0, 0, 0]
[[element]]
name = "mass"
type = "rigid_body"
at = "b"
mass = 0.24
inertia = { xx = 0.003, yy = 0.004, zz = 0.005 }
)";
        return fmt::format(
            "[simulation]\nduration = 0.004\nstep = 1e-4\ngravity = [2, -9.5, 1]\nspectral_radius = {}\n{}"
            "[[element]]\nname = \"e\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"b\"\n{}",
            radius, part, kSprings);
    };
    for (const bool is_body : {true, false})
        for (const double radius : {0.95, 0.8}) {
            const RecordedRun rows(text(is_body, radius));
            for (size_t n = 1; n < rows.count(); ++n)
                EXPECT_LT((rows.vector(n, "e.force") - 0.24 * Eigen::Vector3d(2, -9.5, 1)).norm(), 0.35 * 0.24 * 9.76)
                    << is_body << " " << radius << " row " << n << ": " << rows.vector(n, "e.force").transpose();
        }
}

// Oracle: k d + c d' by the recorded deflections. A body that hinges hold, by beams, has velocities of the instant that are
// off by what the forces of these change in a step; a stiff damper on the same body made 7 kN of that, where 250 N act.
TEST(Instant, DampersOnABodyOnHingesHaveTheRateOfTheirDeflection) {
    const std::string text = test::RandomMachine(1115).text();
    const RecordedRun rows(text);
    const size_t element = text.find("name = \"e5\"");
    const auto list = [&](const char* key) {
        std::istringstream in(text.substr(text.find('[', text.find(std::string("\n") + key, element)) + 1));
        Eigen::Vector3d v;
        char comma;
        in >> v.x() >> comma >> v.y() >> comma >> v.z();
        return v;
    };
    const Eigen::Vector3d k = list("stiffness = "), c = list("damping = ");
    ASSERT_GT(c.minCoeff(), 1e5);
    const double h = rows(1, "time");
    for (size_t n = 1; n + 1 < rows.count(); ++n) {
        const Eigen::Vector3d rate = (rows.vector(n + 1, "e5.deflection") - rows.vector(n - 1, "e5.deflection")) / (2 * h);
        const Eigen::Vector3d expected = k.cwiseProduct(rows.vector(n, "e5.deflection")) + c.cwiseProduct(rate);
        EXPECT_LT((rows.vector(n, "e5.force") - expected).norm(), 0.01) << n;
        EXPECT_LT(expected.norm(), 2000) << "it is no matter of the rate taken";
    }
}

// Oracle: continuity. Of a machine that turns as a whole and whose nodes are apart, the first row goes on from the next two.
TEST(Instant, TheFirstAccelerationOfATurningMasslessNodeGoesOnFromTheNext) {
    const double h = 2e-6;
    const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = {}
step = {}
[nodes]
mid = [0.2, 0.05, 0]
[[body]]
name = "a"
mass = 1.3
inertia = [0.01, 0.014, 0.019]
velocity = [0.1, 0.2, -0.1]
angular_velocity = [1, -2, 3]
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.015]
position = [0.4, 0, 0.1]
velocity = [0.3, -0.5, 0.6]
angular_velocity = [2, 1, -1]
[[element]]
name = "s1"
type = "spring_damper"
from = "a"
to = "mid"
stiffness = 20000
damping = 5
rotational_stiffness = 200
rotational_damping = 0.1
[[element]]
name = "s2"
type = "spring_damper"
from = "mid"
to = "b"
stiffness = 10000
damping = 9
rotational_stiffness = 100
rotational_damping = 0.2
)toml",
                                       10 * h, h));
    const Vector3d first = rows.vector(0, "mid.acceleration");
    const Vector3d gone_on =
        3 * rows.vector(1, "mid.acceleration") - 3 * rows.vector(2, "mid.acceleration") + rows.vector(3, "mid.acceleration");
    EXPECT_GT(first.norm(), 100);
    EXPECT_LT((first - gone_on).norm(), 1e-4 * first.norm()) << first.transpose() << " : " << gone_on.transpose();
}

// Oracle: two massless nodes in a row: c1 v1 = c2 (v2 − v1) = c3 (0.3 − v2).
TEST(Instant, MasslessNodesInARowStartAsTheirDampersBalance) {
    const RecordedRun rows(R"toml(
[simulation]
duration = 1e-3
step = 1e-5
[nodes]
one = [0, 0, 0]
two = [0, 0, 0]
wall = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.015]
velocity = [0, 0.3, 0]
[[element]]
name = "s1"
type = "spring_damper"
from = "wall"
to = "one"
stiffness = 20000
damping = 5
rotational_stiffness = 200
[[element]]
name = "s2"
type = "spring_damper"
from = "one"
to = "two"
stiffness = 7000
damping = 2
rotational_stiffness = 90
[[element]]
name = "s3"
type = "spring_damper"
from = "two"
to = "b"
stiffness = 10000
damping = 9
rotational_stiffness = 100
)toml");
    const double c = 1 / (1 / 5. + 1 / 2. + 1 / 9.);
    EXPECT_NEAR(rows(0, "one.velocity.y"), 0.3 * c / 5, 1e-12);
    EXPECT_NEAR(rows(0, "two.velocity.y"), 0.3 * (1 - c / 9), 1e-12);
    for (size_t n = 0; n < rows.count(); ++n) {
        EXPECT_NEAR(rows(n, "s1.force.y"), rows(n, "s2.force.y"), 1e-9 * 3) << n;
        EXPECT_NEAR(rows(n, "s3.force.y"), rows(n, "s2.force.y"), 1e-9 * 3) << n;
        EXPECT_LT(std::abs(rows(n, "one.angular_velocity.x")), 1e-6) << n;
    }
}

// The same in a row of which nothing but forces, or nothing but moments, is without mass: rotations are fixed, or the nodes
// are point masses.
TEST(Instant, MasslessHalvesInARowStartAsTheirDampersBalance) {
    const double c = 1 / (1 / 5. + 1 / 2. + 1 / 9.);
    for (const bool turns : {false, true}) {
        const std::string kind = turns ? "rotational_" : "", node = turns ? "" : R"(, fixed = ["rx", "ry", "rz"])",
                          masses = turns ? R"toml([[element]]
name = "m1"
type = "point_mass"
at = "one"
mass = 0.7
[[element]]
name = "m2"
type = "point_mass"
at = "two"
mass = 0.4
)toml"
                                         : "";
        const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 1e-3
step = 1e-5
[nodes]
one = {{ position = [0, 0, 0]{1} }}
two = {{ position = [0, 0, 0]{1} }}
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.012, 0.015]
{3}velocity = [0, 0.3, 0]
[[element]]
name = "s1"
type = "spring_damper"
from = "wall"
to = "one"
{4}{0}stiffness = 2000
{0}damping = 5
[[element]]
name = "s2"
type = "spring_damper"
from = "one"
to = "two"
{4}{0}stiffness = 900
{0}damping = 2
[[element]]
name = "s3"
type = "spring_damper"
from = "two"
to = "b"
{4}{0}stiffness = 1000
{0}damping = 9
{2})toml",
                                           kind, node, masses, turns ? "angular_" : "", turns ? "stiffness = 20000\n" : ""));
        const std::string rate = turns ? "angular_velocity.y" : "velocity.y", force = turns ? "moment.y" : "force.y";
        EXPECT_NEAR(rows(0, "one." + rate), 0.3 * c / 5, 1e-12) << turns;
        EXPECT_NEAR(rows(0, "two." + rate), 0.3 * (1 - c / 9), 1e-12) << turns;
        for (size_t n = 0; n < rows.count(); ++n) {
            EXPECT_NEAR(rows(n, "s1." + force), rows(n, "s2." + force), 1e-9 * 3) << turns << " " << n;
            EXPECT_NEAR(rows(n, "s3." + force), rows(n, "s2." + force), 1e-9 * 3) << turns << " " << n;
        }
    }
}

// Oracle: the same machine at a tenth of the step. Five rigid directions of the rod and the moment of the beam meet at the
// massless rotation of a point mass. Its balance corrects the moments: the forces that masses need stay with them.
TEST(Instant, AMassBetweenABeamAndARodAcceleratesSmoothly) {
    const auto rows_at = [](double h) {
        return RecordedRun(fmt::format(R"toml(
[simulation]
duration = 8e-3
step = {}
gravity = [-0.2, -9.7, -1.3]
[nodes]
mid = {{ position = [2.0, -0.1, 0.37], quaternion = [0.9396926207859084, 0, 0, 0.3420201433256687] }}
[[body]]
name = "b"
mass = 78
box = [0.49, 0.34, 0.23]
position = [2.47, 0.06, 0.85]
quaternion = [0.5, -0.5, 0.5, 0.5]
markers = {{ m = [-0.23, -0.08, -0.15] }}
[[body]]
name = "a"
mass = 0.7
box = [0.11, 0.21, 0.24]
position = [1.5, 0.01, 0.28]
markers = {{ m = [-0.22, 0.2, -0.24], l = [0.12, -0.19, -0.02] }}
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "a.l"
stiffness = [355e3, 328e3, 204e3]
rotational_stiffness = 8e3
damping = 14
rotational_damping = 0.3
[[element]]
name = "beam"
type = "beam"
from = "a.m"
to = "mid"
segments = 4
section = {{ tube = [0.03, 0.016] }}
material = {{ E = 134e9, poisson = 0.3, density = 3980, stiffness_damping = 1.8e-6 }}
[[element]]
name = "mass"
type = "point_mass"
at = "mid"
mass = 0.043
[[element]]
name = "rod"
type = "rod"
from = "mid"
to = "b.m"
segments = 6
section = {{ tube = [0.037, 0.0046] }}
material = {{ E = 51e9, poisson = 0.3, density = 5594 }}
)toml",
                                       h));
    };
    const RecordedRun coarse = rows_at(2e-4), fine = rows_at(2e-5);
    double largest = 0, apart = 0;
    for (size_t n = 2; n < coarse.count(); ++n) {
        largest = std::max(largest, fine.vector(10 * n, "mid.acceleration").norm());
        apart = std::max(apart, (coarse.vector(n, "mid.acceleration") - fine.vector(10 * n, "mid.acceleration")).norm());
    }
    EXPECT_GT(largest, 5);
    EXPECT_LT(apart, 0.05 * largest);
}

// Oracle: Newton's second law of a hub of 2 kg that a stop of its slider brings to rest, over each of the two steps of the
// impact: the joint's force is the change of momentum over the step. The three springs pull with 3 x 10 N/m x 10.3 mm at
// most. They make the hub the last body in the order of elimination of the step's matrix, not of that of an instant.
TEST(Instant, AnImpactsRowHasTheImpulseOfTheStop) {
    std::string text = R"toml(
[simulation]
duration = "0.02 s"
step = "1 ms"
[[body]]
name = "hub"
mass = 2
inertia = [0.1, 0.1, 0.1]
velocity = [1, 0, 0]
[[joint]]
name = "guide"
type = "slider"
between = ["ground", "hub"]
anchor = [0, 0, 0]
axis = [1, 0, 0]
limits = ["-1 m", "10.3 mm"]
)toml";
    for (int i = 1; i <= 3; ++i)
        text += fmt::format(R"toml(
[[body]]
name = "b{0}"
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [0, {0}, 0]
[[element]]
name = "s{0}"
type = "spring_damper"
from = "hub"
to = "b{0}"
stiffness = [10, 10, 10]
)toml",
                            i);
    const RecordedRun rows(text);
    double largest = 0;
    for (size_t n = 0; n < rows.count(); ++n) {
        EXPECT_NEAR(rows(n, "guide.force.x"), -2 * rows(n, "hub.acceleration.x"), 0.31) << n;
        largest = std::max(largest, rows(n, "guide.force.x"));
    }
    EXPECT_GT(largest, 1000);
}

// Oracle: the turn of a free body about the axis of its spin; a mount without rotational stiffness does not resist it.
TEST(Instant, TheRotationOfAMountThatResistsNoneIsMeasured) {
    const RecordedRun rows(R"toml(
[simulation]
duration = 0.1
step = 1e-3
[[body]]
name = "b"
mass = 2
inertia = [1, 1, 1]
angular_velocity = [0, 0, 4]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 100
)toml");
    for (size_t n : {0u, 40u, 100u}) EXPECT_NEAR(rows(n, "s.rotation.z"), 4e-3 * static_cast<double>(n), 1e-9);
}

// Oracle: the same mount with the axes of the marker, said in other ways.
TEST(Instant, AMountHasTheAxesThatItIsGiven) {
    const auto force = [](const std::string& ends, const std::string& rotation) {
        const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 0.05
step = 1e-3
[[body]]
name = "b"
mass = 2
inertia = [0.1, 0.12, 0.15]
velocity = [0.1, 0.2, -0.3]
markers.m = {{ position = [0.1, 0.02, 0.03]{} }}
[[element]]
name = "s"
type = "spring_damper"
stiffness = [100, 3000, 90000]
{}
)toml",
                                           rotation, ends));
        return rows.last("b.position");
    };
    const std::string turned = ", rotation = { axis = [1, 2, 3], angle = \"40 deg\" }";
    const Vector3d expected = force("from = \"b.m\"\nto = \"ground\"", turned);
    const std::string axes = "axes = { axis = [1, 2, 3], angle = \"40 deg\" }";
    EXPECT_LT((force("from = \"b.m\"\nto = \"ground\"\n" + axes, "") - expected).norm(), 1e-12);
    // From the ground they do not turn with the body
    const std::string from_ground = "from = \"ground\"\nto = \"b.m\"\n";
    const Vector3d fixed = force(from_ground, turned);
    EXPECT_LT((force(from_ground + "axes = \"to\"", turned) - fixed).norm(), 1e-12);
    EXPECT_LT((force(from_ground + axes, "") - fixed).norm(), 1e-12);
    EXPECT_LT((fixed - expected).norm(), 5e-4);
    EXPECT_GT((force(from_ground, "") - fixed).norm(), 2e-3);
}

}  // namespace
}  // namespace dttmm::host
