// SPDX-License-Identifier: BSD-3-Clause
#include "model/cut_lines.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// The catalogue of the tests and a line "pole" with segments, a size and a required modulus.
const ElementCatalogue& line_catalogue() {
    static const dttmm_parameter parameters[] = {
        {"segments", "1", 1, DTTMM_PARAMETER_INTEGER, 10, 1, 1000, nullptr, 0, "lumps"},
        {"size", "m", 1, 0, 0.5, 0, 9, nullptr, 0, "of the section"},
        {"modulus", "Pa", 1, DTTMM_PARAMETER_REQUIRED, 0, 0, 1e15, nullptr, 0, "of the material"},
    };
    static const dttmm_element_type pole = {"pole", DTTMM_ENDS_LINE, 3, parameters, "a line"};
    static const ElementCatalogue catalogue = [] {
        ElementCatalogue result = test_catalogue();
        result.add("extra", pole);
        return result;
    }();
    return catalogue;
}

Model parse_lines(const std::string& rest) { return parse_model(model_with(rest), "m.toml", line_catalogue()); }
std::string line_fault(const std::string& rest) {
    return error_of([&] { parse_lines(rest); });
}

const std::string kRoot =
    "[nodes]\nroot = { position = [1, 2, 7], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }\n";
const std::string kPole =
    "[[element]]\nname = \"pole\"\ntype = \"pole\"\nfrom = \"root\"\nto = \"plate.a\"\nsize = 0.25\nmodulus = 3\n";
/// Lines 21 to 25.
const std::string kSections =
    "sections = [\n{ length = 1 },\n{ length = \"1500 mm\", size = 2, segments = 4 },\n{ length = \"=1.5\", modulus = 5 "
    "},\n]\n";

// Oracle: the chain written out by hand. The pole leads from z = 7 down to z = 3.
TEST(CutLines, SectionsAreAChainOfElements) {
    const Model model = parse_lines(kRoot + kPole + kSections);
    ASSERT_EQ(model.elements.size(), 3u);
    EXPECT_EQ(model.elements[0].name, "pole1");
    EXPECT_EQ(model.elements[2].name, "pole3");
    EXPECT_THAT(model.elements[0].values, ElementsAre(10, 0.25, 3));
    EXPECT_THAT(model.elements[1].values, ElementsAre(4, 2, 3));
    EXPECT_THAT(model.elements[2].values, ElementsAre(10, 0.25, 5));
    ASSERT_EQ(model.nodes.size(), 3u);
    EXPECT_EQ(model.nodes[1].name, "pole_1");
    EXPECT_EQ(model.nodes[1].position, Eigen::Vector3d(1, 2, 6));
    EXPECT_EQ(model.nodes[2].position, Eigen::Vector3d(1, 2, 4.5));
    EXPECT_EQ(model.elements[0].ends[0].node, 0);
    EXPECT_EQ(model.elements[0].ends[1].node, 1);
    EXPECT_EQ(model.elements[1].ends[0].node, 1);
    EXPECT_EQ(model.elements[2].ends[0].node, 2);
    EXPECT_EQ(model.elements[2].ends[1].marker, 0);
    EXPECT_EQ(model.elements[1].place, "m.toml:23:1");
}

// A file without nodes gets some, while its elements are at hand.
TEST(CutLines, SectionsAndProbesInAFileWithoutNodes) {
    const Model model = parse_lines("[[body]]\nname = \"other\"\nmass = 2\ninertia = [2, 3, 4]\nmarkers.b = [1, 2, 7]\n" +
                                    std::string(kPole).replace(kPole.find("root"), 4, "other.b") + kSections +
                                    "[[probe]]\nname = \"high\"\non = \"pole\"\nat = 0.1\n");
    EXPECT_EQ(model.elements.size(), 4u);
    EXPECT_EQ(model.nodes.size(), 3u);
}

