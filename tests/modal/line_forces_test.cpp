// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_forces.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <functional>
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

LineShapes shapes_of(const Section& section) {
    Line line;
    line.axes = Matrix3::Identity();
    line.section = section;
    return LineWaves(line, kPiece, Directions(0b111111)).static_shapes();
}

/// All of a line as one piece whose waves know no axial force.
Matrix12 stiffness(const LineForces& forces, const Section& section) {
    return forces.stiffness({0, 1, Matrix3::Identity(), kPiece, {}, {}}, section, shapes_of(section));
}

/// Points at equal steps along x, beside which the line lies by `beside` in y.
std::vector<Vector3> points(int segments, const std::function<double(double)>& beside = {}) {
    std::vector<Vector3> all;
    for (int k = 0; k <= segments; ++k) {
        const double s = kPiece * k / segments;
        all.emplace_back(s, beside ? beside(s) : 0, 0);
    }
    return all;
}

/// What axial forces, from one end to the other, add to the stiffness of a piece between two stations.
Matrix12 under(double first, double last) {
    Vector6 a = Vector6::Zero(), b = a;
    a(0) = first;
    b(0) = last;
    return stiffness({points(1), {a, b}, Vector6::Zero()}, slender());
}

// A load that rises along a line from 2 q/3 to 5 q/3. Oracle: N by hand, its mean by the sum of many places.
TEST(LineForces, AForceIsQuadraticUnderALoadThatRises) {
    constexpr double kLoad = 913;
    const Vector3 way(2.0 / 3, -1.0 / 3, 2.0 / 3);  // of the line and of the load
    const auto axial = [&](double s) { return kPiece * kLoad * (2.0 / 3 * (1 - s) + 0.5 * (1 - s * s)); };
    for (const bool turns : {false, true})
        for (const int segments : {1, 3}) {
            std::vector<Vector3> places;
            std::vector<Vector6> forces(static_cast<size_t>(segments) + 1, Vector6::Zero());
            Matrix3 axes;
            axes << way, Vector3(2, 2, -1) / 3, Vector3(-1, 2, 2) / 3;
            for (int k = 0; k <= segments; ++k) {
                const double s = static_cast<double>(k) / segments;
                places.emplace_back(kPiece * s * way);
                forces[static_cast<size_t>(k)].head<3>() = axial(s) * way;
            }
            Vector6 turning = Vector6::Zero();
            turning(0) = turns ? kLoad * 2 / 3 : 0;
            turning(3) = turns ? kLoad * 5 / 3 : 0;
            LineForces line(places, forces, turning);
            if (!turns) line.set_rise(kPiece * kLoad * way);
            line.set_sections(std::vector<Matrix3>(static_cast<size_t>(segments), axes), {way, way});
            for (const double s : {0.0, 0.17, 0.5, 0.81, 1.0})
                EXPECT_NEAR((line.at(s).head<3>() - axial(s) * way).norm(), 0, 1e-12 * axial(0)) << s;
            for (const auto& [from, to] : {std::pair(0.0, 1.0), std::pair(0.11, 0.93), std::pair(0.4, 0.5)}) {
                double mean = 0;
                for (int k = 0; k < 1000; ++k) mean += axial(from + (to - from) * (k + 0.5) / 1000) / 1000;
                EXPECT_NEAR(line.mean_force(from, to).dot(way), mean, 1e-6 * axial(0)) << from;
            }
        }
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

/// Forces of a load q per length between pins.
LineForces under_uniform_load(double q, int segments) {
    std::vector<Vector6> stations;
    for (int k = 0; k <= segments; ++k) {
        const double s = kPiece * k / segments;
        Vector6 forces = Vector6::Zero();
        forces(1) = q * (kPiece / 2 - s);
        forces(5) = -q * s * (kPiece - s) / 2;
        stations.push_back(forces);
    }
    return {points(segments), stations, Vector6::Zero()};
}

// Oracle: of a beam that a uniform moment bends, w' = κ (s − L/2), ∫ w'·u' ds of the cubic u = s (1 − s/L)² and of the other
// end is κ L²/12, and the energy ½ EA/L (Δu_x + ∫ w'·u' ds)². The difference of two EA leaves out what the moment does.
TEST(LineForces, ABentAxisCouplesBendingAndTension) {
    constexpr double kMoment = 900;
    const Section section = slender();
    Section stiff = section;
    stiff.EA *= 3;
    Vector6 moment = Vector6::Zero();
    moment(5) = kMoment;
    const LineForces forces(points(1), {moment, moment}, Vector6::Zero());
    const Matrix12 K = stiffness(forces, stiff) - stiffness(forces, section);
    const double longer = -kMoment / section.EIz * kPiece * kPiece / 12, along = 2 * section.EA / kPiece;
    const auto near = [](double found, double expected) { EXPECT_NEAR(found, expected, 1e-8 * std::abs(expected)); };
    near(K(0, 5), -along * longer);
    near(K(6, 5), along * longer);
    near(K(6, 11), -along * longer);
    near(K(5, 5), along * longer * longer);
    near(K(5, 11), -along * longer * longer);
    EXPECT_NEAR(K(6, 1), 0, 1e-9 * along * std::abs(longer));  // a shift bends nothing
    EXPECT_NEAR(K(6, 4), 0, 1e-9 * along * std::abs(longer));
    EXPECT_NEAR(K(0, 0), 0, 1e-9 * along);
}

// Oracle: the force method for an arc of curvature κ about z, clamped at its start, in first order of κ: with y = ∫ φ, φ = κ
// (s − L/2), a force along z and a moment about x at its end couple by ∫ (−y − φ (L − s))/GJ + φ (L − s)/EIy ds = κ L³ (1/(6
// GJ) − 1/(12 EIy)). By the inverse, and the balance of the whole, a rotation of its start about y makes a moment about x at
// its end of −κ (EIy − GJ/2). What the moment does as it turns, −½ M ∫ (θ_x θ_y' − θ_y θ_x') ds, is zero.
TEST(LineForces, ABentAxisCouplesBendingAndTorsion) {
    constexpr double kMoment = 40;
    const Section section = slender();
    Vector6 moment = Vector6::Zero();
    moment(5) = kMoment;
    const Matrix12 K = stiffness({points(1), {moment, moment}, Vector6::Zero()}, section);
    const double expected = -(section.EIy - 0.5 * section.GJ) * kMoment / section.EIz;
    EXPECT_NEAR(K(9, 4), expected, 1e-6 * std::abs(expected));
    EXPECT_NEAR(K(4, 9), expected, 1e-6 * std::abs(expected));
}

/// A line in a plane, bent by a moment and a force at its start and by a load per length, its axis by Runge and Kutta's
/// method, turned into an oblique plane.
struct Arc {
    std::vector<Vector3> points;
    std::vector<Vector6> forces;
    std::vector<Matrix3> axes;
    std::array<Vector3, 2> ends;
    double energy = 0;  ///< ∫ EI κ² ds
};

Arc arc_of(double bending, double moment, const Vector3& force, double load) {
    constexpr int kSegments = 256, kSteps = 4;
    const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 0.5).normalized()).toRotationMatrix();
    Arc arc;
    Eigen::VectorXd y(5);  // place, angle, moment, force across
    y << 0, 0, 0, moment, force.y();
    const auto rate = [&](const Eigen::VectorXd& at) {
        Eigen::VectorXd change(5);
        const double c = std::cos(at(2)), s = std::sin(at(2));
        change << c, s, at(3) / bending, s * force.x() - c * at(4), load;
        return change;
    };
    const double h = kPiece / kSegments / kSteps;
    for (int k = 0; k <= kSegments; ++k) {
        const Vector3 along = turn * Vector3(std::cos(y(2)), std::sin(y(2)), 0);
        Vector6 forces;
        forces << turn * Vector3(force.x(), y(4), 0), turn * Vector3(0, 0, y(3));
        arc.points.push_back(turn * Vector3(y(0), y(1), 0));
        arc.forces.push_back(forces);
        if (k == 0) arc.ends[0] = along;
        arc.ends[1] = along;
        if (k == kSegments) break;
        arc.axes.push_back(turn);
        arc.energy += y(3) * y(3) / bending * kPiece / kSegments;
        for (int i = 0; i < kSteps; ++i) {
            const Eigen::VectorXd k1 = rate(y), k2 = rate(y + 0.5 * h * k1), k3 = rate(y + 0.5 * h * k2),
                                  k4 = rate(y + h * k3);
            y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        }
    }
    return arc;
}

