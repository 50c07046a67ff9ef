// SPDX-License-Identifier: BSD-3-Clause
//
// Springs with laws of their own: between bodies, at nodes, in chains with beams.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "support/paths.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using test::RecordedRun;

/// Time of a step: a period of x'' + x + x³ = 0 that starts at rest's place with the speed of the amplitude 2, divided. From
/// nonlinear.md A7, confirmed below: ω = 1.97601636407125.
constexpr double kPeriod = 2 * M_PI / 1.97601636407125;
constexpr double kSpeed = 3.4641016151377544;  // √(a² + a⁴/2)
constexpr double kMass = 2.5;

enum class Held { body, node, hinge };  // the last: a node on a hinge that is rigid but along its z

/// The oscillator along an axis turned in space.
std::string duffing(Held held, double step, double periods, const char* more = "") {
    const Eigen::Vector3d way =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.2, -0.6, 0.3).normalized()) * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d v = kSpeed * way;
    const std::string speed = fmt::format("velocity = [{}, {}, {}]", v.x(), v.y(), v.z()),
                      turned = "{ axis = [0.2, -0.6, 0.3], angle = 0.7 }",
                      mass =
                          fmt::format("[[element]]\nname = \"mass\"\ntype = \"point_mass\"\nat = \"m\"\nmass = {}\n", kMass);
    std::string parts, spring;
    switch (held) {
        case Held::body:
            parts = fmt::format("[[body]]\nname = \"m\"\nmass = {}\ninertia = [1, 2, 3]\n{}\n", kMass, speed);
            break;
        case Held::node:
            parts = fmt::format("[nodes]\nm = {{ position = [0, 0, 0], {}, fixed = [\"rx\", \"ry\", \"rz\"] }}\n{}", speed,
                                mass);
            break;
        case Held::hinge:
            parts = fmt::format(
                "[nodes]\nbase = {{ position = [0, 0, 0], rotation = {0}, fixed = [\"x\", \"y\", \"z\", \"rx\", "
                "\"ry\", \"rz\"] }}\nm = {{ position = [0, 0, 0], rotation = {0}, {1} }}\n{2}",
                turned, speed, mass);
            break;
    }
    spring = held == Held::hinge ? "type = \"elastic_hinge\"\nfrom = \"base\"\n"
                                 : fmt::format("type = \"spring_damper\"\nfrom = \"ground\"\naxes = {}\n", turned);
    return fmt::format(R"(
[simulation]
step = {}
duration = {}
{}
[output]
step = {}
{}
[[element]]
name = "spring"
{}to = "m"
z = {{ law = "cubic", stiffness = {}, cubic = {} }}
)",
                       step, periods * kPeriod, more, step, parts, spring, kMass, kMass);
}

double error_after_a_period(Held held, int steps) {
    const RecordedRun run(duffing(held, kPeriod / steps, 1));
    return run.last("m.position").norm();
}

// Oracle: the exact period 4 K(m)/√(1 + a²), m = a²/(2 (1 + a²)), by the arithmetic-geometric mean.
TEST(LawsOfSprings, DuffingsPeriodIsMetToSecondOrder) {
    double a = 1, g = std::sqrt(1 - 0.4);  // m = 4/10
    for (int i = 0; i < 6; ++i) std::tie(a, g) = std::pair((a + g) / 2, std::sqrt(a * g));
    EXPECT_NEAR(4 * (M_PI / (2 * a)) / std::sqrt(5), kPeriod, 1e-13);
    for (Held held : {Held::body, Held::node, Held::hinge}) {
        double before = error_after_a_period(held, 50);
        EXPECT_LT(before, 0.1);
        for (int steps : {100, 200, 400, 800}) {
            const double error = error_after_a_period(held, steps);
            EXPECT_NEAR(before / error, 4, 0.1) << steps;
            before = error;
        }
    }
}

/// Largest change of the energy as share of it.
double lost_energy(Held held, double steps, double periods) {
    const RecordedRun run(duffing(held, kPeriod / steps, periods));
    double worst = 0;
    for (size_t n = 0; n < run.count(); ++n) {
        const double energy = run(n, "energy.kinetic") + run(n, "energy.strain");
        worst = std::max(worst, std::abs(energy / (0.5 * kMass * kSpeed * kSpeed) - 1));
    }
    return worst;
}

