// SPDX-License-Identifier: BSD-3-Clause
#include "element/beam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "core/error.h"
#include "element/line_parts.h"
#include "support/exact_timoshenko.h"
#include "support/linear_algebra.h"

namespace dttmm::plugin {
namespace {

using namespace test_lines;
using test::ExactTimoshenko;
using test::with;
using testing::HasSubstr;

Beam beam(int segments, const Given& given) {
    const std::vector<double> values = test::values_of(Beam::kType, with(given, {{"segments", {1.0 * segments}}}));
    return Beam(std::span<const double, 5 + kSectionValueCount>(values));
}
/// Text of the error with which an element refuses.
template <class Call>
std::string refusal(const Call& call) {
    try {
        call();
        return "not refused";
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
        return error.what();
    }
}

// ---- Masses -------------------------------------------------------------------------------------------------------------

// Oracle: a uniform bar: mass ρA L, inertia about its middle ρA L³/12 + ρI L across, polar L along. The lumps with inertias
// of their segments make it exactly, whatever their number.
TEST(Beam, ItsLumpsHaveTheMassAndInertiaOfTheBar) {
    const double L = (kTo - kFrom).norm();
    const Vector3 middle = 0.5 * (kFrom + kTo);
    for (const Given& given : {kTube, kUneven})
        for (int segments : {1, 2, 3, 11}) {
            const Beam element = beam(segments, given);
            const Section& s = element.section();
            const Parts parts = between(kFrom, kTo, element);
            ASSERT_EQ(parts.lumps.size(), static_cast<size_t>(segments));
            EXPECT_TRUE(parts.mounted.empty());
            const Inertia sum = total(parts, middle);
            const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
            const Vector3 principal(s.inertia * L, s.rotary_y * L + s.mass * L * L * L / 12,
                                    s.rotary_z * L + s.mass * L * L * L / 12);
            EXPECT_NEAR(sum.mass, s.mass * L, 1e-14 * sum.mass);
            EXPECT_LT((sum.centre - middle).norm(), 1e-15);
            EXPECT_LT((R.transpose() * sum.tensor * R - Matrix3(principal.asDiagonal())).norm(), 1e-14 * principal.norm());
        }
}

// Oracle: Steiner about the elastic axis; section.inertia is about that axis already.
TEST(Beam, AMassOffsetMovesTheLumpsAndNothingElse) {
    const double a = 0.03, b = -0.07, L = (kTo - kFrom).norm();
    const Vector3 middle = 0.5 * (kFrom + kTo);
    const Beam element = beam(5, with(kUneven, {{"section.mass_offset", {a, b}}}));
    const Section& s = element.section();
    const Parts parts = between(kFrom, kTo, element), centred = between(kFrom, kTo, beam(5, kUneven));
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    const Inertia sum = total(parts, middle);
    EXPECT_LT((sum.centre - middle - R * Vector3(0, a, b)).norm(), 1e-15);
    const double bar = s.mass * L * L * L / 12, m = s.mass * L;
    Matrix3 expected;
    expected << 0.2 * L, 0, 0, 0, s.rotary_y * L + bar + m * b * b, -m * a * b, 0, -m * a * b,
        s.rotary_z * L + bar + m * a * a;
    EXPECT_LT((R.transpose() * sum.tensor * R - expected).norm(), 1e-14 * expected.norm());
    for (size_t j = 0; j < parts.joints.size(); ++j) {
        EXPECT_EQ(parts.joints[j].pose.position, centred.joints[j].pose.position);
        EXPECT_EQ(parts.joints[j].law->stiffness, centred.joints[j].law->stiffness);
    }
}

// ---- Static compliance --------------------------------------------------------------------------------------------------

/// Timoshenko's cantilever by its closed form, axes of the beam: [x y z rx ry rz] of the tip per wrench on it.
Matrix6 cantilever(const Section& s, double l) {
    Matrix6 c = Matrix6::Zero();
    c.diagonal() << l / s.EA, l * l * l / (3 * s.EIz) + l / s.GAy, l * l * l / (3 * s.EIy) + l / s.GAz, l / s.GJ, l / s.EIy,
        l / s.EIz;
    c(1, 5) = c(5, 1) = l * l / (2 * s.EIz);
    c(2, 4) = c(4, 2) = -l * l / (2 * s.EIy);
    return c;
}

// Oracle: the closed form. A span of the beam seen at its middle is a joint without coupling and exactly that span, so that
// the chain is the beam for any number of segments: rounding only, no lumping error.
TEST(Beam, ItsJointsHaveTheStaticComplianceOfTheCantilever) {
    const double L = (kTo - kFrom).norm();
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    for (const Given& given :
         {kTube, kUneven, with(kUneven, {{"theory", {0}}}), with(kUneven, {{"section.mass_offset", {0.02, 0.03}}})})
        for (int segments : {1, 2, 3, 10, 37}) {
            const Beam element = beam(segments, given);
            const Matrix6 c = in_axes(R, compliance(between(kFrom, kTo, element), kTo)),
                          exact = cantilever(element.section(), L);
            EXPECT_LT((c - exact).norm(), 1e-13 * exact.norm()) << segments;
            EXPECT_LT((c.diagonal() - exact.diagonal()).cwiseQuotient(exact.diagonal()).cwiseAbs().maxCoeff(), 1e-11)
                << segments;
        }
}

// Joints lead from end to end, lump by lump.
TEST(Beam, ItsJointsFormAChainThroughTheLumps) {
    for (int segments : {1, 2, 7}) {
        const Parts parts = between(kFrom, kTo, beam(segments, kUneven));
        ASSERT_EQ(parts.joints.size(), static_cast<size_t>(segments) + 1);
        int station = 0;
        for (int j = 0; j <= segments; ++j) {
            EXPECT_EQ(parts.joints[static_cast<size_t>(j)].from, station);
            station = j == segments ? 1 : 2 + j;
            EXPECT_EQ(parts.joints[static_cast<size_t>(j)].to, station);
        }
        for (int i = 0; i < segments; ++i) {
            const Vector3 middle = kFrom + (i + 0.5) / segments * (kTo - kFrom);
            EXPECT_LT((parts.lumps[static_cast<size_t>(i)].pose.position - middle).norm(), 1e-15);
        }
    }
}

// Oracle: damping over stiffness is the same number in every direction of every joint.
TEST(Beam, StiffnessDampingIsProportional) {
    const Parts parts = between(kFrom, kTo, beam(4, with(kUneven, {{"material.stiffness_damping", {3e-5}}})));
    for (const JointPart& joint : parts.joints) {
        EXPECT_EQ(joint.law->damping, 3e-5 * joint.law->stiffness);
        EXPECT_TRUE(joint.law->rigid.none());
    }
}

// ---- Symmetries ---------------------------------------------------------------------------------------------------------

// Oracle: the same beam from its other end: x and y turn round, z stays. Compliance and inertia in the world stay.
TEST(Beam, IsTheSameFromItsOtherEnd) {
    for (int segments : {1, 2, 5}) {
        const Given given = with(kUneven, {{"section.mass_offset", {0.03, -0.07}}});
        const Given mirrored = with(kUneven, {{"section.mass_offset", {-0.03, -0.07}}});
        const Parts there = between(kFrom, kTo, beam(segments, given)), back = between(kTo, kFrom, beam(segments, mirrored));
        const Vector3 middle = 0.5 * (kFrom + kTo);
        const Matrix6 c = compliance(there, kTo);
        EXPECT_LT((compliance(back, kTo) - c).norm(), 1e-13 * c.norm());
        const Matrix3 J = total(there, middle).tensor;
        EXPECT_LT((total(back, middle).tensor - J).norm(), 1e-13 * J.norm());
        for (size_t i = 0; i < there.lumps.size(); ++i)
            EXPECT_LT((there.lumps[i].pose.position - back.lumps[back.lumps.size() - 1 - i].pose.position).norm(), 1e-15);
        const Matrix3 half_turn = Vector3(-1, -1, 1).asDiagonal();
        EXPECT_LT((there.lumps[0].pose.rotation * half_turn - back.lumps[0].pose.rotation).norm(), 1e-14);
    }
}

// Oracle: everything turned about the origin, `up` with it: every part turned, every law the same.
TEST(Beam, TurnsWithItsEnds) {
    const Matrix3 Q = rotation_from_vector({1.9, -0.7, 0.4});
    const Vector3 up(0.2, -1, 0.6), turned = Q * up;
    const Parts parts = between(kFrom, kTo, beam(3, with(kUneven, {{"up", {up.x(), up.y(), up.z()}}})));
    const Parts other = between(Q * kFrom, Q * kTo, beam(3, with(kUneven, {{"up", {turned.x(), turned.y(), turned.z()}}})));
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_LT((other.lumps[i].pose.position - Q * parts.lumps[i].pose.position).norm(), 1e-15);
        EXPECT_LT((other.lumps[i].pose.rotation - Q * parts.lumps[i].pose.rotation).norm(), 1e-14);
        EXPECT_LT((other.lumps[i].inertia - parts.lumps[i].inertia).norm(), 1e-14 * parts.lumps[i].inertia.norm());
    }
    for (size_t j = 0; j < 4; ++j) {
        EXPECT_LT((other.joints[j].pose.position - Q * parts.joints[j].pose.position).norm(), 1e-15);
        EXPECT_LT((other.joints[j].pose.rotation - Q * parts.joints[j].pose.rotation).norm(), 1e-14);
        EXPECT_LT((other.joints[j].law->stiffness - parts.joints[j].law->stiffness).norm(),
                  1e-14 * parts.joints[j].law->stiffness.norm());
    }
}

TEST(Beam, StiffnessesThatTimeNeedsAreNamed) {
    for (const char* key : {"EIy", "EIz", "GJ", "GAy", "GAz"}) {
        Given given = kUneven;
        given.erase(std::string("section.") + key);
        const std::string text = refusal([&] { between(kFrom, kTo, beam(3, given)); });
        EXPECT_THAT(text, HasSubstr(std::string("section.") + key + " is needed"));
        const bool of_shear = key[1] == 'A';
        if (of_shear) {
            EXPECT_NO_THROW(between(kFrom, kTo, beam(3, with(given, {{"theory", {0}}})))) << key;
        }
    }
    EXPECT_THAT(refusal([] { between(kFrom, kFrom, beam(3, kUneven)); }), HasSubstr("0 m apart"));
}

// ---- The free beam ------------------------------------------------------------------------------------------------------

constexpr double kLength = 1.2;

/// Mass and stiffness matrices of the lumps and the joints between them, ends left off: 6 unknowns per lump, world axes.
struct Free {
    Eigen::MatrixXd M, K;