/// Its stiffness by so many pieces, of its ends alone.
Matrix12 by_pieces(const Arc& arc, const Section& section, int count) {
    LineForces line(arc.points, arc.forces, Vector6::Zero());
    line.set_sections(arc.axes, arc.ends);
    const auto n = static_cast<Eigen::Index>(6 * (count + 1));
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    Eigen::Index at = 0;
    for (const LineForces::Piece& piece : line.cut(count, section)) {
        Section scaled = section;
        for (double* stiffness : {&scaled.EA, &scaled.EIy, &scaled.EIz, &scaled.GJ})
            *stiffness *= piece.length * count / line.length();
        Line own;
        own.axes = piece.axes;
        own.section = scaled;
        const LineShapes shapes = LineWaves(own, piece.length, Directions(0b111111), piece.axial).static_shapes();
        Matrix12 turn = Matrix12::Zero();
        for (int i : {0, 3, 6, 9}) turn.block<3, 3>(i, i) = piece.axes;
        K.block<12, 12>(at, at) += turn * (shapes.stiffness + line.stiffness(piece, scaled, shapes)) * turn.transpose();
        at += 6;
    }
    Eigen::MatrixXd ends = Eigen::MatrixXd::Zero(n, 12);
    ends.topLeftCorner<6, 6>().setIdentity();
    ends.bottomRightCorner<6, 6>().setIdentity();
    if (count > 1) ends.middleRows(6, n - 12) = -K.block(6, 6, n - 12, n - 12).ldlt().solve(K.middleRows(6, n - 12) * ends);
    return ends.transpose() * K * ends;
}

