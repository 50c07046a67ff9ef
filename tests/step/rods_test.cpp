// SPDX-License-Identifier: BSD-3-Clause
//
// Rods in time: rigid directions across the axes, and trusses of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using test::RecordedRun;

// Oracle: the same rod along x. In 100 random directions, near and far from the origin, divided or not, with turned nodes,
// from either end, the same shock makes the same way along it.
TEST(Rods, LieInAnyDirection) {
    std::mt19937 dice(7);
    std::normal_distribution<double> number;
    const auto vector = [&] { return Vector3d(number(dice), number(dice), number(dice)); };
    const auto text = [](const Vector3d& x) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", x.x(), x.y(), x.z()); };
    const auto way = [&](const Vector3d& start, const Vector3d& direction, const Vector3d& turn, int segments, bool turned) {
        const Vector3d end = start + direction;
        const RecordedRun rows(fmt::format(R"(
[simulation]
duration = "2 ms"
step = "0.1 ms"
[nodes]
root = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = {{ position = {}, rotation = {{ axis = {}, angle = "50 deg" }} }}
[[load]]
on = "tip"
direction = {}
force = {{ type = "haversine", peak = 1e5, start = 0, width = "1 ms" }}
[[element]]
name = "r"
type = "rod"
from = "{}"
to = "{}"
segments = {}
section = {{ circle = "20 mm" }}
material = {{ E = "200 GPa", poisson = 0.3, density = 7800 }}
)",
                                           text(start), text(end), text(turn), text(direction.normalized()),
                                           turned ? "tip" : "root", turned ? "root" : "tip", segments));
        const Vector3d last = rows.last("tip.position");
        EXPECT_LT((last - end).cross(direction.normalized()).norm(), 1e-9);
        return (last - end).dot(direction.normalized());
    };
    for (int segments : {1, 2, 10}) {
        const double expected = way(Vector3d::Zero(), {1, 0, 0}, {0, 0, 1}, segments, false);
        EXPECT_GT(std::abs(expected), 1e-5);
        for (int i = 0; i < 34; ++i) {
            const Vector3d direction = vector().normalized(), start = (i % 3 == 0 ? 50.0 : 1.0) * vector();
            EXPECT_NEAR(way(start, direction, vector(), segments, i % 2 == 1), expected, 1e-6 * std::abs(expected))
                << segments << " along " << direction.transpose();
        }
    }
}

/// A machine turned and shifted as a whole.
struct Place {
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    Vector3d shift = Vector3d::Zero();
    std::string point(const Vector3d& x) const { return text(shift + turn * x); }
    std::string direction(const Vector3d& x) const { return text(turn * x); }
    std::string axes(const Eigen::Quaterniond& own) const {
        const Eigen::AngleAxisd all(turn * own);
        return fmt::format("{{ axis = {}, angle = {:.17g} }}", text(all.axis()), all.angle());
    }
    static std::string text(const Vector3d& x) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", x.x(), x.y(), x.z()); }
};

/// Where a body stands at the end, seen from the machine [m].
Vector3d end_of(const Place& place, const std::string& model) {
    return place.turn.inverse() * (RecordedRun(model).last("arm.position") - place.shift);
}

constexpr const char* kSection = R"(section = { circle = "20 mm" }
material = { E = "200 GPa", poisson = 0.3, density = 7800 }
)";

