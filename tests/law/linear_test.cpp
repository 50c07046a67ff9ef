// SPDX-License-Identifier: BSD-3-Clause
#include "law/linear.h"

#include <gtest/gtest.h>

#include <array>

namespace dttmm::plugin {
namespace {

// Oracle: Hooke by hand.
TEST(Linear, IsHookesSpring) {
    const Linear law(std::array{4.0});
    const LawOnPath path = law.along({1, 0.5});
    EXPECT_EQ(path.force, 2);
    EXPECT_EQ(path.mean, 3);
    EXPECT_EQ(path.stored, 0.5);
    EXPECT_TRUE(law.is_linear());
}

}  // namespace
}  // namespace dttmm::plugin
