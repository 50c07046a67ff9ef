// SPDX-License-Identifier: BSD-3-Clause
#include "study/work.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

TEST(WorkOfAStudy, ListsOfCasesReadBack) {
    const std::vector<size_t> cases = {0, 1, 2, 6, 8, 9};
    EXPECT_EQ(describe_cases(cases), "1-3,7,9-10");
    EXPECT_EQ(parse_cases("1-3,7,9-10", 10), cases);
    for (const char* wrong : {"", "0", "11", "3-2", "1,", "1-", "a", "1 2", "9-11"})
        EXPECT_THROW(parse_cases(wrong, 10), Error) << wrong;
}

}  // namespace
}  // namespace dttmm::host
