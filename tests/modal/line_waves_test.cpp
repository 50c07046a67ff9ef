// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_waves.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.h"

namespace dttmm::plugin {
namespace {

constexpr double kRigid = std::numeric_limits<double>::infinity();
const Directions kAll("111111");

/// Every constant another; Euler-Bernoulli.
Line euler() {
    Line line;
    line.axes = Matrix3::Identity();
    Section& s = line.section;
    s.EA = 4e8, s.EIy = 3e5, s.EIz = 7e5, s.GJ = 2e5, s.GAy = s.GAz = kRigid;
    s.mass = 16, s.inertia = 0.05;
    return line;
}

/// The same with shear, rotary inertia and a mass axis beside the elastic one.
Line timoshenko() {
    Line line = euler();
    Section& s = line.section;
    s.GAy = 5e7, s.GAz = 8e7, s.rotary_y = 0.012, s.rotary_z = 0.028;
    s.offset_y = 0.02, s.offset_z = -0.03, s.inertia += s.mass * (0.02 * 0.02 + 0.03 * 0.03);
    return line;
}

constexpr double kLength = 1.7;

Matrix12 stiffness(const Line& line, double lambda, int count = 1, Directions active = kAll) {
    Matrix12 D;
    LineWaves(line, kLength, active).evaluate<double>(count, lambda, 1.0, D, nullptr);
    return D;
}

Matrix12 mass(const Line& line, double lambda) {
    Matrix12 D, M;
    LineWaves(line, kLength, kAll).evaluate<double>(1, lambda, 1.0, D, &M);
    return M;
}

void expect_near(const Matrix12& found, const Matrix12& expected, double relative) {
    // Forces by displacements, moments by rotations: each by the size of its row and column
    for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 12; ++j) {
            const double size = std::sqrt(std::abs(expected(i, i) * expected(j, j)));
            EXPECT_NEAR(found(i, j), expected(i, j), relative * size) << i << ", " << j;
        }
}

/// A bar of stiffness K = EA or GJ and inertia μ per length: b K cot bl at its ends, b = ω √(μ/K).
void expect_bar(const Matrix12& D, int d, double K, double mu, double omega) {
    const double b = omega * std::sqrt(mu / K), bl = b * kLength;
    EXPECT_NEAR(D(d, d), b * K / std::tan(bl), 1e-12 * K / kLength);
    EXPECT_NEAR(D(d, d + 6), -b * K / std::sin(bl), 1e-12 * K / kLength);
    EXPECT_NEAR(D(d + 6, d + 6), D(d, d), 1e-12 * K / kLength);
}

/// Euler's beam of [v0 θ0 v1 θ1], θ = v': the classical functions of L = βl.
Eigen::Matrix4d euler_beam(double EI, double mu, double omega) {
    const double l = kLength, L = l * std::pow(mu * omega * omega / EI, 0.25);
    const double s = std::sin(L), c = std::cos(L), S = std::sinh(L), C = std::cosh(L);
    const double f = EI / (1 - c * C) / (l * l * l);
    const double a = L * L * L * (c * S + s * C), b = L * L * s * S * l, g = L * L * L * (S + s), h = L * L * (C - c) * l,
                 p = L * (s * C - c * S) * l * l, q = L * (S - s) * l * l;
    Eigen::Matrix4d D;
    D << a, b, -g, h, b, p, -h, q, -g, -h, a, -b, h, q, -b, p;
    return f * D;
}

Eigen::Matrix4d part(const Matrix12& D, const std::array<int, 4>& at, const std::array<double, 4>& sign) {
    Eigen::Matrix4d out;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            out(i, j) = sign[static_cast<size_t>(i)] * sign[static_cast<size_t>(j)] *
                        D(at[static_cast<size_t>(i)], at[static_cast<size_t>(j)]);
    return out;
}

// Oracle: closed forms of bars and of Euler's beam, from far below the first frequency of the clamped line up to several
// above. Exact but for rounding, which 1 − cos L cosh L magnifies near its zeros and where it is small (L⁴/6): 1e-9 there.
TEST(LineWaves, HasTheDynamicStiffnessOfBarsAndOfEulersBeam) {
    for (const double omega : {40.0, 300.0, 1100.0, 4000.0}) {
        const Line line = euler();
        const Section& s = line.section;
        const Matrix12 D = stiffness(line, omega * omega);
        expect_bar(D, 0, s.EA, s.mass, omega);
        expect_bar(D, 3, s.GJ, s.inertia, omega);
        for (const bool in_xy : {true, false}) {
            const double EI = in_xy ? s.EIz : s.EIy;
            // θy turns z towards x: w' = −θy
            const Eigen::Matrix4d found =
                in_xy ? part(D, {1, 5, 7, 11}, {1, 1, 1, 1}) : part(D, {2, 4, 8, 10}, {1, -1, 1, -1});
            const Eigen::Matrix4d expected = euler_beam(EI, s.mass, omega);
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                    EXPECT_NEAR(found(i, j), expected(i, j),
                                1e-9 * EI / std::pow(kLength, 3 - i % 2 - j % 2) +
                                    1e-10 * std::sqrt(std::abs(expected(i, i) * expected(j, j))))
                        << omega << ": " << i << ", " << j;
        }
        EXPECT_EQ(D(0, 1), 0);
        EXPECT_EQ(D(1, 4), 0);
        EXPECT_EQ(D(3, 2), 0);
    }
}

// Oracle: Przemieniecki's stiffness of a beam with shear, φ = 12 EI/(κGA l²).
TEST(LineWaves, AtRestItIsTheStaticBeam) {
    const Line line = timoshenko();
    const Section& s = line.section;
    const double l = kLength;
    Matrix12 K = Matrix12::Zero();
    const auto bar = [&](int d, double k) {
        K(d, d) = K(d + 6, d + 6) = k;
        K(d, d + 6) = K(d + 6, d) = -k;
    };
    bar(0, s.EA / l);
    bar(3, s.GJ / l);
    const auto plane = [&](int v, int r, double sign, double EI, double GA) {
        const double phi = 12 * EI / (GA * l * l), f = EI / (l * l * l * (1 + phi));
        const std::array<int, 4> at{v, r, v + 6, r + 6};
        const std::array<double, 4> o{1, sign, 1, sign};
        Eigen::Matrix4d k;
        k << 12, 6 * l, -12, 6 * l, 6 * l, (4 + phi) * l * l, -6 * l, (2 - phi) * l * l, -12, -6 * l, 12, -6 * l, 6 * l,
            (2 - phi) * l * l, -6 * l, (4 + phi) * l * l;
        for (size_t i = 0; i < 4; ++i)
            for (size_t j = 0; j < 4; ++j)
                K(at[i], at[j]) = o[i] * o[j] * f * k(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    };
    plane(1, 5, 1, s.EIz, s.GAy);
    plane(2, 4, -1, s.EIy, s.GAz);
    expect_near(stiffness(line, 0), K, 1e-13);
}

// Oracle: −∂D/∂λ by differences of D; their own error is of the second order in the step.
TEST(LineWaves, ItsMassIsTheDerivativeOfItsStiffness) {
    for (const Line& line : {euler(), timoshenko()})
        for (const double lambda : {0.0, 3e4, 2.5e6, -4e5}) {
            const double step = 60;
            const Matrix12 difference = -(stiffness(line, lambda + step) - stiffness(line, lambda - step)) / (2 * step);
            expect_near(mass(line, lambda), difference, 2e-6);
        }
}

// Oracle: at rest the mass of a line moved as a whole is its mass and moves with its centre; inertia m l²/12 about it.
TEST(LineWaves, ItsMassMovedAsAWholeIsThatOfARigidBody) {
    const Line line = timoshenko();
    const Section& s = line.section;
    const Matrix12 M = mass(line, 0);
    Eigen::Matrix<double, 12, 6> whole = Eigen::Matrix<double, 12, 6>::Zero();  // about the start
    whole.topRows<6>().setIdentity();
    whole.bottomRows<6>().setIdentity();
    whole.block<3, 3>(6, 3) = -skew(Vector3(kLength, 0, 0));
    const Matrix6 found = whole.transpose() * M * whole;
    const double m = s.mass * kLength;
    const Vector3 c(kLength / 2, s.offset_y, s.offset_z);
    Matrix3 own =
        Vector3((s.inertia - s.mass * (c.y() * c.y() + c.z() * c.z())) * kLength,
                s.rotary_y * kLength + m * kLength * kLength / 12, s.rotary_z * kLength + m * kLength * kLength / 12)
            .asDiagonal();
    Matrix6 expected;
    expected << m * Matrix3::Identity(), -m * skew(c), m * skew(c), own - m * skew(c) * skew(c);
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-11 * m * kLength * kLength);
}

// Oracle: two halves joined at their middle are the whole.
TEST(LineWaves, TwoPiecesAreOne) {
    const Line line = timoshenko();
    for (const double lambda : {0.0, 2e5, 3e6}) {
        const Matrix12 half = stiffness(line, lambda, 2), whole = stiffness(line, lambda);
        const Matrix6 middle = half.bottomRightCorner<6, 6>() + half.topLeftCorner<6, 6>();
        const Matrix6 across = half.topRightCorner<6, 6>();
        const Eigen::PartialPivLU<Matrix6> lu(middle);
        Matrix12 joined;
        joined << half.topLeftCorner<6, 6>() - across * lu.solve(across.transpose()), -across * lu.solve(across),
            -across.transpose() * lu.solve(across.transpose()),
            half.bottomRightCorner<6, 6>() - across.transpose() * lu.solve(across);
        expect_near(joined, whole, 1e-10);
    }
}

// Oracle: transfer over s1 and then over s2 is that over both, and D follows from it: n0 on the start is −f.
TEST(LineWaves, TransfersMultiply) {
    const Line line = timoshenko();
    const LineWaves waves(line, kLength, kAll);
    Vector12 unit;  // of displacements and of forces
    unit << 1, 1, 1, 1, 1, 1, 1e6, 1e6, 1e6, 1e6, 1e6, 1e6;
    const auto in_units = [&](const Matrix12& U) {
        return Matrix12(unit.cwiseInverse().asDiagonal() * U * unit.asDiagonal());
    };
    for (const double lambda : {0.0, 7e4, 5e6}) {
        const Matrix12 one = in_units(waves.transfer(lambda, 0.6)), two = in_units(waves.transfer(lambda, 1.1)),
                       both = in_units(waves.transfer(lambda, kLength));
        EXPECT_LT((two * one - both).cwiseAbs().maxCoeff(), 1e-12 * both.cwiseAbs().maxCoeff()) << lambda;
        EXPECT_LT((one * two - both).cwiseAbs().maxCoeff(), 1e-12 * both.cwiseAbs().maxCoeff()) << lambda;

        const Matrix12 D = stiffness(line, lambda), U = waves.transfer(lambda, kLength);
        const Vector12 ends =
            (Vector12() << 1e-3, 2e-3, -1e-3, 0.01, 0.02, -0.03, 2e-3, -1e-3, 3e-3, 0.02, -0.01, 0.02).finished();
        Vector12 start;
        start << ends.head<6>(), -D.topRows<6>() * ends;
        const Vector12 end = U * start;
        EXPECT_LT((end.head<6>() - ends.tail<6>()).cwiseAbs().maxCoeff(), 1e-10 * ends.norm()) << lambda;
        EXPECT_LT((end.tail<6>() - D.bottomRows<6>() * ends).cwiseAbs().maxCoeff(),
                  1e-10 * (D.cwiseAbs() * ends.cwiseAbs()).maxCoeff())
            << lambda;
    }
    EXPECT_EQ(waves.transfer(5e6, 0), Matrix12::Identity());
}

// Oracle: frequencies of the clamped bar, π/l √(K/μ), and of the clamped Euler beam, 22.373/l² √(EI/μ): no piece has one
// below ω. And the bound is not wasteful: one and a half as many pieces as are needed, and one more, at most.
TEST(LineWaves, PiecesHeldAtTheirEndsStaySilent) {
    const Line line = euler();
    const Section& s = line.section;
    const LineWaves waves(line, kLength, kAll);
    int before = 0;
    for (double omega = 1; omega < 3e6; omega *= 1.7) {
        const int count = waves.pieces(omega, 100000);
        const double l = kLength / count;
        EXPECT_GT(M_PI / l * std::sqrt(s.EA / s.mass), omega);
        EXPECT_GT(M_PI / l * std::sqrt(s.GJ / s.inertia), omega);
        EXPECT_GT(22.3732854 / (l * l) * std::sqrt(s.EIy / s.mass), omega);
        EXPECT_GE(count, before);
        before = count;
        const double needed = std::max({1.0, omega * kLength / M_PI * std::sqrt(s.mass / s.EA),
                                        omega * kLength / M_PI * std::sqrt(s.inertia / s.GJ),
                                        kLength * std::sqrt(omega / 22.3732854 * std::sqrt(s.mass / s.EIy))});
        EXPECT_LE(count, 1.5 * needed + 1) << omega;
    }
    EXPECT_GT(before, 100);
    EXPECT_EQ(waves.pieces(1e9, 50), 51) << "more than asked for";
}

// Oracle: a held bar vibrates from ω² = π² K/(μ l²) on; half of that is used. A held beam is known not to below
// 4 π⁴ EI/(μ l⁴), by Wirtinger's inequalities for its deflection and its rotation.
TEST(LineWaves, PiecesAreThoseOfTheirBound) {
    const Line line = euler();
    const Section& s = line.section;
    const auto expect_pieces = [&](const char* directions, double most, double at_three) {
        const LineWaves waves(line, kLength, Directions(directions));
        EXPECT_EQ(waves.pieces(most * (1 - 1e-9), 100), 1) << directions;
        EXPECT_EQ(waves.pieces(most * (1 + 1e-9), 100), 2) << directions;
        EXPECT_EQ(waves.pieces(at_three * (1 - 1e-9), 100), 3) << directions;
        EXPECT_EQ(waves.pieces(at_three * (1 + 1e-9), 100), 4) << directions;
    };
    const double along = M_PI / kLength * std::sqrt(s.EA / s.mass / 2);
    expect_pieces("000001", along, 3 * along);
    const double about = M_PI / kLength * std::sqrt(s.GJ / s.inertia / 2);
    expect_pieces("001000", about, 3 * about);
    const double across = 2 * std::pow(M_PI / kLength, 2) * std::sqrt(s.EIz / s.mass / 2);
    expect_pieces("100010", across, 9 * across);
}

// Oracle: the inequality of the bound itself, written out for every direction, with the mass matrix of a section whose mass
// lies beside its axis. It holds for the pieces, and not for one piece less.
TEST(LineWaves, PiecesOfACoupledBeamAreThoseOfTheirBound) {
    constexpr double kLong = 500;  // hundreds of pieces: every term counts
    Line line = timoshenko();
    Section& s = line.section;
    s.GAy = 3e6, s.GAz = 4e6;
    const double y = s.offset_y, z = s.offset_z, m = s.mass, J = s.inertia;
    const double about_y = s.rotary_y + m * z * z, about_z = s.rotary_z + m * y * y;
    const auto share = [](double mixed, double one, double other) { return std::abs(mixed) / std::sqrt(one * other); };
    const double along_y = share(m * z, m, about_y), along_z = share(m * y, m, about_z), y_twist = share(m * z, m, J),
                 z_twist = share(m * y, m, J), yz = share(m * y * z, about_y, about_z);
    for (const double axial : {0.0, -2e6, 1e6})
        for (const double omega : {300.0, 3e3, 2e4, 1e5}) {
            const double lambda = 2 * omega * omega;
            const auto holds = [&](int count) {
                const double x = std::pow(kLong / count / M_PI, 2);
                const auto bends = [&](double EI, double GA, double mass, double rotary) {
                    const double a = 1 - axial / GA;
                    return lambda * mass * a * a * x * x / 4 +
                               (lambda * rotary + std::abs(axial * a) + EI * lambda * mass / GA) * x <=
                           EI;
                };
                return lambda * m * (1 + along_y + along_z) * x <= s.EA &&
                       lambda * J * (1 + z_twist + y_twist) * x <= s.GJ &&
                       bends(s.EIz, s.GAy, m * (1 + y_twist), about_z * (1 + along_z + yz)) &&
                       bends(s.EIy, s.GAz, m * (1 + z_twist), about_y * (1 + along_y + yz));
            };
            const int count = LineWaves(line, kLong, kAll, {axial, axial}).pieces(omega, 100000);
            EXPECT_TRUE(holds(count)) << axial << ": " << omega;
            if (count > 1) {
                EXPECT_FALSE(holds(count - 1)) << axial << ": " << omega;
            }
        }
}

// Oracle: π √(EI/|N a|) is the length at which a held beam may buckle by the bound, at rest. Where N = GA, a is zero and the
// deflection goes its own way: up to √2 π √(EI/(λ J)), and π √(GA/(λ µ)), whichever is shorter.
TEST(LineWaves, PiecesUnderPressureAndAsStrongATensionAsShear) {
    Line line = timoshenko();
    Section& s = line.section;
    s.offset_y = s.offset_z = 0, s.GAy = 3e6;
    const Directions plane("100010");
    for (const double axial : {-6e6, -2e6, 1e6}) {
        const double longest = M_PI * std::sqrt(s.EIz / std::abs(axial * (1 - axial / s.GAy)));
        for (const int count : {2, 5}) {
            EXPECT_EQ(LineWaves(line, (count - 1e-6) * longest, plane, {axial, axial}).pieces(0, 100), count) << axial;
            EXPECT_EQ(LineWaves(line, (count + 1e-6) * longest, plane, {axial, axial}).pieces(0, 100), count + 1) << axial;
        }
    }
    for (const double axial : {3e6 * (1 - 1e-12), 3e6, 3e6 * (1 + 1e-12)}) {
        const int count = LineWaves(line, kLength, plane, {axial, axial}).pieces(1e5, 100000);
        const double lambda = 2e10, x = std::pow(kLength / count / M_PI, 2);
        EXPECT_LE((lambda * s.rotary_z + s.EIz * lambda * s.mass / s.GAy) * x, s.EIz) << axial;
        EXPECT_LT(count, 200) << axial;
    }
}

// Oracle: from rest up to ω the transfer from the forces at one held end to the displacements at the other is never
// singular: no piece vibrates with its ends held.
TEST(LineWaves, PiecesOfABeamWithAllCouplingsStaySilent) {
    Line soft = timoshenko();
    soft.section.GAy = 3e5, soft.section.GAz = 4e5, soft.section.offset_y = 0.15, soft.section.inertia += 0.4;
    for (const Line& line : {timoshenko(), soft})
        for (const double axial : {0.0, -2e5, -2e6, 2e5, 9e6}) {
            const LineWaves waves(line, kLength, kAll, {axial, axial});
            for (double omega = 10; omega < 1e6; omega *= 3) {
                const int count = waves.pieces(omega, 100000);
                double before = 0;
                for (int k = 0; k <= 40; ++k) {
                    const double part = k / 40.0;
                    const Matrix12 U = waves.transfer(std::pow(part * omega, 2), kLength / count);
                    Vector6 unit;  // of displacement by force: balanced
                    unit << 1, 1, 1, count / kLength, count / kLength, count / kLength;
                    const Matrix6 across =
                        unit.cwiseInverse().asDiagonal() * U.topRightCorner<6, 6>() * unit.cwiseInverse().asDiagonal();
                    const double det = across.determinant();
                    EXPECT_TRUE(k == 0 || det * before > 0) << axial << ": " << omega << ", " << part;
                    before = det;
                }
            }
        }
}

// Oracle: without its deflection a bending plane does not move, and its rotation passes; a rod passes all but x.
TEST(LineWaves, PassesWhatTheModelDoesNotSpan) {
    EXPECT_EQ(LineWaves(euler(), kLength, kAll).passed(), Directions());
    EXPECT_EQ(LineWaves(euler(), kLength, Directions("101011")).passed(), Directions());          // rz, rx, y, x
    EXPECT_EQ(LineWaves(euler(), kLength, Directions("111001")).passed(), Directions("110000"));  // neither y nor z
    Line rod = euler();
    rod.stretches_only = true;
    EXPECT_EQ(LineWaves(rod, kLength, kAll).passed(), Directions("111110"));
    const Matrix12 D = stiffness(euler(), 1e4, 1, Directions("101011"));
    for (int d : {2, 4, 8, 10}) EXPECT_EQ(D.row(d).norm(), 0) << d;
    for (int d : {0, 1, 3, 5}) EXPECT_GT(D(d, d), 0) << d;
}

TEST(LineWaves, NamesTheStiffnessThatIsNeeded) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refused = [&](double Section::*value, const char* directions) -> std::string {
        Line line = euler();
        line.section.*value = nan;
        try {
            LineWaves(line, kLength, Directions(directions));
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
            return error.what();
        }
        return {};
    };
    EXPECT_THAT(refused(&Section::EIz, "100011"), testing::HasSubstr("section.EIz"));
    EXPECT_THAT(refused(&Section::EIy, "010101"), testing::HasSubstr("section.EIy"));
    EXPECT_THAT(refused(&Section::GJ, "001000"), testing::HasSubstr("section.GJ"));
    EXPECT_THAT(refused(&Section::GAy, "100011"), testing::HasSubstr("section.GAy"));
    EXPECT_THAT(refused(&Section::inertia, "001000"), testing::HasSubstr("section.inertia"));
    EXPECT_EQ(refused(&Section::EIy, "100011"), "");
    EXPECT_EQ(refused(&Section::inertia, "100011"), "");
}

