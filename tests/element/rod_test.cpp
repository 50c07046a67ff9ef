// SPDX-License-Identifier: BSD-3-Clause
#include "element/rod.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "element/line_parts.h"

namespace dttmm::plugin {
namespace {

using namespace test_lines;
using test::with;

Rod rod(int segments, const Given& given) {
    const std::vector<double> values = test::values_of(Rod::kType, with(given, {{"segments", {1.0 * segments}}}));
    return Rod(std::span<const double, 1 + kSectionValueCount>(values));
}

TEST(Rod, AMassOffItsAxisIsRefused) {
    try {
        rod(3, {{"section.EA", {1e8}}, {"section.mass", {7}}, {"section.mass_offset", {0, 0.01}}});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
        EXPECT_NE(std::string(error.what()).find("section.mass_offset"), std::string::npos) << error.what();
    }
}

// Oracle: compliance L/EA along and nothing else; mass and inertia of a thin bar, exactly.
TEST(Rod, StretchesAndIsRigidOtherwise) {
    const double L = (kTo - kFrom).norm();
    const Vector3 middle = 0.5 * (kFrom + kTo);
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3);
    for (int segments : {1, 2, 6}) {
        const Parts parts = between(
            kFrom, kTo,
            rod(segments, {{"section.EA", {3.1e8}}, {"section.mass", {13.7}}, {"material.stiffness_damping", {2e-5}}}));
        ASSERT_EQ(parts.lumps.size(), static_cast<size_t>(segments));
        ASSERT_EQ(parts.joints.size(), static_cast<size_t>(segments) + 1);
        for (const JointPart& joint : parts.joints) {
            EXPECT_EQ(joint.law->rigid, Directions(0b111110));
            EXPECT_EQ(joint.law->damping(0), 2e-5 * joint.law->stiffness(0));
        }
        Matrix6 expected = Matrix6::Zero();
        expected(0, 0) = L / 3.1e8;
        EXPECT_LT((in_axes(R, compliance(parts, kTo)) - expected).norm(), 1e-14 * expected.norm());
        const Inertia sum = total(parts, middle);
        EXPECT_NEAR(sum.mass, 13.7 * L, 1e-14 * sum.mass);
        EXPECT_LT((sum.centre - middle).norm(), 1e-15);
        const double across = 13.7 * L * L * L / 12;
        EXPECT_LT((R.transpose() * sum.tensor * R - Matrix3(Vector3(0, across, across).asDiagonal())).norm(),
                  1e-14 * across);
    }
}

TEST(Rod, OfAShapeHasItsPolarInertia) {
    const Rod element = rod(4, kTube);
    const double L = (kTo - kFrom).norm();
    const Matrix3 R = beam_axes(kFrom, kTo, kNotGiven3), J = total(between(kFrom, kTo, element), 0.5 * (kFrom + kTo)).tensor;
    EXPECT_NEAR((R.transpose() * J * R)(0, 0), element.section().inertia * L, 1e-13 * element.section().inertia * L);
}

}  // namespace
}  // namespace dttmm::plugin
