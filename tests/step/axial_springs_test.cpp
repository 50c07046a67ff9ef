// SPDX-License-Identifier: BSD-3-Clause
//
// Springs along lines that move far: against integrations of their equations of motion, and a known mechanism.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/adaptive_ode.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using test::RecordedRun;

constexpr double kGravity = 9.80665;

std::string simulation(double step, double duration, bool has_gravity, const char* more = "") {
    return fmt::format("[simulation]\nstep = {:.17g}\nduration = {}\n{}\n{}\n[output]\nstep = {:.17g}\n", step, duration,
                       has_gravity ? fmt::format("gravity = [0, 0, {}]", -kGravity) : "", more, step);
}

/// Largest error by which a position differs from a path that is known at rows of a run.
double worst(const RecordedRun& run, const std::string& channel, const std::function<Vector3d(double)>& path, int stride) {
    double error = 0;
    for (size_t n = 0; n < run.count(); n += static_cast<size_t>(stride))
        error = std::max(error, (run.vector(n, channel) - path(run(n, "time"))).norm());
    return error;
}

// ---- A mass on a spring and damper that swings: cases 1 and 2 of Chrono's TSDA tests -------------------------------------

enum class Held { body, node };

/// Chrono's case 2: 1 kg at [0, 2, 0], k = 100 N/m, c = 5 N s/m to the origin, undeformed at the start, under gravity.
std::string swinging(Held held, double step, double duration, double natural, const char* law, const char* more = "") {
    const std::string mass = held == Held::body
                                 ? "[[body]]\nname = \"m\"\nmass = 1\nposition = [0, 2, 0]\n"
                                   "inertia = { xx = 0.04, yy = 0.1, zz = 0.1 }\n"
                                 : "[[element]]\nname = \"mass\"\ntype = \"point_mass\"\nat = \"m\"\nmass = 1\n";
    const std::string nodes =
        std::string("[nodes]\norigin = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }\n") +
        (held == Held::node ? "m = { position = [0, 2, 0], fixed = [\"rx\", \"ry\", \"rz\"] }\n" : "");
    return simulation(step, duration, true, more) + nodes + mass +
           fmt::format(
               "[[element]]\nname = \"s\"\ntype = \"axial_spring\"\nfrom = \"origin\"\nto = \"m\"\n{}\n"
               "natural_length = {}\n",
               law, natural);
}

Vector3d path_of_swing(double t, double k, double k3, double c, double natural) {
    Eigen::VectorXd y(4);
    y << 2, 0, 0, 0;  // y, z, y', z'
    y = test::integrate(
        [&](double, const Eigen::VectorXd& s) {
            const double length = s.head<2>().norm(), d = length - natural;
            const Eigen::Vector2d n = s.head<2>() / length;
            const double force = k * d + k3 * d * d * d + c * n.dot(s.tail<2>());
            Eigen::VectorXd rate(4);
            rate << s.tail<2>(), -force * n - Eigen::Vector2d(0, kGravity);
            return rate;
        },
        y, t);
    return {0, y(0), y(1)};
}

// Oracle: the equations of motion of a point in a plane, integrated to 1e-13.
TEST(AxialSprings, AMassOnOneSwingsToSecondOrder) {
    const struct {
        const char* law;
        double k, k3, c, natural;
    } cases[] = {{"stiffness = 100\ndamping = 5", 100, 0, 5, 2},
                 {"stiffness = 70\nlaw = \"cubic\"\ncubic = 90\ndamping = 0.4", 70, 90, 0.4, 1.7}};
    for (const auto& [law, k, k3, c, natural] : cases)
        for (Held held : {Held::body, Held::node}) {
            const auto path = [&](double t) { return path_of_swing(t, k, k3, c, natural); };
            double before = 0;
            for (int n : {1, 2, 4, 8}) {
                const RecordedRun run(swinging(held, 0.02 / n, 3, natural, law));
                const double error = worst(run, "m.position", path, 10 * n);
                if (n > 1) {
                    EXPECT_NEAR(before / error, 4, 0.35) << law << " " << n;
                }
                before = error;
            }
            EXPECT_LT(before, 2e-3);
        }
}

