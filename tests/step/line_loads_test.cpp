// SPDX-License-Identifier: BSD-3-Clause
//
// Forces per length on beams and rods in time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/adaptive_ode.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using test::RecordedRun;

constexpr const char* kStrip =
    "theory = \"euler-bernoulli\"\nsection = { EA = 1e6, EIy = 40, EIz = 70, GJ = 60, mass = 0.8 }\n"
    "material = { stiffness_damping = 0.02 }\n";
/// So light that dampers stop it at once: every mode dies by 40 per second or more.
constexpr const char* kLightStrip =
    "theory = \"euler-bernoulli\"\nsection = { EA = 1e6, EIy = 40, EIz = 70, GJ = 60, mass = 0.02 }\n"
    "material = { stiffness_damping = 0.02 }\n";

/// A rise to the value over half the run, then rest.
std::string risen(double value) { return fmt::format("{{ type = \"step\", to = {:.17g}, start = 0, end = 1.5 }}", value); }

// ---- Statics ------------------------------------------------------------------------------------------------------------

/// Deflection of the tip of a cantilever of 1.5 m with EI = 40, that leads in no direction of the axes, under loads of a few
/// newtons per metre across it, settled.
double cantilever_tip(int segments, double at_from, double at_to, const char* axes) {
    const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 3
step = "3 ms"
[nodes]
root = {{ position = [0.3, -0.1, 0.2], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [0.3, 0.8, 1.4]
[[element]]
name = "girder"
type = "beam"
from = "root"
to = "tip"
segments = {}
up = [0, -0.8, 0.6]
{}
[[load]]
element = "girder"
axes = "{}"
direction = {}
force_per_length = [{}, {}]
)toml",
                                       segments, kLightStrip, axes,
                                       axes == std::string("world") ? "[0, -0.8, 0.6]" : "[0, 0, 1]", risen(at_from),
                                       risen(at_to)));
    return (rows.last("tip.position") - Vector3d(0.3, 0.8, 1.4)).dot(Vector3d(0, -0.8, 0.6));
}

// Oracle: closed forms for the tip: w L⁴/8EI of a uniform load, w₀ L⁴/30EI of one that falls to zero at the tip, 11 w₀
// L⁴/120EI of one that rises to it. The error of the division is of order 2. Loads in the element's axes that bend it little
// are those in the world's.
TEST(LineLoads, ACantileverSettlesToSecondOrderInSegments) {
    constexpr double kL = 1.5, kEI = 40, kW = 0.02;
    const double L4 = std::pow(kL, 4);
    const struct {
        double at_from, at_to, tip;
    } cases[] = {{kW, kW, kW * L4 / (8 * kEI)}, {kW, 0, kW * L4 / (30 * kEI)}, {0, kW, 11 * kW * L4 / (120 * kEI)}};
    for (const auto& [at_from, at_to, tip] : cases)
        for (const char* axes : {"world", "element"}) {
            const double coarse = cantilever_tip(3, at_from, at_to, axes) / tip - 1,
                         fine = cantilever_tip(6, at_from, at_to, axes) / tip - 1;
            EXPECT_LT(std::abs(fine), 0.012) << at_from << " " << at_to << " " << axes;
            EXPECT_NEAR(coarse / fine, 4, 0.08) << at_from << " " << at_to << " " << axes;
        }
}

// Oracle: statics of what the segments carry: a force F_i and a moment M_i at the middles x_i of exact beams between them,
// w(L) = Σ F_i x_i² (3L − x_i)/6EI + M_i x_i (L − x_i/2)/EI, the moments of a linear force included. The load is so small
// that geometry does not count.
TEST(LineLoads, SegmentsCarryTheResultantOfTheirPart) {
    constexpr double kL = 1.5, kEI = 40, kFrom = 0.013, kTo = -0.005;
    for (int n : {1, 4}) {
        double tip = 0;
        for (int i = 0; i < n; ++i) {
            const double l = kL / n, x = (i + 0.5) * l, force = l * (kFrom + (i + 0.5) / n * (kTo - kFrom)),
                         moment = (kTo - kFrom) / kL * l * l * l / 12;
            tip += (force * x * x * (3 * kL - x) / 6 + moment * x * (kL - x / 2)) / kEI;
        }
        EXPECT_NEAR(cantilever_tip(n, kFrom, kTo, "world") / tip, 1, 2e-6) << n;
    }
}