// Oracle: many pieces, the limit of which is the same however they are made; and a round section may spin about a bent axis.
// The stiffness of bent lines erred by the square of the length of a piece.
TEST(LineForces, PiecesOfABentLineConvergeFastAndSpinFreely) {
    struct Case {
        double EIz, moment;
        Vector3 force;
        double load;
    };
    const Case cases[] = {{3e5, 6e4, {0, 0, 0}, 0},     {3e5, 1e5, {0, 6e4, 0}, 0}, {3e5, 0, {0, -8e4, 0}, 1e5},
                          {3e5, 1e5, {5e5, 6e4, 0}, 0}, {9e5, 1e5, {0, 6e4, 0}, 0}, {9e5, 2e5, {2e6, 6e4, 0}, 0}};
    for (const Case& bent : cases) {
        Section section = slender();
        section.EA = 4e9;
        section.EIz = bent.EIz;
        const Arc arc = arc_of(bent.EIz, bent.moment, bent.force, bent.load);
        const Matrix12 fine = by_pieces(arc, section, 32), four = by_pieces(arc, section, 4),
                       eight = by_pieces(arc, section, 8);
        Vector12 spin = Vector12::Zero();
        for (int end : {0, 1}) spin.segment<3>(6 * end + 3) = arc.ends[as_size(end)];
        EXPECT_GT((four - fine).norm(), 10 * (eight - fine).norm()) << bent.EIz << " " << bent.moment;
        EXPECT_LT((eight - fine).norm(), 3e-4 * fine.norm()) << bent.EIz << " " << bent.moment;
        const auto held = [&](const Matrix12& K) { return spin.dot(K * spin); };
        if (bent.EIz != section.EIy) {  // the spin is held by the difference of both
            EXPECT_GT(std::abs(held(four - fine)), 10 * std::abs(held(eight - fine))) << bent.EIz << " " << bent.moment;
            continue;
        }
        EXPECT_NEAR(held(four), 0, 1e-9 * arc.energy) << bent.moment;
    }
}

// Oracle: a sag of 0.024 of the radius of gyration wants 0.024/3e-3 pieces, less than 0.006 two.
TEST(LineForces, PiecesByTheBend) {
    const Section section = slender();
    const double radius = std::sqrt(section.EIy / section.EA);
    const auto pieces = [&](double share) {
        const auto sag = [&](double s) { return share * radius * 4 * s / kPiece * (1 - s / kPiece); };
        const LineForces forces(points(40, sag), std::vector<Vector6>(41, Vector6::Zero()), Vector6::Zero());
        EXPECT_NEAR(forces.bend(section), share, 1e-9 * share);
        return forces.pieces(section);
    };
    EXPECT_EQ(pieces(0.0239), 8);
    EXPECT_EQ(pieces(0.0241), 9);
    EXPECT_EQ(pieces(0.0004), 2);
    EXPECT_EQ(pieces(0.9e-5), 1);
    EXPECT_EQ(pieces(0.9e-12), 0);
}

