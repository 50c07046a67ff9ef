// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/signal_jumps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dttmm::host {
namespace {

constexpr double kDuration = 1.7;

// Oracle: 3 sin(20 t), whose range is 6, and a jump at 0.613 s. One of more than a hundredth of the range is found.
TEST(SignalJumps, OfAValue) {
    for (const double share : {0.0, 0.008, 0.0125, -0.3, 2.0}) {
        const double range = 6 + (std::abs(share) > 0.1 ? 6 * std::abs(share) : 0), size = share * range;
        const auto found = find_jump([&](double t) { return 3 * std::sin(20 * t) + (t >= 0.613 ? size : 0); }, kDuration);
        ASSERT_EQ(found.has_value(), std::abs(share) > 0.01) << share;
        if (!found) continue;
        EXPECT_NEAR(found->size, size, 1e-3 * range);
        EXPECT_NEAR(found->time, 0.613, 1e-5);
        EXPECT_FALSE(found->is_slope);
    }
}

// The same of a motor, whose jump of a millionth counts. Oracle as above; beside it forty kinks, which are larger in speed.
TEST(SignalJumps, OfAMotion) {
    for (const double share : {0.0, 0.8e-6, 1.25e-6, -1e-3}) {
        const auto saw = [](double t) { return 1e-3 * std::abs(std::fmod(23.7 * t, 2.0) - 1); };
        const double size = 6 * share;
        const auto found =
            find_jump_of_speed([&](double t) { return 3 * std::sin(20 * t) + saw(t) + (t >= 0.613 ? size : 0); }, kDuration);
        ASSERT_EQ(found && !found->is_slope, std::abs(share) > 1e-6) << share;
        if (!found || found->is_slope) continue;
        EXPECT_NEAR(found->size, size, 0.02 * std::abs(size) + 1e-7);
        EXPECT_NEAR(found->time, 0.613, 1e-5);
    }
}

// Oracle: the speed of 3 sin(20 t) has the range 120. A kink at 0.613 s of more than a hundredth of that is found; smooth
// motions have none, however fast.
TEST(SignalJumps, OfASpeed) {
    for (const double share : {0.0, 0.008, 0.0125, -0.2}) {
        const double size = 120 * share;
        const auto found =
            find_jump_of_speed([&](double t) { return 3 * std::sin(20 * t) + size * std::max(0.0, t - 0.613); }, kDuration);
        ASSERT_EQ(found.has_value(), std::abs(share) > 0.01) << share;
        if (!found) continue;
        EXPECT_TRUE(found->is_slope);
        EXPECT_NEAR(found->size, size, 0.01 * std::abs(size));
        EXPECT_NEAR(found->time, 0.613, 1e-5);
    }
    for (const double frequency : {0.1, 10.0, 300.0, 2000.0})
        EXPECT_FALSE(find_jump_of_speed([&](double t) { return std::sin(2 * M_PI * frequency * t); }, kDuration));
}

}  // namespace
}  // namespace dttmm::host
