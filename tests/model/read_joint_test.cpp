// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_joint.h"

#include <cmath>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A second body on lines 12 to 17, turned by a quarter about z: its marker b is at the plate's a, its c at (5, 2, 4).
const std::string kDisc =
    "[[body]]\nname = \"disc\"\nmass = 3\ninertia = [2, 3, 4]\nposition = [5, 0, 4]\n"
    "rotation = { axis = [0, 0, 2], angle = \"90 deg\" }\nmarkers = { b = [2, 4, -1], c = [2, 0, 0] }\n";

/// The header of a joint on line 19, its name on line 20; `text` begins on line 21.
std::string with_joint(const std::string& text) { return model_with(kDisc + "[[joint]]\nname = \"pin\"\n" + text); }
Joint joint(const std::string& text) { return parse(with_joint(text)).joints.at(0); }
std::string joint_fault(const std::string& text) { return errors_of(with_joint(text)); }

const std::string kBetween = "between = [\"plate\", \"disc\"]\n";
const std::string kAxis = "axis = [0, 3, 4]\n";

TEST(ReadJoint, EveryTypeIsRead) {
    const Joint hinge =
        joint("type = \"hinge\"\n" + kBetween + kAxis + "anchor = [1, \"20 mm\", -3]\nlimits = [\"-30 deg\", 0.25]\n");
    EXPECT_EQ(hinge.name, "pin");
    EXPECT_EQ(hinge.type, JointType::hinge);
    EXPECT_EQ(hinge.first, 0);
    EXPECT_EQ(hinge.second, 1);
    EXPECT_LT((hinge.anchor - Eigen::Vector3d(1, 0.02, -3)).norm(), 1e-15);
    EXPECT_LT((hinge.axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
    ASSERT_TRUE(hinge.limits);
    EXPECT_NEAR((*hinge.limits)[0], -M_PI / 6, 1e-15);
    EXPECT_EQ((*hinge.limits)[1], 0.25);
    EXPECT_EQ(hinge.place, "m.toml:19:1");

    const Joint slider = joint("type = \"slider\"\n" + kBetween + kAxis + "limits = [\"-5 mm\", 0]\n");
    EXPECT_EQ(slider.type, JointType::slider);
    EXPECT_EQ((*slider.limits)[0], -0.005);
    EXPECT_EQ((*slider.limits)[1], 0);
    EXPECT_EQ(joint("type = \"ball\"\nanchor = [1, 2, 3]\n" + kBetween).type, JointType::ball);
    EXPECT_EQ(joint("type = \"fixed\"\n" + kBetween).type, JointType::fixed);
    EXPECT_FALSE(joint("type = \"fixed\"\n" + kBetween).limits);
}

// Oracle: by hand. axis2 is 0.9e-6 rad off the right angle: what remains of it along axis is taken away.
TEST(ReadJoint, TheAxesOfAUniversalJointAreMadeOrthonormal) {
    const Joint cross =
        joint("type = \"universal\"\nanchor = [0, 0, 0]\naxis = [0, 3, 4]\naxis2 = [2, 1.08e-6, 1.44e-6]\n" + kBetween);
    EXPECT_EQ(cross.type, JointType::universal);
    EXPECT_NEAR(cross.axis.dot(cross.axis2), 0, 1e-16);
    EXPECT_NEAR(cross.axis2.norm(), 1, 1e-15);
    EXPECT_LT((cross.axis2 - Eigen::Vector3d::UnitX()).norm(), 1e-9);
}

// Oracle: the marker's position in the world, turned by hand.
TEST(ReadJoint, TheAnchorIsAPlaceOrAMarkerOrTheSecondBody) {
    const auto anchor = [](const std::string& between, const std::string& rest) {
        return joint("type = \"" + std::string(rest.find("axis") == rest.npos ? "fixed" : "slider") +
                     "\"\nbetween = " + between + "\n" + rest)
            .anchor;
    };
    const Eigen::Vector3d a(1, 2, 3), c(5, 2, 4), disc(5, 0, 4);
    EXPECT_LT((anchor("[\"plate.a\", \"disc\"]", "") - a).norm(), 1e-14);
    EXPECT_LT((anchor("[\"plate\", \"disc.c\"]", "") - c).norm(), 1e-14);
    EXPECT_LT((anchor("[\"plate.a\", \"disc.b\"]", "") - a).norm(), 1e-14);
    EXPECT_LT((anchor("[\"ground\", \"disc.c\"]", "axis = [1, 0, 0]\n") - c).norm(), 1e-14);
    EXPECT_LT((anchor("[\"plate\", \"disc\"]", "anchor = \"disc.c\"\n") - c).norm(), 1e-14);
    EXPECT_LT((anchor("[\"disc\", \"ground\"]", "anchor = \"plate\"\n")).norm(), 1e-14);
    EXPECT_LT((anchor("[\"plate\", \"disc\"]", "") - disc).norm(), 1e-14);
    EXPECT_LT((anchor("[\"disc\", \"plate\"]", "")).norm(), 1e-14);
    EXPECT_LT((anchor("[\"disc\", \"ground\"]", "") - disc).norm(), 1e-14);
    EXPECT_LT((anchor("[\"ground\", \"disc\"]", "") - disc).norm(), 1e-14);
    const Joint grounded = joint("type = \"ball\"\nbetween = [\"disc.c\", \"ground\"]\n");
    EXPECT_EQ(grounded.first, 1);
    EXPECT_EQ(grounded.second, -1);
    EXPECT_LT((grounded.anchor - c).norm(), 1e-14);
}

TEST(ReadJoint, AJointHasOneAnchor) {
    EXPECT_EQ(joint_fault("type = \"ball\"\nbetween = [\"plate.a\", \"disc.c\"]\n"),
              "m.toml:22:23: joint \"pin\": a joint has one anchor, to within 1e-06 m at the start, but \"plate.a\" is at "
              "(1, 2, 3) m "
              "and \"disc.c\" at (5, 2, 4) m; move a body, or name the body without marker");
    EXPECT_THAT(
        joint_fault("type = \"ball\"\nbetween = [\"plate\", \"disc.c\"]\nanchor = [5, 2, 4.00001]\n"),
        HasSubstr("m.toml:22:21: joint \"pin\": a joint has one anchor, to within 1e-06 m at the start, but anchor is at"));
    EXPECT_LT((joint("type = \"ball\"\nbetween = [\"plate\", \"disc.c\"]\nanchor = [5, 2, 4.0000009]\n").anchor -
               Eigen::Vector3d(5, 2, 4.0000009))
                  .norm(),
              1e-15);
    EXPECT_THAT(
        joint_fault("type = \"ball\"\n" + kBetween),
        HasSubstr("m.toml:19:1: joint \"pin\": missing key \"anchor\": a ball joint is at a point; give three lengths"));
    EXPECT_THAT(joint_fault("type = \"hinge\"\n" + kAxis + kBetween), HasSubstr("missing key \"anchor\""));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = \"ground\"\n" + kBetween),
                HasSubstr("m.toml:22:10: joint \"pin\": anchor: the ground has no point of its own"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = \"disc.d\"\n" + kBetween),
                HasSubstr("m.toml:22:10: joint \"pin\": anchor: body \"disc\" has no marker \"d\"; known here: b, c"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = [1, 2]\n" + kBetween), HasSubstr("anchor wants 3 numbers, got 2"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = [1, nan, 2]\n" + kBetween),
                HasSubstr("anchor must be finite, got nan"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = [1, 2e6, 2]\n" + kBetween), HasSubstr("anchor must be ≤ 1000000 m"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = [1, \"2 kg\", 2]\n" + kBetween),
                HasSubstr("anchor: expected a value in m, got \"2 kg\""));
}

