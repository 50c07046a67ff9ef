// SPDX-License-Identifier: BSD-3-Clause
#include "modal/balanced_lu.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace dttmm::plugin {
namespace {

using Number = std::complex<double>;

/// Springs between all masses, which nothing holds but a row of a rigid direction at the first, in units in which both are
/// near one.
Eigen::MatrixXcd held_springs(int masses, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0.5, 1.5);
    Eigen::MatrixXcd A = Eigen::MatrixXcd::Zero(masses + 1, masses + 1);
    for (int i = 0; i < masses; ++i)
        for (int j = 0; j < i; ++j) {
            const double re = uniform(random), im = 0.1 * uniform(random);
            const Number k(re, im);
            A(i, i) += k;
            A(j, j) += k;
            A(i, j) = A(j, i) = -k;
        }
    A(0, masses) = A(masses, 0) = 1;
    return A;
}

// Oracle: the same equations in balanced units, solved by dense elimination. (That units are needed,
// Frf.OfStiffPartsInAnyUnits shows.)
TEST(BalancedLu, SolvesStiffPartsBesideRigidDirections) {
    std::mt19937 random(5);
    constexpr int kMasses = 20;
    const Eigen::MatrixXcd A = held_springs(kMasses, random);
    const Eigen::VectorXcd r = Eigen::VectorXcd::Random(kMasses + 1), expected = A.partialPivLu().solve(r);
    BalancedLu lu;
    for (const int exponent : {0, 15, 30}) {
        Eigen::VectorXd units = Eigen::VectorXd::Constant(kMasses + 1, std::ldexp(1.0, exponent));
        units(kMasses) = std::ldexp(1.0, -exponent);
        ASSERT_TRUE(lu.factor((units.asDiagonal() * A * units.asDiagonal()).eval().sparseView()));
        const Eigen::VectorXcd found = units.cwiseProduct(lu.solve(units.cwiseProduct(r)));
        EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm()) << exponent;
    }
}

TEST(BalancedLu, SaysWhatIsSingular) {
    BalancedLu lu;
    Eigen::MatrixXcd A = Eigen::MatrixXcd::Identity(3, 3);
    A(1, 1) = 0;
    EXPECT_FALSE(lu.factor(A.sparseView()));
    A(1, 1) = 1e-9;
    EXPECT_TRUE(lu.factor(A.sparseView()));
    EXPECT_EQ(lu.size(), 3);
}

}  // namespace
}  // namespace dttmm::plugin
