// SPDX-License-Identifier: BSD-3-Clause
#include "solve/elimination_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace dttmm::plugin {
namespace {

using ::testing::ElementsAre;

std::vector<int> frames_of(const EliminationOrder& order) {
    std::vector<int> frames;
    for (const EliminationOrder::Pivot& pivot : order.pivots()) frames.push_back(pivot.frame);
    return frames;
}

TEST(EliminationOrder, AChainIsEatenFromBothTips) {
    const EliminationOrder order(5, {{0, 1, 0}, {1, 2, 0}, {3, 2, 0}, {3, 4, 0}});
    EXPECT_THAT(frames_of(order), ElementsAre(0, 4, 1, 3, 2));
    for (const EliminationOrder::Pivot& pivot : order.pivots()) EXPECT_TRUE(pivot.is_plain);
    EXPECT_EQ(order.plain().back().neighbour, -1);
    // The row of a coupling is eliminated first, whichever way the link leads
    EXPECT_FALSE(order.links()[0].is_transposed);
    EXPECT_TRUE(order.links()[3].is_transposed);
    EXPECT_TRUE(order.links()[1].coupling >= 0 && !order.links()[1].is_transposed);
}

TEST(EliminationOrder, WhatIsHeldBySomethingKnownGoesLast) {
    EXPECT_THAT(frames_of(EliminationOrder(3, {{0, -1, 6}, {0, 1, 0}, {1, 2, 0}})), ElementsAre(2, 1, 0));
    EXPECT_THAT(frames_of(EliminationOrder(3, {{0, -1, 0}, {0, 1, 0}, {1, 2, 0}})), ElementsAre(0, 2, 1));
}

// A ring of four: the first to go couples its two neighbours, which were not; what comes then is a triangle.
TEST(EliminationOrder, ALoopFillsIn) {
    const EliminationOrder order(4, {{0, 1, 0}, {1, 2, 0}, {2, 3, 0}, {3, 0, 0}});
    EXPECT_EQ(order.couplings().size(), 5u);
    EXPECT_EQ(order.pivots()[0].neighbours.size(), 2u);
    ASSERT_EQ(order.pivots()[0].fills.size(), 1u);
    const EliminationOrder::Coupling& fill = order.couplings()[static_cast<size_t>(order.pivots()[0].fills[0])];
    EXPECT_THAT((std::set{fill.row, fill.column}), ElementsAre(1, 3));
    EXPECT_TRUE(order.pivots()[0].is_elastic);
    EXPECT_FALSE(order.pivots()[0].is_plain);
    EXPECT_TRUE(order.general().empty());
    EXPECT_FALSE(EliminationOrder(2, {{0, 1, 1}, {1, -1, 0}}).pivots()[0].is_elastic) << "a rigid direction meets there";
    EXPECT_EQ(order.pivots()[1].fills.size(), 1u) << "one of the ring by the second frame";
}

// Two joints that are rigid meet at frame 0: what the frame cannot tell apart goes on to frame 1.
TEST(EliminationOrder, RowsOfTwoJointsArePassedOn) {
    const EliminationOrder order(2, {{0, -1, 3}, {0, 1, 2}, {1, -1, 6}});
    EXPECT_THAT(frames_of(order), ElementsAre(0, 1));
    EXPECT_EQ(order.rows().size(), 11u);
    EXPECT_EQ(order.links()[2].first_row, 5);
    EXPECT_THAT(order.pivots()[0].rigid, ElementsAre(0, 1, 2, 3, 4));
    EXPECT_EQ(order.pivots()[0].passed, 0);
    EXPECT_THAT(order.pivots()[1].children, ElementsAre(0));
    EXPECT_EQ(EliminationOrder(2, {{0, 1, 2}, {1, -1, 6}}).passing().size(), 0u) << "rows of one joint are independent";
}

}  // namespace
}  // namespace dttmm::plugin
