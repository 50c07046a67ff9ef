// SPDX-License-Identifier: BSD-3-Clause
#include "element/axial_spring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "support/element_values.h"

namespace dttmm::plugin {
namespace {

using testing::HasSubstr;

constexpr double kCubicLaw = 1;
const Pose kFirst{Vector3(0.3, -0.2, 0.5), Matrix3::Identity()}, kSecond{Vector3(0.7, 0.4, -0.7), Matrix3::Identity()};
const double kApart = 1.4;  // √(0.4² + 0.6² + 1.2²)

JointPart part_of(const test::Given& given, const Pose& from = kFirst, const Pose& to = kSecond) {
    const Pose ends[] = {from, to};
    const Parts parts = AxialSpring(test::values_of(AxialSpring::type(), given)).discretise(ends);
    EXPECT_TRUE(parts.lumps.empty());
    EXPECT_EQ(parts.joints.size(), 1u);
    return parts.joints.front();
}

/// Force at the start [N].
double start_force(const test::Given& given) {
    const JointLaw law = *part_of(given).law;
    return law.at(0, law.axial->length - law.axial->natural, nullptr).force;
}

std::string spring_fault(const test::Given& given, const Pose& to = kSecond) {
    try {
        part_of(given, kFirst, to);
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
        return error.what();
    }
    return "none";
}

// Oracle: geometry by hand.
TEST(AxialSpring, LiesAlongTheLineBetweenItsEnds) {
    const JointPart part = part_of({{"stiffness", {800}}, {"damping", {3}}});
    EXPECT_EQ(part.from, 0);
    EXPECT_EQ(part.to, 1);
    EXPECT_EQ(part.pose.position, kSecond.position);
    EXPECT_LT((part.pose.rotation.col(0) - Vector3(0.4, 0.6, -1.2) / kApart).norm(), 1e-15);
    EXPECT_LT((part.pose.rotation.transpose() * part.pose.rotation - Matrix3::Identity()).norm(), 1e-15);
    EXPECT_NEAR(part.law->axial->length, kApart, 1e-15);
    EXPECT_EQ(part.law->stiffness, 800 * Vector6::UnitX());
    EXPECT_EQ(part.law->damping, 3 * Vector6::UnitX());
}

// Oracle: k (L − L0) of a length or a force that is given; k d + k3 d³ turned round.
TEST(AxialSpring, HasItsNaturalLengthOrItsPreload) {
    EXPECT_EQ(start_force({{"stiffness", {800}}}), 0);
    EXPECT_NEAR(start_force({{"stiffness", {800}}, {"natural_length", {1.1}}}), 800 * 0.3, 1e-12);
    EXPECT_NEAR(start_force({{"stiffness", {800}}, {"natural_length", {1.9}}}), -800 * 0.5, 1e-12);
    EXPECT_NEAR(start_force({{"stiffness", {800}}, {"natural_length", {0}}}), 800 * 1.4, 1e-12);
    const double length = part_of({{"stiffness", {800}}}).law->axial->length;
    for (const double rounding : {-4e-16, 3e-16}) {
        EXPECT_EQ(start_force({{"stiffness", {800}}, {"natural_length", {length * (1 + rounding)}}}), 0) << rounding;
        EXPECT_NE(start_force({{"stiffness", {800}}, {"natural_length", {length * (1 + 1e4 * rounding)}}}), 0) << rounding;
    }
    for (double force : {250.0, -37.5, 0.3, 5e4}) {
        EXPECT_NEAR(start_force({{"stiffness", {800}}, {"preload", {force}}}), force, 1e-12 * std::abs(force));
        EXPECT_NEAR(start_force({{"law", {kCubicLaw}}, {"stiffness", {0}}, {"cubic", {6e4}}, {"preload", {force}}}), force,
                    1e-12 * std::abs(force));
    }
}

// Oracle: a spring that softens, 3 d − d³, bears 1.9 first at the least root of d³ − 3 d + 1.9 = 0.
TEST(AxialSpring, APreloadIsThatOfTheLeastElongation) {
    const JointLaw law = *part_of({{"law", {kCubicLaw}}, {"stiffness", {3}}, {"cubic", {-1}}, {"preload", {-1.9}}}).law;
    const double d = law.axial->natural - law.axial->length;
    EXPECT_NEAR(3 * d - d * d * d, 1.9, 1e-14);
    EXPECT_LT(d, 1);
}

TEST(AxialSpring, FaultsHaveTheirCure) {
    EXPECT_EQ(spring_fault({}), "stiffness is missing: the law linear needs it");
    EXPECT_EQ(spring_fault({{"stiffness", {1}}, {"cubic", {1}}}), "cubic does not belong to the law linear: remove it");
    EXPECT_EQ(spring_fault({{"stiffness", {1}}, {"natural_length", {1}}, {"preload", {1}}}),
              "natural_length and preload say the same: leave one out");
    EXPECT_EQ(spring_fault({{"law", {kCubicLaw}}, {"stiffness", {3}}, {"cubic", {-1}}, {"preload", {2.1}}}),
              "preload: its law has no force of 2.1 N up to 1000 m; the largest is 2 N");
    EXPECT_THAT(spring_fault({{"stiffness", {1}}}, kFirst), HasSubstr("its ends are 0 m apart"));
}

}  // namespace
}  // namespace dttmm::plugin
