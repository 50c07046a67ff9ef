// SPDX-License-Identifier: BSD-3-Clause
#include "element/elastic_hinge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/rotation.h"
#include "core/state_vector.h"
#include "element/registry.h"
#include "support/element_values.h"

namespace dttmm::plugin {
namespace {

using test::Given;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ElasticHinge hinge(const Given& given) {
    const std::vector<double> values = test::values_of(ElasticHinge::type(), given);
    return ElasticHinge(values);
}

/// The number that a word of a parameter stands for.
double word(const char* parameter, const std::string& name) {
    for (uint32_t p = 0; p < ElasticHinge::type().parameter_count; ++p) {
        const dttmm_parameter& declared = ElasticHinge::type().parameters[p];
        for (uint32_t w = 0; w < declared.word_count; ++w)
            if (declared.name == std::string(parameter) && declared.words[w].name == name) return declared.words[w].value;
    }
    ADD_FAILURE() << parameter << " knows no " << name;
    return std::nan("");
}

TEST(ElasticHinge, WhatIsNotNamedIsRigid) {
    const JointLaw law = hinge({}).law();
    EXPECT_TRUE(law.rigid.all());
    EXPECT_TRUE(law.elastic().none());
    EXPECT_TRUE(law.stiffness.isZero(0));
    EXPECT_TRUE(law.damping.isZero(0));
}

// Oracle: the words by their meaning, direction by direction: a spring, one with a damper, a damper alone, free, rigid
// twice.
TEST(ElasticHinge, WordsAndNumbersMakeTheLaw) {
    const JointLaw law = hinge({{"stiffness.x", {7.3e6}},
                                {"stiffness.y", {word("stiffness.y", "free")}},
                                {"stiffness.z", {word("stiffness.z", "rigid")}},
                                {"stiffness.rx", {210}},
                                {"stiffness.ry", {word("stiffness.ry", "free")}},
                                {"damping.rx", {0.7}},
                                {"damping.ry", {5}}})
                             .law();
    EXPECT_EQ(law.rigid, Directions(0b100100));
    EXPECT_EQ(law.elastic(), Directions(0b011001));
    EXPECT_EQ(law.carried(), Directions(0b111101));
    EXPECT_EQ(law.stiffness, (Vector6() << 7.3e6, 0, 0, 210, 0, 0).finished());
    EXPECT_EQ(law.damping, (Vector6() << 0, 0, 0, 0.7, 5, 0).finished());
}

// Oracle: section 1.6 of the transfer matrix method: compliances 1/(k + c C), zero where rigid, infinite where free.
TEST(ElasticHinge, TheTransferMatrixHasNoComplianceInRigidDirections) {
    const double C = 800;
    const Matrix13 U = hinge({{"stiffness.y", {3e5}}, {"damping.y", {40}}, {"stiffness.rz", {90}}, {"stiffness.rx", {0}}})
                           .law()
                           .transfer({1, C}, Vector6::Zero());
    Matrix13 expected = Matrix13::Identity();
    expected(state::kPosition + 1, state::kForce + 1) = -1 / (3e5 + 40 * C);
    expected(state::kAngle + 2, state::kMoment + 2) = 1 / 90.0;
    expected(state::kAngle, state::kMoment) = kInfinity;
    EXPECT_EQ(U, expected);
}

// One joint, no mass: at the `to` end, in the axes of the `from` end, wherever the two are.
TEST(ElasticHinge, ItsJointStandsAtTheToEndInTheAxesOfTheFromEnd) {
    const Pose ends[] = {{{0.3, -0.1, 0.2}, rotation_from_vector({0.4, -0.8, 1.3})},
                         {{0.7, 0.25, -0.3}, rotation_from_vector({-1.1, 0.2, 0.6})}};
    const Parts parts = hinge({{"stiffness.rz", {0}}}).discretise(ends);
    EXPECT_TRUE(parts.lumps.empty());
    EXPECT_TRUE(parts.mounted.empty());
    ASSERT_EQ(parts.joints.size(), 1u);
    const JointPart& joint = parts.joints[0];
    EXPECT_EQ(joint.from, 0);
    EXPECT_EQ(joint.to, 1);
    EXPECT_EQ(joint.law->rigid, Directions(0b011111));
    EXPECT_EQ(joint.pose.position, ends[1].position);
    EXPECT_EQ(joint.pose.rotation, ends[0].rotation);
}

TEST(ElasticHinge, DampingInARigidDirectionIsRefused) {
    for (const char* direction : kDirectionNames) {
        const std::string stiffness = std::string("stiffness.") + direction, damping = std::string("damping.") + direction;
        try {
            hinge({{damping, {0.3}}});
            ADD_FAILURE() << "not refused: " << damping;
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
            EXPECT_THAT(error.what(), testing::HasSubstr(damping + ":"));
            EXPECT_THAT(error.what(), testing::HasSubstr("rigid"));
        }
        EXPECT_NO_THROW(hinge({{damping, {0.3}}, {stiffness, {0}}})) << "a damper alone";
        EXPECT_NO_THROW(hinge({{damping, {0.3}}, {stiffness, {12}}}));
    }
}

// Oracle: the law's tangent at rest, k; a direction with a law is not rigid, though it is not named.
TEST(ElasticHinge, ADirectionMayHaveALawOfItsOwn) {
    const double cubic = word("ry.law", "cubic");
    const Given own = {{"ry.law", {cubic}}, {"ry.stiffness", {40}}, {"ry.cubic", {-7}}};
    Given given = own;
    given.insert({"damping.ry", {0.3}});
    const JointLaw law = hinge(given).law();
    EXPECT_EQ(law.rigid, Directions(0b101111));
    ASSERT_TRUE(law.laws[4]);
    EXPECT_EQ(law.laws[4]->first(0.5).force, 40 * 0.5 - 7 * 0.125);
    EXPECT_EQ(law.stiffness, (Vector6() << 0, 0, 0, 0, 40, 0).finished());
    EXPECT_EQ(law.damping(4), 0.3);
    given = own;
    given.insert({"stiffness.ry", {word("stiffness.ry", "free")}});
    EXPECT_NO_THROW(hinge(given));
    given = own;
    given.insert({"stiffness.ry", {12}});
    try {
        hinge(given);
        ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "stiffness: direction ry has a law; put 0 there, or leave ry out");
    }
}

// Infinity is allowed as the value of a word, never for a damping, and nothing else that is not finite.
TEST(ElasticHinge, OnlyTheWordIsInfinite) {
    uint32_t type = 0;
    while (std::string(element_types()[type].name) != "elastic_hinge") ++type;
    const auto accepts = [&](const Given& given) {
        try {
            make_element(type, test::values_of(ElasticHinge::type(), given).data());
            return true;
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_ARGUMENT);
            return false;
        }
    };
    EXPECT_TRUE(accepts({{"stiffness.x", {kInfinity}}}));
    EXPECT_FALSE(accepts({{"stiffness.x", {-kInfinity}}}));
    EXPECT_FALSE(accepts({{"stiffness.x", {std::nan("")}}}));
    EXPECT_FALSE(accepts({{"stiffness.x", {-1}}}));
    EXPECT_FALSE(accepts({{"stiffness.rz", {1}}, {"damping.rz", {kInfinity}}}));
}

}  // namespace
}  // namespace dttmm::plugin