// Oracle: the cuts by hand: at 1.5 m in the second section, at 0.5 m in the first, whose ten lumps are five and five.
// Of the four lumps of the second, 0.375 m long, 0.5 m and 1 m need two and three.
TEST(CutLines, ProbesCutTheirLine) {
    const Model model = parse_lines(kRoot + kPole + kSections +
                                    "[[probe]]\nname = \"low\"\non = \"pole\"\nat = 1.5\n[[probe]]\nname = \"high\"\non = "
                                    "\"pole\"\nat = \"500 mm\"\n[[load]]\nelement = \"pole\"\ndirection = [1, 0, "
                                    "0]\nforce_per_length = 8\n");
    std::vector<std::string> names;
    for (const Element& element : model.elements) names.push_back(element.name);
    EXPECT_THAT(names, ElementsAre("pole1", "pole_high", "pole2", "pole_low", "pole3"));
    EXPECT_THAT(model.elements[0].values, ElementsAre(5, 0.25, 3));
    EXPECT_THAT(model.elements[1].values, ElementsAre(5, 0.25, 3));
    EXPECT_THAT(model.elements[2].values, ElementsAre(2, 2, 3));
    EXPECT_THAT(model.elements[3].values, ElementsAre(3, 2, 3));
    ASSERT_EQ(model.nodes.size(), 5u);
    EXPECT_EQ(model.nodes[3].name, "low");
    EXPECT_EQ(model.nodes[3].position, Eigen::Vector3d(1, 2, 5.5));
    EXPECT_EQ(model.nodes[4].position, Eigen::Vector3d(1, 2, 6.5));
    EXPECT_EQ(model.elements[2].ends[1].node, 3);
    EXPECT_EQ(model.elements[3].ends[0].node, 3);
    ASSERT_EQ(model.loads.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(model.loads[static_cast<std::size_t>(i)].element, i);
}

// Oracle: the longest lump, 0.4 m, counted out in the three parts. Neither the order of the probes nor that of the ends
// matters.
TEST(CutLines, NoLumpIsLongerThanWithoutProbes) {
    const auto lumps = [](double first, double second) {
        const Model model = parse_lines(
            kRoot + kPole + "segments = 10\n" +
            fmt::format("[[probe]]\nname = \"a\"\non = \"pole\"\nat = {}\n[[probe]]\nname = \"b\"\non = \"pole\"\nat = {}\n",
                        first, second));
        std::vector<double> counts;
        for (const Element& element : model.elements) counts.push_back(element.values[0]);
        return counts;
    };
    EXPECT_THAT(lumps(0.96, 2.49), ElementsAre(3, 4, 4));
    EXPECT_THAT(lumps(2.49, 0.96), ElementsAre(3, 4, 4));
    EXPECT_THAT(lumps(4 - 2.49, 4 - 0.96), ElementsAre(4, 4, 3));
    EXPECT_THAT(lumps(0.8, 2.4), ElementsAre(2, 4, 4));
    EXPECT_THAT(line_fault(kRoot + kPole + "segments = 2.5\n[[probe]]\nname = \"a\"\non = \"pole\"\nat = 0.96\n"),
                HasSubstr("whole number, got 2.5"));
}

TEST(CutLines, AProbeOnABodyIsAMarker) {
    const Model model = parse_lines("[[probe]]\nname = \"tip\"\non = \"plate\"\nposition = [\"2 m\", 0, 1]\n");
    ASSERT_EQ(model.bodies[0].markers.size(), 2u);
    EXPECT_EQ(model.bodies[0].markers[1].name, "tip");
    EXPECT_EQ(model.bodies[0].markers[1].position, Eigen::Vector3d(2, 0, 1));
    EXPECT_TRUE(model.bodies[0].markers[1].is_probe);
    EXPECT_FALSE(model.bodies[0].markers[0].is_probe);
}

// Oracle: the place, the rule and the cure in the message.
TEST(CutLines, FaultsOfSections) {
    const auto fault = [](std::string what, const std::string& instead) {
        std::string text = kRoot + kPole + kSections;
        return line_fault(text.replace(text.find(what), what.size(), instead));
    };
    EXPECT_THAT(fault("length = 1 ", "length = 2 "), HasSubstr("m.toml:21:1: element \"pole\": the sections are 5 m long "
                                                               "together, but its ends are 4 m apart"));
    // 1e-6 of the distance of 4 m
    EXPECT_THAT(fault("length = 1 ", "length = 1.0000056 "), HasSubstr("but its ends are 4 m apart"));
    for (const char* length : {"length = 1.0000028 ", "length = 0.9999972 "}) {
        std::string text = kRoot + kPole + kSections;
        const Model model = parse_lines(text.replace(text.find("length = 1 "), 11, length));
        EXPECT_NEAR(model.nodes[2].position.z(), 4.5, 2e-6) << "scaled to the distance";
    }
    EXPECT_THAT(fault("length = 1 ", "length = 0 "),
                HasSubstr("m.toml:22:12: element \"pole\": length must be > 0 m, got 0"));
    EXPECT_THAT(fault("length = 1 ", "size = 1 "), HasSubstr("m.toml:22:1: element \"pole\": a section without length"));
    EXPECT_THAT(fault("size = 2", "from = \"plate\""),
                HasSubstr("element \"pole\": from is not of a section; leave it out"));
    EXPECT_THAT(fault("size = 2", "sise = 2"), HasSubstr("m.toml:23:30: element \"pole2\": unknown key \"sise\""));
    EXPECT_THAT(fault("type = \"pole\"", "type = \"strut\""), HasSubstr("m.toml:21:1: element \"pole\": unknown key "
                                                                        "\"sections\" in [[element]] number 1"));
    EXPECT_THAT(fault("\"root\"", "\"ground\""), HasSubstr("its sections lie on the line from `from` to `to`"));
    EXPECT_THAT(line_fault(kRoot + kPole + "sections = []\n"),
                HasSubstr("m.toml:21:12: element \"pole\": sections must be a list"));
}

TEST(CutLines, FaultsOfProbes) {
    const auto fault = [](const std::string& on, const std::string& at) {
        return line_fault(kRoot + kPole + "[[probe]]\nname = \"mid\"\non = \"" + on + "\"\n" + at + "\n");
    };
    EXPECT_THAT(fault("pole", "at = 5"), HasSubstr("m.toml:24:6: probe \"mid\": at: the line is 4 m long, got 5 m"));
    EXPECT_THAT(fault("pole", "at = 4"), HasSubstr("m.toml:24:6: probe \"mid\": at: a node or an end is 0 m away"));
    // 1e-3 of the line of 4 m
    EXPECT_THAT(fault("pole", "at = 0.0027"), HasSubstr("place the probe at least 0.004 m away"));
    EXPECT_THAT(fault("pole", "at = 3.9973"), HasSubstr("place the probe at least 0.004 m away"));
    for (const char* at : {"0.0054", "3.9946"})
        EXPECT_EQ(parse_lines(kRoot + kPole + "[[probe]]\nname = \"mid\"\non = \"pole\"\nat = " + at + "\n").elements.size(),
                  2u);
    EXPECT_THAT(fault("pole", "at = 0"), HasSubstr("probe \"mid\": at must be > 0 m, got 0"));
    EXPECT_THAT(fault("pole", ""), HasSubstr("m.toml:21:1: probe \"mid\": missing key \"at\""));
    EXPECT_THAT(fault("pol", "at = 1"),
                HasSubstr("m.toml:23:6: probe \"mid\": on: there is no body or element \"pol\"; did you "
                          "mean \"pole\"?"));
    EXPECT_THAT(fault("plate", "at = 1"), HasSubstr("m.toml:24:1: probe \"mid\": at is for a probe on a beam or rod"));
    EXPECT_THAT(fault("pole", "position = [1, 2, 3]"), HasSubstr("position is for a probe on a body"));
    EXPECT_THAT(fault("pole", "at = 1\n[[probe]]\nname = \"mid\"\non = \"pole\"\nat = 2"),
                HasSubstr("m.toml:26:8: probe name \"mid\" on line 26 is taken already, on line 22"));
    EXPECT_THAT(
        fault("pole", "at = 1\n[[load]]\nelement = \"pole\"\ndirection = [1, 0, 0]\nforce_per_length = [1, 2]"),
        HasSubstr("m.toml:28:20: element \"pole\" has sections or probes: a force_per_length on it has one value; write "
                  "one for each of its parts, pole, pole_mid"));
}

}  // namespace
}  // namespace dttmm::host