/// A body that swings on a rod between two ball joints, which leave the rod free to spin about itself.
Vector3d swing_on_a_link(const Place& place, double length, int segments, bool turned) {
    const Vector3d end = length * Vector3d(0.31, -0.52, 0.77);
    constexpr const char* kBall = "stiffness = { rx = \"free\", ry = \"free\", rz = \"free\" }\n";
    return end_of(place, fmt::format(R"(
[simulation]
duration = "20 ms"
step = "0.1 ms"
gravity = {}
[nodes]
g = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
p = {}
q = {}
[[body]]
name = "arm"
mass = 2
inertia = [0.1, 0.12, 0.13]
position = {}
rotation = {}
angular_velocity = {}
[[element]]
name = "p1"
type = "elastic_hinge"
from = "g"
to = "p"
{}[[element]]
name = "p2"
type = "elastic_hinge"
from = "q"
to = "arm"
{}[[element]]
name = "rod"
type = "rod"
from = "{}"
to = "{}"
segments = {}
{})",
                                     place.direction({1, -2, -9}), place.point(Vector3d::Zero()),
                                     place.point(Vector3d::Zero()), place.point(end), place.point(end),
                                     place.axes(Eigen::Quaterniond::Identity()), place.direction({1, 2, -3}), kBall, kBall,
                                     turned ? "q" : "p", turned ? "p" : "q", segments, kSection));
}

/// A turning body with a rod that stands out from it and is pulled at its end.
Vector3d pull_at_a_spoke(const Place& place, double length, int segments, bool turned) {
    return end_of(
        place, fmt::format(R"(
[simulation]
duration = "20 ms"
step = "0.1 ms"
[nodes]
tip = {}
[[body]]
name = "arm"
mass = 3.3
inertia = [0.1, 0.12, 0.09]
position = {}
rotation = {}
angular_velocity = {}
[[load]]
on = "tip"
direction = {}
force = {{ type = "haversine", peak = 330, start = 0, width = "15 ms" }}
[[element]]
name = "rod"
type = "rod"
from = "{}"
to = "{}"
segments = {}
{})",
                           place.point(length * Vector3d(0.37, -0.74, 0.56)), place.point(Vector3d::Zero()),
                           place.axes(Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vector3d(0.2, -0.7, 1.1).normalized()))),
                           place.direction({0.3, 0.7, -1.1}), place.direction({0.38, 0.89, -0.25}), turned ? "arm" : "tip",
                           turned ? "tip" : "arm", segments, kSection));
}

// Oracle: the same machine unturned. Which rigid direction belongs to which frame is no matter of rounding: links between
// ball joints and spokes of turning bodies, 20 mm to 8 m, near and far from the origin, divided or not, from either end.
TEST(Rods, OnMovingBodiesRunInAnyDirection) {
    constexpr int kDirections = 10;
    std::mt19937 dice(5);
    std::normal_distribution<double> number;
    const auto vector = [&] { return Vector3d(number(dice), number(dice), number(dice)); };
    for (const auto machine : {swing_on_a_link, pull_at_a_spoke}) {
        for (int segments : {1, 2, 3, 10}) {
            for (double length : {0.02, 0.1, 0.3, 8.0}) {
                const Vector3d expected = machine({}, length, segments, false);
                for (int i = 0; i < kDirections; ++i) {
                    const Place place{
                        Eigen::Quaterniond(number(dice), number(dice), number(dice), number(dice)).normalized(),
                        (i % 3 == 0 ? 30.0 : 1.0) * vector()};
                    EXPECT_LT((machine(place, length, segments, i % 2 == 1) - expected).norm(), 1e-6 * (length + 1))
                        << (machine == swing_on_a_link ? "link of " : "spoke of ") << length << " m in " << segments << ", "
                        << i;
                }
            }
        }
    }
}

