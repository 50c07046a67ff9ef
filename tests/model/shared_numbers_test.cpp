// SPDX-License-Identifier: BSD-3-Clause
#include "model/shared_numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;

TEST(SharedNumbers, CopiesShareUntilOneIsChanged) {
    SharedNumbers first{3, 5, 7};
    const SharedNumbers second = first;
    EXPECT_EQ(first.data(), second.data());
    first.change()[1] = 11;
    EXPECT_THAT(first, ElementsAre(3, 11, 7));
    EXPECT_THAT(second, ElementsAre(3, 5, 7));
    const double* const own = first.data();
    first.change()[2] = 13;
    EXPECT_EQ(first.data(), own);
}

TEST(SharedNumbers, NoneAreEmptyAndMayBecomeSome) {
    SharedNumbers none;
    EXPECT_TRUE(none.empty());
    EXPECT_EQ(none, SharedNumbers(std::vector<double>()));
    none.change().push_back(2);
    EXPECT_THAT(none, ElementsAre(2));
    EXPECT_TRUE(SharedNumbers().empty());
}

}  // namespace
}  // namespace dttmm::host
