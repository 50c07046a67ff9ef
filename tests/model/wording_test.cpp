// SPDX-License-Identifier: BSD-3-Clause
#include "model/wording.h"

#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

TEST(Wording, QuoteEscapesWhatATerminalWouldActUpon) {
    EXPECT_EQ(quote("plate"), "\"plate\"");
    EXPECT_EQ(quote("Платте é"), "\"Платте é\"");
    EXPECT_EQ(quote("a\nb\x1b[31m"), "\"a\\u{a}b\\u{1b}[31m\"");
    EXPECT_EQ(quote("a\u202e"
                    "b"),
              "\"a\\u{202e}b\"");  // right-to-left override
    EXPECT_EQ(quote("\xff"
                    "a"),
              "\"\\xffa\"");
}

TEST(Wording, QuoteIsShort) { EXPECT_EQ(quote(std::string(10000, 'x')), "\"" + std::string(100, 'x') + "…\""); }

// Oracle: counted by hand; "ca" to "abc" is the textbook pair that tells this distance (3) from the unrestricted one (2).
TEST(Wording, EditDistanceCountsEditsAndSwaps) {
    EXPECT_EQ(compute_edit_distance("", "abc"), 3);
    EXPECT_EQ(compute_edit_distance("kitten", "sitting"), 3);
    EXPECT_EQ(compute_edit_distance("tpye", "type"), 1);
    EXPECT_EQ(compute_edit_distance("ca", "abc"), 3);
    EXPECT_EQ(compute_edit_distance("same", "same"), 0);
}

TEST(Wording, NearestIsOfferedOnlyIfNear) {
    EXPECT_EQ(find_nearest("stifness", {"damping", "stiffness"}), "stiffness");
    EXPECT_EQ(find_nearest("foo", {"cos", "sin"}), std::nullopt);
    EXPECT_EQ(find_nearest("k9", {"k1", "c"}), "k1");
    EXPECT_EQ(suggestion("foo", {"cos", "sin"}), "; known here: cos, sin");
    EXPECT_EQ(suggestion("foo", {}), "");
}

TEST(Wording, LongListsAreCut) {
    EXPECT_EQ(listed({"a", "b"}), "a, b");
    EXPECT_TRUE(listed(std::vector<std::string>(27, "x")).ends_with("x and 7 more"));
}

}  // namespace
}  // namespace dttmm::host
