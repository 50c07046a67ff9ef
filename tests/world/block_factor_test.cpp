// SPDX-License-Identifier: BSD-3-Clause
#include "world/block_factor.h"

#include <gtest/gtest.h>

#include <random>

namespace dttmm::host {
namespace {

// Oracle: the right-hand side that the solution was made from. With and without coupling; factored twice, for what was there
// before must not linger.
TEST(BlockFactor, SolvesWithAndWithoutCoupling) {
    std::mt19937 generator(11);
    std::uniform_real_distribution<double> number(-1, 1);
    for (const bool coupled : {false, true}) {
        BlockMatrix matrix(3, coupled ? std::vector<std::pair<int, int>>{{2, 0}} : std::vector<std::pair<int, int>>{});
        BlockFactor factor(matrix);
        for (int repeat = 0; repeat < 2; ++repeat) {
            matrix.set_zero();
            Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(18, 18);
            const auto add = [&](int i, int j, const BlockMatrix::Block& block) {
                matrix.add(i, j, block);
                dense.block<6, 6>(matrix.index(i), matrix.index(j)) += block;
            };
            for (int b = 0; b < 3; ++b) {
                const BlockMatrix::Block root = BlockMatrix::Block::NullaryExpr([&] { return number(generator); });
                add(b, b, root * root.transpose() + 3 * BlockMatrix::Block::Identity());
            }
            const BlockMatrix::Block across = BlockMatrix::Block::NullaryExpr([&] { return 0.3 * number(generator); });
            if (coupled) add(0, 2, across), add(2, 0, across.transpose());
            const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(18, [&] { return number(generator); });
            ASSERT_TRUE(factor.factor(matrix));
            Eigen::VectorXd found(18);
            factor.solve(dense * x, found);
            EXPECT_LT((found - x).norm(), 1e-14);
        }
    }
}

TEST(BlockFactor, SaysWhenTheMatrixIsSingular) {
    for (const bool coupled : {false, true}) {
        BlockMatrix matrix(2, coupled ? std::vector<std::pair<int, int>>{{0, 1}} : std::vector<std::pair<int, int>>{});
        BlockFactor factor(matrix);
        BlockMatrix::Block block = BlockMatrix::Block::Identity();
        matrix.add(0, 0, block);
        block(4, 4) = 0;
        matrix.add(1, 1, block);
        EXPECT_FALSE(factor.factor(matrix));
    }
}

TEST(BlockFactor, OfNoBodiesHasNothingToSolve) {
    BlockMatrix matrix(0, {});
    matrix.set_zero();
    BlockFactor factor(matrix);
    EXPECT_TRUE(factor.factor(matrix));
    Eigen::VectorXd x(0);
    factor.solve(x, x);
    EXPECT_EQ(x.size(), 0);
}

}  // namespace
}  // namespace dttmm::host