// Oracle: elastic stiffness (1 + iωη) at a frequency: D of the line with E (1 + iωη), at rest exactly that factor.
TEST(LineWaves, DampingTurnsItsModulus) {
    const Line line = timoshenko();
    const LineWaves waves(line, kLength, kAll);
    LineWaves::Square<std::complex<double>> D;
    const std::complex<double> factor(1, 0.3);
    waves.evaluate<std::complex<double>>(1, 0.0, factor, D, nullptr);
    const Matrix12 K = stiffness(line, 0);
    EXPECT_LT((D - factor * K).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
    // A bar: b² = ω² μ/(EA (1 + iωη))
    const double omega = 3000;
    waves.evaluate<std::complex<double>>(1, omega * omega, factor, D, nullptr);
    Line straight = euler();
    const std::complex<double> b = omega * std::sqrt(straight.section.mass / (straight.section.EA * factor));
    LineWaves(straight, kLength, kAll).evaluate<std::complex<double>>(1, omega * omega, factor, D, nullptr);
    EXPECT_LT(std::abs(D(0, 0) - b * straight.section.EA * factor / std::tan(b * kLength)), 1e-12 * std::abs(D(0, 0)));
}

// Oracle: GJ φ'' = (F − λ I) φ in torsion, in closed form; coupled, the same equations by a Taylor series in many short
// steps.
TEST(LineWaves, WhatItsWeightDoesToItsRotations) {
    const auto twisted = [](double falling, double lambda) {
        Matrix3 F = Matrix3::Zero();
        F(0, 0) = falling;
        Matrix12 D;
        LineWaves(euler(), kLength, kAll, {}, F).evaluate<double>(1, lambda, 1.0, D, nullptr);
        return std::pair(D(3, 3), D(3, 9));
    };
    constexpr double kGJ = 2e5, kInertia = 0.05;
    for (const auto& [falling, lambda] : {std::pair(3e5, 0.0), {-2e5, 0.0}, {1e5, 5e6}}) {
        const double k2 = (falling - lambda * kInertia) / kGJ, k = std::sqrt(std::abs(k2)), x = k * kLength;
        const double own = kGJ * k / (k2 > 0 ? std::tanh(x) : std::tan(x)),
                     across = -kGJ * k / (k2 > 0 ? std::sinh(x) : std::sin(x));
        const auto [D33, D39] = twisted(falling, lambda);
        EXPECT_NEAR(D33, own, 1e-11 * std::abs(own)) << falling;
        EXPECT_NEAR(D39, across, 1e-11 * std::abs(across)) << falling;
    }

    Matrix3 F;
    F << -3e5, 2e4, -5e4, 2e4, 1.7e5, 4e4, -5e4, 4e4, -0.8e5;
    const Line line = timoshenko();
    constexpr double kLambda = 2e5;
    const LineWaves waves(line, kLength, kAll, {}, F);
    // [d; n]' = S [d; n] of the header
    Matrix12 S = Matrix12::Zero();
    const Section& own = line.section;
    const Vector3 c(0, own.offset_y, own.offset_z);
    const Matrix3 cross = (Matrix3() << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0).finished();
    Matrix6 M = Matrix6::Zero(), A = Matrix6::Zero();
    M.topLeftCorner<3, 3>() = own.mass * Matrix3::Identity();
    M.topRightCorner<3, 3>() = -own.mass * cross;
    M.bottomLeftCorner<3, 3>() = own.mass * cross;
    M.bottomRightCorner<3, 3>() = -own.mass * cross * cross;
    M(3, 3) = own.inertia;
    M.diagonal().tail<2>() += Eigen::Vector2d(own.rotary_y, own.rotary_z);
    A(1, 5) = 1;
    A(2, 4) = -1;
    S.topLeftCorner<6, 6>() = A;
    S.topRightCorner<6, 6>().diagonal() << 1 / own.EA, 1 / own.GAy, 1 / own.GAz, 1 / own.GJ, 1 / own.EIy, 1 / own.EIz;
    S.bottomLeftCorner<6, 6>() = -kLambda * M;
    S.bottomLeftCorner<6, 6>().bottomRightCorner<3, 3>() += F;
    S.bottomRightCorner<6, 6>() = -A.transpose();
    Matrix12 U = Matrix12::Identity();
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i) {
        Matrix12 term = U;
        for (int k = 1; k < 14; ++k) {
            term = (kLength / kSteps / k * (S * term)).eval();
            U += term;
        }
    }
    const Matrix12 found = waves.transfer(kLambda, kLength);
    for (Eigen::Index i = 0; i < 12; ++i) EXPECT_LT((found - U).row(i).norm(), 1e-9 * U.row(i).norm()) << i;
    Matrix12 D;
    waves.evaluate<double>(1, kLambda, 1.0, D, nullptr);
    EXPECT_LT((D - D.transpose()).norm(), 1e-12 * D.norm());
    // A piece that is held tips over where √(−F/GJ) l reaches π
    Matrix3 tips = Matrix3::Zero();
    for (const auto& [angle, count] : {std::pair(0.99, 1), {1.01, 2}, {2.99, 3}, {3.01, 4}}) {
        tips(0, 0) = -kGJ * std::pow(angle * std::numbers::pi / kLength, 2);
        EXPECT_EQ(LineWaves(euler(), kLength, kAll, {}, tips).pieces(0, 1000), count);
    }
}

