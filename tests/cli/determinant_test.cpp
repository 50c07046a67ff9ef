// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes --determinant`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

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

}  // namespace
}  // namespace dttmm::host
