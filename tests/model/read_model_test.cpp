// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_model.h"

#include <sys/stat.h>

#include <filesystem>

#include "model/test_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

const fs::path kExamples = fs::path(test::paths::source_dir()) / "examples";

// Oracle: the file itself, converted by hand. Decimal units are exact, so the numbers are too; the mass is one product.
TEST(ReadModel, FourBoltPlate) {
    const Model model = read_model(kExamples / "four_bolt_plate" / "model.toml", test_catalogue());
    EXPECT_EQ(model.title, "Four-bolt clamped plate");
    EXPECT_EQ(model.simulation.duration, 1);
    EXPECT_EQ(model.simulation.step, 0.001);
    EXPECT_EQ(model.simulation.coupling, Coupling::implicit);
    EXPECT_EQ(model.output.every, 1);
    ASSERT_EQ(model.parameters.size(), 3u);
    EXPECT_EQ(model.parameters[1].value, 100);
    EXPECT_EQ(model.parameters[1].unit, "N*s/m");

    ASSERT_EQ(model.bodies.size(), 1u);
    const Body& plate = model.bodies[0];
    EXPECT_DOUBLE_EQ(plate.mass, 9.42);
    ASSERT_EQ(plate.markers.size(), 4u);
    EXPECT_EQ(plate.markers[2].name, "corner3");
    EXPECT_EQ(plate.markers[2].position, Eigen::Vector3d(-0.13, -0.08, 0));

    ASSERT_EQ(model.loads.size(), 1u);
    EXPECT_EQ(model.loads[0].direction, Eigen::Vector3d(0, 0, 1));
    EXPECT_EQ(model.loads[0].signal.value(0), 0);
    EXPECT_DOUBLE_EQ(model.loads[0].signal.value(0.0092), 500);
    EXPECT_EQ(model.loads[0].signal.value(0.0184), 1000);

    ASSERT_EQ(model.elements.size(), 4u);
    for (int i = 0; i < 4; ++i) {
        const Element& bolt = model.elements[static_cast<std::size_t>(i)];
        EXPECT_EQ(bolt.name, "bolt" + std::to_string(i + 1));
        EXPECT_EQ(bolt.ends[0].body, -1);
        EXPECT_EQ(bolt.ends[1].body, 0);
        EXPECT_EQ(bolt.ends[1].marker, i);
        EXPECT_THAT(bolt.values, ElementsAre(5e5, 5e5, 5e5, 100, 100, 100, 0, 0, 0, 0, 0, 0));
    }
    EXPECT_TRUE(model.warnings.empty());
}

TEST(ReadModel, FourBoltPlateWithOneBoltSofter) {
    ModelOverrides overrides;
    overrides.parameters = {{"k1", "400 N/mm"}};
    const Model model = read_model(kExamples / "four_bolt_plate" / "model.toml", test_catalogue(), overrides);
    EXPECT_EQ(model.elements[0].values[2], 4e5);
    EXPECT_EQ(model.elements[1].values[2], 5e5);
}

TEST(ReadModel, StiffBolts) {
    const Model model = read_model(kExamples / "stiff_bolts" / "model.toml", test_catalogue());
    ASSERT_EQ(model.elements.size(), 4u);
    EXPECT_THAT(model.elements[0].values, ElementsAre(4e8, 4e8, 4e8, 1000, 1000, 1000, 0, 0, 0, 0, 0, 0));
    EXPECT_THAT(model.elements[3].values, ElementsAre(5e8, 5e8, 5e8, 1000, 1000, 1000, 0, 0, 0, 0, 0, 0));
    EXPECT_EQ(model.bodies[0].markers[1].position, Eigen::Vector3d(-0.13, 0.08, 0));
    EXPECT_TRUE(model.warnings.empty());
}

TEST(ReadModel, LineEndsOfBothKindsAndAMarkAtTheStart) {
    std::string text = "\xef\xbb\xbf" + model_with("[[load]]\non = \"plat\"\ndirection = [0, 0, 1]\nforce = 1\n");
    for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += 2) text.replace(at, 1, "\r\n");
    EXPECT_THAT(errors_of(text), HasSubstr("m.toml:13:6: load number 1: on: there is no body \"plat\""));
}

TEST(ReadModel, TheFormatIsChecked) {
    EXPECT_EQ(errors_of(""), "m.toml:1:1: no format key; begin the file with: format = \"dttmm/1\"");
    EXPECT_EQ(errors_of("# nothing\n\n"), "m.toml:1:1: no format key; begin the file with: format = \"dttmm/1\"");
    EXPECT_EQ(errors_of("format = \"dttmm/9\"\nnew_key = 1\n"),
              "m.toml:1:10: this version reads format \"dttmm/1\" only, got \"dttmm/9\"");
    EXPECT_THAT(errors_of("format = 1\n"), HasSubstr("got a number"));
}

