// SPDX-License-Identifier: BSD-3-Clause
//
// Springs along lines with a force at the start: its stiffness is in the modes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/rotation.h"
#include "modal/modal_analysis.h"
#include "modal/respond_at.h"
#include "support/linear_algebra.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;
using test::tube;
using testing::HasSubstr;

dttmm_modal_model all_of(const dttmm_network& network) { return {&network, 0, nullptr, 0b111111, 0, nullptr}; }

/// A bead of 0.3 kg between two springs of ugly lengths along one line, under a force.
NetworkModel bead(double force) {
    const Vector3 way = Vector3(0.3, -0.7, 0.5).normalized(), at(0.4, 0.1, -0.2);
    NetworkModel network;
    network.node("a", DTTMM_NODE_GROUND, at - 0.7 * way);
    network.node("b", DTTMM_NODE_GROUND, at + 1.1 * way);
    network.node("m", DTTMM_NODE_INNER, at).fixed = 0b111000;
    network.element("bead", "point_mass", {"m"}, {{"mass", {0.3}}});
    network.element("first", "axial_spring", {"a", "m"}, {{"stiffness", {500}}, {"preload", {force}}});
    network.element("second", "axial_spring", {"m", "b"},
                    {{"law", {1}}, {"stiffness", {200}}, {"cubic", {3e5}}, {"preload", {force}}});
    return network;
}

// Oracle: closed form. Across, a string under tension: F (1/L1 + 1/L2); along it the tangents of the laws, of the cubic one
// at the elongation at which it has the force.
TEST(ForcesAtStart, ABeadOnAStringVibratesAcrossByItsTension) {
    constexpr double kForce = 40;
    double d = 0.05;
    for (int i = 0; i < 20; ++i) d -= (200 * d + 3e5 * d * d * d - kForce) / (200 + 9e5 * d * d);
    const double across = std::sqrt(kForce * (1 / 0.7 + 1 / 1.1) / 0.3) / (2 * std::numbers::pi),
                 along = std::sqrt((500 + 200 + 9e5 * d * d) / 0.3) / (2 * std::numbers::pi);
    const NetworkModel model = bead(kForce);
    const dttmm_network network = model.description();
    ModalAnalysis analysis(all_of(network));
    ASSERT_EQ(analysis.find_modes(3, 0), 3u);
    const double expected[] = {across, across, along};
    for (uint32_t m = 0; m < 3; ++m) {
        dttmm_mode mode;
        analysis.mode(m, &mode, nullptr, nullptr, nullptr);
        EXPECT_NEAR(mode.frequency, expected[m], 1e-9 * expected[m]) << m;
        EXPECT_LT(mode.residual, 1e-6);  // of the overall transfer equation
    }
    EXPECT_NEAR(analysis.force_at_start(1), kForce, 1e-12 * kForce);
    EXPECT_EQ(analysis.force_at_start(0), 0);
    // At rest the response is that of the stiffness
    const Vector3 side = Vector3(0.3, -0.7, 0.5).unitOrthogonal();
    Vector6 push = Vector6::Zero();
    push.head<3>() = side;
    const std::vector<double> nodes = respond_at(analysis, 0, 2, push, 3);
    const Vector3 answer(nodes[24], nodes[26], nodes[28]);
    EXPECT_LT((answer - side / (kForce * (1 / 0.7 + 1 / 1.1))).norm(), 1e-12);
}

// A compressed one gives way to the side: that is said, and no frequency invented.
TEST(ForcesAtStart, WhatWouldGrowIsRefused) {
    const NetworkModel model = bead(-15);
    const dttmm_network network = model.description();
    for (bool is_response : {false, true}) {
        ModalAnalysis analysis(all_of(network));
        try {
            if (is_response)
                respond_at(analysis, 3, 2, Vector6::UnitX(), 3);
            else
                analysis.find_modes(3, 0);
            FAIL() << "accepted";
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
            EXPECT_THAT(error.what(), HasSubstr("2 of its motions would grow"));
        }
    }
}

/// A body in space on five springs, each with another force, at points off its centre.
struct Rope {
    Vector3 ground, point;  ///< world, at the start
    double stiffness, force;
};
const Rope kRopes[] = {{{1.0, 0.2, 0.9}, {0.21, 0.03, 0.12}, 900, 60},
                       {{-0.8, 0.5, 0.7}, {-0.17, 0.11, 0.05}, 1400, 35},
                       {{0.1, -1.2, -0.4}, {0.02, -0.19, -0.07}, 700, 80},
                       {{0.3, 0.9, -1.1}, {0.09, 0.14, -0.13}, 1100, -12},
                       {{-0.9, -0.6, -0.5}, {-0.11, -0.08, 0.16}, 800, 45}};
