// SPDX-License-Identifier: BSD-3-Clause
#include "identify/limit_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/error.h"

namespace dttmm::host {
namespace {

// Oracle: of a parabola 4 x^2 the limit is at half of the root of what is allowed, whatever the first guess.
TEST(LimitSearch, FindsTheLimitOfAParabola) {
    for (const double first : {1e-3, 1.0, 30.0}) {
        const LimitFound found = find_limit([](double x) { return Rise{4 * x * x}; }, first, 100, 3.84);
        ASSERT_TRUE(found.distance);
        EXPECT_NEAR(*found.distance, std::sqrt(3.84) / 2, 0.05) << first;
        EXPECT_TRUE(found.is_converged);
    }
}

TEST(LimitSearch, NoLimitWithinReachIsNone) {
    const LimitFound found = find_limit([](double) { return Rise{1}; }, 1, 100, 3.84);
    EXPECT_FALSE(found.distance);
    EXPECT_TRUE(found.is_converged);
}

TEST(LimitSearch, AStepIsALimit) {
    const LimitFound found = find_limit([](double x) { return Rise{x < 0.7 ? 0.0 : 1e6}; }, 1, 100, 3.84);
    ASSERT_TRUE(found.distance);
    EXPECT_NEAR(*found.distance, 0.7, 0.05);
    EXPECT_TRUE(found.is_converged);
}

// The first guess is 1e12 times too short, and a step is at most threefold.
TEST(LimitSearch, TellsThatItDidNotConverge) {
    const LimitFound found = find_limit([](double x) { return Rise{x < 1 ? 0.0 : 10}; }, 1e-12, 100, 3.84);
    EXPECT_FALSE(found.is_converged);
}

TEST(LimitSearch, OtherUnknownsThatDidNotConvergeMakeTheLimitAGuess) {
    const LimitFound found = find_limit([](double x) { return Rise{x * x, false}; }, 1, 100, 3.84);
    ASSERT_TRUE(found.distance);
    EXPECT_FALSE(found.is_converged);
}

TEST(LimitSearch, WhereTheModelHasNoAnswerTheLimitIsUnknown) {
    const LimitFound found = find_limit(
        [](double x) -> Rise {
            if (x > 2) throw Error(ExitCode::numerical_failure, "no equilibrium");
            return {0.1 * x};
        },
        1, 100, 3.84);
    EXPECT_FALSE(found.distance);
    EXPECT_FALSE(found.is_converged);
}

}  // namespace
}  // namespace dttmm::host
