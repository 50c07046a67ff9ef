// SPDX-License-Identifier: BSD-3-Clause
#include "study/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dttmm::host {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Oracle: by hand: 1 2 4 9: mean 4, squares 9 + 4 + 0 + 25 = 38 over 3; quantiles at 1 + 3 p.
TEST(StatisticsOfFigures, ByHand) {
    const std::vector<double> values = {9, kNone, 1, 4, kNone, 2};
    const FigureStatistics of = compute_statistics(values);
    EXPECT_EQ(of.count, 4u);
    EXPECT_DOUBLE_EQ(of.mean, 4);
    EXPECT_DOUBLE_EQ(of.deviation, std::sqrt(38.0 / 3));
    EXPECT_EQ(of.minimum, 1);
    EXPECT_EQ(of.maximum, 9);
    EXPECT_DOUBLE_EQ(of.quantiles[1], 1.15);  // 5 %
    EXPECT_DOUBLE_EQ(of.quantiles[3], 3);     // 50 %
    EXPECT_DOUBLE_EQ(of.quantiles[5], 8.25);  // 95 %
}

// Oracle: 1e9 + the same: no digit is lost but those of the numbers themselves.
TEST(StatisticsOfFigures, ALargeMeanCostsNoDigits) {
    const FigureStatistics of = compute_statistics(std::vector<double>{1e9 + 1, 1e9 + 2, 1e9 + 4, 1e9 + 9});
    EXPECT_DOUBLE_EQ(of.deviation, std::sqrt(38.0 / 3));
}

TEST(StatisticsOfFigures, OfOneAndOfNone) {
    const FigureStatistics one = compute_statistics(std::vector<double>{7});
    EXPECT_EQ(one.mean, 7);
    EXPECT_TRUE(std::isnan(one.deviation));
    EXPECT_EQ(one.quantiles[6], 7);
    EXPECT_EQ(compute_statistics(std::vector<double>{kNone}).count, 0u);
    EXPECT_TRUE(std::isnan(compute_statistics({}).mean));
}

// Oracle: by hand: x = 1 2 3, y = 2 1 6: covariance 4, deviations sqrt(2) and sqrt(14): 4/sqrt(28).
TEST(StatisticsOfFigures, Correlation) {
    EXPECT_NEAR(compute_correlation(std::vector<double>{1, 2, kNone, 3, 9}, std::vector<double>{2, 1, 5, 6, kNone}),
                4 / std::sqrt(28.0), 1e-15);
    EXPECT_TRUE(std::isnan(compute_correlation(std::vector<double>{1, 1}, std::vector<double>{2, 3})));
    EXPECT_THAT(compute_ranks(std::vector<double>{5, 1, 5, 9}), testing::ElementsAre(2.5, 1, 2.5, 4));
}

// Oracle: y falls strictly where it is a number; the other x have no part in the ranks.
TEST(StatisticsOfFigures, RanksAreAmongThePairsThatCount) {
    const std::vector<double> x = {1, 2, 2.1, 2.2, 2.3, 2.4, 3, 4}, y = {9, 7, kNone, kNone, kNone, kNone, 6, 1};
    EXPECT_DOUBLE_EQ(compute_rank_correlation(x, y), -1);
    EXPECT_TRUE(std::isnan(compute_rank_correlation(x, std::vector<double>(8, kNone))));
}

}  // namespace
}  // namespace dttmm::host
