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

// A load along a direction in which its node is held would be taken by the ground unseen.
TEST(ReadLoad, ALoadOnWhatIsFixedIsRefused) {
    const auto held = [](const std::string& fixed, const std::string& load) {
        return model_with("[nodes]\ntip = { position = [0, 0, 1], fixed = " + fixed + " }\n[[load]]\non = \"tip\"\n" + load +
                          "\n[[element]]\nname = \"mass\"\ntype = \"lump\"\nat = \"tip\"\nmass = 1\n");
    };
    const std::string all = R"(["x", "y", "z", "rx", "ry", "rz"])", some = R"(["x", "z", "ry"])";
    EXPECT_THAT(errors_of(held(all, "direction = [1, 2, 3]\nforce = 7")),
                HasSubstr("m.toml:15:6: load number 1: node \"tip\" is fixed in the direction of the force"));
    EXPECT_THAT(errors_of(held(some, "direction = [1, 0, 3]\nforce = 7")),
                HasSubstr("is fixed in the direction of the force"));
    EXPECT_THAT(errors_of(held(some, "direction = [0, 2, 0]\nmoment = 7")),
                HasSubstr("is fixed in the direction of the moment"));
    EXPECT_EQ(parse(held(some, "direction = [1, 1e-3, 0]\nforce = 7")).loads.size(), 1u);
    EXPECT_EQ(parse(held(some, "direction = [1, 0, 0]\nmoment = 7")).loads.size(), 1u);
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

}  // namespace
}  // namespace dttmm::host
