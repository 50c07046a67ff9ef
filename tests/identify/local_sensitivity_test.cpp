// SPDX-License-Identifier: BSD-3-Clause
#include "identify/local_sensitivity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "identify/figures_of.h"

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

}  // namespace
}  // namespace dttmm::host
