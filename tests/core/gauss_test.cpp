// SPDX-License-Identifier: BSD-3-Clause
#include "core/gauss.h"

#include <gtest/gtest.h>

#include <random>

namespace dttmm::plugin {
namespace {

SmallMatrix random_matrix(int rows, int columns, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    SmallMatrix matrix(rows, columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) matrix(i, j) = number(generator);
    return matrix;
}

// Oracle: B is made from a known X; every size up to the largest.
TEST(Gauss, RecoversAKnownSolution) {
    for (int n = 1; n <= 12; ++n) {
        const SmallMatrix A = random_matrix(n, n, 7u + static_cast<unsigned>(n)), X = random_matrix(n, 3, 90);
        const Elimination solved = eliminate_full_pivot(A, A * X);
        ASSERT_TRUE(solved.regular());
        EXPECT_LT((solved.X - X).cwiseAbs().maxCoeff(), 1e-11 / solved.reciprocal_condition * 1e-2) << "n = " << n;
    }
}

// Oracle: x = 3, y = 4 from a system that fails without pivoting (a zero on the diagonal).
TEST(Gauss, PivotsPastAZeroDiagonal) {
    SmallMatrix A(2, 2), B(2, 1);
    A << 0, 2, 5, 1;
    B << 8, 19;
    const Elimination solved = eliminate_full_pivot(A, B);
    EXPECT_DOUBLE_EQ(solved.X(0), 3);
    EXPECT_DOUBLE_EQ(solved.X(1), 4);
}

// Oracle: rows that differ by 1e12 in size are the same equations; the compliance of a stiff bolt is no singularity.
TEST(Gauss, RowScaleIsNotTakenForSingularity) {
    SmallMatrix A = random_matrix(6, 6, 3), X = random_matrix(6, 2, 4);
    A.row(0) *= 1e-12;
    A.row(4) *= 1e9;
    const Elimination solved = eliminate_full_pivot(A, A * X);
    ASSERT_TRUE(solved.regular());
    EXPECT_LT((solved.X - X).cwiseAbs().maxCoeff(), 1e-12);
}

// Oracle: column 2 of A is zero, so unknown 2 is the one no equation determines.
TEST(Gauss, NamesTheUndeterminedUnknown) {
    SmallMatrix A = random_matrix(5, 5, 11);
    A.col(2).setZero();
    const Elimination solved = eliminate_full_pivot(A, random_matrix(5, 1, 12));
    EXPECT_FALSE(solved.regular());
    EXPECT_EQ(solved.reciprocal_condition, 0);
    EXPECT_EQ(solved.weakest_unknown, 2);
}

TEST(Gauss, NearlyDependentRowsAreNotRegular) {
    SmallMatrix A = random_matrix(4, 4, 21);
    A.row(3) = A.row(1) * (1 + 1e-16) + A.row(2);
    EXPECT_FALSE(eliminate_full_pivot(A, random_matrix(4, 1, 22)).regular());
}

// Oracle: [1, 1; 1, 1 + d] has the condition number 4/d but for terms of order one. 1e-14 of its inverse is the limit.
TEST(Gauss, IsRegularAboveRoundingOfSums) {
    const auto is_regular = [](double inverse_condition) {
        SmallMatrix A(2, 2);
        A << 1, 1, 1, 1 + 4 * inverse_condition;
        return eliminate_full_pivot(A, SmallMatrix::Ones(2, 1)).regular();
    };
    EXPECT_FALSE(is_regular(0.8e-14));
    EXPECT_TRUE(is_regular(1.25e-14));
}

TEST(Gauss, NonFiniteEntriesAreNotRegular) {
    SmallMatrix A = random_matrix(3, 3, 31);
    A(1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(eliminate_full_pivot(A, random_matrix(3, 1, 32)).regular());
}

TEST(Gauss, NoUnknownsIsRegular) { EXPECT_TRUE(eliminate_full_pivot(SmallMatrix(0, 0), SmallMatrix(0, 13)).regular()); }

}  // namespace
}  // namespace dttmm::plugin
