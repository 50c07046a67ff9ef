// SPDX-License-Identifier: BSD-3-Clause
#include "record/tell.h"

#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

// Oracle: lines by hand.
TEST(Wrap, BreaksAtBlanksAndIndentsWhatFollows) {
    EXPECT_EQ(wrap("short", 20), "short");
    EXPECT_EQ(wrap("  indented stays so", 40), "  indented stays so");
    EXPECT_EQ(wrap("warning: the step is too long", 16), "warning: the\n    step is too\n    long");
    EXPECT_EQ(wrap("a /path/that/is/longer/than/a/line b", 12), "a /path/that/is/longer/than/a/line\n    b");
    EXPECT_EQ(wrap("", 10), "");
}

}  // namespace
}  // namespace dttmm::host
