// SPDX-License-Identifier: BSD-3-Clause
//
// Grids read back by vtu_reader.h, which shares nothing with the writer.
#include "report/vtu_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "record/error_matcher.h"
#include "report/scene_results.h"
#include "report/vtu_reader.h"

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

void export_frames(const TemporaryFolder& folder) {
    const Results results = read_results(folder.path());
    write_vtu(Scene(results, {100, 100000}), folder / "o<&>ut.pvd");
}

VtuReader frame(const TemporaryFolder& folder, const std::string& name) {
    return VtuReader(read_text(folder / ("o<&>ut.frames/" + name)));
}

Eigen::Vector3d vector_of_grid(const std::vector<double>& numbers, std::size_t point) {
    return {numbers[3 * point], numbers[3 * point + 1], numbers[3 * point + 2]};
}

// Oracle: the poses of the rows by hand. Body of 8 points, two nodes, a line of 2, a beam of 7, a line of 2.
TEST(VtuFiles, ARunHasPointsWhereTheyAre) {
    const TemporaryFolder folder;
    write_scene_run(folder);
    export_frames(folder);
    const std::string collection = read_text(folder / "o<&>ut.pvd");
    EXPECT_THAT(collection, HasSubstr("<DataSet timestep=\"0.5\" part=\"0\" file=\"o&lt;&amp;>ut.frames/f000000.vtu\"/>"));
    EXPECT_THAT(collection, HasSubstr("<DataSet timestep=\"1.5\" part=\"0\" file=\"o&lt;&amp;>ut.frames/f000002.vtu\"/>"));
    const VtuReader grid = frame(folder, "f000001.vtu");
    EXPECT_EQ(grid.count("NumberOfPoints"), 21u);
    EXPECT_EQ(grid.count("NumberOfCells"), 6u);
    EXPECT_THAT(grid.doubles("TimeValue"), ElementsAre(0.75));
    EXPECT_FALSE(grid.has("frequency"));
    EXPECT_THAT(grid.numbers<uint8_t>("types", "UInt8"), ElementsAre(12, 1, 1, 4, 4, 4));
    EXPECT_THAT(grid.numbers<uint8_t>("kind", "UInt8"), ElementsAre(0, 1, 1, 2, 2, 2));
    EXPECT_THAT(grid.numbers<int64_t>("offsets", "Int64"), ElementsAre(8, 9, 10, 12, 19, 21));
    EXPECT_THAT(grid.numbers<int32_t>("part", "Int32"), ElementsAre(0, 1, 2, 3, 4, 5));
    EXPECT_THAT(grid.texts("part_names"), ElementsAre("b", "n", "Fuß", "spring", "leg", "ground spring"));
    const std::vector<int64_t> points = grid.numbers<int64_t>("connectivity", "Int64");
    for (std::size_t i = 0; i < 21; ++i) EXPECT_EQ(points[i], static_cast<int64_t>(i));
    const std::vector<double> forces = grid.doubles("force"), at = grid.doubles("Points"),
                              moved = grid.doubles("displacement");
    EXPECT_EQ(forces[3], 13);
    EXPECT_TRUE(std::isnan(forces[4]));
    // The ends of the spring: the marker, from (1, 2.5, 3), has gone half a turn to b - 0.5 x; n has risen
    EXPECT_NEAR((vector_of_grid(at, 10) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(moved, 10) - Eigen::Vector3d(0, -0.5, 0)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(at, 11) - Eigen::Vector3d(4, 2, 3.5)).norm(), 0, 1e-12);
    // The box: its middle is the centre of mass, its edges are 1, 2 and 4, its volume 8 and positive
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 8; ++i) middle += vector_of_grid(at, i) / 8;
    EXPECT_NEAR((middle - Eigen::Vector3d(1.5, 2, 3.25)).norm(), 0, 1e-12);
    const Eigen::Vector3d a = vector_of_grid(at, 1) - vector_of_grid(at, 0),
                          b = vector_of_grid(at, 3) - vector_of_grid(at, 0),
                          c = vector_of_grid(at, 4) - vector_of_grid(at, 0);
    EXPECT_NEAR(a.cross(b).dot(c), 8, 1e-9);
    EXPECT_NEAR((vector_of_grid(at, 6) - vector_of_grid(at, 0) - a - b - c).norm(), 0, 1e-12);
}

// Oracle: u + theta × r on points at the start; the stations of shapes.csv.
TEST(VtuFiles, AModeHasItsShapeAtTheStart) {
    const TemporaryFolder folder;
    write_scene_modes(folder);
    export_frames(folder);
    EXPECT_THAT(read_text(folder / "o<&>ut.pvd"), HasSubstr("<DataSet timestep=\"2\" "));
    const VtuReader grid = frame(folder, "f000001.vtu");
    EXPECT_THAT(grid.doubles("frequency"), ElementsAre(12.5));
    const std::vector<double> at = grid.doubles("Points"), shape = grid.doubles("displacement");
    EXPECT_NEAR((vector_of_grid(at, 10) - Eigen::Vector3d(1, 2.5, 3)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(shape, 10) - Eigen::Vector3d(-1, 0, 0.5)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(shape, 11) - Eigen::Vector3d(0, 0.25, 0)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(at, 13) - Eigen::Vector3d(4, 2, 1.5)).norm(), 0, 1e-12);
    EXPECT_NEAR((vector_of_grid(shape, 13) - Eigen::Vector3d(0, 0.75, 0)).norm(), 0, 1e-12);
    for (std::size_t i = 0; i < 8; ++i) {
        const Eigen::Vector3d r = vector_of_grid(at, i) - Eigen::Vector3d(1, 2, 3);
        EXPECT_NEAR((vector_of_grid(shape, i) - Eigen::Vector3d(-2 * r.y(), 2 * r.x(), 0.5)).norm(), 0, 1e-12) << i;
    }
}

TEST(VtuFiles, FramesOfAnotherTimeAreRemovedAndOtherFilesRefused) {
    const TemporaryFolder folder;
    write_scene_run(folder);
    export_frames(folder);
    write_scene_equilibria(folder);
    std::filesystem::remove(folder / "history.csv");
    export_frames(folder);
    EXPECT_TRUE(std::filesystem::exists(folder / "o<&>ut.frames/f000001.vtu"));
    EXPECT_FALSE(std::filesystem::exists(folder / "o<&>ut.frames/f000002.vtu"));
    EXPECT_THAT(frame(folder, "f000000.vtu").texts("left_out"), testing::Contains(HasSubstr("\"wind\"")));
    write_text(folder / "o<&>ut.frames/thesis.vtu", "years of work");
    expect_error([&] { export_frames(folder); }, ExitCode::input_output, HasSubstr("holds other files than frames"));
    EXPECT_EQ(read_text(folder / "o<&>ut.frames/thesis.vtu"), "years of work");
    EXPECT_TRUE(std::filesystem::exists(folder / "o<&>ut.frames/f000001.vtu")) << "nothing is removed before";
}

}  // namespace
}  // namespace dttmm::host