TEST(ReadJoint, EndsMustBeTwoBodiesOrABodyAndTheGround) {
    const auto between = [](const std::string& ends) { return joint_fault("type = \"fixed\"\nbetween = " + ends + "\n"); };
    EXPECT_THAT(between("[\"ground\", \"ground\"]"), HasSubstr("m.toml:22:22: joint \"pin\": both ends are on the ground"));
    EXPECT_THAT(between("[\"plate\", \"plate.a\"]"),
                HasSubstr("m.toml:22:21: joint \"pin\": both ends are on the same body"));
    EXPECT_THAT(between("[\"plate\", \"dics\"]"),
                HasSubstr("m.toml:22:21: joint \"pin\": between: there is no body \"dics\"; did you mean \"disc\"?"));
    EXPECT_THAT(between("[\"plate.b\", \"disc\"]"), HasSubstr("between: body \"plate\" has no marker \"b\""));
    EXPECT_THAT(between("[\"plate\", 3]"), HasSubstr("m.toml:22:21: joint \"pin\": between must be a text, got a number"));
    EXPECT_THAT(between("[\"plate\"]"), HasSubstr("m.toml:22:11: joint \"pin\": between wants two names, e.g."));
    EXPECT_THAT(between("\"plate\""), HasSubstr("or [\"ground\", \"crank.pin\"]; got a text"));
    EXPECT_THAT(joint_fault("type = \"fixed\"\n"), HasSubstr("m.toml:19:1: joint \"pin\": missing key \"between\""));
}