// Oracle: many short uniform lines in a row, each under the force of its middle, which err by second order: extrapolated.
// The series is as exact over the whole line as over pieces.
TEST(LineWaves, AnAxialForceThatVariesAlongTheLine) {
    const Line line = timoshenko();
    const LineWaves::Axial axial{4.1e6, -1.7e6};
    const LineWaves graded(line, kLength, kAll, axial);
    EXPECT_TRUE(graded.is_graded());
    EXPECT_FALSE(LineWaves(line, kLength, kAll, {3e5, 3e5}).is_graded());
    constexpr double kLambda = 3e5;
    const auto in_row = [&](int count) {
        Matrix12 U = Matrix12::Identity();
        for (int k = 0; k < count; ++k) {
            const double middle = axial[0] + (k + 0.5) / count * (axial[1] - axial[0]);
            U = (LineWaves(line, kLength / count, kAll, {middle, middle}).transfer(kLambda, kLength / count) * U).eval();
        }
        return U;
    };
    const Matrix12 expected = (4 * in_row(800) - in_row(400)) / 3;
    const auto error = [&](int count) {
        Matrix12 U = Matrix12::Identity();
        const double h = kLength / count;
        for (int k = 0; k < count; ++k) U = (graded.transfer(kLambda, h, k * h) * U).eval();
        double largest = 0;  // of what belongs together: rows of one unit
        for (Eigen::Index i = 0; i < 12; ++i)
            largest = std::max(largest, (U - expected).row(i).norm() / expected.row(i).norm());
        return largest;
    };
    for (const int count : {1, 3, 16}) EXPECT_LT(error(count), 1e-9) << count;
    const Vector12 some = Vector12::LinSpaced(-0.7, 1.9);
    const Vector12 by_transfer = graded.transfer(kLambda, 0.4, 0.3) * some;
    EXPECT_LT((graded.carry(some, kLambda, 0.4, 0.3) - by_transfer).norm(), 1e-12 * by_transfer.norm());
    // The dynamic stiffness is that of the same equations, and its mass is -∂D/∂λ
    Matrix12 D, M, above, below;
    graded.evaluate<double>(4, kLambda, 1, D, &M, 2);
    const Matrix12 U = graded.transfer(kLambda, kLength / 4, kLength / 2);
    Vector12 ends;
    ends << 0.3, -1.1, 0.7, 0.2, 0.5, -0.4, 0.9, 0.1, -0.6, 0.8, -0.3, 0.2;
    Vector12 start;
    start << ends.head<6>(), -(D * ends).head<6>();
    const Vector12 finish = U * start;
    EXPECT_LT((finish.head<6>() - ends.tail<6>()).norm(), 1e-9);
    EXPECT_LT((finish.tail<6>() - (D * ends).tail<6>()).norm(), 1e-9 * (D * ends).tail<6>().norm());
    EXPECT_LT((D - D.transpose()).norm(), 1e-12 * D.norm());
    const double step = 1e-3 * kLambda;
    graded.evaluate<double>(4, kLambda + step, 1, above, nullptr, 2);
    graded.evaluate<double>(4, kLambda - step, 1, below, nullptr, 2);
    EXPECT_LT((M + (above - below) / (2 * step)).norm(), 1e-6 * M.norm());
}

