// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mode_derivatives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "identify/figures_of.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

struct Machine {
    std::string name;
    std::vector<std::string> parameters;
    double bound;  ///< share of the frequency
};
void PrintTo(const Machine& one, std::ostream* out) { *out << one.name; }

LocalSensitivity differentiate(const FiguresOf& figures) {
    LocalSensitivity found;
    found.figures.setZero(as_row(figures.figures().size()));
    found.slopes = found.errors = found.competing = found.reach =
        Eigen::MatrixXd::Zero(found.figures.size(), figures.function().nominal().size());
    std::string reason;
    EXPECT_TRUE(differentiate_modes(figures.function(), 2, found, reason)) << reason;
    return found;
}

class FrequencySlopes : public testing::TestWithParam<Machine> {};

// Oracle: differences of frequencies, of machines whose frequencies are apart: trees of beams and masses, beams between
// bodies, positions and lengths, hinges, machines about their equilibrium.
TEST_P(FrequencySlopes, AreThoseOfDifferences) {
    const Machine& given = GetParam();
    const FiguresOf figures(example(given.name), given.parameters, {"mode*.frequency"}, {{"--count", "6"}});
    const LocalSensitivity found = differentiate(figures);
    const Eigen::MatrixXd slopes = figures.differences(1e-3);
    EXPECT_GT(found.slopes.cwiseAbs().maxCoeff(), 1e-3);
    for (Eigen::Index f = 0; f < slopes.rows(); ++f)
        for (Eigen::Index p = 0; p < slopes.cols(); ++p) {
            const double bound = given.bound * std::max(std::abs(found.figures(f)), slopes.row(f).cwiseAbs().maxCoeff());
            EXPECT_NEAR(found.slopes(f, p), slopes(f, p), bound)
                << figures.figures()[as_size(f)].name << " by " << given.parameters[as_size(p)];
            EXPECT_LE(found.errors(f, p), bound) << figures.figures()[as_size(f)].name;
        }
}

INSTANTIATE_TEST_SUITE_P(
    Of, FrequencySlopes,
    testing::Values(Machine{"hydroplane", {"kh"}, 1e-8}, Machine{"headstock_on_bolts", {"kb", "front", "s1"}, 1e-8},
                    Machine{"pump_on_mounts", {"k", "k1"}, 1e-8}, Machine{"cylinder_head", {"R", "L", "k"}, 1e-8},
                    Machine{"pendulum_on_bolts", {"d", "depth", "k"}, 1e-7},
                    Machine{"inverted_pendulum", {"m", "l", "J"}, 1e-8}, Machine{"engine_that_sags", {"k", "k3", "s"}, 1e-7},
                    Machine{"stiff_bolts", {"k1"}, 1e-8}),
    [](const testing::TestParamInfo<Machine>& one) { return one.param.name; });

// Oracle: an inverted pendulum on a spring that is too weak: f = -sqrt((m g l - k)/(J + m l^2))/(2 pi).
TEST(FrequencySlopesOf, AMotionThatGrows) {
    const double k = 80, m = 12, l = 0.85, J = 0.75, inertia = J + m * l * l;
    const FiguresOf figures(example("inverted_pendulum"), {"k"}, {"mode1.frequency"}, {{"--set", "k=80 N*m/rad"}});
    const LocalSensitivity found = differentiate(figures);
    const double rate = 2 * M_PI * std::abs(found.figures(0));
    ASSERT_LT(found.figures(0), 0);
    EXPECT_NEAR(rate * rate * inertia / (m * 9.81 * l - k), 1, 1e-9);
    EXPECT_NEAR(found.slopes(0, 0), k / (2 * rate * inertia) / (2 * M_PI), 1e-8);
}

}  // namespace
}  // namespace dttmm::host
