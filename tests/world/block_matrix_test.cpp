// SPDX-License-Identifier: BSD-3-Clause
#include "world/block_matrix.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace dttmm {
namespace {

// Oracle: the same sums in a dense matrix, in the order that index() tells; the pattern is a chain with a loop and a repeat.
TEST(BlockMatrix, HoldsTheUpperTriangleOfASymmetricSum) {
    const int n = 5;
    const std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}, {3, 2}, {3, 4}, {4, 0}, {1, 0}};
    BlockMatrix matrix(n, pairs);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * n, 6 * n);
    std::mt19937 generator(3);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto add = [&](int i, int j, const BlockMatrix::Block& block) {
        matrix.add(i, j, block);
        dense.block<6, 6>(matrix.index(i), matrix.index(j)) += block;
    };
    for (int repeat = 0; repeat < 2; ++repeat)
        for (auto [i, j] : pairs) {
            const BlockMatrix::Block block = BlockMatrix::Block::NullaryExpr([&] { return number(generator); });
            add(i, j, block);
            add(j, i, block.transpose());
        }
    for (int i = 0; i < n; ++i) {
        BlockMatrix::Block block = BlockMatrix::Block::NullaryExpr([&] { return number(generator); });
        block = (block + block.transpose()).eval();
        add(i, i, block);
    }
    const Eigen::MatrixXd upper = Eigen::MatrixXd(matrix.upper());
    EXPECT_LT((upper - Eigen::MatrixXd(dense.triangularView<Eigen::Upper>())).norm(), 1e-14);
    matrix.set_zero();
    EXPECT_EQ(matrix.upper().norm(), 0);
}

// A body's six unknowns are its own: the indices are a permutation of 0, 6, 12, …
TEST(BlockMatrix, EveryBodyHasItsPlace) {
    const BlockMatrix matrix(4, {{0, 3}, {3, 1}, {1, 2}});
    std::set<int> places;
    for (int b = 0; b < 4; ++b) places.insert(matrix.index(b));
    EXPECT_EQ(places, (std::set<int>{0, 6, 12, 18}));
}

// The factor of a chain must not fill in, else the cost of a step is not linear in the number of bodies.
TEST(BlockMatrix, OrdersAChainWithoutFill) {
    std::vector<std::pair<int, int>> chain;
    for (int b = 0; b + 1 < 200; ++b) chain.emplace_back(b, b + 1);
    const BlockMatrix matrix(200, chain);
    // Elimination in the matrix's order: a body may have at most one later neighbour when its turn comes.
    std::vector<int> order(200);
    for (int b = 0; b < 200; ++b) order[static_cast<size_t>(matrix.index(b) / 6)] = b;
    std::vector<std::set<int>> neighbours(200);
    for (auto [i, j] : chain) {
        neighbours[static_cast<size_t>(i)].insert(j);
        neighbours[static_cast<size_t>(j)].insert(i);
    }
    size_t fill = 0;
    for (int b : order) {
        const std::set<int> left = neighbours[static_cast<size_t>(b)];
        for (int i : left) {
            for (int j : left)
                if (i < j && neighbours[static_cast<size_t>(i)].insert(j).second) {
                    neighbours[static_cast<size_t>(j)].insert(i);
                    ++fill;
                }
            neighbours[static_cast<size_t>(i)].erase(b);
        }
    }
    EXPECT_LE(fill, 1u);
}

}  // namespace
}  // namespace dttmm
