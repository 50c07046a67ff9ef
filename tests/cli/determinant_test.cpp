// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes --determinant` and `--matrix`.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "cli/modes_run.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

const std::string kHydroplane =
    (std::filesystem::path(test::paths::source_dir()) / "examples/hydroplane/model.toml").string();

// Oracle: the natural frequencies, found and counted otherwise: the sign of the determinant changes at each simple one, and
// nowhere else.
TEST(Determinant, ItsSignChangesAtTheNaturalFrequenciesOfTheHydroplane) {
    const TemporaryFolder folder;
    const Ended ended = run_dttmm(folder.path(), {"modes", kHydroplane, "--json", "-o", "out", "--determinant",
                                                  "5 Hz..150 Hz:1451", "--below", "150 Hz"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto rows = read_history(folder / "out/determinant.csv");
    ASSERT_EQ(rows.size(), 1451u);
    std::vector<double> frequencies;
    const auto json = nlohmann::json::parse(ended.out);
    for (const auto& frequency : json["frequencies_hz"]) frequencies.push_back(frequency);
    ASSERT_GT(frequencies.size(), 5u);
    size_t changes = 0;
    for (size_t i = 1; i < rows.size(); ++i) {
        ASSERT_EQ(std::abs(rows[i][1]), 1);
        if (rows[i][1] == rows[i - 1][1]) continue;
        ASSERT_LT(changes, frequencies.size());
        EXPECT_GE(frequencies[changes], rows[i - 1][0]);
        EXPECT_LE(frequencies[changes++], rows[i][0]);
    }
    EXPECT_EQ(changes, frequencies.size());
}

TEST(Determinant, WrongRangesAreRefused) {
    const TemporaryFolder folder;
    for (const char* range :
         {"5..150", "5Hz..150Hz", "5Hz..150Hz:1", "150Hz..5Hz:10", "5Hz..150kg:10", "..:3", ":3", "1Hz..2Hz:9999999999"})
        EXPECT_EQ(run_dttmm(folder.path(), {"modes", kHydroplane, "-o", "out", "--determinant", range}).code, 2) << range;
}

/// overall_matrix.csv.
struct WrittenMatrix {
    std::vector<std::string> equations, unknowns, units;
    Eigen::MatrixXd U;

    size_t unknown(const std::string& name) const {
        const auto found = std::ranges::find(unknowns, name);
        EXPECT_NE(found, unknowns.end()) << name;
        return static_cast<size_t>(found - unknowns.begin());
    }
};

WrittenMatrix matrix_at(const std::string& model, const std::string& frequency) {
    const TemporaryFolder folder;
    const Ended ended = run_dttmm(folder.path(), {"modes", model, "-q", "-o", "out", "--matrix", frequency});
    EXPECT_EQ(ended.code, 0) << ended.err;
    WrittenMatrix matrix;
    std::istringstream lines(read_text(folder / "out/overall_matrix.csv"));
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line + ",");
        rows.emplace_back();
        for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
    }
    matrix.unknowns.assign(rows.at(0).begin() + 2, rows[0].end());
    matrix.units.assign(rows.at(1).begin() + 2, rows[1].end());
    matrix.U.resize(static_cast<Eigen::Index>(rows.size() - 2), static_cast<Eigen::Index>(matrix.unknowns.size()));
    for (size_t i = 2; i < rows.size(); ++i) {
        matrix.equations.push_back(rows[i][0]);
        for (size_t j = 2; j < rows[i].size(); ++j)
            matrix.U(static_cast<Eigen::Index>(i - 2), static_cast<Eigen::Index>(j - 2)) = std::stod(rows[i][j]);
    }
    return matrix;
}

