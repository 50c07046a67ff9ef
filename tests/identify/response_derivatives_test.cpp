// SPDX-License-Identifier: BSD-3-Clause
#include "identify/response_derivatives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "identify/figures_of.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

struct Vibration {
    std::string name;
    std::vector<std::string> parameters;
    std::vector<std::pair<std::string, std::string>> options;
};
void PrintTo(const Vibration& one, std::ostream* out) { *out << one.name; }

LocalSensitivity room_for(const FiguresOf& figures) {
    LocalSensitivity found;
    found.figures.setZero(as_row(figures.figures().size()));
    found.slopes = found.errors = Eigen::MatrixXd::Zero(found.figures.size(), figures.function().nominal().size());
    return found;
}

class ResponseSlopes : public testing::TestWithParam<Vibration> {};

// Oracle: differences of responses at two given frequencies: beams, rigid parts, materials by rows, loads by parameters,
// forces of elements and motions of bodies, about an equilibrium.
TEST_P(ResponseSlopes, AreThoseOfDifferences) {
    const Vibration& given = GetParam();
    const FiguresOf figures(example(given.name), given.parameters, {"*.largest"}, given.options);
    LocalSensitivity found = room_for(figures);
    std::string reason;
    ASSERT_TRUE(differentiate_responses(figures.function(), 2, found, reason)) << reason;
    const Eigen::MatrixXd slopes = figures.differences(5e-4);
    EXPECT_GT(slopes.cwiseAbs().maxCoeff(), 0);
    double largest = 0;
    for (Eigen::Index f = 0; f < slopes.rows(); ++f) {
        const double size = std::max(std::abs(found.figures(f)), slopes.row(f).cwiseAbs().maxCoeff());
        if (size < 1e-9 * found.figures.maxCoeff()) continue;  // rounding
        largest = std::max(largest, slopes.row(f).cwiseAbs().maxCoeff() / size);
        for (Eigen::Index p = 0; p < slopes.cols(); ++p) {
            EXPECT_NEAR(found.slopes(f, p), slopes(f, p), 1e-7 * size)
                << figures.figures()[as_size(f)].name << " by " << given.parameters[as_size(p)];
            EXPECT_LT(found.errors(f, p), 1e-7 * size);
        }
    }
    EXPECT_GT(largest, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Of, ResponseSlopes,
                         testing::Values(Vibration{"compressor_on_rubber", {"u"}, {{"--out", "mount*.force"}}},
                                         Vibration{"cylinder_head",
                                                   {"k", "L", "loose"},
                                                   {{"--in", "head.z"},
                                                    {"--out", "head.position.z"},
                                                    {"--out", "shank1.force.x"},
                                                    {"--from", "60 Hz"},
                                                    {"--to", "61 Hz"},
                                                    {"--points", "2"}}},
                                         Vibration{"pendulum_on_bolts",
                                                   {"d", "k", "c"},
                                                   {{"--in", "pendulum.x"},
                                                    {"--out", "bolt*.force"},
                                                    {"--from", "240 Hz"},
                                                    {"--to", "241 Hz"},
                                                    {"--points", "2"}}}),
                         [](const testing::TestParamInfo<Vibration>& one) { return one.param.name; });

TEST(ResponseSlopesOf, DampingOfModesIsRefused) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", read_text(example("pump_on_mounts")) + "\n[damping]\nmodal = \"2 %\"\n");
    const FiguresOf figures(
        folder / "model.toml", {"k"}, {"*.largest"},
        {{"--in", "pump.z"}, {"--out", "pump.position.z"}, {"--from", "12 Hz"}, {"--to", "13 Hz"}, {"--points", "2"}});
    LocalSensitivity found = room_for(figures);
    std::string reason;
    EXPECT_FALSE(differentiate_responses(figures.function(), 2, found, reason));
    EXPECT_THAT(reason, HasSubstr("with damping of modes it is not known how a response changes"));
}

// The largest force stands in the row of the load, and another speed has another row.
TEST(ResponseSlopesOf, LoadsWhoseFrequencyMovesAreRefused) {
    const FiguresOf figures(example("compressor_on_rubber"), {"Omega"}, {"*.largest"}, {{"--out", "mount*.force"}});
    LocalSensitivity found = room_for(figures);
    std::string reason;
    EXPECT_FALSE(differentiate_responses(figures.function(), 2, found, reason));
    EXPECT_THAT(reason, HasSubstr("the frequency of a load changes with a parameter"));
}

}  // namespace
}  // namespace dttmm::host
