// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_load.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

std::string with_load(const std::string& text) { return model_with("[[load]]\n" + text); }
std::string load_fault(const std::string& text) { return errors_of(with_load(text)); }

TEST(ReadLoad, ActsOnABodyOrAMarker) {
    const Load load = parse(with_load("on = \"plate\"\ndirection = [3, 0, 4]\nforce = 7\n")).loads.at(0);
    EXPECT_EQ(load.on.body, 0);
    EXPECT_EQ(load.on.marker, -1);
    EXPECT_LT((load.direction - Eigen::Vector3d(0.6, 0, 0.8)).norm(), 1e-15);
    EXPECT_FALSE(load.is_moment);
    EXPECT_EQ(load.signal.value(0), 7);
    EXPECT_EQ(parse(with_load("on = \"plate.a\"\ndirection = [1e-200, 0, 0]\nmoment = 7\n")).loads.at(0).on.marker, 0);
}

// [0, 0, 2] is one newton as [0, 0, 1] is; of [3, 0, 4] nobody expects five.
TEST(ReadLoad, ALengthAlongOneAxisIsToldOf) {
    const auto warnings = [](const std::string& direction) {
        return parse(with_load("on = \"plate\"\ndirection = " + direction + "\nforce = 7\n")).warnings;
    };
    EXPECT_THAT(warnings("[0, 0, 2]"), testing::ElementsAre(WarningIs(
                                           "direction-length", HasSubstr("the length of direction, 2, does not count"))));
    for (const char* direction : {"[0, 0, 1]", "[0, -1, 0]", "[3, 0, 4]", "[1, 1, 0]"})
        EXPECT_THAT(warnings(direction), testing::IsEmpty()) << direction;
}

TEST(ReadLoad, ALoadMayActOnANode) {
    const Load load =
        parse(model_with("[nodes]\ntip = [0, 0, 1]\n[[load]]\non = \"tip\"\ndirection = [0, 0, 1]\nmoment = 7\n"
                         "[[element]]\nname = \"mass\"\ntype = \"lump\"\nat = \"tip\"\nmass = 1\n"))
            .loads.at(0);
    EXPECT_EQ(load.on, (Attachment{-1, -1, 0}));
    EXPECT_TRUE(load.is_moment);
}

// A clamp has no reaction of its own loads: the ground would take them unseen. A node that is fixed in part has.
TEST(ReadLoad, ALoadOnAClampIsRefusedAndOneIntoASupportWarnedOf) {
    const auto held = [](const std::string& fixed, const std::string& load) {
        return model_with("[nodes]\ntip = { position = [0, 0, 1], fixed = " + fixed + " }\n[[load]]\non = \"tip\"\n" + load +
                          "\n[[element]]\nname = \"mass\"\ntype = \"lump\"\nat = \"tip\"\nmass = 1\n");
    };
    const std::string all = R"(["x", "y", "z", "rx", "ry", "rz"])", some = R"(["x", "z", "ry"])";
    EXPECT_THAT(errors_of(held(all, "direction = [1, 2, 3]\nforce = 7")),
                HasSubstr("m.toml:15:6: load number 1: node \"tip\" is fixed in all directions"));
    const auto warnings = [&](const std::string& load) {
        auto all_warnings = parse(held(some, load)).warnings;
        std::erase_if(all_warnings, [](const auto& warning) { return warning.code != "load-on-support"; });
        return all_warnings;
    };
    EXPECT_THAT(warnings("direction = [1, 0, 3]\nforce = 7"),
                testing::ElementsAre(WarningIs("load-on-support", HasSubstr("is fixed in the direction of the force"))));
    EXPECT_THAT(warnings("direction = [0, 1, 0]\nmoment = 7"),
                testing::ElementsAre(WarningIs("load-on-support", HasSubstr("is fixed in the direction of the moment"))));
    EXPECT_THAT(warnings("direction = [1, 1e-3, 0]\nforce = 7"), testing::IsEmpty());
    EXPECT_THAT(warnings("direction = [1, 0, 0]\nmoment = 7"), testing::IsEmpty());
}

