// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_element.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A second body with two markers on lines 12 to 17, 2000 m from the first; then the header of an element on line 18.
const std::string kSecondBody =
    "[[body]]\nname = \"disc\"\ndensity = 7\nsphere = 1\nposition = [2000, 0, 0]\nmarkers = { b = [0, 0, 0], c = [0, 0, 1] "
    "}\n";

std::string with_element(const std::string& text) {
    return model_with(kSecondBody + "[[element]]\nname = \"bolt3\"\n" + text);
}
const std::string kEnds = "type = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate.a\"\n";  // lines 20 to 22

Element element(const std::string& text) { return parse(with_element(text)).elements.at(0); }
std::string element_fault(const std::string& text) { return errors_of(with_element(text)); }

TEST(ReadElement, ValuesStandInTheDeclaredOrder) {
    const Element e =
        element(kEnds + "damping = [1, \"2 N*s/mm\", 3]\nstiffness = \"500 N/mm\"\nrotational_damping = [4, 5, 6]\n");
    EXPECT_EQ(e.name, "bolt3");
    EXPECT_EQ(e.type, 0);
    EXPECT_THAT(e.values, ElementsAre(5e5, 5e5, 5e5, 1, 2000, 3, 0, 0, 0, 4, 5, 6));
    EXPECT_EQ(e.place, "m.toml:18:1");
}

TEST(ReadElement, EndsAreResolved) {
    const Element e = element("type = \"strut\"\nlengths = [1, 2]\nfrom = \"disc.c\"\nto = \"plate\"\n");
    EXPECT_EQ(e.type, 1);
    EXPECT_EQ(e.ends[0].body, 1);
    EXPECT_EQ(e.ends[0].marker, 1);
    EXPECT_EQ(e.ends[1].body, 0);
    EXPECT_EQ(e.ends[1].marker, -1);
    EXPECT_THAT(e.values, ElementsAre(1, 2, 0.25));
    EXPECT_EQ(element(kEnds).ends[0].body, -1);
}

TEST(ReadElement, ValuesMustSatisfyTheDeclaration) {
    EXPECT_EQ(element_fault(kEnds + "stiffness = \"-500 N/mm\"\n"),
              "m.toml:23:13: element \"bolt3\": stiffness must be ≥ 0 N/m, got -500 N/mm");
    EXPECT_THAT(element_fault(kEnds + "damping = [0, -1, 0]\n"),
                HasSubstr("m.toml:23:15: element \"bolt3\": damping must be ≥ 0 N*s/m, got -1"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = [1, 2]\n"), HasSubstr("stiffness wants 3 numbers, got 2"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = nan\n"), HasSubstr("stiffness must be finite, got nan"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = inf\n"), HasSubstr("stiffness must be finite, got inf"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = \"500 N/mM\"\n"),
                HasSubstr("unknown unit \"N/mM\" in \"500 N/mM\"; accepted here: N/m, N/mm, kN/m, kN/mm, MN/m"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = \"500 kg\"\n"), HasSubstr("expected a value in N/m, got \"500 kg\""));
    EXPECT_THAT(element_fault(kEnds + "stiffness = \"0,5 N/m\"\n"), HasSubstr("the decimal sign is a point"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = \"=1/0\"\n"),
                HasSubstr("stiffness: the value of \"=1/0\" is not finite"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = \"=0-3\"\n"), HasSubstr("must be ≥ 0 N/m, got \"=0-3\" = -3 N/m"));
    EXPECT_THAT(element_fault(kEnds + "stiffness = { x = 1 }\n"), HasSubstr("expected a number in N/m, got a table"));
    EXPECT_THAT(element_fault(kEnds + "stifness = 1\n"),
                HasSubstr("m.toml:23:1: element \"bolt3\": unknown key \"stifness\" in "
                          "[[element]] number 1; did you mean \"stiffness\"?"));
    const std::string strut = "type = \"strut\"\nfrom = \"ground\"\nto = \"plate\"\n";
    EXPECT_THAT(element_fault(strut), HasSubstr("m.toml:18:1: element \"bolt3\": missing key \"lengths\""));
    EXPECT_THAT(element_fault(strut + "lengths = 3\n"),
                HasSubstr("lengths wants 2 numbers, got a number"));  // does not spread
    EXPECT_THAT(element_fault(strut + "lengths = [1, 8]\nratio = 0.6\n"), HasSubstr("lengths must be ≤ 7 m, got 8"));
    EXPECT_THAT(element_fault(strut + "lengths = [1, 0.4]\nratio = 0.6\n"), HasSubstr("ratio must be ≤ 0.5, got 0.6"));
    EXPECT_THAT(element_fault(strut + "lengths = [1, 0.4]\n"), HasSubstr("lengths must be ≥ 0.5 m, got 0.4"));
}

