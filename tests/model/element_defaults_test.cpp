// SPDX-License-Identifier: BSD-3-Clause
#include "model/element_defaults.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kTwoSprings =
    "[[element]]\nname = \"a\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate.a\"\n[[element]]\nname = "
    "\"b\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate.a\"\nstiffness = [7, 8, 9]\n";

// Oracle: own keys win, others come from the defaults, and elements of another type have none of them.
TEST(ElementDefaults, OwnKeysWin) {
    const Model model =
        parse(model_with(kTwoSprings + "[[element]]\nname = \"c\"\ntype = \"strut\"\nfrom = \"ground\"\nto = \"plate\"\n"
                                       "[defaults.spring_damper]\nstiffness = \"=k\"\ndamping = 2\n"
                                       "[defaults.strut]\nlengths = [1, 2]\n[parameters]\nk = \"3 N/mm\"\n"));
    EXPECT_THAT(model.elements[0].values, ElementsAre(3e3, 3e3, 3e3, 2, 2, 2, 0, 0, 0, 0, 0, 0));
    EXPECT_THAT(model.elements[1].values, ElementsAre(7, 8, 9, 2, 2, 2, 0, 0, 0, 0, 0, 0));
    EXPECT_THAT(model.elements[2].values, ElementsAre(1, 2, 0.25));
}

TEST(ElementDefaults, ReachBodiesLoadsPatternsAndCircles) {
    const Model model = parse(std::string(kStart) + kSimulation + R"toml([defaults.body]
density = 7000
markers = { hub = [0, 0, 3] }
[defaults.load]
direction = [0, 0, -1]
[defaults.spring_damper]
stiffness = 5
[[repeat]]
index = "i"
count = 2
[[repeat.body]]
name = "disc{i}"
sphere = "=0.1*i"
[[repeat.load]]
on = "disc{i}"
force = "=i"
[[bolt_circle]]
name = "bolt"
count = 3
radius = 1
from = "disc1.hub"
to = "disc2"
element = { type = "spring_damper" }
)toml");
    EXPECT_NEAR(model.bodies[1].mass, 7000 * M_PI / 6 * 8e-3, 1e-12);
    ASSERT_EQ(model.bodies[0].markers.size(), 4u);
    EXPECT_EQ(model.bodies[0].markers[1].position, Eigen::Vector3d(1, 0, 3));
    EXPECT_EQ(model.loads[1].direction.z(), -1);
    EXPECT_EQ(model.elements[2].values[0], 5);
}

// Oracle: the place in the defaults, the rule, and one message for both elements.
TEST(ElementDefaults, FaultsPointAtTheDefaults) {
    const auto fault = [](const std::string& defaults) { return errors_of(model_with(kTwoSprings + defaults)); };
    EXPECT_THAT(fault("[defaults.spring_damper]\ndamping = -2\n"),
                HasSubstr("m.toml:24:11: element \"a\": damping must be ≥ 0 N*s/m, got -2 (and in 1 more copy of this)"));
    EXPECT_THAT(fault("[defaults.spring_damper]\ndampng = 2\n"),
                HasSubstr("m.toml:24:1: element \"a\": unknown key \"dampng\""));
    EXPECT_THAT(fault("[defaults.spring]\ndamping = 2\n"), HasSubstr("m.toml:23:11: defaults: unknown key \"spring\""));
    EXPECT_THAT(fault("[defaults]\nbody = 3\n"),
                HasSubstr("m.toml:24:1: defaults: body must be a table; write [defaults.body]"));
    EXPECT_THAT(fault("[[defaults]]\nbody = 3\n"), HasSubstr("m.toml:23:1: defaults: expected a table"));
    EXPECT_THAT(fault("[defaults.spring_damper]\nname = \"x\"\n"),
                HasSubstr("m.toml:24:1: defaults: name belongs to each element alone"));
    EXPECT_THAT(parse(model_with("[defaults.strut]\nratio = 0.1\n")).warnings,
                testing::Contains(WarningIs("unused-defaults",
                                            "m.toml:12:11: defaults of \"strut\": the model has none of "
                                            "these")));
}

}  // namespace
}  // namespace dttmm::host
