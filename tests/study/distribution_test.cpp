// SPDX-License-Identifier: BSD-3-Clause
#include "study/distribution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/error.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<Parameter> kFile = {{"k1", 5e5, "N/m", "500 N/mm"},
                                      {"k2", 6e5, "N/m", "600 N/mm"},
                                      {"k10", 7e5, "N/m", "700 N/mm"},
                                      {"loss", 0.02, "1", "2 %"},
                                      {"both", 1.1e6, "", "=k1+k2"}};

std::string refusal_of(const std::string& text) {
    try {
        parse_variation(text, kFile);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage) << text;
        return error.what();
    }
    ADD_FAILURE() << "accepted: " << text;
    return {};
}

// Oracle: tables of the normal distribution: 97.7249868 % lie below mean + 2 deviations, 50 % below the mean.
TEST(Distribution, NormalByItsQuantiles) {
    const Distribution normal = parse_variation("k1 ~ normal(500 N/mm, 10 %)", kFile).distribution;
    EXPECT_DOUBLE_EQ(normal.quantile(0.5), 5e5);
    EXPECT_NEAR(normal.quantile(0.9772498680518208), 6e5, 1e-6);
    const Distribution own = parse_variation("k1 ~ normal(500 N/mm, 25 N/mm)", kFile).distribution;
    EXPECT_NEAR(own.quantile(0.15865525393145707), 4.75e5, 1e-6);
}

// Oracle: mean and deviation of the value itself, by the midpoint rule over its quantiles.
TEST(Distribution, LognormalHasTheMeanAndTheDeviationAskedFor) {
    const Distribution bell = parse_variation("k1 ~ lognormal(500 N/mm, 30 %)", kFile).distribution;
    constexpr int kCount = 400000;
    double sum = 0, squares = 0;
    for (int i = 0; i < kCount; ++i) {
        const double value = bell.quantile((i + 0.5) / kCount);
        sum += value;
        squares += value * value;
    }
    const double mean = sum / kCount;
    EXPECT_NEAR(mean, 5e5, 20);
    EXPECT_NEAR(std::sqrt(squares / kCount - mean * mean), 1.5e5, 200);
}

TEST(Distribution, UniformAndLists) {
    const Distribution even = parse_variation("loss ~ uniform(1 %, 3 %)", kFile).distribution;
    EXPECT_NEAR(even.quantile(0.25), 0.015, 1e-15);
    const Distribution list = parse_variation("k1 ~ list(400 N/mm, 0.5 kN/mm, 7e5 N/m)", kFile).distribution;
    EXPECT_THAT(list.values, ElementsAre(4e5, 5e5, 7e5));
    EXPECT_EQ(list.quantile(1.0 / 3 - 1e-9), 4e5);
    EXPECT_EQ(list.quantile(1.0 / 3 + 1e-9), 5e5);
    EXPECT_EQ(list.quantile(1 - 1e-16), 7e5);
}

TEST(Distribution, NamesAsRangesListsAndPatterns) {
    EXPECT_THAT(parse_variation("k1..k2 ~ uniform(1 N/m, 2 N/m)", kFile).names, ElementsAre("k1", "k2"));
    EXPECT_THAT(
        parse_variation("k1..2, loss ~ uniform(1, 2)", {{"k1", 1, "1", "1"}, {"k2", 1, "1", "1"}, {"loss", 1, "1", "1"}})
            .names,
        ElementsAre("k1", "k2", "loss"));
    EXPECT_THAT(parse_variation("k* ~ uniform(1 N/m, 2 N/m)", kFile).names, ElementsAre("k1", "k2", "k10"));
    EXPECT_THAT(refusal_of("k1..k4 ~ uniform(1 N/m, 2 N/m)"), HasSubstr("no such parameter \"k3\""));
    EXPECT_THAT(refusal_of("k2..k1 ~ uniform(1 N/m, 2 N/m)"), HasSubstr("is no range of names"));
    EXPECT_THAT(refusal_of("q* ~ uniform(1 N/m, 2 N/m)"), HasSubstr("no parameter is called like \"q*\""));
    EXPECT_THAT(refusal_of(", ~ uniform(1 N/m, 2 N/m)"), HasSubstr("a name is missing"));
}

TEST(Distribution, WrongTextsAreRefusedWithTheCure) {
    EXPECT_THAT(refusal_of("k1 normal(1, 2)"), HasSubstr("write \"names ~ distribution\""));
    EXPECT_THAT(refusal_of("k1 ~"), HasSubstr("the distribution is missing"));
    EXPECT_THAT(refusal_of("k1 ~ 5"), HasSubstr("is no distribution: write normal("));
    EXPECT_THAT(refusal_of("k1 ~ normale(1 N/m, 2 N/m)"), HasSubstr("did you mean \"normal\"?"));
    EXPECT_THAT(refusal_of("k1 ~ normal(500 N/mm)"), HasSubstr("write normal(mean, deviation)"));
    EXPECT_THAT(refusal_of("k1 ~ normal(500, 10 %)"),
                HasSubstr("of which unit? the file gives \"k1\" in N/mm: write \"500 N/mm\""));
    EXPECT_THAT(refusal_of("k1 ~ normal(5 mm, 10 %)"), HasSubstr("expected a value in N/m"));
    EXPECT_THAT(refusal_of("k1 ~ normal(500 N/mm, 0 %)"), HasSubstr("must be above 0"));
    EXPECT_THAT(refusal_of("k1 ~ lognormal(-5 N/m, 1 N/m)"), HasSubstr("of a lognormal distribution must be above 0"));
    EXPECT_THAT(refusal_of("k1 ~ uniform(2 N/m, 1 N/m)"), HasSubstr("must be below"));
    EXPECT_THAT(refusal_of("k1 ~ list(2 N/m, )"), HasSubstr("expected a number"));
}

}  // namespace
}  // namespace dttmm::host
