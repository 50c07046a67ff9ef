// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_values.h"

#include <cmath>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsNan;

constexpr double kRigid = std::numeric_limits<double>::infinity();

/// The beam "rod" of the test catalogue; its parameters begin on line 17, and E comes last.
std::string with_beam(const std::string& parameters, const std::string& material = "material.E = \"2 GPa\"\n") {
    return model_with("[[element]]\nname = \"rod\"\ntype = \"beam\"\nfrom = \"ground\"\nto = \"plate\"\n" + parameters +
                      material);
}
std::vector<double> values(const std::string& parameters) { return parse(with_beam(parameters)).elements.at(0).values; }
std::string value_fault(const std::string& parameters) { return errors_of(with_beam(parameters)); }

TEST(ReadValues, WhatIsLeftOutIsTheDefaultOrNotANumber) {
    EXPECT_THAT(values(""), ElementsAre(1, 10, IsNan(), IsNan(), IsNan(), kRigid, 2e9));
}

TEST(ReadValues, NestedTablesWordsAndWholeNumbersAreRead) {
    EXPECT_THAT(values("theory = \"timoshenko\"\nsegments = 24\nsection = { tube = [\"50 mm\", 0.03], mass = \"3 t\" }\n"
                       "stiffness = { y = \"free\" }\n"),
                ElementsAre(2, 24, 0.05, 0.03, 3000, 0, 2e9));
    EXPECT_THAT(values("segments = \"=2*3\"\nsection.mass = 7\nstiffness.y = 5e8\n"),
                ElementsAre(1, 6, IsNan(), IsNan(), 7, 5e8, 2e9));
    EXPECT_EQ(values("stiffness.y = \"=4+4\"\n")[5], 8);
    EXPECT_EQ(values("stiffness.y = \"5 kN/mm\"\n")[5], 5e6);
    EXPECT_EQ(values("stiffness.y = \"rigid\"\n")[5], kRigid);
}

TEST(ReadValues, KeysOfNestedTablesAreChecked) {
    EXPECT_EQ(value_fault("section = { tub = [1, 2] }\n"),
              "m.toml:17:13: element \"rod\": section: unknown key \"tub\"; did you mean \"tube\"?");
    EXPECT_EQ(value_fault("section = 3\n"),
              "m.toml:17:11: element \"rod\": section: expected a table such as { tube = ... }, got a number");
    EXPECT_EQ(value_fault("section = { tube = 3 }\n"),
              "m.toml:17:20: element \"rod\": section: tube wants 2 numbers, got a number");
    EXPECT_EQ(value_fault("section = { mass = -1 }\n"),
              "m.toml:17:20: element \"rod\": section: mass must be ≥ 0 kg, got -1");
    EXPECT_EQ(value_fault("sections = { mass = 1 }\n"),
              "m.toml:17:1: element \"rod\": unknown key \"sections\" in [[element]] number "
              "1; did you mean \"section\"?");
    EXPECT_EQ(errors_of(with_beam("", "")), "m.toml:12:1: element \"rod\": missing key \"material.E\"");
    EXPECT_EQ(errors_of(with_beam("", "material = {}\n")), "m.toml:17:12: element \"rod\": material: missing key \"E\"");
}

TEST(ReadValues, FaultyWordsAreToldWithTheWordsThereAre) {
    EXPECT_EQ(
        value_fault("theory = \"timoschenko\"\n"),
        "m.toml:17:10: element \"rod\": theory must be one of: euler-bernoulli, timoshenko; got \"timoschenko\"; did you "
        "mean \"timoshenko\"?");
    EXPECT_EQ(value_fault("theory = 2\n"),
              "m.toml:17:10: element \"rod\": theory must be one of: euler-bernoulli, timoshenko; got a "
              "number");
    EXPECT_EQ(value_fault("theory = \"=1\"\n"),
              "m.toml:17:10: element \"rod\": theory must be one of: euler-bernoulli, timoshenko; "
              "got \"=1\"");
    EXPECT_EQ(
        value_fault("stiffness = { y = \"fre\" }\n"),
        "m.toml:17:19: element \"rod\": stiffness: y must be a number in N/m or one of: free, rigid; got \"fre\"; did you "
        "mean \"free\"?");
    EXPECT_THAT(value_fault("stiffness.y = \"5 kg\"\n"), HasSubstr("expected a value in N/m, got \"5 kg\""));
    EXPECT_THAT(value_fault("stiffness.y = inf\n"), HasSubstr("y must be finite, got inf")) << "that is what words are for";
}

TEST(ReadValues, WholeNumbersAreWhole) {
    EXPECT_EQ(value_fault("segments = 2.5\n"), "m.toml:17:12: element \"rod\": segments must be a whole number, got 2.5");
    EXPECT_THAT(value_fault("segments = 0\n"), HasSubstr("segments must be ≥ 1, got 0"));
}

// What a parameter is not given does not make two elements differ, nor an element that is rigid one that carries nothing.
TEST(ReadValues, ElementsAlikeAreToldApartByWhatIsGiven) {
    const auto twins = [](const std::string& second) {
        const std::string start = "[[element]]\nname = \"twin\"\ntype = \"beam\"\nfrom = \"ground\"\nto = \"plate\"\n";
        return parse(with_beam("") + start + second + "material.E = 2e9\n").warnings;
    };
    EXPECT_THAT(twins(""), ElementsAre(WarningIs("duplicate-element", HasSubstr("identical to element \"rod\""))));
    EXPECT_THAT(twins("section.mass = 1\n"), ElementsAre());
}

}  // namespace
}  // namespace dttmm::host