TEST(ReadElement, UnknownTypesNameThePluginsAndWhatTheyDeclare) {
    const std::string text = element_fault("type = \"spring_dampr\"\nfrom = \"ground\"\nto = \"plate\"\nwhatever = 3\n");
    EXPECT_EQ(text,
              "m.toml:20:8: element \"bolt3\": no loaded plugin declares element type \"spring_dampr\"; declared: "
              "spring_damper (plugin \"dttmm\"), "
              "strut (plugin \"extra\"), beam (plugin \"extra\"), lump (plugin \"extra\"); did you mean \"spring_damper\"?");
    EXPECT_THAT(element_fault("type = \"/tmp/x.so\"\nfrom = \"ground\"\nto = \"plate\"\n"),
                HasSubstr("no loaded plugin declares element type \"/tmp/x.so\""));
    EXPECT_THAT(element_fault("from = \"ground\"\nto = \"plate\"\n"), HasSubstr("missing key \"type\""));
    EXPECT_THAT(element_fault("type = 3\nfrom = \"ground\"\nto = \"plate\"\n"),
                HasSubstr("type must be a text, got a number"));
    EXPECT_THAT(error_of([&] { parse_model(with_element(kEnds), "m.toml", ElementCatalogue{}); }),
                HasSubstr("declared: none, as no plugin is loaded"));
}

TEST(ReadElement, EndsMustBeTwoPlaces) {
    const auto with_ends = [](const std::string& from, const std::string& to) {
        return element_fault("type = \"spring_damper\"\nfrom = \"" + from + "\"\nto = \"" + to + "\"\n");
    };
    EXPECT_THAT(with_ends("ground", "ground"), HasSubstr("m.toml:22:6: element \"bolt3\": both ends are on the ground"));
    EXPECT_THAT(with_ends("plate", "plate.a"), HasSubstr("both ends are on the same body"));
    EXPECT_THAT(with_ends("ground", "plat.a"),
                HasSubstr("m.toml:22:6: element \"bolt3\": to: there is no body \"plat\"; did you mean \"plate\"?"));
    EXPECT_THAT(with_ends("disc.d", "plate"),
                HasSubstr("m.toml:21:8: element \"bolt3\": from: body \"disc\" has no marker \"d\"; known here: b, c"));
    EXPECT_THAT(element_fault("type = \"spring_damper\"\nfrom = \"ground\"\n"), HasSubstr("missing key \"to\""));
    EXPECT_THAT(element_fault("type = \"spring_damper\"\nfrom = \"ground\"\nto = 3\n"),
                HasSubstr("to must be a text, got a number"));
}

/// Two nodes on lines 13 and 14, an element called "bolt3" from line 15 with its type on line 17, and a lump on both nodes.
std::string with_nodes(const std::string& element) {
    return model_with("[nodes]\nhub = [0, 0, 0]\ntip = [0, 0, 0]\n[[element]]\nname = \"bolt3\"\n" + element +
                      "[[element]]\nname = \"masses\"\ntype = \"lump\"\nmass = 2\nat = [\"tip\", \"hub\"]\n");
}

TEST(ReadElement, EndsMayBeNodes) {
    const auto ends = [](const std::string& text) { return parse(with_nodes(text)).elements.at(0).ends; };
    const Attachment hub{-1, -1, 0}, tip{-1, -1, 1}, ground{}, plate{0, -1, -1};
    EXPECT_THAT(ends("type = \"spring_damper\"\nfrom = \"hub\"\nto = \"tip\"\n"), ElementsAre(hub, tip));
    EXPECT_THAT(ends("type = \"spring_damper\"\nfrom = \"ground\"\nto = \"tip\"\n"), ElementsAre(ground, tip));
    EXPECT_THAT(ends("type = \"spring_damper\"\nfrom = \"hub\"\nto = \"plate\"\n"), ElementsAre(hub, plate));
    EXPECT_THAT(ends("type = \"lump\"\nmass = 1\nat = \"tip\"\n"), ElementsAre(tip));
    EXPECT_THAT(ends("type = \"lump\"\nmass = 1\nat = [\"tip\", \"hub\"]\n"), ElementsAre(tip, hub));
}

