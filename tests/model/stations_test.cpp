// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "model/expanded_file.h"
#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A valid model with these stations and more; the first line of them is line 13.
std::string with_stations(const std::string& stations, const std::string& more = {}) {
    return model_with("[stations]\n" + stations + more);
}

std::string station_fault(const std::string& stations, const std::string& more = {}) {
    return errors_of(with_stations(stations, more));
}

constexpr const char* kTwo =
    "front = [\"120 mm\", 0.03, \"=h\"]\nrear = [\"=front.x + 0.2\", \"=-front.y\", \"=2*front.z\"]\n";
constexpr const char* kHeight = "[parameters]\nh = \"40 mm\"\n";

TEST(Stations, AreThePlacesThatTheirNumbersName) {
    const std::string nodes =
        "[nodes]\na = \"=rear\"\nb = { position = \"= front \" }\nc = [\"=rear.x - front.x\", \"=sqrt(rear.y^2)\", "
        "\"=h\"]\n";
    const std::string elements =
        "[[element]]\nname = \"s1\"\ntype = \"spring_damper\"\nfrom = \"a\"\nto = \"b\"\nstiffness = 1\n"
        "[[element]]\nname = \"s2\"\ntype = \"spring_damper\"\nfrom = \"b\"\nto = \"c\"\nstiffness = 1\n";
    const Model model = parse(with_stations(kTwo, kHeight + nodes + elements));
    ASSERT_EQ(model.nodes.size(), 3u);
    EXPECT_EQ(model.nodes[0].position, Eigen::Vector3d(0.12 + 0.2, -0.03, 2 * 0.04));
    EXPECT_EQ(model.nodes[1].position, Eigen::Vector3d(0.12, 0.03, 0.04));
    EXPECT_EQ(model.nodes[2].position, Eigen::Vector3d(0.12 + 0.2 - 0.12, 0.03, 0.04));
}

TEST(Stations, HoldPositionsOfBodiesMarkersAndJoints) {
    const std::string body =
        "[[body]]\nname = \"arm\"\ndensity = 1000\nbox = [0.1, 0.2, 0.3]\nposition = \"=front\"\nmarkers = { end = "
        "\"=rear\" }\n"
        "[[joint]]\nname = \"pin\"\ntype = \"ball\"\nbetween = [\"arm\", \"ground\"]\nanchor = \"=front\"\n";
    const Model model = parse(with_stations(kTwo, kHeight + body));
    const Body& arm = model.bodies.back();
    EXPECT_EQ(arm.markers.back().position, Eigen::Vector3d(0.12 + 0.2, -0.03, 2 * 0.04));
    EXPECT_EQ(model.joints.back().anchor, Eigen::Vector3d(0.12, 0.03, 0.04));
}

TEST(Stations, AreParametersThatMove) {
    ModelOverrides moved;
    moved.parameters = {{"front.x", "500 mm"}, {"front.y", "0.01"}, {"front.z", "7 mm"}};
    const std::string text = with_stations(kTwo, kHeight);
    const std::vector<Parameter> parameters = parse(text, moved).parameters;
    std::vector<std::string> names;
    std::vector<double> values;
    for (const Parameter& one : parameters) {
        names.push_back(one.name);
        values.push_back(one.value);
        EXPECT_EQ(one.unit, "m");
    }
    EXPECT_THAT(names, ElementsAre("h", "front.x", "front.y", "front.z", "rear.x", "rear.y", "rear.z"));
    EXPECT_THAT(values, ElementsAre(0.04, 0.5, 0.01, 0.007, 0.5 + 0.2, -0.01, 0.014));
    moved.parameters = {{"front.x", "0.5"}};  // a length in mm becomes one in m? The file says mm
    EXPECT_THAT(errors_of(text, moved, ExitCode::usage), HasSubstr("--set front.x=0.5: of which unit? the file gives mm"));
    moved.parameters = {{"front.x", "0.5"}};  // what the file has there is a fault still, and no unit
    EXPECT_EQ(errors_of(with_stations("front = [\"2 kg\", 0, 0]\n"), moved),
              "m.toml:13:10: station \"front.x\": expected a length, got \"2 kg\"");
    moved.parameters = {{"front.w", "1"}};
    EXPECT_THAT(errors_of(text, moved, ExitCode::usage), HasSubstr("--set front.w: the model has no such parameter"));
}