TEST(ReadModel, UnknownTopKeysGetTheNearest) {
    EXPECT_THAT(errors_of("paramters = {}\n" + model_with("")),
                HasSubstr("m.toml:1:1: unknown key \"paramters\"; did you mean \"parameters\"?"));
    EXPECT_THAT(errors_of("solvr = 1\n" + model_with("")),
                HasSubstr("unknown key \"solvr\"; known here: format, title, parameters, stations, simulation"));
}

TEST(ReadModel, WhatIsForModesIsReadOrRefusedByName) {
    EXPECT_TRUE(parse(model_with("[modes]\ncount = 3\nbeams = \"exact\"\n")).nodes.empty());
    EXPECT_EQ(errors_of("modes = 3\n" + model_with("")), "m.toml:1:1: modes must be a table, got a number; write [modes]");
    EXPECT_THAT(errors_of("dofs = [\"x\"]\n" + model_with("[[joint]]\ntype = \"bal\"\n")),
                HasSubstr("m.toml:1:1: dofs is for `dttmm modes`"));
}

TEST(ReadModel, AModelNeedsABodyOrANode) {
    EXPECT_THAT(errors_of("body = []\n" + std::string(kStart) + kSimulation), HasSubstr("m.toml:1:1: no body"));
    EXPECT_THAT(errors_of(std::string(kStart) + kSimulation), HasSubstr("no body: at least one [[body]] is needed"));
    EXPECT_THAT(errors_of(std::string(kStart) + kSimulation + "[nodes]\n"), HasSubstr("no body: at least one [[body]]"));
    const std::string on_tip = "[nodes]\ntip = [0, 0, 1]\n[[element]]\nname = \"mass\"\ntype = \"lump\"\nat = \"tip\"\n";
    EXPECT_TRUE(parse(std::string(kStart) + kSimulation + on_tip + "mass = 1\n").bodies.empty());
}

TEST(ReadModel, AllFaultsOfAFileAreToldInOneGo) {
    const std::string text = errors_of(
        "title = 3\nformat = \"dttmm/1\"\n[simulation]\nduration = 1\nstep = 0\n[[body]]\nname = \"a b\"\nmass = 0\n"
        "inertia = [2, 3, 4]\n[[load]]\non = \"x\"\ndirection = [0, 0, 0]\nforce = true\n[[element]]\ntype = \"s\"\n");
    for (const char* place :
         {"m.toml:1:9: title", "m.toml:5:8: simulation: step", "m.toml:7:8: body name", "m.toml:8:8: body \"a b\": mass",
          "m.toml:11:6: load number 1: on", "m.toml:12:13: load number 1: direction", "m.toml:13:9: load number 1: force",
          "m.toml:14:1: element number 1: missing key \"name\"", "m.toml:15:8: element number 1: no loaded plugin"})
        EXPECT_THAT(text, HasSubstr(place));
}

TEST(ReadModel, FiftyOneErrorsShowFifty) {
    std::string text = model_with("[parameters]\n");
    for (int i = 0; i < 51; ++i) text += "p" + std::to_string(i) + " = true\n";
    const std::string errors = errors_of(text);
    EXPECT_THAT(errors, HasSubstr("\"p49\""));
    EXPECT_TRUE(errors.ends_with("\nand 1 more error")) << errors;
}

TEST(ReadModel, AFreeBodyIsWarnedOf) {
    EXPECT_THAT(parse(model_with("")).warnings,
                ElementsAre(WarningIs(
                    "free-body", "m.toml:7:1: body \"plate\": free body: no element, joint, load or gravity acts on it")));
    EXPECT_TRUE(parse(model_with("[[load]]\non = \"plate\"\ndirection = [0, 0, 1]\nforce = 1\n")).warnings.empty());
    EXPECT_TRUE(parse(simulation_with("duration = 1\nstep = 0.1\ngravity = [0, 0, -9.81]\n")).warnings.empty());
}

TEST(ReadModel, TheTextIsKept) {
    const Model model = parse(model_with(""));
    EXPECT_EQ(model.source, model_with(""));
    EXPECT_EQ(model.path, "m.toml");
}

TEST(ReadModel, UnreadableFilesAreInputErrors) {
    const auto fault = [](const fs::path& file) {
        return error_of([&] { read_model(file, test_catalogue()); }, ExitCode::input_output);
    };
    EXPECT_THAT(fault("no/such/file.toml"), HasSubstr("no/such/file.toml: there is no such file"));
    EXPECT_THAT(fault(testing::TempDir()), HasSubstr("is not a regular file"));
    const fs::path fifo = fs::path(testing::TempDir()) / "read_model_test.fifo";
    fs::remove(fifo);
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    EXPECT_THAT(fault(fifo), HasSubstr("is not a regular file"));
    fs::remove(fifo);
}

}  // namespace
}  // namespace dttmm::host