const Vector3 kCentre(0.013, -0.021, 0.017);

/// Their energy when the body has moved by u and turned by a rotation vector about its centre.
double energy(const Vector6& u) {
    double sum = 0;
    for (const Rope& rope : kRopes) {
        const Vector3 point = kCentre + u.head<3>() + rotation_from_vector(Vector3(u.tail<3>())) * (rope.point - kCentre);
        const double natural = (rope.point - rope.ground).norm() - rope.force / rope.stiffness;
        sum += 0.5 * rope.stiffness * std::pow((point - rope.ground).norm() - natural, 2);
    }
    return sum;
}

// Oracle: the second differences of the springs' energy.
TEST(ForcesAtStart, LeversTurnWithTheBody) {
    NetworkModel model;
    Matrix3 inertia;
    inertia << 0.021, 0.004, -0.002, 0.004, 0.033, 0.003, -0.002, 0.003, 0.027;
    // Every point is a node of the body; the first is that in whose axes it is given
    std::vector<std::string> points;
    for (size_t r = 0; r < std::size(kRopes); ++r) {
        model.node("g" + std::to_string(r), DTTMM_NODE_GROUND, kRopes[r].ground);
        points.push_back("p" + std::to_string(r));
        model.node(points.back(), DTTMM_NODE_INNER, kRopes[r].point);
    }
    const Vector3 centre = kCentre - kRopes[0].point;
    model.element("body", "rigid_body", points,
                  {{"mass", {2.3}},
                   {"center_of_mass", {centre.x(), centre.y(), centre.z()}},
                   {"inertia.xx", {inertia(0, 0)}},
                   {"inertia.yy", {inertia(1, 1)}},
                   {"inertia.zz", {inertia(2, 2)}},
                   {"inertia.xy", {inertia(0, 1)}},
                   {"inertia.xz", {inertia(0, 2)}},
                   {"inertia.yz", {inertia(1, 2)}}});
    for (size_t r = 0; r < std::size(kRopes); ++r) {
        // Some from the ground to the body, some the other way
        const std::string ground = "g" + std::to_string(r);
        model.element("rope" + std::to_string(r), "axial_spring",
                      r % 2 == 0 ? std::vector{ground, points[r]} : std::vector{points[r], ground},
                      {{"stiffness", {kRopes[r].stiffness}}, {"preload", {kRopes[r].force}}});
    }
    constexpr double e = 2e-4;
    Matrix6 K, M = Matrix6::Zero();
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
            const auto at = [&](double a, double b) { return energy(a * e * Vector6::Unit(i) + b * e * Vector6::Unit(j)); };
            K(i, j) = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * e * e);
        }
    M.diagonal().head<3>().setConstant(2.3);
    M.bottomRightCorner<3, 3>() = inertia;
    const test::Pencil exact = test::solve_pencil(0.5 * (K + K.transpose()), M);
    const dttmm_network network = model.description();
    ModalAnalysis analysis(all_of(network));
    ASSERT_EQ(analysis.find_modes(6, 0), 6u);
    for (uint32_t m = 0; m < 6; ++m) {
        dttmm_mode mode;
        std::vector<double> shares(network.element_count);
        analysis.mode(m, &mode, nullptr, nullptr, shares.data());
        EXPECT_NEAR(std::pow(2 * std::numbers::pi * mode.frequency, 2) / exact.values(m), 1, 1e-6) << m;
        double sum = 0;
        for (double share : shares) sum += share;
        EXPECT_NEAR(sum, 1, 1e-9);
    }
}

