// SPDX-License-Identifier: BSD-3-Clause
#include "world/singular_position.h"

#include <gtest/gtest.h>

#include "support/bodies.h"

namespace dttmm::host {
namespace {

// Oracle: the drawings. A chain from the ground and a tree have no loop, also in any order of the joints; four bars, two
// hinges between the same bodies, and a chain that ends on the ground again have one.
TEST(SingularPosition, LoopsOfJoints) {
    const auto loop = [](const std::vector<std::pair<int, int>>& between) {
        std::vector<Joint> joints;
        for (const auto& [first, second] : between)
            joints.push_back(test::pin("j", first, second, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
        return form_loop(joints);
    };
    EXPECT_FALSE(loop({}));
    EXPECT_FALSE(loop({{-1, 0}}));
    EXPECT_FALSE(loop({{2, 1}, {-1, 0}, {1, 0}}));
    EXPECT_FALSE(loop({{3, 4}, {0, 3}, {-1, 1}, {0, 2}, {1, 0}}));
    EXPECT_TRUE(loop({{-1, 0}, {0, -1}}));
    EXPECT_TRUE(loop({{-1, 0}, {1, 2}, {0, 1}, {2, -1}}));
    EXPECT_TRUE(loop({{3, 4}, {-1, 0}, {5, 3}, {4, 5}}));
}

}  // namespace
}  // namespace dttmm::host