// Oracle: the paper's size of (36) without the zeros of (37), and the determinant that the other option prints.
TEST(OverallMatrix, TheHydroplaneHas24EquationsForAsManyUnknowns) {
    const TemporaryFolder folder;
    ASSERT_EQ(run_dttmm(folder.path(), {"modes", kHydroplane, "-q", "-o", "out", "--determinant", "20 Hz..45 Hz:2"}).code,
              0);
    const auto rows = read_history(folder / "out/determinant.csv");
    for (const size_t row : {0u, 1u}) {
        const WrittenMatrix matrix = matrix_at(kHydroplane, fmt::format("{} Hz", row == 0 ? 20 : 45));
        ASSERT_EQ(matrix.U.rows(), 24);
        ASSERT_EQ(matrix.U.cols(), 24);
        EXPECT_EQ(std::set(matrix.unknowns.begin(), matrix.unknowns.end()).size(), 24u);
        // Rows and columns in units of their largest entries, as numbers of 1e9 N and 1e-9 m would cancel
        Eigen::MatrixXd U = matrix.U;
        double logarithm = 0;
        for (int pass = 0; pass < 6; ++pass) {
            for (Eigen::Index i = 0; i < 24; ++i) {
                const double size = U.row(i).norm(), other = U.col(i).norm();
                U.row(i) /= std::sqrt(size);
                U.col(i) /= std::sqrt(other);
                logarithm += 0.5 * (std::log10(size) + std::log10(other));
            }
        }
        const double rest = U.fullPivLu().determinant();
        EXPECT_EQ(rest > 0 ? 1 : -1, rows[row][1]);
        EXPECT_NEAR(std::log10(std::abs(rest)) + logarithm, rows[row][2], 1e-5);
    }
}

// Oracle: the shape of the mode, found otherwise. At a natural frequency the vector that the matrix makes zero has the free
// ends as they move in the mode, and at the ground the force of a spring there, k u.
TEST(OverallMatrix, ItsZeroIsTheMode) {
    const auto json = modes_of_file(kHydroplane);
    for (const size_t m : {0u, 2u, 4u}) {
        const auto& mode = json["modes"][m];
        const WrittenMatrix matrix = matrix_at(kHydroplane, fmt::format("{:.17g} Hz", mode["frequency_hz"].get<double>()));
        Eigen::MatrixXd U = matrix.U;
        Eigen::VectorXd scale = Eigen::VectorXd::Ones(24);
        for (int pass = 0; pass < 6; ++pass)
            for (Eigen::Index i = 0; i < 24; ++i) {
                U.row(i) /= std::sqrt(U.row(i).norm());
                const double size = std::sqrt(U.col(i).norm());
                U.col(i) /= size;
                scale(i) *= size;
            }
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(U, Eigen::ComputeFullV);
        const Eigen::VectorXd zero = svd.matrixV().col(23).cwiseQuotient(scale);
        const auto value = [&](const std::string& name) { return zero(static_cast<Eigen::Index>(matrix.unknown(name))); };
        const auto& shape = mode["shape"];
        const double unit = value("tip_left.free.y") / shape["tip_left"][1].get<double>();
        EXPECT_NEAR(value("tip_left.free.rx") / unit, shape["tip_left"][3].get<double>(), 1e-6);
        EXPECT_NEAR(value("tip_right.free.y") / unit, shape["tip_right"][1].get<double>(), 1e-6);
        // The foot is the root, to which the machine hands its force on; a bearing is a tip
        const double foot = 5e8 * shape["foot"][1].get<double>(), bearing = -5e8 * shape["bearing_left"][1].get<double>();
        EXPECT_NEAR(value("ground at foot.fy") / unit, foot, 1e-6 * std::abs(foot));
        EXPECT_NEAR(value("ground at bearing_left.fy") / unit, bearing, 1e-6 * std::abs(bearing));
        EXPECT_EQ(matrix.units[matrix.unknown("ground at foot.fy")], "N");
        EXPECT_EQ(matrix.units[matrix.unknown("tip_left.free.rx")], "rad");
    }
}

TEST(OverallMatrix, WrongFrequenciesAreRefused) {
    const TemporaryFolder folder;
    for (const char* frequency : {"matrix.csv", "-3 Hz", "3 kg"})
        EXPECT_EQ(run_dttmm(folder.path(), {"modes", kHydroplane, "-o", "out", "--matrix", frequency}).code, 2) << frequency;
    const Ended swept =
        run_dttmm(folder.path(), {"modes", kHydroplane, "-o", "out", "--matrix", "3 Hz", "--sweep", "kh=1 MN/m,2 MN/m"});
    EXPECT_EQ(swept.code, 2);
    EXPECT_THAT(swept.err, testing::HasSubstr("--matrix is for one case"));
}

}  // namespace
}  // namespace dttmm::host
