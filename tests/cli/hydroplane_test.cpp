// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace dttmm::host