// Oracle: evaluate(), at λ below and above zero up to the largest, and beyond it, of a section whose planes do not couple
// and of one whose mass lies beside its axis. Longer pieces need more powers of λ than it takes.
TEST(LineWaves, AnExpansionByTheSquaredFrequency) {
    Line beside = timoshenko();
    beside.section.offset_y = 0.013;
    beside.section.offset_z = -0.007;
    for (const Line& line : {timoshenko(), euler(), beside})
        for (const LineWaves::Axial axial : {LineWaves::Axial{0, 0}, {2.1e5, 2.1e5}, {-3e5, 1.4e6}}) {
            const LineWaves waves(line, kLength, kAll, axial);
            const double omega = 900;
            const int count = waves.pieces(omega, 100);
            const auto expansion = waves.expand(count, 2 * omega * omega, count - 1);
            ASSERT_TRUE(expansion);
            for (const double share : {-1.0, -0.3, 0.0, 1e-6, 0.2, 1.0}) {
                const double lambda = share * 2 * omega * omega;
                Matrix12 D, M, expected, mass;
                waves.evaluate<double>(count, lambda, 1, expected, &mass, count - 1);
                waves.evaluate(*expansion, lambda, D, &M);
                const Vector12 size = expected.diagonal().cwiseAbs().cwiseSqrt(), heavy = mass.diagonal().cwiseSqrt();
                EXPECT_LT((size.cwiseInverse().asDiagonal() * (D - expected) * size.cwiseInverse().asDiagonal())
                              .cwiseAbs()
                              .maxCoeff(),
                          1e-12)
                    << share;
                EXPECT_LT((heavy.cwiseInverse().asDiagonal() * (M - mass) * heavy.cwiseInverse().asDiagonal())
                              .cwiseAbs()
                              .maxCoeff(),
                          1e-11)
                    << share;
                Matrix12 alone;
                waves.evaluate(*expansion, lambda, alone, nullptr);
                EXPECT_LT((alone - D).cwiseAbs().maxCoeff(), 1e-12 * D.cwiseAbs().maxCoeff()) << share;
            }
            EXPECT_FALSE(waves.expand(1, 1e4 * omega * omega));
        }
}

}  // namespace
}  // namespace dttmm::plugin
