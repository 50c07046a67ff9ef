// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/sweep_plan.h"

#include <gtest/gtest.h>

#include "model/error.h"

namespace dttmm::host {
namespace {

using Values = std::vector<std::string>;

ExitCode code_of(const std::string& text) {
    try {
        parse_sweep_axis(text);
        return ExitCode::ok;
    } catch (const Error& error) {
        return error.code();
    }
}

// Oracle: nine values from 300 to 500 N/mm by hand, both ends included, in SI.
TEST(SweepPlan, ARangeHasItsEndsAndIsEvenlySpaced) {
    const SweepAxis axis = parse_sweep_axis("k1=300N/mm..500N/mm:9");
    EXPECT_EQ(axis.name, "k1");
    ASSERT_EQ(axis.values.size(), 9u);
    EXPECT_EQ(axis.values.front(), "300000 N/m");
    EXPECT_EQ(axis.values[1], "325000 N/m");
    EXPECT_EQ(axis.values.back(), "500000 N/m");
}

TEST(SweepPlan, ARangeMayFallAndMayBeOfPlainNumbers) {
    EXPECT_EQ(parse_sweep_axis("n=3..-1:3").values, (Values{"3", "1", "-1"}));
    EXPECT_EQ(parse_sweep_axis("n=7..7:1").values, Values{"7"});
}

TEST(SweepPlan, AListKeepsItsTexts) {
    EXPECT_EQ(parse_sweep_axis("k1=400N/mm,450 N/mm").values, (Values{"400N/mm", "450 N/mm"}));
}

TEST(SweepPlan, FaultsAreRefused) {
    for (const char* text : {"k1", "=3", "k1="}) EXPECT_EQ(code_of(text), ExitCode::usage) << text;
    for (const char* text : {"k1=1..2", "k1=1..2:0", "k1=1..2:-3", "k1=1..2:1000000000", "k1=1..2:2.5", "k1=1N..2m:3",
                             "k1=a..b:3", "k1=7..9:1", "k1=1,,2", "k1=1,", "k1=3 blobs", "k1=..2:3"})
        EXPECT_EQ(code_of(text), ExitCode::model_invalid) << text;
}

TEST(SweepPlan, SeveralAxesSpanAGridTheLastFastest) {
    const std::vector<SweepCase> grid = make_grid({{"a", {"1", "2", "3"}}, {"b", {"x", "y"}}});
    ASSERT_EQ(grid.size(), 6u);
    EXPECT_EQ(grid[0], (SweepCase{{"a", "1"}, {"b", "x"}}));
    EXPECT_EQ(grid[1], (SweepCase{{"a", "1"}, {"b", "y"}}));
    EXPECT_EQ(grid[5], (SweepCase{{"a", "3"}, {"b", "y"}}));
    EXPECT_THROW(make_grid({{"a", {"1"}}, {"a", {"2"}}}), Error);
    EXPECT_THROW(make_grid({{"a", Values(1000, "1")}, {"b", Values(1000, "1")}}), Error);
}

}  // namespace
}  // namespace dttmm::host
