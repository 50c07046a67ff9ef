// SPDX-License-Identifier: BSD-3-Clause
#include "report/base64.h"

#include <gtest/gtest.h>

#include <vector>

namespace dttmm::host {
namespace {

// Oracle: the vectors of RFC 4648, section 10.
TEST(Base64, VectorsOfTheStandard) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foob"), "Zm9vYg==");
    EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64("\xff\xfe"), "//4=");
}

// Oracle: IEEE 754, little-endian: 1 is 00 00 80 3f and 00 00 00 00 00 00 f0 3f, -2 is 00 00 00 c0.
TEST(Base64, NumbersAreLittleEndian) {
    EXPECT_EQ(base64_of_floats(std::vector<double>{1, -2}), base64(std::string_view("\0\0\x80\x3f\0\0\0\xc0", 8)));
    EXPECT_EQ(base64_of_doubles(std::vector<double>{1}), base64(std::string_view("\0\0\0\0\0\0\xf0\x3f", 8)));
}

}  // namespace
}  // namespace dttmm::host
