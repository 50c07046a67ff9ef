// SPDX-License-Identifier: BSD-3-Clause
#include "model/element_scale.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kScaled = model_with(
    "[[element]]\nname = \"bolt\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate.a\"\nstiffness = [10, 0, 30]\n"
    "damping = 4\nrotational_stiffness = 7\n[[element]]\nname = \"other\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto "
    "= "
    "\"plate\"\nstiffness = 5\n");

TEST(ElementScale, FactorsActOnStiffnessAndDampingOfOneElement) {
    ModelOverrides overrides;
    overrides.scales = {{"bolt", 0.5, 3}, {"bolt", 0.5, 1}};
    const Model model = parse(kScaled, overrides);
    EXPECT_THAT(model.elements[0].values, ElementsAre(2.5, 0, 7.5, 12, 12, 12, 1.75, 1.75, 1.75, 0, 0, 0));
    EXPECT_THAT(model.elements[1].values, ElementsAre(5, 5, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0));
    EXPECT_TRUE(has_part(model.elements[0], test_catalogue(), ScaledPart::damping));
    EXPECT_FALSE(has_part(model.elements[1], test_catalogue(), ScaledPart::damping));
}

TEST(ElementScale, RefusesWhatItCannotScale) {
    ModelOverrides overrides;
    overrides.scales = {{"nut", 0.5, 1}};
    EXPECT_THAT(errors_of(kScaled, overrides), HasSubstr("no element \"nut\""));
    overrides.scales = {{"other", 1, 2}};
    EXPECT_THAT(errors_of(kScaled, overrides), HasSubstr("\"other\" has no damping"));
}

}  // namespace
}  // namespace dttmm::host
