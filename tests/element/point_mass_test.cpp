// SPDX-License-Identifier: BSD-3-Clause
#include "element/point_mass.h"

#include <gtest/gtest.h>

#include <array>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

const std::array<Pose, 3> kPointNodes = {Pose{{0.3, -0.1, 0.2}, rotation_from_vector({0.4, -0.8, 1.3})},
                                         Pose{{0.7, 0.25, -0.3}, rotation_from_vector({-1.1, 0.2, 0.6})},
                                         Pose{{-0.4, 0.9, 0.1}, Matrix3::Identity()}};

TEST(PointMass, IsALumpWithoutExtentAtItsFirstNode) {
    const Parts parts = PointMass(std::array{2.5}).discretise(kPointNodes);
    EXPECT_TRUE(parts.joints.empty());
    ASSERT_EQ(parts.lumps.size(), 1u);
    EXPECT_EQ(parts.lumps[0].mass, 2.5);
    EXPECT_TRUE(parts.lumps[0].inertia.isZero(0));
    EXPECT_EQ(parts.lumps[0].pose.position, kPointNodes[0].position);
    EXPECT_EQ(parts.lumps[0].pose.rotation, kPointNodes[0].rotation);
    EXPECT_EQ(parts.mounted, (std::vector<int>{0, 0, 0}));
}

}  // namespace
}  // namespace dttmm::plugin
