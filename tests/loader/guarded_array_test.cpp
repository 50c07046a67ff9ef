// SPDX-License-Identifier: BSD-3-Clause
#include "loader/guarded_array.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dttmm::host {
namespace {

TEST(GuardedArray, IsWholeUntilItIsWrittenPast) {
    GuardedArray array(5);
    ASSERT_EQ(array.size(), 5u);
    for (size_t i = 0; i < 5; ++i) EXPECT_EQ(array[i], 0);
    for (size_t i = 0; i < 5; ++i) array.data()[i] = NAN;
    EXPECT_EQ(array.overrun(), nullptr);
    for (const int past : {0, 3, 7}) {
        GuardedArray end(5), start(5);
        end.data()[5 + past] = 0;
        start.data()[-1 - past] = NAN;
        EXPECT_STREQ(end.overrun(), "end") << past;
        EXPECT_STREQ(start.overrun(), "start") << past;
        end.resize(5);
        EXPECT_EQ(end.overrun(), nullptr);
    }
    EXPECT_EQ(GuardedArray().overrun(), nullptr);
}

}  // namespace
}  // namespace dttmm::host
