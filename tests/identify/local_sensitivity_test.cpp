// SPDX-License-Identifier: BSD-3-Clause
#include "identify/local_sensitivity.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "identify/figures_of.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

// Oracle: differences so near that a slider slips in the same steps. At 2 % of its force it slips in others: 241 for 823.
TEST(DifferencesOfFigures, ShrinkUntilTheyHold) {
    const FiguresOf figures(example("minimal_law"), {"slip"}, {"damper.force.z:final,rms"},
                            {{"--plugin", test::paths::jenkins()}});
    const LocalSensitivity found = differentiate_figures(figures.function(), 2);
    const Eigen::MatrixXd slopes = figures.differences(2e-5);
    for (Eigen::Index f = 0; f < 2; ++f) EXPECT_NEAR(found.slopes(f, 0) / slopes(f, 0), 1, 1e-5);
    EXPECT_NEAR(slopes(0, 0), 823, 1) << "as a stranger found it";
}

/// The damping ratio of a mass on a spring and damper whose damping is an expression in c [N s/m], here 30, by ln c.
LocalSensitivity of_damping(const std::filesystem::path& folder, const std::string& damping) {
    const std::filesystem::path file = folder / "model.toml";
    write_text(file, fmt::format(R"(format = "dttmm/1"
dofs = ["z"]
[parameters]
c = "30 N*s/m"
[[body]]
name = "b"
mass = 2.5
inertia = [1, 1, 1]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 4e4
damping = "={}"
)",
                                 damping));
    return differentiate_figures(FiguresOf(file, {"c"}, {"damped1.damping_ratio"}).function(), 2);
}

const double kUnit = 30 / (2 * std::sqrt(4e4 * 2.5));  // the damping ratio of 30 N s/m

// Oracle: the slope of the side on which the file's value lies.
TEST(DifferencesOfFigures, KnowKinksAndJumpsBesideThem) {
    const TemporaryFolder folder;
    for (const double beside : {3e-7, 4e-6, 5e-5, 7e-4, 2.5e-3, 4e-3, 7e-3, 9e-3, 0.013, 0.018}) {
        const LocalSensitivity kink = of_damping(folder.path(), fmt::format("c + 0.3*abs(c - 30*(1 + {}))", beside));
        EXPECT_NEAR(kink.slopes(0, 0), 0.7 * kUnit, kink.errors(0, 0) + 1e-9) << "a kink at a share of " << beside;
        const LocalSensitivity jump = of_damping(folder.path(), fmt::format("c*(1 + 1e-3*sign(c - 30*(1 + {})))", beside));
        EXPECT_NEAR(jump.slopes(0, 0), (1 - 1e-3) * kUnit, jump.errors(0, 0) + 1e-9) << "a jump at a share of " << beside;
        if (beside < 1e-3) continue;  // what is nearer is not always found, but is in the error
        EXPECT_LT(kink.errors(0, 0), 2e-5 * kUnit);
        EXPECT_LT(jump.errors(0, 0), 2e-5 * kUnit);
    }
}

// Oracle: where two slopes meet at the file's value, no slope is near both; a jump adds its height over the distance.
TEST(DifferencesOfFigures, KnowKinksAndJumpsAtThem) {
    const TemporaryFolder folder;
    EXPECT_GT(of_damping(folder.path(), "c + 0.3*abs(c - 30)").errors(0, 0), 0.3 * kUnit * (1 - 1e-3));
    const LocalSensitivity jump = of_damping(folder.path(), "c*(1 + 1e-3*sign(c - 30))");
    EXPECT_NEAR(jump.slopes(0, 0), kUnit, jump.errors(0, 0) + 1e-9);
}

}  // namespace
}  // namespace dttmm::host