// Oracle: geometry, the law and the balance of the mass, in every row. Where directions are rigid, as at the node, dampers
// go by the increments of the length over two steps.
TEST(AxialSprings, RecordTheirForceAndLength) {
    constexpr double kStep = 0.005;
    for (Held held : {Held::body, Held::node}) {
        const RecordedRun run(swinging(held, kStep, 2, 1.7, "stiffness = 100\ndamping = 5"));
        for (size_t n = 1; n + 1 < run.count(); ++n) {
            const Vector3d x = run.vector(n, "m.position"), v = run.vector(n, "m.velocity");
            const double length = x.norm(),
                         rate = held == Held::body
                                    ? x.dot(v) / length
                                    : (run.vector(n + 1, "m.position").norm() - run.vector(n - 1, "m.position").norm()) /
                                          (2 * kStep);
            const double force = 100 * (length - 1.7) + 5 * rate;
            EXPECT_NEAR(run(n, "s.length"), length, 1e-12);
            EXPECT_NEAR(run(n, "s.force"), force, 1e-9);
            const Vector3d balance = -run(n, "s.force") * x / length - Vector3d(0, 0, kGravity);
            EXPECT_LT((run.vector(n, "m.acceleration") - balance).norm(), 1e-8);
        }
    }
}

// Oracle: conservation, without a damper: of energy and of the moment of momentum about the vertical
// within what second order allows, without drift.
TEST(AxialSprings, KeepEnergyAndMomentum) {
    for (double step : {0.01, 0.005}) {
        const RecordedRun run(simulation(step, 60, true) + R"(
[nodes]
origin = { position = [0.1, 0, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[body]]
name = "m"
mass = 1.3
position = [0, 2, 0]
velocity = [1.1, 0.2, -0.4]
inertia = { xx = 0.04, yy = 0.1, zz = 0.1 }
[[element]]
name = "s"
type = "axial_spring"
from = "origin"
to = "m"
stiffness = 120
preload = 30
)");
        const auto energy = [&](size_t n) {
            return run(n, "energy.kinetic") + run(n, "energy.strain") + 1.3 * kGravity * run(n, "m.position.z");
        };
        const auto momentum = [&](size_t n) {
            const Vector3d x = run.vector(n, "m.position") - Vector3d(0.1, 0, 0.3), v = run.vector(n, "m.velocity");
            return x.x() * v.y() - x.y() * v.x();
        };
        const size_t half = run.count() / 2;
        double most[2] = {0, 0}, turned[2] = {0, 0};
        for (size_t n = 0; n < run.count(); ++n) {
            most[n >= half] = std::max(most[n >= half], std::abs(energy(n) - energy(0)));
            turned[n >= half] = std::max(turned[n >= half], std::abs(momentum(n) - momentum(0)));
        }
        EXPECT_LT(most[0], 0.9 * std::pow(step / 0.01, 2)) << step;
        EXPECT_LT(most[1], 1.3 * most[0]) << step;
        EXPECT_LT(turned[0], 2e-3 * std::pow(step / 0.01, 2)) << step;
        EXPECT_LT(turned[1], 1.3 * turned[0]) << step;
    }
}

// ---- Levers: a body that swings and turns, case 4 of Chrono's TSDA tests with a cubic law --------------------------------

// Oracle: the planar equations of motion, integrated to 1e-13. The spring acts at an end of the body and at a point off the
// axis of a second, heavy one that it pulls along.
TEST(AxialSprings, TurnTheBodiesOnWhichTheyAct) {
    constexpr double kMass[2] = {1, 4}, kInertia[2] = {0.1, 0.7}, k = 50, k3 = 30, c = 0.7, natural = 1.2;
    const Eigen::Vector2d arm[2] = {{-0.6, 0.5}, {0.9, -0.2}};  // y, z in the bodies
    const auto model = [&](double step) {
        std::string text = simulation(step, 1.5, false);
        const double y[2] = {2, 0};
        for (int b : {0, 1})
            text += fmt::format(
                "[[body]]\nname = \"b{0}\"\nmass = {1}\nposition = [0, {2}, 0]\nvelocity = [0, 0, {3}]\n"
                "angular_velocity = [{4}, 0, 0]\ninertia = {{ xx = {5}, yy = {5}, zz = {5} }}\nmarkers = {{ p = [0, {6}, "
                "{7}] }}\n",
                b, kMass[b], y[b], b == 0 ? 1.5 : 0, b == 0 ? -2 : 3, kInertia[b], arm[b].x(), arm[b].y());
        return text + fmt::format(
                          "[[element]]\nname = \"s\"\ntype = \"axial_spring\"\nfrom = \"b1.p\"\nto = \"b0.p\"\nlaw = "
                          "\"cubic\"\nstiffness = {}\ncubic = {}\ndamping = {}\nnatural_length = {}\n",
                          k, k3, c, natural);
    };
    const auto path = [&](double t) {
        Eigen::VectorXd s(12);  // y z angle of both, their rates
        s << 2, 0, 0, 0, 0, 0, 0, 1.5, -2, 0, 0, 3;
        return test::integrate(
            [&](double, const Eigen::VectorXd& x) {
                Eigen::Vector2d p[2], lever[2], v[2];
                for (int b : {0, 1}) {
                    const double angle = x(3 * b + 2), w = x(6 + 3 * b + 2);
                    lever[b] = Eigen::Rotation2Dd(angle) * arm[b];
                    p[b] = x.segment<2>(3 * b) + lever[b];
                    v[b] = x.segment<2>(6 + 3 * b) + w * Eigen::Vector2d(-lever[b].y(), lever[b].x());
                }
                const Eigen::Vector2d line = p[0] - p[1];
                const Eigen::Vector2d n = line.normalized();
                const double d = line.norm() - natural;
                const Eigen::Vector2d F = (k * d + k3 * d * d * d + c * n.dot(v[0] - v[1])) * n;
                Eigen::VectorXd rate(12);
                rate.head<6>() = x.tail<6>();
                for (int b : {0, 1}) {
                    const Eigen::Vector2d own = b == 0 ? Eigen::Vector2d(-F) : F;
                    rate.segment<2>(6 + 3 * b) = own / kMass[b];
                    rate(6 + 3 * b + 2) = (lever[b].x() * own.y() - lever[b].y() * own.x()) / kInertia[b];
                }
                return rate;
            },
            s, t);
    };
    double before = 0;
    for (int n : {1, 2, 4}) {
        const RecordedRun run(model(0.005 / n));
        double error = 0;
        for (size_t row = 0; row < run.count(); row += static_cast<size_t>(30 * n)) {
            const Eigen::VectorXd exact = path(run(row, "time"));
            for (int b : {0, 1}) {
                const std::string name = fmt::format("b{}", b);
                const Vector3d x = run.vector(row, name + ".position");
                const Eigen::Matrix3d R = run.attitude(row, name);
                error = std::max(
                    {error, (x.tail<2>() - exact.segment<2>(3 * b)).norm(), std::abs(x.x()),
                     (R.bottomRightCorner<2, 2>() - Eigen::Rotation2Dd(exact(3 * b + 2)).toRotationMatrix()).norm()});
            }
        }
        if (n > 1) {
            EXPECT_NEAR(before / error, 4, 0.3) << n;
        }
        before = error;
    }
    EXPECT_LT(before, 2e-3);
}

// ---- In networks ---------------------------------------------------------------------------------------------------------

// Oracle: an equivalent model. In small motions a long spring along y is a spring_damper in y: from a body to the tip of a
// beam, which has no mass there, and from that to the ground, with a tension in both that the tip bears in balance.
TEST(AxialSprings, AreSpringDampersInSmallMotions) {
    const auto run_with = [](const char* load, const char* first, const char* second) {
        return RecordedRun(simulation(1e-4, 0.05, false) + fmt::format(R"(
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [0.7, 0, 0]
far = {{ position = [0.7, -300, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 30
position = [0.7, 300, 0]
inertia = {{ xx = 4, yy = 5, zz = 6 }}
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "tip"
segments = 3
section = {{ tube = ["50 mm", "30 mm"] }}
material = {{ E = "204 GPa", poisson = 0.26, density = "7800 kg/m^3" }}
[[load]]
on = "tip"
force = {{ type = "sine", amplitude = "100 N", frequency = "40 Hz" }}
direction = [0, 1, 0]
{}
[[element]]
name = "first"
from = "b"
to = "tip"
{}
[[element]]
name = "second"
from = "far"
to = "tip"
{}
)",
                                                                       load, first, second));
    };
    const RecordedRun across = run_with("", "type = \"spring_damper\"\nstiffness = [0, 2e5, 0]\ndamping = [0, 30, 0]",
                                        "type = \"spring_damper\"\nstiffness = [0, 7e4, 0]\ndamping = [0, 20, 0]"),
                      along = run_with("[[load]]\non = \"b\"\ndirection = [0, 1, 0]\nforce = 400",
                                       "type = \"axial_spring\"\nstiffness = 2e5\ndamping = 30\npreload = 400",
                                       "type = \"axial_spring\"\nstiffness = 7e4\ndamping = 20\npreload = 400");
    double most[2] = {0, 0}, apart[2] = {0, 0};
    for (size_t n = 0; n < across.count(); ++n)
        for (int i : {0, 1}) {
            const char* channel = i == 0 ? "tip.position" : "b.position";
            most[i] = std::max(most[i], (across.vector(n, channel) - across.vector(0, channel)).norm());
            apart[i] = std::max(apart[i], (across.vector(n, channel) - along.vector(n, channel)).norm());
        }
    for (int i : {0, 1}) {
        EXPECT_GT(most[i], 1e-6);
        EXPECT_LT(apart[i], 1e-5 * most[i]) << i;
    }
}

}  // namespace
}  // namespace dttmm::host