// Oracle: 5 w L⁴/384EI in the middle of a simply supported beam, w₀ L⁴/153.6EI under a triangle from zero to w₀; half of the
// load, or a third and two thirds of it, on each support. Two beams of unlike division meet in the middle.
TEST(LineLoads, ASimplySupportedBeamSettlesToSecondOrderInSegments) {
    constexpr double kL = 2, kEI = 40, kW = 0.5;
    const auto run = [](int segments, double left, double middle, double right) {
        return RecordedRun(fmt::format(R"toml(
[simulation]
duration = 3
step = "3 ms"
[nodes]
left = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }}
middle = [1, 0, 0]
right = {{ position = [2, 0, 0], fixed = ["y", "z"] }}
[[element]]
name = "a"
type = "beam"
from = "left"
to = "middle"
segments = {0}
{1}
[[element]]
name = "b"
type = "beam"
from = "right"
to = "middle"
segments = {2}
{1}
[[load]]
element = "a"
direction = [0, 0, -1]
force_per_length = [{3}, {4}]
[[load]]
element = "b"
direction = [0, 0, -1]
force_per_length = [{5}, {4}]
)toml",
                                       segments, kLightStrip, segments, risen(left), risen(middle), risen(right)));
    };
    const auto error = [&](int segments, double at_left, double expected) {
        const RecordedRun rows = run(segments, at_left, 0.5 * (at_left + kW), kW);
        // Force of an element at its `from` end, in local axes: what the rest is pushed with, and the support pushes back
        const double supports[] = {rows.last("a.force").z(), rows.last("b.force").z()};
        EXPECT_NEAR(supports[0], -(at_left / 3 + kW / 6) * kL, 1e-5 * kW);
        EXPECT_NEAR(supports[1], -(at_left / 6 + kW / 3) * kL, 1e-5 * kW);
        return -rows.last("middle.position").z() / expected - 1;
    };
    const double L4 = std::pow(kL, 4);
    for (const auto& [at_left, expected] :
         {std::pair{kW, 5 * kW * L4 / (384 * kEI)}, {0.0, 0.5 * 5 * kW * L4 / (384 * kEI)}}) {
        const double coarse = error(2, at_left, expected), fine = error(4, at_left, expected);
        EXPECT_LT(std::abs(fine), 0.012) << at_left;
        EXPECT_NEAR(coarse / fine, 4, 0.1) << at_left;
    }
}

// Oracle: equal displacements and equal forces of an elastic bar: a rod that hangs, w L²/2EA; of n segments, whose lumps are
// at their middles, exactly that.
TEST(LineLoads, ARodStretches) {
    const RecordedRun rows(R"toml(
[simulation]
duration = 3
step = "3 ms"
[nodes]
root = { position = [0.3, -0.1, 0.2], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.3, 0.8, 1.4]
[[element]]
name = "bar"
type = "rod"
from = "root"
to = "tip"
segments = 3
section = { EA = 5000, mass = 0.8, inertia = 1e-4 }
material = { stiffness_damping = 0.02 }
[[load]]
element = "bar"
axes = "element"
direction = [1, 0, 0]
force_per_length = { type = "step", to = "7 N/m", start = 0, end = 1.5 }
)toml");
    const double stretch = (rows.last("tip.position") - Vector3d(0.3, -0.1, 0.2)).norm() - 1.5;
    EXPECT_NEAR(stretch, 7 * 1.5 * 1.5 / (2 * 5000), 1e-9);
    EXPECT_NEAR(rows.last("bar.force").x(), 7 * 1.5, 1e-6);
}

