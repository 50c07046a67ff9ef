// SPDX-License-Identifier: BSD-3-Clause
#include "statics/loads_without_potential.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

// Oracle: a dense solution of the whole unsymmetric matrix.
TEST(LoadsWithoutPotential, SolveAsTheWholeMatrix) {
    constexpr int kFrames = 4;
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> draw(-1, 1);
    const auto random = [&] {
        Matrix6 block;
        for (double& number : block.reshaped()) number = draw(engine);
        return block;
    };
    Elimination matrix(kFrames, {{-1, 0, 0}, {0, 1, 0}, {1, 2, 0}, {3, 1, 0}});
    matrix.set_zero();
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(6 * kFrames, 6 * kFrames);
    for (int f = 0; f < kFrames; ++f) {
        const Matrix6 part = random();
        const Matrix6 block = part * part.transpose() + 5 * Matrix6::Identity();
        matrix.add_diagonal(f, block);
        whole.block<6, 6>(6 * f, 6 * f) += block;
    }
    const int links[3][2] = {{0, 1}, {1, 2}, {3, 1}};
    for (int l = 0; l < 3; ++l) {
        const Matrix6 block = random();
        matrix.add_coupling(l + 1, block);
        whole.block<6, 6>(6 * links[l][0], 6 * links[l][1]) += block;
        whole.block<6, 6>(6 * links[l][1], 6 * links[l][0]) += block.transpose();
    }
    ASSERT_FALSE(matrix.factor());
    LoadsWithoutPotential loads;
    for (const int frame : {2, 0, 3}) {
        const Matrix6 part = frame == 0 ? Matrix6(Matrix6::Zero()) : Matrix6(4 * random());
        loads.add(frame, part);
        whole.block<6, 6>(6 * frame, 6 * frame) += part;
    }
    std::vector<Vector6> r(kFrames);
    Eigen::VectorXd right(6 * kFrames);
    for (int f = 0; f < kFrames; ++f) {
        for (double& number : r[as_size(f)]) number = draw(engine);
        right.segment<6>(6 * f) = r[as_size(f)];
    }
    const Eigen::VectorXd expected = whole.fullPivLu().solve(right);
    std::vector<double> none;
    loads.solve(matrix, r, none);
    for (int f = 0; f < kFrames; ++f)
        EXPECT_LT((r[as_size(f)] - expected.segment<6>(6 * f)).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace dttmm::plugin