// Oracle: the parabola of a beam under a uniform load.
TEST(LineForces, MomentsAreAsTheShearWantsThem) {
    constexpr double kQ = 310;
    for (const int segments : {1, 3, 8}) {
        const LineForces forces = under_uniform_load(kQ, segments);
        for (const double s : {0.0, 0.11, 0.9, kPiece}) {
            EXPECT_NEAR(forces.at(s / kPiece)(1), kQ * (kPiece / 2 - s), 1e-12 * kQ);
            EXPECT_NEAR(forces.at(s / kPiece)(5), -kQ * s * (kPiece - s) / 2, 1e-12 * kQ) << s;
        }
        EXPECT_NEAR(forces.mean_force().y(), 0, 1e-12 * kQ);
        EXPECT_NEAR(forces.mean_force(0.1, 0.7).y(), kQ * kPiece * 0.1, 1e-12 * kQ);
    }
}

// Oracle: the shares by hand. A share of 1e-5 of the bending stiffness moves the lowest frequency of a mast by less than
// 3e-6. Sixteen times as much wants two pieces if it is an axial force that is not linear, four if it is the square of a
// moment. The waves know a linear axial force.
TEST(LineForces, PiecesByTheShareOfTheStiffness) {
    const Section section = slender();
    const double along = M_PI * M_PI * section.EIy / (kPiece * kPiece),
                 across = std::sqrt(section.EIy * section.GJ) / kPiece;
    const auto pieces = [&](Eigen::Index direction, const std::function<double(double)>& size, int segments = 8) {
        std::vector<Vector6> forces;
        for (int k = 0; k <= segments; ++k) forces.push_back(size(2.0 * k / segments - 1) * Vector6::Unit(direction));
        return LineForces(points(segments), forces, Vector6::Zero()).pieces(section);
    };
    const auto axial = [&](double share, int segments = 8) {  // of zero mean
        return pieces(
            0, [&](double x) { return x == 0 ? 0 : (x < 0 ? -1 : 1) * (1 - std::abs(x)) * share * along / 0.75; }, segments);
    };
    EXPECT_EQ(pieces(0, [&](double x) { return x * along; }), 0) << "linear";
    EXPECT_EQ(axial(0.9e-12), 0);
    EXPECT_EQ(axial(1.1e-12), 1);
    EXPECT_EQ(axial(0.9e-5), 1);
    EXPECT_EQ(axial(1.1e-5), 2);
    EXPECT_EQ(axial(1.59e-5), 2);
    EXPECT_EQ(axial(1.61e-5), 3);
    EXPECT_EQ(axial(0.3), 8) << "its segments at most";
    const auto rising = [&](double share) {  // half-way farthest from linear
        LineForces forces(points(8), std::vector<Vector6>(9, Vector6::Zero()), Vector6::Zero());
        forces.set_rise(Vector3(8 * share * along, 0, 0));
        return forces.pieces(section);
    };
    EXPECT_EQ(rising(0.9e-12), 0);
    EXPECT_EQ(rising(1.1e-12), 1);
    EXPECT_EQ(rising(1.59e-5), 2);
    EXPECT_EQ(rising(9.9e-2), 18) << "more than its segments";
    for (const Eigen::Index moment : {3, 4, 5}) {
        const auto with = [&](double share) { return pieces(moment, [&](double) { return std::sqrt(share) * across; }); };
        const double softest = section.EIy / std::min(section.GJ, section.EIy);  // nothing is as share of bending alone
        EXPECT_EQ(with(0.98e-12 * softest), 0);
        EXPECT_EQ(with(1.02e-12 * softest), 1);
        EXPECT_EQ(with(0.98e-5), 1);
        EXPECT_EQ(with(1.02e-5), 2);
        EXPECT_EQ(with(15.7e-5), 4);
    }
}

}  // namespace
}  // namespace dttmm::plugin
