// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes`: energies.csv and the kind of each mode.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "cli/modes_run.h"
#include "support/linear_algebra.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

/// Two bodies on springs along x, and a mass at a node: K and M are 3 × 3. The first body turns too, about z, apart from it.
const char* kThree = R"(format = "dttmm/1"
dofs = ["x", "rz"]
modes = { count = 3 }
[nodes]
n = [2, 0, 0]
[[body]]
name = "a"
mass = 2
inertia = [1, 1, 0.5]
[[body]]
name = "b"
mass = 3
inertia = [1, 1, 1]
position = [1, 0, 0]
[[element]]
name = "one"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = [700, 0, 0]
rotational_stiffness = [0, 0, 9000]
[[element]]
name = "two"
type = "spring_damper"
from = "a"
to = "b"
stiffness = [400, 0, 0]
rotational_stiffness = [0, 0, 5000]
[[element]]
name = "three"
type = "spring_damper"
from = "b"
to = "n"
stiffness = [300, 0, 0]
rotational_stiffness = [0, 0, 4000]
[[element]]
name = "mass"
type = "point_mass"
at = "n"
mass = 1.5
)";

// Oracle: the eigenproblem written out. Each share is m u²/uᵀMu and k δ²/uᵀKu, of directions of elements alike; shares add
// up to one.
TEST(Energies, SharesAreThoseOfTheEigenproblem) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kThree);
    const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "-o", "out"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::istringstream lines(read_text(folder / "out/energies.csv"));
    std::map<std::pair<int, std::string>, std::vector<std::string>> rows;
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "mode,frequency,energy,of,share,x,y,z,rx,ry,rz,r1,r2,r3");
    std::getline(lines, line);
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::vector<std::string> row;
        for (std::string cell; std::getline(fields, cell, ',');) row.push_back(cell);
        rows[{std::stoi(row[0]), row[2] + " " + row[3]}] = row;
    }
    const Eigen::Vector3d m(2, 3, 1.5), k(700, 400, 300);
    Eigen::Matrix3d K;
    K << 1100, -400, 0, -400, 700, -300, 0, -300, 300;
    const test::Pencil exact = test::solve_pencil(K, Eigen::Matrix3d(m.asDiagonal()));
    for (int mode = 1; mode <= 3; ++mode) {
        const Eigen::Vector3d u = exact.vectors.col(mode - 1);
        const Eigen::Vector3d stretch(u(0), u(1) - u(0), u(2) - u(1));
        const double kinetic = u.cwiseAbs2().dot(m), strain = stretch.cwiseAbs2().dot(k);
        const auto share = [&](const std::string& of, size_t column = 4) { return std::stod(rows.at({mode, of})[column]); };
        EXPECT_NEAR(std::stod(rows.at({mode, "kinetic a"})[1]), std::sqrt(exact.values(mode - 1)) / (2 * M_PI), 1e-9);
        EXPECT_NEAR(share("kinetic a"), 2 * u(0) * u(0) / kinetic, 1e-9);
        EXPECT_NEAR(share("kinetic a", 5), 2 * u(0) * u(0) / kinetic, 1e-9);
        EXPECT_NEAR(share("kinetic b"), 3 * u(1) * u(1) / kinetic, 1e-9);
        EXPECT_NEAR(share("kinetic others"), 1.5 * u(2) * u(2) / kinetic, 1e-9);
        const char* name[] = {"strain one", "strain two", "strain three"};
        for (int e = 0; e < 3; ++e) {
            EXPECT_NEAR(share(name[e]), k(e) * stretch(e) * stretch(e) / strain, 1e-9);
            EXPECT_NEAR(share(name[e], 5), k(e) * stretch(e) * stretch(e) / strain, 1e-9);
        }
    }
    EXPECT_THAT(ended.out, ::testing::HasSubstr("effective mass of these modes: x 100 %, rz"));
}

// Oracle: a free-standing calculation of the engine, in the README of the example: 55 % sideways, 30 % roll, 15 % bounce.
// Each share about principal axes is positive; they add up to what rotation has in world axes.
TEST(Energies, TheEngineRollsAndBounces) {
    const TemporaryFolder folder;
    const Ended ended = run_dttmm(
        folder.path(),
        {"modes",
         (std::filesystem::path(test::paths::source_dir()) / "examples/engine_on_inclined_mounts/model.toml").string(), "-o",
         "out"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, ::testing::HasSubstr("y 55 %, rx 30 %, z 15 %"));
    EXPECT_THAT(ended.out, ::testing::HasSubstr("rx 65 %, y 23 %"));
    std::istringstream lines(read_text(folder / "out/energies.csv"));
    std::string line;
    size_t count = 0;
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::vector<std::string> row;
        for (std::string cell; std::getline(fields, cell, ',');) row.push_back(cell);
        if (row.size() < 14 || row[3] != "engine") continue;
        ++count;
        double world = 0, principal = 0;
        for (size_t c = 8; c < 11; ++c) world += std::stod(row[c]);
        for (size_t c = 11; c < 14; ++c) {
            principal += std::stod(row[c]);
            EXPECT_GE(std::stod(row[c]), 0);
        }
        EXPECT_NEAR(world, principal, 1e-9);
    }
    EXPECT_EQ(count, 6u);
}

// Oracle: one body has all of the kinetic energy of each mode, however it stands in the world; directions add up to it.
TEST(Energies, ATurnedBodyHasAllOfIt) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
[[body]]
name = "block"
mass = 3
inertia = [0.04, 0.07, 0.05]
rotation = { axis = [1, -2, 0.5], angle = "50 deg" }
markers.corner = [0.1, 0.2, -0.15]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "block.corner"
stiffness = [900, 1500, 2100]
rotational_stiffness = [40, 60, 90]
)");
    const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out", "--count", "6"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::istringstream lines(read_text(folder / "out/energies.csv"));
    size_t count = 0;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line);
        std::vector<std::string> row;
        for (std::string cell; std::getline(fields, cell, ',');) row.push_back(cell);
        if (row[3] != "block") continue;
        ++count;
        double sum = 0;
        for (size_t c = 5; c < 11; ++c) sum += std::stod(row[c]);
        EXPECT_NEAR(std::stod(row[4]), 1, 1e-9);
        EXPECT_NEAR(sum, 1, 1e-9);
    }
    EXPECT_EQ(count, 6u);
}

}  // namespace
}  // namespace dttmm::host