// Oracle: a rod stretches only, so its tip turns with the body that it stands on. The tip has a mass or none and no inertia
// of its own: the damper along the rod has a lever on it by rounding alone, more of that far from the origin. h^2 w^3/6
// parts the two, 4e-4 rad/s.
TEST(Rods, ATipTurnsWithItsBody) {
    std::mt19937 dice(11);
    std::normal_distribution<double> number;
    const auto vector = [&] { return Vector3d(number(dice), number(dice), number(dice)); };
    for (const char* mass : {"", "[[element]]\nname = \"mass\"\ntype = \"point_mass\"\nat = \"tip\"\nmass = 0.0713\n"})
        for (int segments : {1, 2, 7})
            for (int i = 0; i < 10; ++i) {
                const Place place{Eigen::Quaterniond(number(dice), number(dice), number(dice), number(dice)).normalized(),
                                  (i < 6 ? 1.0 : 1e4) * vector()};
                const RecordedRun rows(fmt::format(R"(
[simulation]
duration = "20 ms"
step = "1 ms"
gravity = {}
[nodes]
tip = {}
[[body]]
name = "arm"
mass = 3.3
inertia = [0.1, 0.12, 0.09]
position = {}
angular_velocity = {}
[[element]]
name = "rod"
type = "rod"
from = "arm"
to = "tip"
segments = {}
section = {{ tube = [0.037, 0.016] }}
material = {{ E = 3.1e11, poisson = 0.3, density = 1609, stiffness_damping = 4.7e-5 }}
{})",
                                                   place.direction({1, -2, -9}), place.point({0.37, -0.74, 0.56}),
                                                   place.point(Vector3d::Zero()), place.direction({3, 7, -11}), segments,
                                                   mass));
                for (size_t n = 0; n < rows.count(); ++n)
                    EXPECT_LT((rows.vector(n, "tip.angular_velocity") - rows.vector(n, "arm.angular_velocity")).norm(), 1e-3)
                        << mass << segments << " " << i << " row " << n;
            }
}

// Oracle: statics, u = K⁻¹ f with K = Σ EA/l e eᵀ. Rods between pins that leave all rotations free, at an angle to the axes;
// the load comes slowly.
TEST(Rods, ATrussBetweenPinsCarriesByTheRods) {
    const Vector3d tip(1.0, 1.3, 0), force(6000, -8000, 0);
    const Vector3d feet[] = {{0, 0, 0}, {2.2, 0.1, 0}, {0.3, -0.9, 0}};
    Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
    std::string elements, nodes = "tip = { position = [1.0, 1.3, 0], fixed = [\"z\", \"rx\", \"ry\", \"rz\"] }\n";
    for (int i = 0; i < 3; ++i) {
        const Vector3d bar = tip - feet[i];
        const Eigen::Vector2d e = bar.head<2>() / bar.norm();
        K += 200e9 * M_PI * 1e-4 / bar.norm() * e * e.transpose();
        nodes += fmt::format(
            "w{0} = {{ position = [{1}, {2}, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }}\n"
            "a{0} = [{1}, {2}, 0]\nb{0} = [1.0, 1.3, 0]\n",
            i, feet[i].x(), feet[i].y());
        elements += fmt::format(R"([[element]]
name = "foot{0}"
type = "elastic_hinge"
from = "w{0}"
to = "a{0}"
stiffness = {{ rx = "free", ry = "free", rz = "free" }}
[[element]]
name = "head{0}"
type = "elastic_hinge"
from = "b{0}"
to = "tip"
stiffness = {{ rx = "free", ry = "free", rz = "free" }}
[[element]]
name = "bar{0}"
type = "rod"
from = "a{0}"
to = "b{0}"
segments = 3
section = {{ circle = "20 mm" }}
material = {{ E = "200 GPa", poisson = 0.3, density = 7800, stiffness_damping = 1e-4 }}
)",
                                i);
    }
    const RecordedRun rows("[simulation]\nduration = 0.4\nstep = 1e-4\n[nodes]\n" + nodes + elements + R"([[element]]
name = "m"
type = "point_mass"
at = "tip"
mass = 50
[[load]]
on = "tip"
direction = [0.6, -0.8, 0]
force = { type = "step", from = 0, to = 10000, start = 0, end = 0.1 }
)");
    const Vector3d last = rows.last("tip.position");
    const Eigen::Vector2d expected = K.inverse() * force.head<2>();
    EXPECT_LT(((last - tip).head<2>() - expected).norm(), 1e-3 * expected.norm());
}

}  // namespace
}  // namespace dttmm::host