// Oracle: an identity: a run that starts at rest under loads that last does not move; and the settled deflection above of
// the same segments, Σ F_i x_i² (3L − x_i)/6EI + M_i x_i (L − x_i/2)/EI. The load bends the beam little.
TEST(LineLoads, StaticsHasThem) {
    const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 0.1
step = "1 ms"
start = "equilibrium"
[nodes]
root = {{ position = [0.3, -0.1, 0.2], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [0.3, 0.8, 1.4]
[[element]]
name = "girder"
type = "beam"
from = "root"
to = "tip"
segments = 2
up = [0, -0.8, 0.6]
{}
[[load]]
element = "girder"
axes = "element"
direction = [0, 0, 1]
force_per_length = [0.013, -0.005]
)toml",
                                       kStrip));
    double tip = 0;
    for (int i = 0; i < 2; ++i) {
        const double l = 0.75, x = (i + 0.5) * l, force = l * (0.013 - 0.018 * (i + 0.5) / 2),
                     moment = -0.018 / 1.5 * l * l * l / 12;
        tip += (force * x * x * (4.5 - x) / 6 + moment * x * (1.5 - x / 2)) / 40;
    }
    for (size_t n = 0; n < rows.count(); ++n)
        EXPECT_NEAR((rows.vector(n, "tip.position") - Vector3d(0.3, 0.8, 1.4)).dot(Vector3d(0, -0.8, 0.6)), tip,
                    2e-6 * std::abs(tip))
            << n;
}

// ---- Motion -------------------------------------------------------------------------------------------------------------

// Oracle: a uniform free beam under a uniform load is not bent: all of it moves as its centre of mass does, total/mass, from
// the first row on: half of a t². Two loads, one of them in the element's axes, which do not turn. Iterations end at a
// billionth of the speed.
TEST(LineLoads, AFreeBeamUnderAUniformLoadFallsAsAWhole) {
    const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 0.5
step = "5 ms"
[nodes]
a = [0.3, -0.1, 0.2]
b = [0.3, 0.8, 1.4]
[[element]]
name = "girder"
type = "beam"
from = "a"
to = "b"
segments = 7
up = [0, -0.8, 0.6]
{}
[[load]]
element = "girder"
direction = [1, -2, 2]
force_per_length = "6 N/m"
[[load]]
element = "girder"
axes = "element"
direction = [0, 0, -1]
force_per_length = 0.5
)toml",
                                       kStrip));
    const Vector3d acceleration = (Vector3d(2, -4, 4) - 0.5 * Vector3d(0, -0.8, 0.6)) / 0.8;
    for (size_t n = 0; n < rows.count(); ++n)
        for (const char* node : {"a", "b"}) {
            const double t = rows(n, "time");
            const Vector3d start = node[0] == 'a' ? Vector3d(0.3, -0.1, 0.2) : Vector3d(0.3, 0.8, 1.4);
            EXPECT_LT((rows.vector(n, fmt::format("{}.acceleration", node)) - acceleration).norm(), 1e-8) << n;
            EXPECT_LT((rows.vector(n, fmt::format("{}.velocity", node)) - t * acceleration).norm(),
                      1e-9 * acceleration.norm())
                << n;
            EXPECT_LT((rows.vector(n, fmt::format("{}.position", node)) - start - 0.5 * t * t * acceleration).norm(),
                      1e-9 * acceleration.norm())
                << n;
        }
    EXPECT_LT(std::abs(rows(rows.count() - 1, "energy.residual")), 1e-11 * rows(rows.count() - 1, "energy.work"));
}

/// A body on a beam that leads in no direction of the axes, a second beam from it to a node; with gravity, or with loads in
/// its place.
RecordedRun with_weight(bool is_by_gravity) {
    constexpr const char* kMachine = R"toml(
[nodes]
wall = { position = [0.1, 0.2, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [1.3, 1.1, -0.2]
[[body]]
name = "b"
mass = 1.3
inertia = [0.01, 0.013, 0.015]
position = [0.7, 0.9, 0.5]
rotation = { axis = [1, 2, 3], angle = 0.6 }
markers.m = [-0.1, -0.03, 0.04]
[[element]]
name = "first"
type = "beam"
from = "wall"
to = "b.m"
segments = 3
section = { tube = ["30 mm", "26 mm"] }
material = { E = "70 MPa", poisson = 0.3, density = "2700 kg/m^3" }
[[element]]
name = "second"
type = "beam"
from = "tip"
to = "b"
segments = 5
section = { circle = "7 mm" }
material = { E = "700 MPa", poisson = 0.3, density = "5000 kg/m^3" }
)toml";
    const auto mass_of = [](double area, double density) { return 0.25 * M_PI * area * density; };
    const double first = mass_of(0.03 * 0.03 - 0.026 * 0.026, 2700), second = mass_of(0.007 * 0.007, 5000);
    const double g = std::sqrt(1.2 * 1.2 + 9.81 * 9.81 + 3.4 * 3.4);
    const std::string loads = is_by_gravity ? ""
                                            : fmt::format(R"toml(
[[load]]
element = "first"
direction = [1.2, -9.81, 3.4]
force_per_length = {:.17g}
[[load]]
element = "second"
direction = [1.2, -9.81, 3.4]
force_per_length = "={:.17g}*(t<1e9)"
[[load]]
on = "b"
direction = [1.2, -9.81, 3.4]
force = {:.17g}
)toml",
                                                          first * g, second * g, 1.3 * g);
    return RecordedRun(fmt::format("[simulation]\nduration = 0.6\nstep = 0.001\n{}{}{}",
                                   is_by_gravity ? "gravity = [1.2, -9.81, 3.4]\n" : "", kMachine, loads));
}

