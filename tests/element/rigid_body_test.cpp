// SPDX-License-Identifier: BSD-3-Clause
#include "element/rigid_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "core/error.h"
#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

const std::array<Pose, 3> kNodes = {Pose{{0.3, -0.1, 0.2}, rotation_from_vector({0.4, -0.8, 1.3})},
                                    Pose{{0.7, 0.25, -0.3}, rotation_from_vector({-1.1, 0.2, 0.6})},
                                    Pose{{-0.4, 0.9, 0.1}, Matrix3::Identity()}};

//                                            mass  centre of mass       xx    yy    zz    xy     xz    yz
constexpr std::array<double, 10> kUglyBody = {3.7, 0.02, -0.05, 0.31, 0.11, 0.17, 0.19, 0.013, -0.02, 0.007};

// Oracle: the centre of mass from the rotated first node by hand; the tensor entry by entry, in the axes of that node.
TEST(RigidBody, StandsInTheAxesOfItsFirstNode) {
    const Parts parts = RigidBody(kUglyBody).discretise(kNodes);
    EXPECT_TRUE(parts.joints.empty());
    ASSERT_EQ(parts.lumps.size(), 1u);
    const Lump& lump = parts.lumps[0];
    EXPECT_EQ(lump.mass, 3.7);
    const Matrix3& R = kNodes[0].rotation;
    const Vector3 centre = kNodes[0].position + 0.02 * R.col(0) - 0.05 * R.col(1) + 0.31 * R.col(2);
    EXPECT_LT((lump.pose.position - centre).norm(), 1e-15);
    EXPECT_EQ(lump.pose.rotation, R);
    Matrix3 inertia;
    inertia << 0.11, 0.013, -0.02, 0.013, 0.17, 0.007, -0.02, 0.007, 0.19;
    EXPECT_EQ(lump.inertia, inertia);
    EXPECT_EQ(parts.mounted, (std::vector<int>{0, 0, 0}));
}

/// Status of a body with principal moments that stand at an angle to its axes.
dttmm_status status_of(const Vector3& moments, const Vector3& turn) {
    const Matrix3 R = rotation_from_vector(turn);
    const Matrix3 J = R * moments.asDiagonal() * R.transpose();
    try {
        RigidBody(std::array{1.0, 0.0, 0.0, 0.0, J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)});
        return DTTMM_OK;
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("inertia"));
        return error.status();
    }
}

// Oracle: principal moments of a mass, ∫(y² + z²) and so on: none negative, none above the sum of the others; thin rods (0,
// a, a) and flat plates (a, b, a + b) lie on the edge and are masses, in whatever axes.
TEST(RigidBody, TensorsOfNoMassAreRefused) {
    for (const Vector3& turn : {Vector3(0, 0, 0), Vector3(0.4, -0.8, 1.3)}) {
        EXPECT_EQ(status_of({0, 0, 0}, turn), DTTMM_OK) << "a point";
        EXPECT_EQ(status_of({0, 0.3, 0.3}, turn), DTTMM_OK) << "a rod";
        EXPECT_EQ(status_of({0.1, 0.3, 0.4}, turn), DTTMM_OK) << "a plate";
        EXPECT_EQ(status_of({2e-9, 3e-9, 4e-9}, turn), DTTMM_OK) << "a grain";
        EXPECT_EQ(status_of({0.1, 0.3, 0.401}, turn), DTTMM_ERROR_MODEL);
        EXPECT_EQ(status_of({-0.001, 0.3, 0.3}, turn), DTTMM_ERROR_MODEL);
        EXPECT_EQ(status_of({0, 0, 0.2}, turn), DTTMM_ERROR_MODEL);
        EXPECT_EQ(status_of({1e-9, 1e-9, 4e-9}, turn), DTTMM_ERROR_MODEL);
    }
}

}  // namespace
}  // namespace dttmm::plugin
