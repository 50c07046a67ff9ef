// SPDX-License-Identifier: BSD-3-Clause
#include "world/block_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <random>
#include <set>

namespace dttmm::host {
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

// Oracle: the saddle-point system written out densely and solved with pivoting. Joints of 3, 5 and 6 equations, two to the
// ground, one pair of bodies joined twice (redundant: only E parts them), heavy beside light bodies; LDLᵀ without pivoting
// must do as well. The system is set up twice: what was there before must not linger.
TEST(BlockMatrix, JointsMakeASaddlePointThatFactorsWithoutPivoting) {
    const int n = 4;
    const std::vector<BlockMatrix::JointNode> joints = {{-1, 2, 5}, {2, 0, 3}, {1, 3, 6}, {3, 1, 5}, {0, -1, 3}};
    BlockMatrix matrix(n, {{0, 1}, {3, 2}}, joints);
    ASSERT_EQ(matrix.size(), 6 * n + 22);
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto random = [&](int rows, int columns) {
        return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return number(generator); }).eval();
    };
    for (int repeat = 0; repeat < 2; ++repeat) {
        matrix.set_zero();
        Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(matrix.size(), matrix.size());
        const auto add = [&](int i, int j, const BlockMatrix::Block& block) {
            matrix.add(i, j, block);
            dense.block<6, 6>(matrix.index(i), matrix.index(j)) += block;
        };
        for (int b = 0; b < n; ++b) {
            const Eigen::MatrixXd root = random(6, 6);
            add(b, b, std::pow(10, 2 * b - 3) * (root * root.transpose() + Eigen::MatrixXd::Identity(6, 6)));
        }
        for (auto [i, j] : {std::pair{0, 1}, {3, 2}}) {  // a spring between two bodies: positive semidefinite in all
            const BlockMatrix::Block S =
                std::pow(10, i) * BlockMatrix::Block(random(6, 6).cwiseAbs2().rowwise().sum().asDiagonal());
            add(i, i, S);
            add(j, j, S);
            add(i, j, -S);
            add(j, i, -S);
        }
        for (int b = 0; b < n; ++b) {
            const BlockMatrix::Block expected = dense.block<6, 6>(matrix.index(b), matrix.index(b));
            EXPECT_EQ(matrix.diagonal(b), expected);
        }
        Eigen::MatrixXd twin;
        for (int j = 0; j < 5; ++j) {
            const auto& joint = joints[static_cast<size_t>(j)];
            Eigen::MatrixXd first = random(joint.equations, 6), second = random(joint.equations, 6);
            if (j == 2) twin = first;
            if (j == 3) second = twin.topRows(5), first = -second;  // says again what joint 2 says, in part
            if (j == 2) second = -first;
            const Eigen::VectorXd E = Eigen::VectorXd::Constant(joint.equations, 1e-7 * (1 + j));
            matrix.set_joint(j, first, second, E);
            const int row = matrix.joint_index(j);
            for (auto [body, J] : {std::pair{joint.first, &first}, {joint.second, &second}}) {
                if (body < 0) continue;
                dense.block(row, matrix.index(body), joint.equations, 6) = *J;
                dense.block(matrix.index(body), row, 6, joint.equations) = J->transpose();
            }
            dense.block(row, row, joint.equations, joint.equations).diagonal() = -E;
        }
        const Eigen::MatrixXd upper = Eigen::MatrixXd(matrix.upper());
        EXPECT_LT((upper - Eigen::MatrixXd(dense.triangularView<Eigen::Upper>())).norm(), 1e-12 * upper.norm());
        Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper, Eigen::NaturalOrdering<int>> solver(matrix.upper());
        ASSERT_EQ(solver.info(), Eigen::Success);
        const Eigen::VectorXd x = random(matrix.size(), 1), b = dense * x;
        const Eigen::VectorXd u = solver.solve(b);
        EXPECT_LT((dense * u - b).norm(), 1e-9 * b.norm());
    }
}

}  // namespace
}  // namespace dttmm::host