// Oracle: the same with gravity, which is a force per length of mass per length times g, to what the iterations leave.
TEST(LineLoads, AWeightPerLengthIsGravity) {
    const RecordedRun gravity = with_weight(true), loads = with_weight(false);
    ASSERT_EQ(gravity.count(), loads.count());
    for (size_t n = 0; n < loads.count(); n += 7) {
        for (const auto& [channel, scale] : {std::pair{"b.position", 1.0},
                                             {"b.velocity", 3.0},
                                             {"b.acceleration", 30.0},
                                             {"tip.position", 1.0},
                                             {"tip.velocity", 10.0},
                                             {"first.force", 30.0},
                                             {"second.moment", 1.0}})
            EXPECT_LT((gravity.vector(n, channel) - loads.vector(n, channel)).norm(), 1e-9 * scale)
                << channel << " row " << n;
        EXPECT_NEAR(gravity(n, "energy.work"), loads(n, "energy.work"), 1e-9);
    }
}

/// A free beam of one segment, a rigid bar of its mass μL with μL³/12 about its middle, under 3 N/m at `from` and 5 N/m at
/// `to`, across it at first.
constexpr double kBar = 1.2, kMassPerLength = 0.8;

double turning_bar_error(double h, bool turns) {
    const RecordedRun rows(fmt::format(R"toml(
[simulation]
duration = 1
step = {}
[nodes]
a = [0.1, 0.2, 0.3]
b = [0.1, 1.4, 0.3]
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = 1
theory = "euler-bernoulli"
section = {{ EA = 1e9, EIy = 1e9, EIz = 1e9, GJ = 1e9, mass = 0.8 }}
[[load]]
element = "bar"
axes = "{}"
direction = {}
force_per_length = ["3 N/m", "5 N/m"]
)toml",
                                       h, turns ? "element" : "world", "[0, 0, 1]"));
    // x'' = F(θ)/m, θ'' = M(θ)/J about world x, which is −local y. Force 4 L, moment about the middle (5 − 3) L²/12
    const double mass = kMassPerLength * kBar, inertia = mass * kBar * kBar / 12;
    const auto rate = [&](double, const Eigen::VectorXd& y) {
        const double theta = y(2), force = 4 * kBar, moment = (5 - 3) * kBar * kBar / 12;
        Eigen::VectorXd f(6);
        f << y(3), y(4), y(5), (turns ? -std::sin(theta) : 0) * force / mass, (turns ? std::cos(theta) : 1) * force / mass,
            (turns ? 1 : std::cos(theta)) * moment / inertia;
        return f;
    };
    const size_t last = rows.count() - 1;
    const Eigen::VectorXd end = test::integrate(rate, Eigen::VectorXd::Zero(6), rows(last, "time"));
    const Vector3d along(0, std::cos(end(2)), std::sin(end(2)));
    const Vector3d middle = Vector3d(0.1, 0.8, 0.3) + Vector3d(0, end(0), end(1));
    EXPECT_GT(end(2), 0.8) << "it turns far";
    return (rows.last("b.position") - middle - 0.5 * kBar * along).norm() +
           (rows.last("a.position") - middle + 0.5 * kBar * along).norm();
}

// Oracle: the equations of motion of a rigid bar in its plane, by an error-controlled method. In the element's axes the load
// turns with the bar; in the world's it keeps its direction. Second order in the step.
TEST(LineLoads, TurnABarOrFollowIt) {
    for (bool turns : {false, true}) {
        const double coarse = turning_bar_error(4e-3, turns), fine = turning_bar_error(2e-3, turns);
        EXPECT_LT(fine, 2e-5) << turns;
        EXPECT_NEAR(coarse / fine, 4, 0.1) << turns;
    }
}

