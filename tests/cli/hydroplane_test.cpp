// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "process.h"
#include "support/hydroplane_determinant.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using test::HydroplaneDeterminant;
using Equation10 = HydroplaneDeterminant::Equation10;

std::vector<double> frequencies(const std::string& kh) {
    const TemporaryFolder folder;
    const fs::path model = fs::path(test::paths::source_dir()) / "examples" / "hydroplane" / "model.toml";
    const Ended ended = run_dttmm(folder.path(), {"modes", model, "--set", "kh=" + kh, "--json"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    return nlohmann::json::parse(ended.out).at("frequencies_hz").get<std::vector<double>>();
}

bool is_zero_between(const HydroplaneDeterminant& determinant, double low, double high) {
    return (determinant(low) > 0) != (determinant(high) > 0);
}

// Oracle: the paper's own equations, corrected. All its frequencies are single here, so that the determinant changes its
// sign at each. The same differential equations exactly on both sides: rounding parts them, by 2e-13 of the frequency.
TEST(Hydroplane, HasTheZerosOfThePapersDeterminant) {
    for (const double kh : {5.0, 20.0, 160.0}) {
        const std::vector<double> found = frequencies(std::to_string(kh) + "MN/m");
        ASSERT_EQ(found.size(), 8u);
        const HydroplaneDeterminant determinant(1e6 * kh);
        for (double f : found)
            EXPECT_TRUE(is_zero_between(determinant, f * (1 - 1e-11), f * (1 + 1e-11))) << "kh " << kh << ", " << f << " Hz";
    }
}

// With eq. (10) as it is printed the symmetric frequencies are others, lower by up to 2 %.
TEST(Hydroplane, HasNotThoseOfEquation10AsPrinted) {
    const HydroplaneDeterminant printed(20e6, Equation10::printed), corrected(20e6);
    for (double f : {38.58955, 56.73838, 96.32164}) {
        EXPECT_TRUE(is_zero_between(printed, f - 1e-5, f + 1e-5)) << f;
        EXPECT_FALSE(is_zero_between(corrected, f - 1e-5, f + 1e-5)) << f;
    }
}

// Oracle: the modes of the same machine, found without time. Its history vibrates at their frequencies, lower by (ωh)²/12;
// without this they agree to 3e-6, which is the damping's share. What the run holds instead of `dofs` leaves the frequencies
// of the paper's state, but for the sixth and seventh: there the piston rod is a rigid bar.
TEST(Hydroplane, RunsInTimeAtItsFrequencies) {
    const TemporaryFolder folder;
    const fs::path example = fs::path(test::paths::source_dir()) / "examples" / "hydroplane";
    const auto modes = [&](const fs::path& model, const std::string& beams, const std::string& out) {
        const Ended ended = run_dttmm(folder.path(), {"modes", model, "--beams", beams, "-q", "-o", out});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return read_json(folder / out / "summary.json")["frequencies_hz"].get<std::vector<double>>();
    };
    const std::vector<double> paper = modes(example / "model.toml", "exact", "paper"),
                              held = modes(example / "run.toml", "exact", "held"),
                              lumped = modes(example / "run.toml", "lumped", "lumped");
    ASSERT_EQ(held.size(), 8u);
    for (const size_t m : {0u, 1u, 2u, 3u, 4u, 7u}) EXPECT_NEAR(held[m], paper[m], 2e-7 * paper[m]) << m;
    EXPECT_NEAR(held[5], 104.52526, 1e-5);
    EXPECT_NEAR(held[6], paper[6] * (1 - 8e-6), 1e-6 * paper[6]);
    const Ended run = run_dttmm(folder.path(), {"run", example / "run.toml", "-q", "-o", "run"});
    ASSERT_EQ(run.code, 0) << run.err;
    const Ended spectrum = run_dttmm(
        folder.path(), {"spectrum", "run", "-q", "-o", "found", "--from", "0.1 s", "--identify", "8", "--modes", "lumped",
                        "--channels", "tip_*.position.y,tip_*.rotation.x,tiller_left.position.y,tiller_left.rotation.x"});
    ASSERT_EQ(spectrum.code, 0) << spectrum.err;
    const auto found = read_json(folder / "found/summary.json")["identified"]["modes"];
    for (const size_t m : {0u, 1u, 2u, 3u, 4u, 7u}) {
        bool is_there = false;
        for (const auto& one : found) {
            const double recorded = one["frequency_hz"], natural = one["natural_frequency_hz"];
            if (std::abs(natural - lumped[m]) > 1e-3 * lumped[m]) continue;
            is_there = true;
            EXPECT_NEAR(natural, lumped[m], 3e-6 * lumped[m]) << m;
            EXPECT_GT(one["mac"], 0.999) << m;
            const double shift = std::pow(2 * M_PI * lumped[m] * 0.25e-3, 2) / 12;
            EXPECT_LT(recorded, lumped[m]);
            EXPECT_GT(recorded, lumped[m] * (1 - 1.02 * shift)) << m;
        }
        EXPECT_TRUE(is_there) << lumped[m];
    }
}

}  // namespace
}  // namespace dttmm::host
