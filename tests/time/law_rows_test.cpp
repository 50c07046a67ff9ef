// SPDX-License-Identifier: BSD-3-Clause
#include "time/law_rows.h"

#include <gtest/gtest.h>

#include <string>

#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

/// A mass on so many springs with a cubic law each: as many rows, one frame.
LawRows rows_of(int springs) {
    test::NetworkModel model;
    model.node("mass", DTTMM_NODE_INNER, {0.3, 0.1, -0.2});
    model.element("m", "point_mass", {"mass"}, {{"mass", {2}}});
    for (int i = 0; i < springs; ++i) {
        const std::string end = "end" + std::to_string(i);
        model.node(end, DTTMM_NODE_GROUND, {0.1 * i, 0.7, 0.4});
        model.element("s" + std::to_string(i), "axial_spring", {"mass", end},
                      {{"law", {1}}, {"stiffness", {3e3}}, {"cubic", {2e5}}});
    }
    const Mechanism mechanism(model.description());
    return {mechanism, mechanism.assembly.driven_count};
}

// Oracle: rows take their cube in time, 150 for each frame is worth it from the start: 5³ = 125, 6³ = 216.
TEST(LawRows, FewAreWantedFromTheStart) {
    EXPECT_TRUE(rows_of(5).are_wanted(false));
    EXPECT_FALSE(rows_of(6).are_wanted(false));
    EXPECT_TRUE(rows_of(6).are_wanted(true));
}

// Oracle: a hundred at most.
TEST(LawRows, ManyAreNeverWanted) {
    EXPECT_EQ(rows_of(80).count(), 80u);
    EXPECT_TRUE(rows_of(80).are_wanted(true));
    EXPECT_EQ(rows_of(125).count(), 0u);
    EXPECT_FALSE(rows_of(125).are_wanted(true));
}

}  // namespace
}  // namespace dttmm::plugin