// Oracle: conservation. The mean force along the path of a step does the work that the spring stores, at any step size: here
// up to 0.27 of the period. What is left of it is what the solver leaves in every step.
TEST(LawsOfSprings, EnergyIsKeptAtAnyStep) {
    for (Held held : {Held::body, Held::node, Held::hinge})
        for (double steps : {100.0, 10.0, 3.7}) {
            EXPECT_LT(lost_energy(held, steps, 10), 5e-12) << steps;
            EXPECT_LT(lost_energy(held, steps, 100), 1e-10) << steps;
        }
}

// Oracle: the balance at each instant: mass times acceleration is the recorded force, and the force is the law's.
TEST(LawsOfSprings, ARowIsInBalance) {
    for (Held held : {Held::body, Held::node, Held::hinge}) {
        const RecordedRun run(duffing(held, kPeriod / 37, 2));
        for (size_t n = 0; n < run.count(); ++n) {
            const double d = run(n, "spring.deflection.z"), f = run(n, "spring.force.z");
            EXPECT_NEAR(f, kMass * (d + d * d * d), 1e-9);
            EXPECT_NEAR(kMass * run.vector(n, "m.acceleration").norm(), std::abs(f), 1e-9 * 25);
        }
    }
}

// Oracle: the same equation for the rotation about the z of a hinge, which is rigid in its other directions.
TEST(LawsOfSprings, AHingeSwingsAsDuffing) {
    constexpr double kInertia = 0.37;
    const Eigen::Vector3d spin =
        kSpeed * (Eigen::AngleAxisd(-1.1, Eigen::Vector3d(0.5, 0.4, -0.2).normalized()) * Eigen::Vector3d::UnitZ());
    const auto end = [&](int steps) {
        const RecordedRun run(fmt::format(R"(
[simulation]
step = {0}
duration = {1}
[output]
step = {0}
[nodes]
base = {{ position = [0.2, -0.3, 0.1], rotation = {{ axis = [0.5, 0.4, -0.2], angle = -1.1 }}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
arm = {{ position = [0.2, -0.3, 0.1], rotation = {{ axis = [0.5, 0.4, -0.2], angle = -1.1 }}, angular_velocity = [{2}, {3}, {4}] }}
[[element]]
name = "wheel"
type = "rigid_body"
at = "arm"
mass = 1.9
inertia = {{ xx = 0.3, yy = 0.21, zz = {5} }}
[[element]]
name = "spring"
type = "elastic_hinge"
from = "base"
to = "arm"
rz = {{ law = "cubic", stiffness = {5}, cubic = {5} }}
)",
                                          kPeriod / steps, kPeriod, spin.x(), spin.y(), spin.z(), kInertia));
        const size_t last = run.count() - 1;
        EXPECT_NEAR(run(last, "energy.kinetic") + run(last, "energy.strain"), 0.5 * kInertia * kSpeed * kSpeed, 1e-9);
        return std::abs(run(last, "spring.rotation.z"));
    };
    double before = end(100);
    for (int steps : {200, 400, 800}) {
        const double error = end(steps);
        EXPECT_NEAR(before / error, 4, 0.1) << steps;
        before = error;
    }
}

/// Two masses between walls on three springs that are not linear in any direction, struck.
std::string two_masses(Held held) {
    const auto mass = [&](const char* name, double at, double kilograms, const char* velocity) {
        if (held == Held::body)
            return fmt::format(
                "[[body]]\nname = \"{}\"\nmass = {}\ninertia = [1, 1, 1]\nposition = [{}, 0.1, 0]\n"
                "velocity = {}\n",
                name, kilograms, at, velocity);
        return fmt::format(
            "[nodes.{0}]\nposition = [{1}, 0.1, 0]\nvelocity = {3}\n[[element]]\nname = \"mass-{0}\"\n"
            "type = \"rigid_body\"\nat = \"{0}\"\nmass = {2}\ninertia = {{ xx = 1, yy = 1, zz = 1 }}\n",
            name, at, kilograms, velocity);
    };
    const auto spring = [](const char* name, const char* from, const char* to, double k3) {
        return fmt::format(
            "[[element]]\nname = \"{}\"\ntype = \"spring_damper\"\nfrom = \"{}\"\nto = \"{}\"\n"
            "damping = [0.3, 0, 0.1]\nx = {{ law = \"cubic\", stiffness = 40, cubic = {} }}\n"
            "y = {{ law = \"cubic\", stiffness = 0, cubic = {} }}\n"
            "z = {{ law = \"cubic\", stiffness = 90, cubic = -7 }}\n",
            name, from, to, k3, 2 * k3);
    };
    return "[simulation]\nstep = 0.01\nduration = 2\n" + mass("a", 0, 1.3, "[1, 2, -1.5]") +
           mass("b", 0.4, 0.7, "[-2, 0.5, 1]") + spring("s1", "ground", "a", 900) + spring("s2", "a", "b", 3000) +
           spring("s3", "ground", "b", 500);
}

// Oracle: an equivalent model. Bodies are solved for by the host's iteration, nodes with masses by that of the network, with
// its springs beside the matrix.
TEST(LawsOfSprings, NodesMoveAsBodiesDo) {
    const RecordedRun bodies(two_masses(Held::body)), nodes(two_masses(Held::node));
    for (size_t n = 0; n < bodies.count(); ++n)
        for (const char* channel : {"a.position", "b.position", "s2.force"})
            ASSERT_LT((bodies.vector(n, channel) - nodes.vector(n, channel)).norm(), 1e-6 * bodies.vector(n, channel).norm())
                << channel << " row " << n;
}

/// Masses in a row between walls, each on two springs that are not linear in three directions.
std::string row_of_masses(int count, Held held) {
    std::string text = "[simulation]\nstep = 0.005\nduration = 0.5\n";
    for (int i = 0; i < count; ++i) {
        const std::string place = fmt::format("position = [{}, 0, 0]\nvelocity = [0, 0.2, {}]\n", 0.3 * i, i == 0 ? 1 : 0);
        const double mass = 1 + 0.1 * i;
        if (held == Held::body)
            text += fmt::format("[[body]]\nname = \"n{}\"\nmass = {}\ninertia = [1, 1, 1]\n{}", i, mass, place);
        else
            text += fmt::format(
                "[nodes.n{0}]\n{2}[[element]]\nname = \"m{0}\"\ntype = \"rigid_body\"\nat = \"n{0}\"\n"
                "mass = {1}\ninertia = {{ xx = 1, yy = 1, zz = 1 }}\n",
                i, mass, place);
        const std::string law = "{ law = \"cubic\", stiffness = 300, cubic = 1e5 }\n";
        for (const std::string& from : {std::string("ground"), fmt::format("n{}", i - 1)})
            if (i > 0 || from == "ground")
                text += fmt::format(
                    "[[element]]\nname = \"{1}-{0}\"\ntype = \"spring_damper\"\nfrom = \"{1}\"\n"
                    "to = \"n{0}\"\nrotational_stiffness = 40\nx = {2}y = {2}z = {2}",
                    i, from, law);
    }
    return text;
}

// Oracle: the equivalent model of bodies. Few springs stand beside the matrix of the nodes, with many it follows them.
TEST(LawsOfSprings, ManyInANetworkMoveNodesAsBodies) {
    for (int count : {2, 12}) {
        const RecordedRun bodies(row_of_masses(count, Held::body)), nodes(row_of_masses(count, Held::node));
        for (size_t n = 0; n < bodies.count(); ++n)
            ASSERT_LT((bodies.vector(n, "n1.position") - nodes.vector(n, "n1.position")).norm(), 1e-7 * 0.3) << "row " << n;
    }
}

// Oracle: energy. A body of 2 kg and 1 m/s runs by a massless node into a spring k₁ and a cubic spring k₃ in series; at rest
// they hold F²/(2 k₁) + ¼ F^(4/3)/k₃^(1/3) = 1 J. However stiff, the node is found.
TEST(LawsOfSprings, AMasslessNodeFindsItsPlaceOnAStiffLaw) {
    for (double k3 : {1e12, 1e15, 1e17}) {
        const RecordedRun run(fmt::format(R"(
[simulation]
duration = 0.01
step = 0.00001
[nodes]
n = [0, 0, 0]
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.01, 0.01]
velocity = [0, 0, 1]
[[element]]
name = "s1"
type = "spring_damper"
from = "ground"
to = "n"
stiffness = [1e6, 1e6, 1e6]
rotational_stiffness = 1e3
[[element]]
name = "s2"
type = "spring_damper"
from = "n"
to = "b"
stiffness = [1e6, 1e6, 0]
rotational_stiffness = 1e3
z = {{ law = "cubic", stiffness = 0, cubic = {} }}
)",
                                          k3));
        double peak = 0, F = 1000;
        for (size_t n = 0; n < run.count(); ++n) peak = std::max(peak, run(n, "s2.force.z"));
        for (int i = 0; i < 50; ++i)
            F -= (F * F / 2e6 + 0.25 * std::pow(F, 4 / 3.0) / std::cbrt(k3) - 1) / (F / 1e6 + std::cbrt(F / k3) / 3);
        EXPECT_NEAR(peak, F, 2e-4 * F) << k3;
    }
}