TEST(ReadLoad, FaultsNameTheLoadByItsNumber) {
    EXPECT_THAT(load_fault("on = \"ground\"\ndirection = [0, 0, 1]\nforce = 7\n"),
                HasSubstr("m.toml:13:6: load number 1: a load on the ground moves nothing"));
    EXPECT_THAT(load_fault("on = \"plte\"\ndirection = [0, 0, 1]\nforce = 7\n"),
                HasSubstr("on: there is no body \"plte\"; did you mean \"plate\"?"));
    EXPECT_THAT(load_fault("on = \"plate.b\"\ndirection = [0, 0, 1]\nforce = 7\n"),
                HasSubstr("on: body \"plate\" has no marker \"b\""));
    EXPECT_THAT(load_fault("on = \"plate\"\ndirection = [0, 0, 0]\nforce = 7\n"),
                HasSubstr("m.toml:14:13: load number 1: direction must not be zero"));
    EXPECT_THAT(load_fault("on = \"plate\"\ndirection = [0, 0, 1]\n"), HasSubstr("missing key: one of force, moment"));
    EXPECT_THAT(load_fault("on = \"plate\"\ndirection = [0, 0, 1]\nforce = 7\nmoment = 7\n"),
                HasSubstr("\"force\" and \"moment\" exclude each other"));
    EXPECT_THAT(load_fault("on = \"plate\"\ndirection = [0, 0, 1]\nfroce = 7\n"),
                HasSubstr("unknown key \"froce\" in [[load]] number 1; did you mean \"force\"?"));
    EXPECT_THAT(load_fault("direction = [0, 0, 1]\nforce = 7\n"), HasSubstr("missing key \"on\""));
}

// ---- Forces per length --------------------------------------------------------------------------------------------------

/// Of the other types and a line without parameters.
const ElementCatalogue& catalogue_with_line() {
    static const dttmm_element_type line = {"line", DTTMM_ENDS_LINE, 0, nullptr, "a line"};
    static const ElementCatalogue catalogue = [] {
        ElementCatalogue result = test_catalogue();
        result.add("dttmm", line);
        return result;
    }();
    return catalogue;
}

/// A line "girder", a spring "tie" and an element with a fault; the load begins at line 28.
std::string along(const std::string& load) {
    return model_with(
        "[nodes]\ntip = [0, 0, 1]\n[[element]]\nname = \"tie\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = "
        "\"plate\"\nstiffness = 3\n[[element]]\nname = \"girder\"\ntype = \"line\"\nfrom = \"plate\"\nto = "
        "\"tip\"\n\n\n[[load]]\n" +
        load);
}
Model parse_along(const std::string& load) { return parse_model(along(load), "m.toml", catalogue_with_line()); }
std::string along_fault(const std::string& load) {
    return error_of([&] { parse_along(load); });
}