TEST(ReadJoint, EveryTypeHasTheAxesItNeeds) {
    const auto axes = [](const std::string& type, const std::string& text) {
        return joint_fault("type = \"" + type + "\"\nanchor = [0, 0, 0]\n" + kBetween + text);
    };
    for (const char* type : {"hinge", "slider", "universal"}) {
        EXPECT_THAT(axes(type, ""), HasSubstr("m.toml:19:1: joint \"pin\": missing key \"axis\"")) << type;
        EXPECT_THAT(axes(type, "axis = [0, 0, 0]\n"), HasSubstr("m.toml:24:8: joint \"pin\": axis must not be zero"))
            << type;
    }
    EXPECT_THAT(axes("hinge", "axis = [0, inf, 0]\n"), HasSubstr("axis must be finite, got inf"));
    EXPECT_THAT(axes("hinge", "axis = [0, 1]\n"), HasSubstr("axis wants 3 numbers, got 2"));
    EXPECT_THAT(axes("universal", kAxis), HasSubstr("m.toml:19:1: joint \"pin\": missing key \"axis2\""));
    EXPECT_THAT(axes("universal", kAxis + "axis2 = [0, 2, 0]\n"),
                HasSubstr("m.toml:25:9: joint \"pin\": axis2 must be at right angles to axis, got 53.1301 degrees"));
    EXPECT_THAT(axes("universal", kAxis + "axis2 = [2, 1.32e-6, 1.76e-6]\n"), HasSubstr("got 89.9999 degrees"));
    EXPECT_THAT(axes("universal", kAxis + "axis2 = [0, 0, 0]\n"), HasSubstr("axis2 must not be zero"));
    EXPECT_THAT(
        axes("ball", kAxis),
        HasSubstr("m.toml:24:1: joint \"pin\": a ball joint has no axis; it belongs to a hinge, slider or universal"));
    EXPECT_THAT(axes("fixed", kAxis), HasSubstr("a fixed joint has no axis"));
    EXPECT_THAT(axes("hinge", kAxis + "axis2 = [1, 0, 0]\n"),
                HasSubstr("m.toml:25:1: joint \"pin\": a hinge joint has no axis2; it belongs to a universal joint"));
}

TEST(ReadJoint, LimitsHoldTheStartBetweenThem) {
    const auto limits = [](const std::string& type, const std::string& text) {
        return joint_fault("type = \"" + type + "\"\nanchor = [0, 0, 0]\n" + kBetween + kAxis + "limits = " + text + "\n");
    };
    EXPECT_EQ(limits("hinge", "[1, -1]"),
              "m.toml:25:10: joint \"pin\": limits = [low, high] must have low < high, got [1, -1] rad");
    EXPECT_THAT(limits("slider", "[0, 0]"), HasSubstr("must have low < high, got [0, 0] m"));
    EXPECT_THAT(limits("slider", "[1, 2]"),
                HasSubstr("must have 0 between them, which is where the joint starts, got [1, 2] m"));
    EXPECT_THAT(limits("slider", "[-2, -1]"), HasSubstr("must have 0 between them"));
    EXPECT_THAT(limits("hinge", "[\"-180 deg\", 1]"), HasSubstr("of a hinge must lie within -175 to 175 degrees"));
    EXPECT_THAT(limits("hinge", "[-1, \"180 deg\"]"), HasSubstr("of a hinge must lie within -175 to 175 degrees"));
    EXPECT_THAT(limits("slider", "[-1, 2e6]"), HasSubstr("must lie within 1e6 m"));
    EXPECT_THAT(limits("hinge", "[\"-1 mm\", 1]"), HasSubstr("limits: expected a value in rad, got \"-1 mm\""));
    EXPECT_THAT(limits("slider", "[\"-1 deg\", 1]"), HasSubstr("limits: expected a value in m, got \"-1 deg\""));
    EXPECT_THAT(limits("hinge", "[nan, 1]"), HasSubstr("limits must be finite, got nan"));
    EXPECT_THAT(limits("hinge", "[1]"), HasSubstr("limits wants 2 numbers, got 1"));
    EXPECT_THAT(joint_fault("type = \"ball\"\nanchor = [0, 0, 0]\n" + kBetween + "limits = [-1, 1]\n"),
                HasSubstr("m.toml:24:1: joint \"pin\": a ball joint has no limits; it belongs to a hinge or slider"));
}

