// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_node.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// A model with the node "tip", given on line 13, and a mass on it.
std::string with_node(const std::string& node) {
    return model_with("[nodes]\n" + node + "\n[[element]]\nname = \"mass\"\ntype = \"lump\"\nat = \"tip\"\nmass = 1\n");
}
Node node(const std::string& text) { return parse(with_node("tip = " + text)).nodes.at(0); }
std::string node_fault(const std::string& text) { return errors_of(with_node("tip = " + text)); }

TEST(ReadNode, APositionIsEnough) {
    const Node tip = node("[\"1.45 m\", 0, \"-20 mm\"]");
    EXPECT_EQ(tip.name, "tip");
    EXPECT_EQ(tip.position, Eigen::Vector3d(1.45, 0, -0.02));
    EXPECT_TRUE(tip.rotation.isIdentity(0));
    EXPECT_TRUE(tip.fixed.none());
    EXPECT_FALSE(tip.moves);
}

// Oracle: the definitions: bit d of `fixed` is direction d of x y z rx ry rz; a quarter turn about z takes x to y.
TEST(ReadNode, ATableSaysMore) {
    const Node tip = node(
        "{ position = [1, 2, 3], fixed = [\"rz\", \"x\", \"ry\"], velocity = [0, \"4 mm/s\", 5], "
        "rotation = { axis = [0, 0, 2], angle = \"90 deg\" } }");
    EXPECT_EQ(tip.position, Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(tip.fixed.to_ulong(), 0b110001u);
    EXPECT_TRUE(tip.moves);
    EXPECT_EQ(tip.velocity, Eigen::Vector3d(0, 0.004, 5));
    EXPECT_EQ(tip.angular_velocity, Eigen::Vector3d::Zero());
    EXPECT_LT((tip.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
    EXPECT_TRUE(node("{ position = [0, 0, 0], angular_velocity = [0, 0, 0] }").moves) << "at rest, not where it likes";
}

// Oracle: the units: 5 mm and 2 degrees; a signal of each kind at an instant.
TEST(ReadNode, ASupportMovesFixedDirections) {
    const Node tip = node(
        "{ position = [1, 2, 3], fixed = [\"rz\", \"x\", \"y\"], motion = { x = \"-5 mm\", rz = \"=0.1*t\", "
        "y = { type = \"step\", to = \"3 mm\", end = \"2 s\" } } }");
    ASSERT_TRUE(tip.is_support());
    EXPECT_EQ(tip.motion[0]->value(7), -0.005);
    EXPECT_EQ(tip.motion[1]->value(1), 0.0015);
    EXPECT_FALSE(tip.motion[2]);
    EXPECT_DOUBLE_EQ(tip.motion[5]->value(3), 0.3);
    EXPECT_EQ(tip.motion_place, "m.toml:13:66");
    EXPECT_FALSE(node("{ position = [0, 0, 0], fixed = [\"x\"] }").is_support());
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = [\"x\"], motion = { y = 1 } }"),
              "m.toml:13:57: node \"tip\": motion: y is not fixed: a support moves a node in fixed directions only; add "
              "\"y\" to fixed, or leave its motion out");
    EXPECT_EQ(
        node_fault("{ position = [0, 0, 0], fixed = [\"x\"], motion = {} }"),
        "m.toml:13:55: node \"tip\": motion: it moves no direction; write motion = { z = \"-5 mm\" }, or leave it out");
    EXPECT_THAT(node_fault("{ position = [0, 0, 0], fixed = [\"x\"], motion = { x = \"3 N\" } }"), HasSubstr("motion: x"));
    EXPECT_THAT(node_fault("{ position = [0, 0, 0], fixed = [\"x\"], motion = { xx = 1 } }"), HasSubstr("did you mean"));
}

TEST(ReadNode, FaultsNameTheNode) {
    EXPECT_EQ(node_fault("[1, 2]"), "m.toml:13:7: node \"tip\" wants 3 numbers, got 2");
    EXPECT_EQ(node_fault("[0,8, 1, 2]"),
              "m.toml:13:7: node \"tip\" wants 3 numbers, got 4 (a number has a decimal point, 0.8)");
    EXPECT_EQ(node_fault("{ fixed = [] }"), "m.toml:13:7: node \"tip\": missing key \"position\"");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixd = [] }"),
              "m.toml:13:31: node \"tip\": unknown key \"fixd\"; did you mean \"fixed\"?");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = \"x\" }"),
              "m.toml:13:39: node \"tip\": fixed must be a list of directions out of x, y, z, rx, ry, rz; got a text");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = [\"x\", \"theta\"] }"),
              "m.toml:13:45: node \"tip\": fixed: \"theta\" is none of the directions x, y, z, rx, ry, rz");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = [1] }"),
              "m.toml:13:40: node \"tip\": fixed: a number is none of the directions x, y, z, rx, ry, rz");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = [\"x\", \"x\"] }"),
              "m.toml:13:45: node \"tip\": fixed names \"x\" twice");
    EXPECT_EQ(node_fault("{ position = [0, 0, 0], fixed = [\"ry\"], angular_velocity = [0, 1, 0] }"),
              "m.toml:13:66: node \"tip\": angular_velocity moves the node in ry, which is fixed");
    EXPECT_EQ(
        node_fault("[0, 2e6, 0]"),
        "m.toml:13:7: node \"tip\": position must be within 1000000 m of the origin in every direction, got 2000000 m");
    EXPECT_THAT(
        parse(with_node("tip = [0, 2e4, 0]")).warnings,
        testing::Contains(WarningIs("far-from-origin", HasSubstr("node \"tip\": position is 20000 m from the origin"))));
}