TEST(ReadLoad, AForcePerLengthActsAlongAnElement) {
    const Load even =
        parse_along("element = \"girder\"\ndirection = [0, 3, 4]\nforce_per_length = \"2 N/mm\"\n").loads.at(0);
    EXPECT_EQ(even.element, 1);
    EXPECT_FALSE(even.turns);
    EXPECT_LT((even.direction - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
    EXPECT_EQ(even.signal.value(0), 2000);
    EXPECT_EQ(even.at_to().value(0), 2000);
    EXPECT_EQ(even.on, Attachment{});
    const Load linear = parse_along(
                            "element = \"girder\"\naxes = \"element\"\ndirection = [0, 0, -1]\nforce_per_length = "
                            "[\"=7*t\", { type = \"step\", to = \"3 kN/m\", end = 1 }]\n")
                            .loads.at(0);
    EXPECT_TRUE(linear.turns);
    EXPECT_EQ(linear.signal.value(2), 14);
    EXPECT_EQ(linear.at_to().value(2), 3000);
    EXPECT_FALSE(parse_along("element = \"girder\"\naxes = \"world\"\ndirection = [0, 0, -1]\nforce_per_length = 1\n")
                     .loads.at(0)
                     .turns);
}

TEST(ReadLoad, FaultsOfAForcePerLengthNameThePlaceTheRuleAndTheCure) {
    const std::string value = "direction = [0, 0, 1]\nforce_per_length = 7\n";
    EXPECT_THAT(along_fault("element = \"tie\"\n" + value),
                HasSubstr("m.toml:28:11: load number 1: element: line load on a spring_damper: \"tie\" is no line with "
                          "segments; a force_per_length acts on a line"));
    EXPECT_THAT(along_fault("element = \"grider\"\n" + value),
                HasSubstr("m.toml:28:11: load number 1: element: there is no element \"grider\"; did you mean \"girder\"?"));
    EXPECT_THAT(along_fault("element = \"plate\"\n" + value),
                HasSubstr("\"plate\" is no element; a force or moment on it has the key `on`"));
    EXPECT_THAT(along_fault("element = [\"girder\"]\n" + value), HasSubstr("element must be a text, got a list"));
    EXPECT_THAT(along_fault("element = \"girder\"\ndirection = [0, 0, 1]\nforce_per_length = \"7 kN\"\n"),
                HasSubstr("m.toml:30:20: load number 1: force_per_length: expected a value in N/m, got \"7 kN\""));
    EXPECT_THAT(along_fault("element = \"girder\"\ndirection = [0, 0, 1]\nforce_per_length = [1, \"7 kN\"]\n"),
                HasSubstr("m.toml:30:24: load number 1: force_per_length at to: expected a value in N/m"));
    EXPECT_THAT(
        along_fault("element = \"girder\"\ndirection = [0, 0, 1]\nforce_per_length = [0, 0, \"-2 kN/m\"]\n"),
        HasSubstr("m.toml:30:20: load number 1: force_per_length has one value, or two, [at from, at to], got 3; its "
                  "direction stands in `direction`"));
    EXPECT_THAT(along_fault("element = \"girder\"\ndirection = [0, 0, 1]\nforce_per_length = []\n"),
                HasSubstr("has one value, or two, [at from, at to], got 0"));
    EXPECT_THAT(along_fault("element = \"girder\"\ndirection = [0, 0, 1]\nforce = 7\n"),
                HasSubstr("m.toml:30:1: load number 1: a force acts at a point: name a body, a marker or a node with `on`"));
    EXPECT_THAT(along_fault("on = \"plate\"\n" + value),
                HasSubstr("m.toml:30:1: load number 1: a force_per_length acts along an element: name a line with "
                          "`element` in place of `on`"));
    EXPECT_THAT(along_fault("on = \"plate\"\naxes = \"element\"\ndirection = [0, 0, 1]\nforce = 7\n"),
                HasSubstr("m.toml:29:1: load number 1: axes = \"element\" is for a force_per_length"));
    EXPECT_THAT(along_fault("element = \"girder\"\naxes = \"body\"\n" + value),
                HasSubstr("axes = \"body\" is for a force or moment on a body"));
    EXPECT_THAT(along_fault("element = \"girder\"\non = \"plate\"\n" + value),
                HasSubstr("\"element\" and \"on\" exclude each other"));
    EXPECT_THAT(along_fault(value), HasSubstr("missing key \"element\""));
    EXPECT_THAT(along_fault("element = \"girder\"\ndirection = [0, 0, 1]\n"),
                HasSubstr("missing key: one of force, moment, force_per_length"));
    EXPECT_THAT(along_fault("element = \"girder\"\nforce_per_length = 7\n"), HasSubstr("missing key \"direction\""));
}

// An element with a fault of its own is none that there is not.
TEST(ReadLoad, OnAnElementWithAFaultNothingElseIsSaid) {
    std::string text = along("element = \"tie\"\ndirection = [0, 0, 1]\nforce_per_length = 7\n");
    text.replace(text.find("stiffness = 3"), 13, "stiffness = -3");
    const std::string errors = error_of([&] { parse_model(text, "m.toml", catalogue_with_line()); });
    EXPECT_THAT(errors, HasSubstr("stiffness must be"));
    EXPECT_THAT(errors, testing::Not(HasSubstr("no element")));
}

}  // namespace
}  // namespace dttmm::host
