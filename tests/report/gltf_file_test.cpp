// SPDX-License-Identifier: BSD-3-Clause
//
// Binary glTF read back by glb_reader.h, which checks its structure and shares nothing with the writer.
#include "report/gltf_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/glb_reader.h"
#include "report/scene_results.h"

namespace dttmm::host {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSingle = 4e-7;  // of metres: seven digits of numbers up to 5

GlbReader exported_film(const TemporaryFolder& folder, std::string* what = nullptr) {
    const Results results = read_results(folder.path());
    const std::string text = write_gltf(Scene(results, {100, 100000}), folder / "out.glb");
    if (what) *what = text;
    return GlbReader(read_text(folder / "out.glb"));
}

auto near(std::initializer_list<double> wanted) {
    std::vector<testing::Matcher<double>> all;
    for (const double one : wanted) all.push_back(DoubleNear(one, kSingle));
    return testing::ElementsAreArray(all);
}

// Oracle: the rows of history.csv, and by hand the points between them; times from the first row.
TEST(GltfFile, PartsOfARunAreWhereTheRowsHaveThem) {
    const TemporaryFolder folder;
    write_scene_run(folder);
    const GlbReader file = exported_film(folder);
    const auto& run = file.animation("run");
    EXPECT_THAT(file.at("b", "translation", run, 0), near({1, 2, 3}));
    EXPECT_THAT(file.at("b", "translation", run, 0.25), near({1.5, 2, 3}));
    EXPECT_THAT(file.at("b", "translation", run, 0.625), near({1.75, 2.5, 4}));
    EXPECT_THAT(file.at("b", "rotation", run, 0.25), near({0, 0, 1, 0}));
    // The opposite quaternion is the same turn; of the two the nearer to the row before is written
    EXPECT_THAT(file.at("b", "rotation", run, 1), near({0, 0, 0.4358898943540674, -0.9}));
    EXPECT_THAT(file.at("n", "translation", run, 1), near({4, 2, 4}));
    EXPECT_THAT(file.at("n", "rotation", run, 1), near({0, std::sin(0.2), 0, std::cos(0.2)}));
    // From the marker at b + (0, 0.5, 0), a quarter further at b + (-0.5, 0, 0), to n
    EXPECT_THAT(file.at("spring", "translation", run, 0), near({2.5, 2.25, 3}));
    EXPECT_THAT(file.at("spring", "translation", run, 0.25), near({2.5, 2, 3.25}));
    const double length = std::hypot(3, 0.5);
    EXPECT_NEAR(file.at("spring", "scale", run, 0.25)[0], length, kSingle);
    const auto q = file.at("spring", "rotation", run, 0.25);  // x of the prism points from the marker to n
    EXPECT_NEAR(1 - 2 * (q[1] * q[1] + q[2] * q[2]), 3 / length, kSingle);
    EXPECT_NEAR(2 * (q[0] * q[2] - q[3] * q[1]), 0.5 / length, kSingle);
}

// Oracle: a quarter turn about -x, (x, y, z) -> (x, z, -y). The box of mass 12 and moments m/12 (sums of squared edges).
TEST(GltfFile, TheWorldStandsUprightAndBodiesAreTheirBoxes) {
    const TemporaryFolder folder;
    write_scene_run(folder);
    const GlbReader file = exported_film(folder);
    const auto& nodes = file.json["nodes"];
    EXPECT_EQ(file.json["scenes"][0]["nodes"], nlohmann::json::array({0}));
    const std::vector<double> q = nodes[0]["rotation"];
    EXPECT_NEAR(q[0], -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(q[3], std::sqrt(0.5), 1e-12);
    const auto& body = nodes[file.node("b")];
    ASSERT_EQ(body["children"].size(), 1u);
    const auto& box = nodes[body["children"][0].get<std::size_t>()];
    EXPECT_THAT(box["translation"].get<std::vector<double>>(), ElementsAre(0, 0, 0.25));
    std::vector<double> edges = box["scale"];
    std::ranges::sort(edges);
    EXPECT_THAT(edges, ElementsAre(DoubleNear(1, 1e-9), DoubleNear(2, 1e-9), DoubleNear(4, 1e-9)));
    EXPECT_FALSE(body.contains("mesh"));
    // Every face is seen from outside: its first triangle turns about its normal
    const auto& primitive = file.json["meshes"][0]["primitives"][0];
    const std::vector<float> at = file.numbers(primitive["attributes"]["POSITION"]),
                             normal = file.numbers(primitive["attributes"]["NORMAL"]);
    for (std::size_t face = 0; face < 6; ++face) {
        const float *a = &at[12 * face], *n = &normal[12 * face];
        double volume = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            volume += n[k] * ((a[3 + i] - a[i]) * (a[6 + j] - a[j]) - (a[3 + j] - a[j]) * (a[6 + i] - a[i]));
        }
        EXPECT_GT(volume, 0.5) << face;
    }
    const auto& accessor = file.json["accessors"][primitive["indices"].get<std::size_t>()];
    EXPECT_EQ(accessor["count"], 36);
}

// Oracle: 10 % of the diagonal of all boxes and places, or half a radian; the second mode turns b by 2 rad per unit.
TEST(GltfFile, ModesAreEnlargedAndSayByHowMuch) {
    const TemporaryFolder folder;
    write_scene_modes(folder);
    const GlbReader file = exported_film(folder);
    ASSERT_EQ(file.json["animations"].size(), 2u);
    const auto &rigid = file.animation("mode 1: 0 Hz"), &second = file.animation("mode 2: 12.5 Hz");
    EXPECT_EQ(second["extras"]["frequency_hz"], 12.5);
    const double factor = rigid["extras"]["shape_times_m"];
    EXPECT_NEAR(file.at("b", "translation", rigid, 0.25)[0], 1 + factor, kSingle);
    EXPECT_NEAR(file.at("b", "translation", rigid, 0.75)[0], 1 - factor, kSingle);
    EXPECT_THAT(file.at("b", "translation", rigid, 1), near({1, 2, 3}));
    const Results results = read_results(folder.path());
    const Scene scene(results, {100, 100000});
    EXPECT_NEAR(factor, 0.1 * scene.structure().size(), 1e-12);
    EXPECT_LE(second["extras"]["shape_times_m"].get<double>(), 0.25 + 1e-12);
    EXPECT_EQ(file.json["nodes"][file.node("leg")]["children"].size(), 2u) << "three stations";
    // The upper piece of the leg, between its second and third station
    EXPECT_THAT(file.at("leg 2", "translation", rigid, 0.25), near({4 + factor * 0.7, 2, 2.25}));
}

TEST(GltfFile, EquilibriaAreApproachedAndSmallOnesEnlarged) {
    const TemporaryFolder folder;
    write_scene_equilibria(folder);
    std::string what;
    const GlbReader file = exported_film(folder, &what);
    std::vector<std::string> names;
    for (const auto& one : file.json["animations"]) names.push_back(one["name"]);
    ASSERT_EQ(names.size(), 3u);
    EXPECT_EQ(names[0], "equilibrium snow");
    EXPECT_THAT(names[1], HasSubstr("equilibrium snow, enlarged "));
    EXPECT_EQ(names[2], "equilibrium both");
    const auto &plain = file.animation(names[0]), &enlarged = file.animation(names[1]);
    const double factor = enlarged["extras"]["displacements_times"];
    EXPECT_NEAR(file.at("n", "translation", plain, 0.5)[2], 2.999, kSingle);
    EXPECT_NEAR(file.at("n", "translation", enlarged, 1)[2], 3 - 0.002 * factor, kSingle);
    EXPECT_THAT(what, HasSubstr("load case \"wind\" has no equilibrium"));
    EXPECT_THAT(file.json["extras"]["left_out"].dump(), HasSubstr("wind"));
}

TEST(GltfFile, WhatIsNotRecordedStandsStillAndIsNamed) {
    const TemporaryFolder folder;
    write_scene_summary(folder, "summary");
    write_text(folder / "history.csv",
               "time,n.position.x,n.position.y,n.position.z\ns,m,m,m\n0,4,2,3\n1e6,5,2,3\n1000000.001,4,2,3\n");
    std::string what;
    const GlbReader file = exported_film(folder, &what);
    const auto& run = file.animation("run");
    EXPECT_THAT(file.at("b", "translation", run, 1e6), near({1, 2, 3}));
    EXPECT_THAT(what, HasSubstr("no position is recorded of b: drawn at the start"));
    EXPECT_THAT(what, HasSubstr("no rotation is recorded of n"));
    EXPECT_EQ(file.json["extras"]["title"], "a \"ü\" & <b>");
}

}  // namespace
}  // namespace dttmm::host
