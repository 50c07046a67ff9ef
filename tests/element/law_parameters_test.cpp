// SPDX-License-Identifier: BSD-3-Clause
#include "element/law_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "element/spring_damper.h"
#include "support/element_values.h"

namespace dttmm::plugin {
namespace {

constexpr double kLinear = 0, kCubic = 1;

JointLaw law_of(const test::Given& given) { return SpringDamper(test::values_of(SpringDamper::type(), given)).law(); }

std::string fault_of(const test::Given& given) {
    try {
        law_of(given);
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
        return error.what();
    }
    return "none";
}

// Oracle: the directions by hand: each takes its own law, its stiffness is the tangent at rest, and linear ones need none.
TEST(LawParameters, GiveEachDirectionItsLaw) {
    const JointLaw law = law_of({{"stiffness", {7, 0, 0}},
                                 {"y.law", {kLinear}},
                                 {"y.stiffness", {5}},
                                 {"rz.law", {kCubic}},
                                 {"rz.stiffness", {3}},
                                 {"rz.cubic", {-2}}});
    EXPECT_EQ(law.stiffness, (Vector6() << 7, 5, 0, 0, 0, 3).finished());
    for (size_t d = 0; d < 6; ++d) EXPECT_EQ(law.laws[d] != nullptr, d == 5) << d;
    EXPECT_EQ(law.laws[5]->first(0.5).force, 3 * 0.5 - 2 * 0.125);
}

// A law of no stiffness at rest carries its direction all the same.
TEST(LawParameters, ALawWithoutStiffnessCarries) {
    const JointLaw law = law_of({{"x.law", {kCubic}}, {"x.stiffness", {0}}, {"x.cubic", {4}}});
    EXPECT_TRUE(law.carried()[0]);
    EXPECT_FALSE(law.resisting()[0]);
}

TEST(LawParameters, FaultsHaveTheirCure) {
    EXPECT_EQ(fault_of({{"z.cubic", {80}}}), "z.cubic needs a law: add z.law");
    EXPECT_EQ(fault_of({{"z.law", {kCubic}}, {"z.stiffness", {4}}}), "z.cubic is missing: the law cubic needs it");
    EXPECT_EQ(fault_of({{"z.law", {kLinear}}, {"z.stiffness", {4}}, {"z.cubic", {80}}}),
              "z.cubic does not belong to the law linear: remove it");
    EXPECT_EQ(fault_of({{"stiffness", {0, 0, 9}}, {"z.law", {kLinear}}, {"z.stiffness", {4}}}),
              "stiffness: direction z has a law; put 0 there, or leave z out");
    EXPECT_EQ(fault_of({{"rotational_stiffness", {9, 0, 0}}, {"rx.law", {kLinear}}, {"rx.stiffness", {4}}}),
              "rotational_stiffness: direction rx has a law; put 0 there, or leave rx out");
}

}  // namespace
}  // namespace dttmm::plugin