    explicit Free(const Parts& parts) {
        const auto n = static_cast<Eigen::Index>(6 * parts.lumps.size());
        M.setZero(n, n);
        K.setZero(n, n);
        for (size_t i = 0; i < parts.lumps.size(); ++i) {
            const Lump& lump = parts.lumps[i];
            const auto at = static_cast<Eigen::Index>(6 * i);
            M.block<3, 3>(at, at) = lump.mass * Matrix3::Identity();
            M.block<3, 3>(at + 3, at + 3) = lump.pose.rotation * lump.inertia * lump.pose.rotation.transpose();
        }
        for (const JointPart& joint : parts.joints) {
            if (joint.from < 2 || joint.to < 2) continue;
            Eigen::MatrixXd G = Eigen::MatrixXd::Zero(6, n);
            for (const auto& [station, sign] : {std::pair(joint.from, -1.0), std::pair(joint.to, 1.0)}) {
                const Vector3 arm = joint.pose.position - parts.lumps[static_cast<size_t>(station - 2)].pose.position;
                const Matrix3 axes = joint.pose.rotation.transpose();
                const Eigen::Index at = 6 * (station - 2);
                G.block<3, 3>(0, at) = sign * axes;
                G.block<3, 3>(0, at + 3) = -sign * axes * skew(arm);
                G.block<3, 3>(3, at + 3) = sign * axes;
            }
            K += G.transpose() * joint.law->stiffness.asDiagonal() * G;
        }
    }