TEST(Stations, AnIndexIsNotCalledLikeOne) {
    EXPECT_THAT(station_fault("i = [1, 2, 3]\n", "[[repeat]]\nindex = \"i\"\ncount = 2\n"),
                HasSubstr("is the name of a station already"));
}

// A force is no length, also where the speed decides it.
TEST(Stations, AnAmplitudeOfTheSpeedHasTheUnitOfAForce) {
    const std::string load =
        "[[load]]\non = \"plate\"\ndirection = [0, 0, 1]\nharmonic = { amplitude = \"=e.x\", order = 1 }\n";
    const std::string speed = "[parameters]\nOmega = \"3000 rpm\"\n";
    ModelOverrides response;
    response.purpose = Purpose::modes;
    EXPECT_THAT(errors_of(with_stations("e = [\"=Omega*0.001\", 0, 0]\n", speed + load), response),
                HasSubstr("amplitude: expected a value in N"));
}

TEST(Stations, FaultsAreToldWhereTheyStand) {
    EXPECT_THAT(station_fault("front = 3\n"),
                HasSubstr("m.toml:13:9: station \"front\" wants three lengths, [x, y, z], got a "));
    EXPECT_THAT(station_fault("front = [1, 2]\n"), HasSubstr("station \"front\" wants three lengths, [x, y, z], got 2"));
    EXPECT_THAT(station_fault("front = [1, \"2 kg\", 3]\n"),
                HasSubstr("m.toml:13:13: station \"front.y\": expected a length"));
    EXPECT_THAT(station_fault("front = [1, \"=m\", 3]\n", "[parameters]\nm = \"2 kg\"\n"),
                HasSubstr("station \"front.y\": expected a length, got \"=m\", which is \"2 kg\""));
    EXPECT_THAT(station_fault("front = [1, \"=front.x\", \"=front.q\"]\n"), HasSubstr("unknown name \"front.q\""));
    EXPECT_THAT(station_fault("front = [\"=front.y\", \"=front.x\", 0]\n"), HasSubstr("depends on itself: front."));
    EXPECT_THAT(station_fault("fr-ont = [1, 2, 3]\n"), HasSubstr("it must begin with a letter"));
    EXPECT_THAT(station_fault("front = [1, 2, 3]\n", "[parameters]\nfront = 1\n"),
                HasSubstr("has the name of a parameter, line 15"));
    EXPECT_THAT(errors_of("stations = 1\n" + model_with("")), HasSubstr("stations must be a table of name = [x, y, z]"));
}

TEST(Stations, WhereANumberOrThreeAreWantedTheMessageSaysWhich) {
    const std::string body = "[[body]]\nname = \"arm\"\ndensity = 1000\nbox = [0.1, 0.2, 0.3]\n";
    EXPECT_THAT(station_fault(kTwo, kHeight + body + "position = [\"=front\", 0, 0]\n"),
                HasSubstr("\"front\" in \"front\" is a place, not a number: write front.x, front.y or front.z"));
    EXPECT_THAT(
        station_fault(kTwo, kHeight + body + "position = \"=front + 1\"\n"),
        HasSubstr("a station stands alone, \"=front\", or by its coordinates, [\"=front.x\", \"=front.y\", \"=front.z\"]"));
    EXPECT_THAT(station_fault(kTwo, kHeight + body + "position = \"=fornt\"\n"),
                HasSubstr("wants 3 numbers, got a text; no station has this name; did you mean \"front\"?"));
    EXPECT_THAT(station_fault(kTwo, kHeight + body + "velocity = \"=front\"\n"), HasSubstr("expected a value in m/s"));
}

}  // namespace
}  // namespace dttmm::host
