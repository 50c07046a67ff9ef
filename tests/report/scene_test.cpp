// SPDX-License-Identifier: BSD-3-Clause
#include "report/scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "record/error_matcher.h"
#include "report/gltf_file.h"
#include "report/scene_results.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

void expect_at(const Eigen::Vector3d& found, double x, double y, double z, double tolerance = 1e-12) {
    EXPECT_NEAR((found - Eigen::Vector3d(x, y, z)).norm(), 0, tolerance) << found.transpose();
}

// Oracle: by hand; the box of the body reaches from (0, 1.5, 1.25) to (2, 2.5, 5.25), the nodes to (4, 2, 0).
TEST(Scene, TheStructureIsThatOfTheModel) {
    const Structure structure(Json::parse(kSceneModel));
    ASSERT_EQ(structure.owners().size(), 3u);
    ASSERT_EQ(structure.places().size(), 4u);
    EXPECT_EQ(structure.places()[1].name, "b.m");
    expect_at(structure.at_start(structure.places()[1].point), 1, 2.5, 3);
    EXPECT_TRUE(structure.owners()[2].is_fixed);
    ASSERT_EQ(structure.elements().size(), 3u);
    EXPECT_TRUE(structure.elements()[1].is_beam());
    EXPECT_EQ(structure.elements()[1].diameter, 0.2);
    EXPECT_EQ(structure.elements()[2].points[0].owner, -1);
    expect_at(structure.at_start(structure.elements()[2].points[0]), 1, 2, 3);
    EXPECT_NEAR(structure.size(), std::sqrt(16 + 1 + 5.25 * 5.25), 1e-9);
}

// Oracle: a cubic whose ends have turned by 0.2 rad about y: there its tangent is that of the start, turned.
TEST(Scene, BeamsBendAsTheirEndsHaveIt) {
    const TemporaryFolder folder;
    write_scene_run(folder);
    const Results results = read_results(folder.path());
    const Scene scene(results, {100, 100000});
    const Placement placement = scene.place(scene.films()[0].at(1));
    const std::vector<Eigen::Vector3d>& leg = placement.lines[1];
    expect_at(leg.front(), 4, 2, 0);
    expect_at(leg.back(), 4, 2, 3.5);
    const double t = 0.5, tangent_x = 3 * std::sin(0.2), tangent_z = 3 * std::cos(0.2);
    expect_at(leg[3], 4 - t * t * t * tangent_x, 2, 0.5 * 3.5 + t * t * t * 3 - t * t * t * tangent_z);
    EXPECT_EQ(scene.films()[0].at(1).forces[0], 13);
    EXPECT_TRUE(std::isnan(scene.films()[0].at(1).forces[1]));
}

// Oracle: u + theta × r. The box of b reaches 1 along world x and 0.5 along y from its axis; theta is 2 about z.
TEST(Scene, ModesMoveByTheirShapeTimesASine) {
    const TemporaryFolder folder;
    write_scene_modes(folder);
    const Results results = read_results(folder.path());
    const Scene scene(results, {100, 100000});
    ASSERT_EQ(scene.films().size(), 2u);
    const Film& film = scene.films()[1];
    const Instant full = film.at(film.fullest);
    expect_at(full.owners[0].shift, 0, 0, 0.5);
    expect_at(film.at(2).owners[0].shift, 0, 0, 0.25, 1e-15);
    expect_at(film.at(18).owners[0].theta, 0, 0, -2, 1e-15);
    expect_at(scene.linear_shift({0, {0.5, 0, 0}}, full), -1, 0, 0.5);
    EXPECT_NEAR(scene.largest(full).shift, std::hypot(2 * std::hypot(1, 0.5), 0.5), 1e-9);
    EXPECT_EQ(scene.largest(full).angle, 2);
    expect_at(scene.place(full, 0.1).lines[1][1], 4, 2.075, 1.5);
}

TEST(Scene, WhatHasNoMotionIsRefused) {
    const TemporaryFolder folder;
    const auto expect = [&](ExitCode code, const char* text) {
        expect_error([&] { Scene(read_results(folder.path()), {100, 1000}); }, code, HasSubstr(text));
    };
    write_text(folder / "history.csv", "time,n.position.x,n.position.y,n.position.z\ns,m,m,m\n0,4,2,3\n");
    expect(ExitCode::usage, "there is no summary.json");
    write_scene_summary(folder, "summary");
    expect(ExitCode::usage, "fewer than two rows");
    write_text(folder / "history.csv", "time,a\ns,N\n0,1\n1,2\n");
    expect(ExitCode::usage, "no position of a body or node");
    write_scene_summary(folder, "response");
    expect(ExitCode::usage, "have no motion to draw");
    write_text(folder / "summary.json",
               R"({"format": "dttmm-static/1", "model": {"nodes": {"n": {"position": [1e308, -1e308, 1e308],
                   "rotation": [[1,0,0],[0,1,0],[0,0,1]]}, "o": {"position": [-1e308, 1e308, 1e308],
                   "rotation": [[1,0,0],[0,1,0],[0,0,1]]}}}})");
    expect(ExitCode::input_output, "places or inertias that are no numbers");
}

// A machine of 2000 bodies and springs over 2000 rows: the bound of numbers holds, and it is done in seconds.
TEST(Scene, ALargeMachineStaysWithinItsBounds) {
    const TemporaryFolder folder;
    constexpr int kBodies = 2000, kRows = 60;
    Json model = Json::parse(kSceneModel);
    const Json body = model["bodies"]["b"];
    std::string names = "time", units = "s";
    for (int i = 0; i < kBodies; ++i) {
        const std::string name = fmt::format("c{}", i);
        model["bodies"][name] = body;
        model["bodies"][name]["position"] = {i, 0, 0};
        model["elements"]["s" + name] = {{"type", "spring_damper"}, {"from", name}, {"to", "n"}};
        for (const char* axis : {"x", "y", "z"}) names += "," + name + ".position." + axis, units += ",m";
    }
    std::string text = names + "\n" + units + "\n";
    for (int row = 0; row < kRows; ++row) {
        text += fmt::format("{}", row);
        for (int i = 0; i < kBodies; ++i) text += fmt::format(",{},0,{}", i, row);
        text += "\n";
    }
    write_text(folder / "history.csv", text);
    write_text(folder / "summary.json", "{\"format\": \"dttmm-summary/1\", \"model\": " + model.dump() + "}");
    const auto start = std::chrono::steady_clock::now();
    const Results results = read_results(folder.path());
    const Scene scene(results, {2000, 120020});
    EXPECT_EQ(scene.films()[0].times.size(), 20u) << "6001 numbers a row";
    write_gltf(scene, folder / "out.glb");
    EXPECT_LT(std::filesystem::file_size(folder / "out.glb"), 10e6);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

}  // namespace
}  // namespace dttmm::host
