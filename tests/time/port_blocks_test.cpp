// SPDX-License-Identifier: BSD-3-Clause
#include "time/port_blocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

std::vector<std::pair<uint32_t, uint32_t>> pairs_of(const PortBlocks& blocks) {
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    for (const dttmm_block& block : blocks.list()) pairs.emplace_back(block.row, block.column);
    return pairs;
}

/// Three bodies; two springs join the first two, one the last two, one the last to the ground. They are bodies 4, 2 and 7 of
/// the host.
class PortBlocksTest : public ::testing::Test {
protected:
    PortBlocksTest() {
        model_.node("ground", DTTMM_NODE_GROUND, {0.1, -0.2, 0.05});
        model_.node("a", DTTMM_NODE_ON_BODY, {0.7, 0.15, 0.4});
        model_.node("b", DTTMM_NODE_ON_BODY, {1.1, 0.7, 0.2});
        model_.node("c", DTTMM_NODE_ON_BODY, {0.2, 0.9, 0.6});
        for (const auto& [name, from, to] :
             {std::tuple{"first", "a", "b"}, {"second", "b", "a"}, {"third", "b", "c"}, {"fourth", "ground", "c"}})
            model_.element(name, "spring_damper", {from, to}, {{"stiffness", {3e4}}});
        mechanism_.emplace(model_.description());
    }
    PortBodies bodies() const { return {*mechanism_, places_}; }

    test::NetworkModel model_;
    std::optional<Mechanism> mechanism_;
    std::vector<uint32_t> places_ = {4, 2, 7};
};

TEST_F(PortBlocksTest, JointsHaveThePairsThatTheyJoinOnce) {
    EXPECT_THAT(pairs_of(PortBlocks::of_joints(bodies())),
                ElementsAre(Pair(4, 4), Pair(4, 2), Pair(2, 4), Pair(2, 2), Pair(2, 7), Pair(7, 2), Pair(7, 7)));
}

// Oracle: sums by hand. The second joint has its ends the other way round; the fourth one only its `to` end.
TEST_F(PortBlocksTest, JointsAddWhereTheHostHasTheirPairs) {
    PortBlocks blocks = PortBlocks::of_joints(bodies());
    blocks.place(0, 6);  // the pair (4, 4)
    blocks.place(6, 0);
    EndBlocks own;
    for (int i : {0, 1})
        for (int j : {0, 1}) own.at[i][j].setConstant(1 + 2 * i + j);
    own.at[0][1](2, 5) = 20;
    std::vector<double> matrix(36 * blocks.list().size(), 0.5);
    blocks.add(0, own, matrix.data());
    blocks.add(1, own, matrix.data());
    blocks.add(3, own, matrix.data());
    EXPECT_EQ(matrix[36 * 6], 0.5 + 1 + 4) << "first as from, second as to";
    EXPECT_EQ(matrix[36 * 1], 0.5 + 2 + 3);
    EXPECT_EQ(matrix[36 * 1 + 6 * 2 + 5], 0.5 + 20 + 3) << "row by row";
    EXPECT_EQ(matrix[36 * 2 + 6 * 2 + 5], 0.5 + 3 + 20);
    EXPECT_EQ(matrix[36 * 0], 0.5 + 4) << "the ground has no block";
    EXPECT_EQ(matrix[36 * 4], 0.5);
}

TEST_F(PortBlocksTest, ADenseMatrixGoesToAllPairsRowByRow) {
    PortBlocks blocks = PortBlocks::dense(bodies());
    EXPECT_THAT(pairs_of(blocks), ElementsAre(Pair(4, 4), Pair(4, 2), Pair(4, 7), Pair(2, 4), Pair(2, 2), Pair(2, 7),
                                              Pair(7, 4), Pair(7, 2), Pair(7, 7)));
    ASSERT_EQ(blocks.dense_size(), 18u * 18u);
    blocks.place(5, 1);
    blocks.place(1, 5);
    std::vector<double> own(blocks.dense_size()), matrix(own.size(), 0.25);
    for (size_t i = 0; i < own.size(); ++i) own[i] = static_cast<double>(i);
    blocks.add_dense(own.data(), matrix.data());
    // Row 6 + 3 and column 12 + 4 of the whole are row 3 and column 4 of the pair (2, 7)
    EXPECT_EQ(matrix[36 * 1 + 6 * 3 + 4], 0.25 + 9 * 18 + 16);
    EXPECT_EQ(matrix[36 * 8 + 6 * 5 + 5], 0.25 + 17 * 18 + 17);
}

}  // namespace
}  // namespace dttmm::plugin