    /// The unknowns in one plane, [deflection; turn] of every lump.
    Free plane(const Matrix3& axes, int deflection, int turn) const {
        const Eigen::Index lumps = M.rows() / 6;
        Eigen::MatrixXd P = Eigen::MatrixXd::Zero(M.rows(), 2 * lumps);
        for (Eigen::Index i = 0; i < lumps; ++i) {
            P.block<3, 1>(6 * i, 2 * i) = axes.col(deflection);
            P.block<3, 1>(6 * i + 3, 2 * i + 1) = axes.col(turn);
        }
        Free part = *this;
        part.M = P.transpose() * M * P;
        part.K = P.transpose() * K * P;
        return part;
    }

    Eigen::VectorXd omega() const { return test::solve_pencil(K, M).values.cwiseMax(0).cwiseSqrt(); }
};

Parts free_beam(int segments, const Given& given = kTube) {
    const Vector3 way = (kTo - kFrom).normalized();
    return between(kFrom, kFrom + kLength * way, beam(segments, given));
}

ExactTimoshenko exact_beam() {
    const Section s = beam(1, kTube).section();
    return {s.EIz, s.GAy, s.mass, s.rotary_z, kLength};
}

std::vector<double> exact_omega() {
    static const std::vector<double> omega = exact_beam().free_frequencies(6, 2 * M_PI * 20);
    return omega;
}

// Oracle: the published values of this beam, solved elsewhere, to their digits; Euler-Bernoulli's by (βL)² √(EI/ρA L⁴).
TEST(ExactTimoshenko, HasThePublishedFrequencies) {
    const double published[] = {182.9656, 497.0200, 954.2453, 1536.2971, 2225.2393, 3003.2814};
    for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(exact_omega()[i] / (2 * M_PI), published[i], 6e-5) << i;
    ExactTimoshenko thin = exact_beam();
    thin.shear *= 1e12;
    thin.rotary = 0;
    const double roots[] = {4.730040744862704, 7.853204624095838, 10.99560783800167};
    for (size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(thin.free_frequencies(3, 100)[i],
                    roots[i] * roots[i] / (kLength * kLength) * std::sqrt(thin.EI / thin.mass),
                    1e-9 * thin.free_frequencies(3, 100)[i]);
}

// Oracle: exact Timoshenko beam. Errors in percent as computed for this beam elsewhere, to their digits; second order.
TEST(Beam, ItsBendingFrequenciesErrAsLumpingMust) {
    struct Row {
        int segments;
        double errors[6], digit;
    };
    const Row table[] = {{10, {-0.504, -1.815, -3.690, -6.015, -8.678, -11.624}, 1e-3},
                         {20, {-0.126, -0.458, -0.945, -1.563, -2.290, -3.114}, 1e-3},
                         {40, {-0.0315, -0.1149, -0.2376, -0.3947, -0.5808, -0.7931}, 1e-4},
                         {80, {-0.0079, -0.0287, -0.0595, -0.0989, -0.1457, -0.1992}, 1e-4}};
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    double largest_before = 0;
    for (const Row& row : table) {
        const Free free(free_beam(row.segments));
        const Eigen::VectorXd in_y = free.plane(R, 1, 2).omega(), in_z = free.plane(R, 2, 1).omega();
        EXPECT_LT(in_y(1), 1e-3 * in_y(2)) << "two rigid motions";
        double largest = 0;
        for (int i = 0; i < 6; ++i) {
            const double exact = exact_omega()[static_cast<size_t>(i)], error = 100 * (in_y(2 + i) / exact - 1);
            EXPECT_NEAR(error, row.errors[i], 0.6 * row.digit) << row.segments << " segments, mode " << i + 1;
            EXPECT_NEAR(in_z(2 + i), in_y(2 + i), 1e-9 * in_y(2 + i)) << "a tube is round";
            largest = std::max(largest, std::abs(error));
        }
        if (row.segments == 40) {
            EXPECT_NEAR(largest, 0.793, 0.002);
        }
        if (row.segments > 10) {
            EXPECT_NEAR(std::log2(largest_before / largest), 2, row.segments == 20 ? 0.11 : 0.03);
        }
        largest_before = largest;
    }
}

// Oracle: exact shapes at the middles of the segments. Modal assurance criterion (aᵀb)²/(aᵀa bᵀb).
TEST(Beam, ItsShapesAreThoseOfTheExactBeam) {
    const Free plane = Free(free_beam(40)).plane(beam_axes(kFrom, kTo, kNotGiven3), 1, 2);
    const test::Pencil modes = test::solve_pencil(plane.K, plane.M);
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
            Eigen::VectorXd shape(40), exact(40);
            for (int k = 0; k < 40; ++k) {
                shape(k) = modes.vectors(2 * k, 2 + i);
                exact(k) = exact_beam().free_shape(exact_omega()[static_cast<size_t>(j)], (k + 0.5) * kLength / 40);
            }
            const double mac = std::pow(shape.dot(exact), 2) / (shape.squaredNorm() * exact.squaredNorm());
            if (i == j) {
                EXPECT_GT(mac, 0.9994) << i + 1;
            } else {
                EXPECT_LT(mac, 0.02) << i + 1 << ", " << j + 1;
            }
        }
}

// Oracle: six rigid motions, every bending frequency twice, and the waves of a free bar along and about its axis: lumps in a
// row make ω = 2 √(k/m) sin(iπ/2N), i = 1, 2, …
TEST(Beam, ItsFrequenciesInSpaceAreBendingTorsionAndAxialWaves) {
    const int N = 10;
    const Free free(free_beam(N));
    const Section s = beam(N, kTube).section();
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    std::vector<double> expected;
    for (int plane : {1, 2}) {
        const Eigen::VectorXd bending = free.plane(R, plane, 3 - plane).omega();
        expected.insert(expected.end(), bending.begin(), bending.end());
    }
    const double l = kLength / N;
    for (int i = 0; i < N; ++i) {
        expected.push_back(2 * std::sqrt(s.EA / s.mass) / l * std::sin(i * M_PI / (2 * N)));
        expected.push_back(2 * std::sqrt(s.GJ / s.inertia) / l * std::sin(i * M_PI / (2 * N)));
    }
    std::sort(expected.begin(), expected.end());
    const Eigen::VectorXd omega = free.omega();
    ASSERT_EQ(omega.size(), static_cast<Eigen::Index>(expected.size()));
    for (int i = 6; i < omega.size(); ++i) EXPECT_NEAR(omega(i), expected[static_cast<size_t>(i)], 1e-9 * omega(i)) << i;
    EXPECT_LT(omega(5), 1e-3 * omega(6));
}

// Oracle: the bond-space paper's state equations, momentum p of the segments and displacement q of the joints between them,
//     p_i' = T_R C⁻¹ q_{i,i+1} − T_L C⁻¹ q_{i−1,i},   q'_{i,i+1} = T_Lᵀ I⁻¹ p_{i+1} − T_Rᵀ I⁻¹ p_i
// with efforts Q_y Q_z M_y M_z and its compliance terms corrected: a = h³/3EI + h/κGA, b = h²/2EI, g = h/EI of half segments
// h = l/2. They are the lumps and joints in other unknowns: the same eigenvalues, rounding apart.
TEST(Beam, IsTheBeamOfTheBondSpacePaper) {
    const int N = 10;
    const Section s = beam(N, kTube).section();
    const double l = kLength / N, h = l / 2, EI = s.EIz;
    const double a = h * h * h / (3 * EI) + h / s.GAy, b = h * h / (2 * EI), g = h / EI;
    using Matrix4 = Eigen::Matrix4d;
    Matrix4 C_R, C_L, T_R, T_L;
    C_R << a, 0, 0, b, 0, a, -b, 0, 0, -b, g, 0, b, 0, 0, g;
    C_L << a, 0, 0, -b, 0, a, b, 0, 0, b, g, 0, -b, 0, 0, g;
    T_R << 1, 0, 0, 0, 0, 1, 0, 0, 0, -h, 1, 0, h, 0, 0, 1;
    T_L << 1, 0, 0, 0, 0, 1, 0, 0, 0, h, 1, 0, -h, 0, 0, 1;
    const Matrix4 C = C_R + C_L;
    const double m = s.mass * l, J = s.rotary_z * l + m * l * l / 12;
    const Eigen::Vector4d I(m, m, J, J);

    // In units of √I and √C, in which the system matrix is of one size; they leave the eigenvalues alone
    const Matrix4 root_C = C.llt().matrixL(), root_I = I.cwiseSqrt().asDiagonal();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(4 * (2 * N - 1), 4 * (2 * N - 1));
    for (int i = 0; i + 1 < N; ++i) {
        const int q = 4 * N + 4 * i;
        A.block<4, 4>(4 * i, q) = root_I.inverse() * T_R * C.inverse() * root_C;
        A.block<4, 4>(4 * i + 4, q) = -root_I.inverse() * T_L * C.inverse() * root_C;
        A.block<4, 4>(q, 4 * i + 4) = root_C.inverse() * T_L.transpose() * I.cwiseInverse().asDiagonal() * root_I;
        A.block<4, 4>(q, 4 * i) = -root_C.inverse() * T_R.transpose() * I.cwiseInverse().asDiagonal() * root_I;
    }
    std::vector<double> omega;
    const Eigen::VectorXcd eigenvalues = test::eigenvalues(A);
    for (const std::complex<double>& value : eigenvalues) {
        EXPECT_LT(std::abs(value.real()), 1e-9 * A.norm());
        if (value.imag() > 1e-6 * A.norm()) omega.push_back(value.imag());
    }
    std::sort(omega.begin(), omega.end());
    ASSERT_EQ(omega.size(), static_cast<size_t>(4 * (N - 1))) << "pairs of the free beam, beside four zeros";

    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    const Free free(free_beam(N));
    std::vector<double> lumped;
    for (int plane : {1, 2}) {
        const Eigen::VectorXd bending = free.plane(R, plane, 3 - plane).omega();
        lumped.insert(lumped.end(), bending.begin() + 2, bending.end());
    }
    std::sort(lumped.begin(), lumped.end());
    for (size_t i = 0; i < omega.size(); ++i) EXPECT_NEAR(omega[i], lumped[i], 1e-9 * lumped[i]) << i;
}

}  // namespace
}  // namespace dttmm::plugin