TEST(ReadElement, FaultyEndsAtNodesAreTold) {
    const auto between = [](const std::string& from, const std::string& to) {
        return errors_of(with_nodes("type = \"spring_damper\"\nfrom = \"" + from + "\"\nto = \"" + to + "\"\n"));
    };
    const auto at = [](const std::string& place) {
        return errors_of(with_nodes("type = \"lump\"\nmass = 1\nat = " + place + "\n"));
    };
    EXPECT_EQ(between("hub", "hub"), "m.toml:19:6: element \"bolt3\": both ends are on the same node");
    EXPECT_EQ(between("ground", "hub.a"), "m.toml:19:6: element \"bolt3\": to: \"hub\" is a node, which has no markers");
    EXPECT_EQ(between("ground", "tipp"),
              "m.toml:19:6: element \"bolt3\": to: there is no body or node \"tipp\"; did you mean \"tip\"?");
    EXPECT_EQ(at("\"ground\""), "m.toml:19:6: element \"bolt3\": at: the ground does not move; name a node");
    EXPECT_EQ(at("[\"hub\", \"plate.a\"]"),
              "m.toml:19:14: element \"bolt3\": at: \"plate.a\" is a body; give the mass to the body");
    EXPECT_EQ(at("[\"hub\", \"tip\", \"hub\"]"), "m.toml:19:21: element \"bolt3\": at: \"hub\" is named twice");
    EXPECT_EQ(at("[]"), "m.toml:19:6: element \"bolt3\": at is empty; name a node");
    EXPECT_EQ(at("3"), "m.toml:19:6: element \"bolt3\": at must be a text, got a number");
    EXPECT_THAT(errors_of(with_nodes("type = \"lump\"\nmass = 1\nfrom = \"hub\"\nto = \"tip\"\n")),
                testing::AllOf(HasSubstr("unknown key \"from\""), HasSubstr("missing key \"at\"")));
    EXPECT_THAT(errors_of(with_nodes("type = \"spring_damper\"\nat = \"hub\"\n")),
                testing::AllOf(HasSubstr("unknown key \"at\""), HasSubstr("missing key \"from\"")));
}

TEST(ReadElement, NamesAreUniqueAlsoAmongBodies) {
    const auto two = [](const std::string& name) {
        return with_element(kEnds + "[[element]]\nname = \"" + name + "\"\n" + kEnds);
    };
    EXPECT_THAT(errors_of(two("bolt3")),
                HasSubstr("m.toml:24:8: element name \"bolt3\" on line 24 is taken already, on line 19"));
    EXPECT_THAT(errors_of(two("plate")), HasSubstr("m.toml:24:8: element \"plate\": the body on line 8 has the same name"));
    for (const char* name : {"energy", "time"}) EXPECT_THAT(errors_of(two(name)), HasSubstr("is reserved")) << name;
    EXPECT_THAT(errors_of(model_with("[[element]]\n" + kEnds)),
                HasSubstr("m.toml:12:1: element number 1: missing key \"name\""));
}

TEST(ReadElement, TheThirdElementIsNamedWithItsNumber) {
    const std::string text =
        with_element(kEnds + "[[element]]\nname = \"b\"\n" + kEnds + "[[element]]\nname = \"c\"\n" + kEnds + "x = 1\n");
    EXPECT_THAT(errors_of(text), HasSubstr("element \"c\": unknown key \"x\" in [[element]] number 3"));
}

TEST(ReadElement, SuspiciousElementsAreWarnedOf) {
    EXPECT_THAT(parse(with_element(kEnds + "stiffness = 0\n")).warnings,
                Contains(WarningIs("free-element",
                                   "m.toml:18:1: element \"bolt3\": free: every parameter is zero, it carries nothing")));
    EXPECT_THAT(parse(with_element(kEnds + "stiffness = 1\n")).warnings,
                Not(Contains(WarningIs(testing::_, HasSubstr("bolt3")))));
    const std::string twice = kEnds + "stiffness = 1\n[[element]]\nname = \"twin\"\n" + kEnds + "stiffness = [1, 1, 1]\n";
    EXPECT_THAT(parse(with_element(twice)).warnings,
                Contains(WarningIs("duplicate-element",
                                   HasSubstr("m.toml:24:1: element \"twin\": identical to element \"bolt3\""))));
    EXPECT_THAT(parse(with_element("type = \"spring_damper\"\nfrom = \"plate\"\nto = \"disc\"\nstiffness = 1\n")).warnings,
                Contains(WarningIs("ends-apart",
                                   HasSubstr("m.toml:22:6: element \"bolt3\": the ends are 2000 m apart at the start"))));
}

}  // namespace
}  // namespace dttmm::host