// Oracle: conservation, for a mass inside a network beside a body: the host's rates of convergence of steps before say
// nothing of the next.
TEST(LawsOfSprings, EnergyIsKeptBesideABody) {
    for (double step : {2e-4, 1e-4, 5e-5}) {
        const RecordedRun run(fmt::format(R"(
[simulation]
duration = 0.02
step = {}
[nodes]
n = {{ position = [0, 0, 0], fixed = ["rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.01, 0.01]
velocity = [0, 0, 0.5]
[[element]]
name = "lump"
type = "point_mass"
at = "n"
mass = 0.5
[[element]]
name = "s1"
type = "spring_damper"
from = "ground"
to = "n"
stiffness = [1e6, 1e6, 0]
z = {{ law = "cubic", stiffness = 0, cubic = 8e10 }}
[[element]]
name = "s2"
type = "spring_damper"
from = "n"
to = "b"
stiffness = [1e6, 1e6, 0]
rotational_stiffness = 1e3
z = {{ law = "cubic", stiffness = 0, cubic = 8e10 }}
)",
                                          step));
        double worst = 0;
        for (size_t n = 0; n < run.count(); ++n)
            worst = std::max(worst, std::abs(run(n, "energy.kinetic") + run(n, "energy.strain") - 0.25));
        EXPECT_LT(worst, 1e-9 * 0.25) << step;
    }
}

/// A clamped rod, a spring along it, and a load F on its end that rises slowly; turned in space.
std::string pulled(const std::string& spring, double load) {
    return fmt::format(R"(
[simulation]
step = 0.001
duration = 1
[output]
step = 0.01
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
middle = {{ position = [0.6, 0, 0.8], rotation = {{ axis = [0, -1, 0], angle = 0.9272952180016122 }} }}
tip = {{ position = [0.6, 0, 0.8], fixed = ["rx", "ry", "rz"] }}
[[element]]
name = "bar"
type = "beam"
from = "root"
to = "middle"
segments = 7
theory = "euler-bernoulli"
section = {{ EA = 3e5, EIy = 900, EIz = 700, GJ = 500, mass = 2, inertia = 0.01 }}
material = {{ stiffness_damping = 1e-3 }}
[[element]]
name = "spring"
type = "spring_damper"
from = "middle"
to = "tip"
{}
[[load]]
on = "tip"
direction = [0.6, 0, 0.8]
force = {{ type = "step", from = 0, to = {}, start = 0, end = 0.5 }}
)",
                       spring, load);
}

// Oracle: statics. The spring gives by the root of k d + k₃ d³ = F, the bar by F L/EA; a massless node takes part.
TEST(LawsOfSprings, AChainRestsWhereStaticsHasIt) {
    const double load = 500, k = 4000, k3 = 3e9;
    const RecordedRun run(pulled(fmt::format("stiffness = [0, 9e3, 9e3]\nrotational_stiffness = 50\n"
                                             "x = {{ law = \"cubic\", stiffness = {}, cubic = {} }}",
                                             k, k3),
                                 load));
    double d = 0;
    for (int i = 0; i < 60; ++i) d -= (k * d + k3 * d * d * d - load) / (k + 3 * k3 * d * d);
    const size_t end = run.count() - 1;
    EXPECT_NEAR(run(end, "spring.deflection.x"), d, 1e-6 * d);
    EXPECT_NEAR(run(end, "spring.force.x"), load, 1e-6 * load);
    EXPECT_NEAR(run(end, "bar.deflection.x"), load / 3e5, 1e-5 * load / 3e5);
}

// Oracle: the linear springs themselves, which go another way through the program.
TEST(LawsOfSprings, ALinearLawIsASpring) {
    const RecordedRun law(
        pulled("y = { law = \"linear\", stiffness = 9e3 }\nz = { law = \"linear\", stiffness = 8e3 }\n"
               "x = { law = \"cubic\", stiffness = 7e3, cubic = 0 }\nrotational_stiffness = 50",
               400));
    const RecordedRun spring(pulled("stiffness = [7e3, 9e3, 8e3]\nrotational_stiffness = 50", 400));
    for (size_t n = 0; n < law.count(); ++n)
        for (const char* channel : {"spring.force", "bar.force", "tip.position"})
            EXPECT_LT((law.vector(n, channel) - spring.vector(n, channel)).norm(), 1e-9 * 400) << channel << " row " << n;
}

// ---- Laws that remember: the slider and spring of examples/minimal_law
// ----------------------------------------------------

constexpr double kSlipStiffness = 1e6, kSlip = 100, kThrown = 0.5;  // N/m, N, m/s

/// A body thrown against it.
RecordedRun thrown(Held held, double step, double duration) {
    const std::string parts =
        held == Held::body
            ? fmt::format("[[body]]\nname = \"m\"\nmass = {}\ninertia = [1, 2, 3]\nvelocity = [0, 0, {}]\n", kMass, kThrown)
            : fmt::format(
                  "[nodes]\nm = {{ position = [0, 0, 0], velocity = [0, 0, {}], fixed = [\"x\", \"y\", \"rx\", \"ry\", "
                  "\"rz\"] }}\n[[element]]\nname = \"mass\"\ntype = \"point_mass\"\nat = \"m\"\nmass = {}\n",
                  kThrown, kMass);
    return RecordedRun(
        fmt::format("[simulation]\nstep = {}\nduration = {}\n[output]\nstep = {}\n{}\n[[element]]\nname = "
                    "\"pad\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"m\"\nz = {{ law = \"jenkins\", "
                    "stiffness = {}, slip = {} }}\n",
                    step, duration, step, parts, kSlipStiffness, kSlip),
        {test::paths::jenkins()});
}

// Oracle: closed form. It sticks up to 100 N, then slides under that force until its energy but the stored ½ F²/k is gone,
// at F/k + (½ m v² − ½ F²/k)/F, and swings about F/k before that for ever.
TEST(LawsWithMemory, AThrownBodySlidesAsFarAsItsEnergyLasts) {
    const double stored = 0.5 * kSlip * kSlip / kSlipStiffness, energy = 0.5 * kMass * kThrown * kThrown;
    const double turn = kSlip / kSlipStiffness + (energy - stored) / kSlip;
    for (Held held : {Held::body, Held::node}) {
        for (double step : {2e-4, 1e-4}) {
            const RecordedRun run = thrown(held, step, 0.03);
            double farthest = 0, nearest = 1;
            for (size_t n = 0; n < run.count(); ++n) {
                const double z = run(n, "m.position.z");
                farthest = std::max(farthest, z);
                if (run(n, "time") > 0.02) nearest = std::min(nearest, z);
                EXPECT_LE(std::abs(run(n, "pad.force.z")), kSlip * (1 + 1e-12));
                EXPECT_NEAR(run(n, "energy.kinetic") + run(n, "energy.strain") + run(n, "energy.dissipated"), energy,
                            1e-9 * energy);
            }
            const double slack = 40 * step * step;  // of second order
            EXPECT_NEAR(farthest, turn, slack);
            EXPECT_NEAR(nearest, turn - 2 * kSlip / kSlipStiffness, slack);
            EXPECT_NEAR(run(run.count() - 1, "energy.dissipated"), energy - stored, 2 * kSlip * slack);
        }
    }
}

// Oracle: conservation, through impacts on a stop with k h^2/m of 5e4: a trial that lands beyond the
// kink must not be taken for the end.
TEST(LawsWithKinks, ABodyBouncesWithoutGainingEnergy) {
    for (double speed : {0.344, 0.21, 0.127, 0.0371}) {
        const RecordedRun run(
            fmt::format("[simulation]\nstep = 1e-3\nduration = 0.05\n[output]\nstep = 1e-3\n[[body]]\nname = \"b\"\nmass = "
                        "2\ninertia "
                        "= [1, 1, 1]\nvelocity = [0, 0, {}]\n[[element]]\nname = \"stop\"\ntype = \"spring_damper\"\nfrom = "
                        "\"ground\"\nto = \"b\"\nstiffness = [0, 0, 0]\nz = {{ law = \"faulty\", stiffness = 1e11 }}\n",
                        speed),
            {test::paths::binary_dir() + "/tests/faulty/law_gap.so"});
        const double energy = speed * speed;
        double most = 0;
        for (size_t n = 0; n < run.count(); ++n) {
            EXPECT_NEAR(run(n, "energy.kinetic") + run(n, "energy.strain"), energy, 1e-8 * energy) << speed << " " << n;
            most = std::max(most, run(n, "stop.force.z"));
        }
        EXPECT_GT(most, 0);
    }
}

// Oracle: the energy that the slider takes and the spring keeps; from springs that the step follows to ones 70 times too
// stiff for it, where Newton's tangents lead from sticking to sliding and back for ever.
TEST(LawsWithKinks, StiffFrictionIsFound) {
    // A pendulum elsewhere, and a joint that holds the body itself: neither takes anything of its energy
    const std::string alone,
        pendulum =
            "[[body]]\nname = \"p\"\nmass = 1\ninertia = [0.01, 0.01, 0.01]\nposition = [5, 0, 0]\n"
            "[[joint]]\nname = \"pin\"\ntype = \"hinge\"\nbetween = [\"ground\", \"p\"]\n"
            "anchor = [5, 0, 0.5]\naxis = [0, 1, 0]\n",
        slide =
            "[[joint]]\nname = \"slide\"\ntype = \"slider\"\nbetween = [\"ground\", \"b\"]\n"
            "axis = [0.6, 0, 0.8]\n";
    for (const std::string& beside : {alone, pendulum, slide})
        for (double stiffness : {1e7, 3e7, 1e8, 1e9, 1e10})
            for (double speed : {0.02, 0.1, 0.5, 2.0}) {
                const Eigen::Vector3d v =
                    speed * (beside == slide ? Eigen::Vector3d(0.6, 0, 0.8) : Eigen::Vector3d::UnitZ());
                const RecordedRun run(
                    fmt::format(
                        "[simulation]\nstep = 1e-3\nduration = 0.02\n[[body]]\nname = \"b\"\nmass = 2\ninertia = "
                        "[1, 1, 1]\nvelocity = [{}, {}, {}]\n[[element]]\nname = \"pad\"\ntype = "
                        "\"spring_damper\"\nfrom = \"ground\"\nto = \"b\"\nz = {{ law = \"jenkins\", stiffness = {}, "
                        "slip = 1e3 }}\n{}",
                        v.x(), v.y(), v.z(), stiffness, beside),
                    {test::paths::jenkins()});
                const size_t last = run.count() - 1;
                EXPECT_NEAR(run(last, "energy.kinetic") + run(last, "energy.strain") + run(last, "energy.dissipated"),
                            speed * speed, 1e-7 * speed * speed)
                    << stiffness << " " << speed << "\n"
                    << beside;
            }
}

// The same for masses in a row inside a network, each on a pad of its own: few, whose laws are found together in every step,
// and more, of which they are only where a step is slow.
TEST(LawsWithKinks, StiffFrictionInsideANetworkIsFound) {
    // On a guide, a hinge that is rigid but along its z, in place of what is fixed and the pads
    for (const bool is_guided : {false, true})
        for (int count : {1, 2, 14})
            for (double other : {0.01, 1.0})
                for (double stiffness : {1e8, 1e10})
                    for (double speed : {0.1, 0.5}) {
                        std::string nodes, parts;
                        for (int i = 0; i < count; ++i) {
                            nodes += fmt::format("m{} = {{ position = [0, 0, {}], velocity = [0, 0, {}]{} }}\n", i, 0.1 * i,
                                                 speed, is_guided ? "" : ", fixed = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]");
                            parts += fmt::format(
                                "[[element]]\nname = \"mass{0}\"\ntype = \"point_mass\"\nat = \"m{0}\"\nmass = {1}\n"
                                "[[element]]\nname = \"pad{0}\"\ntype = \"{3}\"\nfrom = \"ground\"\nto = "
                                "\"m{0}\"\nz = {{ law = \"jenkins\", stiffness = {2}, slip = 1e3 }}\n",
                                i, i == 0 ? 2 : other, stiffness, is_guided ? "elastic_hinge" : "spring_damper");
                            if (i > 0)
                                parts += fmt::format(
                                    "[[element]]\nname = \"link{0}\"\ntype = \"spring_damper\"\nfrom = \"m{1}\"\nto = "
                                    "\"m{0}\"\nstiffness = [0, 0, 1e6]\n",
                                    i, i - 1);
                        }
                        const RecordedRun run("[simulation]\nstep = 1e-3\nduration = 0.03\n[nodes]\n" + nodes + parts,
                                              {test::paths::jenkins()});
                        const double energy = 0.5 * (2 + (count - 1) * other) * speed * speed;
                        for (size_t n = 1; n < run.count(); ++n)
                            ASSERT_NEAR(run(n, "energy.kinetic") + run(n, "energy.strain") + run(n, "energy.dissipated"),
                                        energy, 1e-6 * energy)
                                << count << " " << other << " " << stiffness << " " << speed << (is_guided ? " guided" : "")
                                << " row " << n;
                    }
}

// Oracle: conservation. A pendulum elsewhere has the means of its velocities in the rows, the body on the spring has not.
TEST(LawsWithKinks, AJointElsewhereTakesNoEnergy) {
    const RecordedRun run(
        "[simulation]\nstep = 1e-3\nduration = 0.1\n[[body]]\nname = \"b\"\nmass = 2\ninertia = [1, 1, 1]\nvelocity = [0, "
        "0, "
        "20]\n[[element]]\nname = \"pad\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"b\"\nz = { law = \"cubic\", "
        "stiffness = 1e3, cubic = 1e9 }\n[[body]]\nname = \"p\"\nmass = 1\ninertia = [0.01, 0.01, 0.01]\nposition = [5, 0, "
        "0]\n"
        "[[joint]]\nname = \"pin\"\ntype = \"hinge\"\nbetween = [\"ground\", \"p\"]\nanchor = [5, 0, 0.5]\naxis = [0, 1, "
        "0]\n");
    for (size_t n = 0; n < run.count(); ++n) EXPECT_NEAR(run(n, "energy.residual"), 0, 1e-12 * 400) << n;
}

// Oracle: conservation, where the first of Newton's trials is beyond all bounds: 1e15 N/m³.
TEST(LawsWithKinks, AHardCubicSpringIsFound) {
    for (const double speed : {2.7, 20.0, 2000.0}) {
        const RecordedRun run(fmt::format(
            "[simulation]\nstep = 1e-3\nduration = 0.02\n[[body]]\nname = \"b\"\nmass = 2\ninertia = [1, 1, 1]\nvelocity = "
            "[0, 0, {}]\n[[element]]\nname = \"pad\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"b\"\nz = {{ law = "
            "\"cubic\", stiffness = 1e3, cubic = 1e15 }}\n",
            speed));
        const double energy = speed * speed;
        for (size_t n = 0; n < run.count(); ++n)
            EXPECT_NEAR(run(n, "energy.kinetic") + run(n, "energy.strain"), energy, 1e-7 * energy) << speed << " " << n;
    }
}

}  // namespace
}  // namespace dttmm::host