TEST(ReadNode, NamesFollowTheRulesOfBodies) {
    EXPECT_THAT(errors_of(with_node("tip = [0, 0, 0]\n\"a b\" = [0, 0, 0]")),
                HasSubstr("m.toml:14:1: node name \"a b\" holds the character"));
    EXPECT_THAT(errors_of(with_node("tip = [0, 0, 0]\nground = [0, 0, 0]")),
                HasSubstr("m.toml:14:1: node \"ground\": the name \"ground\" is reserved"));
    EXPECT_THAT(errors_of(with_node("tip = [0, 0, 0]\nplate = [0, 0, 0]")),
                HasSubstr("m.toml:14:1: node \"plate\": the body on line 8 has the same name"));
    EXPECT_THAT(errors_of(with_node("tip = [0, 0, 0]\n[[joint]]\nname = \"tip\"")),
                HasSubstr("m.toml:15:8: joint \"tip\": the node on line 13 has the same name"));
    EXPECT_THAT(errors_of("nodes = 3\n" + model_with("")),
                HasSubstr("m.toml:1:1: nodes must be a table of name = [x, y, z]"));
}

TEST(ReadNode, ANodeThatNoElementHoldsIsRefused) {
    EXPECT_EQ(errors_of(with_node("tip = [0, 0, 0]\nspare = [0, 0, 0]")),
              "m.toml:14:1: node \"spare\" is used nowhere: no element holds it");
}

TEST(ReadNode, AJointHoldsNoNode) {
    const std::string joint = "tip = [0, 0, 0]\n[[joint]]\nname = \"pin\"\ntype = \"ball\"\n";
    EXPECT_THAT(errors_of(with_node(joint + "between = [\"plate\", \"tip\"]")),
                HasSubstr("m.toml:17:21: joint \"pin\": between: \"tip\" is a node; a joint joins"));
    EXPECT_THAT(errors_of(with_node(joint + "between = [\"ground\", \"plate\"]\nanchor = \"tip\"")),
                HasSubstr("m.toml:18:10: joint \"pin\": anchor: a node is no point of a body"));
}

}  // namespace
}  // namespace dttmm::host