TEST(ReadJoint, TypesAndKeysAreNamed) {
    EXPECT_EQ(joint_fault("type = \"hinges\"\n" + kBetween + kAxis),
              "m.toml:21:8: joint \"pin\": type must be one of: ball, hinge, slider, universal, fixed; got \"hinges\"; did "
              "you mean "
              "\"hinge\"?");
    EXPECT_THAT(joint_fault(kBetween), HasSubstr("m.toml:19:1: joint \"pin\": missing key \"type\""));
    EXPECT_THAT(joint_fault("type = 3\n" + kBetween), HasSubstr("type must be a text, got a number"));
    EXPECT_THAT(joint_fault("type = \"fixed\"\n" + kBetween + "[[joint]]\ntype = \"fixed\"\nx = 1\n" + kBetween),
                HasSubstr("m.toml:25:1: joint number 2: unknown key \"x\" in [[joint]] number 2"));
    EXPECT_THAT(errors_of("joint = 3\n" + model_with("")), HasSubstr("joint must be a list of tables; write [[joint]]"));
}

TEST(ReadJoint, NamesAreUniqueAlsoAmongBodiesAndElements) {
    const auto named = [](const std::string& name) {
        return errors_of(model_with(kDisc +
                                    "[[element]]\nname = \"bolt\"\ntype = \"spring_damper\"\nfrom = \"plate\"\nto = "
                                    "\"ground\"\n[[joint]]\nname = \"pin\"\ntype = \"fixed\"\n" +
                                    kBetween + "[[joint]]\nname = \"" + name + "\"\ntype = \"fixed\"\n" + kBetween));
    };
    EXPECT_THAT(named("pin"), HasSubstr("m.toml:29:8: joint name \"pin\" on line 29 is taken already, on line 25"));
    EXPECT_THAT(named("disc"), HasSubstr("m.toml:29:8: joint \"disc\": the body on line 13 has the same name"));
    EXPECT_THAT(named("bolt"), HasSubstr("m.toml:29:8: joint \"bolt\": the element on line 20 has the same name"));
    EXPECT_THAT(named("a.b"), HasSubstr("joint name \"a.b\" holds a dot"));
    for (const char* name : {"energy", "time", "ground"}) EXPECT_THAT(named(name), HasSubstr("is reserved")) << name;
    EXPECT_THAT(errors_of(model_with(kDisc + "[[joint]]\ntype = \"fixed\"\n" + kBetween)),
                HasSubstr("m.toml:19:1: joint number 1: missing key \"name\""));
}

TEST(ReadJoint, SuspiciousJointsAreWarnedOf) {
    const std::string hinge = "type = \"hinge\"\nanchor = [1, 2, 3]\n" + kAxis;
    const std::string twice = hinge + kBetween + "[[joint]]\nname = \"twin\"\n" + hinge;
    EXPECT_THAT(
        parse(with_joint(twice + "between = [\"disc\", \"plate\"]\n")).warnings,
        Contains(WarningIs("duplicate-joint",
                           "m.toml:25:1: joint \"twin\": identical to joint \"pin\": same bodies, type, anchor and axes")));
    EXPECT_THAT(parse(with_joint(twice + "between = [\"disc\", \"ground\"]\n")).warnings,
                Not(Contains(WarningIs(testing::_, HasSubstr("identical")))));
}

TEST(ReadJoint, MassesThatODEsJointsCannotHoldAreToldOf) {
    const auto model = [](const std::string& mass, const std::string& ends) {
        return model_with("[[body]]\nname = \"dust\"\nmass = " + mass +
                          "\ninertia = [1e-6, 1e-6, 1e-6]\n[[joint]]\nname = \"pin\"\ntype = " +
                          "\"fixed\"\nbetween = [\"plate\", \"" + ends + "\"]\n");
    };
    EXPECT_TRUE(parse(model("2.1e-6", "dust")).warnings.empty());
    EXPECT_THAT(
        parse(model("1.9e-6", "dust")).warnings,
        Contains(WarningIs(
            "mass-ratio",
            "m.toml:19:11: joint \"pin\": the masses of \"plate\" (2 kg) and \"dust\" (1.9e-06 kg) differ by a factor of "
            "1.05e+06; digits are lost: see that the energy balance closes")));
    EXPECT_THAT(
        errors_of(model("1.9e-12", "dust")),
        HasSubstr("m.toml:19:11: joint \"pin\": the masses of \"plate\" (2 kg) and \"dust\" (1.9e-12 kg) differ by a factor "
                  "of 1.05e+12; at most 1e+12 is allowed, as the joint would give way"));
    EXPECT_THAT(parse(model("1.9e-12", "ground")).warnings, Not(Contains(WarningIs(testing::_, HasSubstr("masses")))));
}

TEST(ReadJoint, AJointTouchesItsBodies) {
    EXPECT_TRUE(parse(with_joint("type = \"fixed\"\n" + kBetween)).warnings.empty());
    EXPECT_THAT(parse(with_joint("type = \"fixed\"\nbetween = [\"ground\", \"disc\"]\n")).warnings,
                testing::ElementsAre(WarningIs("free-body", HasSubstr("body \"plate\": free body"))));
}

}  // namespace
}  // namespace dttmm::host
