// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_forces.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "modal/line_waves.h"

namespace dttmm::plugin {
namespace {

constexpr double kPiece = 1.7;

Section slender() {
    Section s;
    s.EA = 4e8, s.EIy = 3e5, s.EIz = 7e5, s.GJ = 2e5;
    s.GAy = s.GAz = std::numeric_limits<double>::infinity();
    s.mass = 16, s.inertia = 0.05;
    return s;
}

/// What axial forces, from one end to the other, add to the stiffness of a piece between two stations.
Matrix12 under(double first, double last) {
    Line line;
    line.axes = Matrix3::Identity();
    line.section = slender();
    const LineWaves waves(line, kPiece, Directions(0b111111));
    Vector6 a = Vector6::Zero(), b = a;
    a(0) = first;
    b(0) = last;
    return LineForces({a, b}, kPiece, Vector6::Zero()).stiffness(0, kPiece, 0, line.section.GJ, waves.static_shapes());
}

// Oracle: the geometric stiffness of a beam with cubic deflections, ∫ N v'² ds, of a force N and of N (1 − s/L).
TEST(LineForces, AxialForceMakesTheGeometricStiffness) {
    constexpr double kN = 913;
    const Matrix12 even = under(kN, kN), falling = under(kN, 0);
    const auto near = [](double found, double expected) { EXPECT_NEAR(found, expected, 1e-9 * std::abs(expected)); };
    near(even(1, 1), 1.2 * kN / kPiece);
    near(even(1, 5), 0.1 * kN);
    near(even(5, 5), 2 * kN * kPiece / 15);
    near(even(5, 11), -kN * kPiece / 30);
    near(even(2, 4), -0.1 * kN);
    near(falling(1, 1), 0.6 * kN / kPiece);
    near(falling(5, 5), kN * kPiece / 10);
    near(falling(11, 11), kN * kPiece / 30);
    near(falling(4, 4), kN * kPiece / 10);
    EXPECT_LT((even - even.transpose()).norm(), 1e-12 * even.norm());
}

/// As joints of equal segments tell them, the outer ones a quarter of a segment inside the ends.
LineForces under_uniform_load(double q, int segments) {
    std::vector<Vector6> joints;
    for (int k = 0; k <= segments; ++k) {
        const double step = kPiece / segments, s = step * k,
                     at = k == 0          ? 0.25 * step
                          : k == segments ? kPiece - 0.25 * step
                                          : s;
        Vector6 forces = Vector6::Zero();
        forces(1) = q * (kPiece / 2 - s);
        forces(5) = -q * s * (kPiece - s) / 2 - forces(1) * (at - s);  // the load stands in the middles of the segments
        joints.push_back(forces);
    }
    static const Section section = slender();
    return {joints, kPiece, Vector6::Zero(), &section};
}

// Oracle: of a beam that sags by w under a uniform load, ∫ w'·u' ds = q L⁴/(120 EI) for the cubic u of a unit rotation of an
// end, and the energy ½ EA/L (Δu_x + ∫ w'·u' ds)².
TEST(LineForces, ABentAxisCouplesBendingAndTension) {
    constexpr double kLoad = 370;
    const Section section = slender();
    Line line;
    line.axes = Matrix3::Identity();
    line.section = section;
    const LineWaves waves(line, kPiece, Directions(0b111111));
    const Matrix12 K = under_uniform_load(kLoad, 40).stiffness_of_axis(0, kPiece, section.EA, waves.static_shapes());
    const double longer = kLoad * std::pow(kPiece, 4) / (120 * section.EIz), along = section.EA / kPiece;
    const auto near = [](double found, double expected) { EXPECT_NEAR(found, expected, 2e-3 * std::abs(expected)); };
    near(K(0, 5), -along * longer);
    near(K(6, 5), along * longer);
    near(K(6, 11), -along * longer);
    near(K(5, 5), along * longer * longer);
    near(K(5, 11), -along * longer * longer);
    EXPECT_NEAR(K(6, 1), 0, 1e-6 * along * longer);  // a shift bends nothing
    EXPECT_NEAR(K(6, 4), 0, 1e-12 * along * longer);
    EXPECT_EQ(K(0, 0), 0);
    EXPECT_EQ(K, K.transpose());
}

// Oracle: the slope of the sag at the ends by hand, which a parabola of that slope and length L turns into L/4 of it, over
// the radius of gyration: 0.04 wants √(0.04/5e-5) pieces, a hundredth of it three.
TEST(LineForces, PiecesByTheBend) {
    const Section section = slender();
    const double radius = std::sqrt(section.EIy / section.EA), load = 24 * section.EIz / std::pow(kPiece, 3) * 4 / kPiece;
    EXPECT_EQ(under_uniform_load(0.04 * radius * load, 40).pieces(section), 29);
    EXPECT_EQ(under_uniform_load(0.0004 * radius * load, 40).pieces(section), 3);
    EXPECT_EQ(under_uniform_load(0.9e-5 * radius * load, 40).pieces(section), 1);
}

// Oracle: the parabola of a beam under a uniform load.
TEST(LineForces, MomentsAreAsTheShearWantsThem) {
    constexpr double kQ = 310;
    for (const int segments : {1, 3, 8}) {
        const LineForces forces = under_uniform_load(kQ, segments);
        for (const double s : {0.0, 0.11, 0.9, kPiece}) {
            EXPECT_NEAR(forces.at(s)(1), kQ * (kPiece / 2 - s), 1e-12 * kQ);
            EXPECT_NEAR(forces.at(s)(5), -kQ * s * (kPiece - s) / 2, 1e-12 * kQ) << s;
        }
        EXPECT_NEAR(forces.mean_force().y(), 0, 1e-12 * kQ);
    }
}

// Oracle: the shares by hand. A share of 1e-5 of the bending stiffness moves the lowest frequency of a mast by less than
// 3e-6. Sixteen times as much wants two pieces if it is an axial force, four if it is the square of a moment.
TEST(LineForces, PiecesByTheShareOfTheStiffness) {
    const Section section = slender();
    const double along = M_PI * M_PI * section.EIy / (kPiece * kPiece),
                 across = std::sqrt(section.EIy * section.GJ) / kPiece;
    const auto pieces = [&](Eigen::Index direction, double size, int segments = 8) {
        std::vector<Vector6> forces;
        for (int k = 0; k <= segments; ++k) forces.push_back((1 - 2.0 * k / segments) * size * Vector6::Unit(direction));
        return LineForces(forces, kPiece, Vector6::Zero()).pieces(section);
    };
    EXPECT_EQ(pieces(0, 0.9e-5 * along), 1);
    EXPECT_EQ(pieces(0, 1.1e-5 * along), 2);
    EXPECT_EQ(pieces(0, 1.59e-5 * along), 2);
    EXPECT_EQ(pieces(0, 1.61e-5 * along), 3);
    EXPECT_EQ(pieces(0, 0.3 * along), 8) << "its segments at most";
    EXPECT_EQ(pieces(0, 0.3 * along, 1), 1);
    for (const Eigen::Index moment : {3, 4, 5}) {
        EXPECT_EQ(pieces(moment, 0.99 * std::sqrt(1e-5) * across), 1);
        EXPECT_EQ(pieces(moment, 1.01 * std::sqrt(1e-5) * across), 2);
        EXPECT_EQ(pieces(moment, 0.99 * std::sqrt(16e-5) * across), 4);
    }
}

}  // namespace
}  // namespace dttmm::plugin