// Oracle: the second difference of the spring's energy by the angle of a flap on a hinge. The reaction of the hinge has a
// lever too: without it the flap would turn about its centre of mass, and tension would seem to stiffen what it softens.
TEST(ForcesAtStart, AHingeBearsThem) {
    const Vector3 pivot(0.2, -0.1, 0.4), centre(0.31, 0.03, -0.02), ball(0.19, 0.05, -0.015), anchor(0.06, 0.02, -0.24);
    const Matrix3 turned = rotation_from_vector(Vector3(0.3, -0.5, 0.2));
    const double stiffness = 3500, mass = 6.4, about = 0.21;
    for (double preload : {140.0, -140.0}) {
        NetworkModel model;
        model.node("wall", DTTMM_NODE_GROUND, pivot, turned);
        model.node("frame", DTTMM_NODE_GROUND, pivot + turned * anchor, turned);
        model.node("pivot", DTTMM_NODE_INNER, pivot, turned);
        model.node("ball", DTTMM_NODE_INNER, pivot + turned * ball, turned);
        model.element("flap", "rigid_body", {"pivot", "ball"},
                      {{"mass", {mass}},
                       {"center_of_mass", {centre.x(), centre.y(), centre.z()}},
                       {"inertia.xx", {0.05}},
                       {"inertia.yy", {about}},
                       {"inertia.zz", {0.24}}});
        model.element("hinge", "elastic_hinge", {"wall", "pivot"}, {{"stiffness.ry", {0}}});
        model.element("spring", "axial_spring", {"frame", "ball"}, {{"stiffness", {stiffness}}, {"preload", {preload}}});
        const double natural = (ball - anchor).norm() - preload / stiffness;
        const auto energy_at = [&](double angle) {
            const Vector3 at = rotation_from_vector(Vector3(0, angle, 0)) * ball;
            return 0.5 * stiffness * std::pow((at - anchor).norm() - natural, 2);
        };
        constexpr double e = 1e-3;
        const double k = (energy_at(e) - 2 * energy_at(0) + energy_at(-e)) / (e * e),
                     inertia = about + mass * (centre.x() * centre.x() + centre.z() * centre.z());
        const dttmm_network network = model.description();
        ModalAnalysis analysis(all_of(network));
        ASSERT_EQ(analysis.find_modes(1, 0), 1u);
        dttmm_mode mode;
        analysis.mode(0, &mode, nullptr, nullptr, nullptr);
        EXPECT_NEAR(mode.frequency, std::sqrt(k / inertia) / (2 * std::numbers::pi), 2e-5 * mode.frequency) << preload;
    }
}

/// The lowest frequencies of a flap on a hinge at the tip of a beam, drawn by a spring along a line, and of a second beam
/// that has nothing to do with it; all turned [Hz].
std::vector<double> flap_on_beam(const Matrix3& turned) {
    const auto at = [&](double x, double y, double z) { return Vector3(turned * Vector3(x, y, z)); };
    NetworkModel model;
    model.node("wall", DTTMM_NODE_GROUND, at(-0.9, 0, 0), turned);
    model.node("frame", DTTMM_NODE_GROUND, at(0.3, 0.1, -0.7), turned);
    model.node("floor", DTTMM_NODE_GROUND, at(2, 1, 0.3), turned);
    model.node("tip", DTTMM_NODE_INNER, at(0, 0, 0), turned);
    model.node("pivot", DTTMM_NODE_INNER, at(0, 0, 0), turned);
    model.node("ball", DTTMM_NODE_INNER, at(0.19, 0.05, -0.015), turned);
    model.node("top", DTTMM_NODE_INNER, at(2, 1, 1.4), turned);
    model.element("arm", "beam", {"wall", "tip"}, tube(4));
    model.element("post", "beam", {"floor", "top"}, tube(3));
    model.element("flap", "rigid_body", {"pivot", "ball"},
                  {{"mass", {6.4}},
                   {"center_of_mass", {0.31, 0.03, -0.02}},
                   {"inertia.xx", {0.05}},
                   {"inertia.yy", {0.21}},
                   {"inertia.zz", {0.24}}});
    model.element("hinge", "elastic_hinge", {"tip", "pivot"}, {{"stiffness.ry", {0}}});
    model.element("spring", "axial_spring", {"frame", "ball"}, {{"stiffness", {3500}}, {"preload", {140}}});
    const dttmm_network network = model.description();
    ModalAnalysis analysis(all_of(network));
    std::vector<double> frequencies(analysis.find_modes(8, 0));
    for (uint32_t m = 0; m < frequencies.size(); ++m) {
        dttmm_mode mode;
        analysis.mode(m, &mode, nullptr, nullptr, nullptr);
        frequencies[m] = mode.frequency;
    }
    return frequencies;
}

// Oracle: the same machine along the axes. Far below zero, where the masses bear the reactions, the waves of a beam
// overflow.
TEST(ForcesAtStart, BeamsBesideThemMayStandAnyWay) {
    const std::vector<double> along_axes = flap_on_beam(Matrix3::Identity());
    ASSERT_GE(along_axes.size(), 8u);
    for (int i = 0; i < 12; ++i) {
        const std::vector<double> turned =
            flap_on_beam(rotation_from_vector(Vector3(0.3 * i - 1, 0.2 + 0.1 * i, 0.7 - 0.23 * i)));
        ASSERT_EQ(turned.size(), along_axes.size()) << i;
        for (size_t m = 0; m < turned.size(); ++m)
            EXPECT_NEAR(turned[m], along_axes[m], 1e-8 * along_axes[m]) << i << ' ' << m;
    }
}

}  // namespace
}  // namespace dttmm::plugin