/// A body between a loaded beam to the ground and a loaded one with its mass off its axis, thrown; loads of all kinds that
/// change.
std::string ugly_machine(double h, double damping) {
    return fmt::format(R"toml(
[simulation]
duration = 0.4
step = {0}
gravity = [0.3, -9.81, 1]
[nodes]
wall = {{ position = [0.1, 0.2, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [1.3, 1.1, -0.2]
[[body]]
name = "b"
mass = 1.3
inertia = [0.01, 0.013, 0.015]
position = [0.7, 0.9, 0.5]
rotation = {{ axis = [1, 2, 3], angle = 0.6 }}
velocity = [0.1, -0.3, 0.2]
markers.m = [-0.1, -0.03, 0.04]
[[element]]
name = "first"
type = "beam"
from = "b.m"
to = "wall"
segments = 3
section = {{ tube = ["30 mm", "26 mm"] }}
material = {{ E = "700 MPa", poisson = 0.3, density = "2700 kg/m^3", stiffness_damping = {1} }}
[[element]]
name = "second"
type = "beam"
from = "b"
to = "tip"
segments = 2
theory = "euler-bernoulli"
section = {{ EA = 3e5, EIy = 20, EIz = 30, GJ = 17, mass = 0.9, inertia = 0.002, mass_offset = [0.02, -0.01] }}
material = {{ stiffness_damping = {1} }}
[[load]]
element = "first"
direction = [1, 2, -1]
force_per_length = ["=9*sin(40*t)", "-5 N/m"]
[[load]]
element = "second"
axes = "element"
direction = [0, 3, 4]
force_per_length = [{{ type = "sine", amplitude = "7 N/m", frequency = "11 Hz" }}, 8]
[[load]]
element = "second"
direction = [0, 1, 0]
force_per_length = "=3*t"
)toml",
                       h, damping);
}

/// Local axes of a beam, z as near to world z as can be.
Eigen::Matrix3d axes_along(const Vector3d& way) {
    const Vector3d x = way.normalized(), y = Vector3d::UnitZ().cross(x).normalized();
    Eigen::Matrix3d axes;
    axes << x, y, x.cross(y);
    return axes;
}

// Oracle: balance. In every row the forces of both beams on the body, recorded at their `from` ends in axes that go with it,
// and its weight make its acceleration.
TEST(LineLoads, RowsOfABodyBesideLoadedBeamsAreInBalance) {
    for (double h : {4e-3, 4e-4}) {
        const RecordedRun rows(ugly_machine(h, 1e-4));
        const Eigen::Matrix3d start = Eigen::AngleAxisd(0.6, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
        const Vector3d position(0.7, 0.9, 0.5), at_marker = position + start * Vector3d(-0.1, -0.03, 0.04);
        const Eigen::Matrix3d first = axes_along(Vector3d(0.1, 0.2, 0.3) - at_marker),
                              second = axes_along(Vector3d(1.3, 1.1, -0.2) - position);
        for (size_t n = 0; n < rows.count(); ++n) {
            const Eigen::Matrix3d turned = rows.attitude(n, "b") * start.transpose();
            const Vector3d force =
                turned * (first * rows.vector(n, "first.force") + second * rows.vector(n, "second.force"));
            const Vector3d needed = 1.3 * (rows.vector(n, "b.acceleration") - Vector3d(0.3, -9.81, 1));
            EXPECT_LT((needed - force).norm(), 1e-9 * (force.norm() + 20)) << h << " row " << n;
        }
    }
}

// Oracle: an identity: what the loads and the weight have done is in the energies. Of the turning motion and the changing
// loads an error of second order is left.
TEST(LineLoads, TheLedgerHasTheirWork) {
    const auto residual = [](double h) {
        const RecordedRun rows(ugly_machine(h, 0));
        double largest = 0;
        for (size_t n = 0; n < rows.count(); ++n) largest = std::max(largest, std::abs(rows(n, "energy.residual")));
        EXPECT_GT(rows(rows.count() - 1, "energy.work"), 0.05);
        return largest;
    };
    const double coarse = residual(4e-4), fine = residual(2e-4);
    EXPECT_LT(fine, 1e-4);
    EXPECT_GT(coarse / fine, 3);
}

}  // namespace
}  // namespace dttmm::host
