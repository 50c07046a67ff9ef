// SPDX-License-Identifier: BSD-3-Clause
#include "law/cubic.h"

#include <gtest/gtest.h>

#include <array>

namespace dttmm::plugin {
namespace {

// Oracle: f = 4 d + 80 d³ by hand at d = 1/2: 2 + 10; stored 4/8 + 80/64; slope 4 + 60; from 0 the mean is the stored energy
// by the deformation.
TEST(Cubic, IsDuffingsSpring) {
    const Cubic law(std::array{4.0, 80.0});
    const LawOnPath path = law.along({0, 0.5});
    EXPECT_EQ(path.force, 12);
    EXPECT_EQ(path.tangent, 64);
    EXPECT_EQ(path.stored, 1.75);
    EXPECT_EQ(path.mean, 3.5);
}

}  // namespace
}  // namespace dttmm::plugin
