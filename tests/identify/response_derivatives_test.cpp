// SPDX-License-Identifier: BSD-3-Clause
#include "identify/response_derivatives.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

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
    found.slopes = found.errors = found.competing = found.reach =
        Eigen::MatrixXd::Zero(found.figures.size(), figures.function().nominal().size());
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

/// Two masses in a row on springs and dampers [kg, N/m, N s/m], F = 1 N on the second.
struct TwoMasses {
    double m1 = 2.5, m2 = 0.9, k1 = 3e4, k2 = 1.7e4, c1 = 1, c2 = 1;
    double second(double f) const {
        const std::complex<double> iw(0, 2 * std::numbers::pi * f), s1 = k1 + iw * c1, s2 = k2 + iw * c2;
        return std::abs((m1 * iw * iw + s1 + s2) / ((m1 * iw * iw + s1 + s2) * (m2 * iw * iw + s2) - s2 * s2));
    }
    /// The largest between two frequencies [Hz], where there is one peak, by thirds of ever smaller intervals.
    double peak(double low = 5, double high = 16) const {
        while (high - low > 1e-9) {
            const double a = low + (high - low) / 3, b = high - (high - low) / 3;
            (second(a) < second(b) ? low : high) = second(a) < second(b) ? a : b;
        }
        return second(low);
    }
    double next_peak() const { return peak(20, 60); }
};

double TwoMasses::*const kParameters[] = {&TwoMasses::k1, &TwoMasses::k2, &TwoMasses::m1, &TwoMasses::c1};

/// Slope of a peak by the logarithm of a parameter, from differences.
template <class Peak>
double slope_of(const TwoMasses& machine, Eigen::Index parameter, const Peak& peak) {
    const auto changed = [&](double share) {
        TwoMasses other = machine;
        other.*kParameters[parameter] *= 1 + share;
        return peak(other);
    };
    const auto slope = [&](double d) { return (changed(d) - changed(-d)) / (2 * d); };
    return (4 * slope(1e-3) - slope(2e-3)) / 3;
}

LocalSensitivity of_peaks(const TemporaryFolder& folder, const TwoMasses& machine, const std::string& to) {
    write_text(folder / "model.toml", fmt::format(R"(format = "dttmm/1"
dofs = ["z"]
[parameters]
k1 = {}
k2 = {}
m1 = {}
c1 = {}
[defaults]
body.inertia = [1, 1, 1]
[[body]]
name = "a"
mass = "=m1"
[[body]]
name = "b"
mass = {}
position = [0, 0, 1]
[[element]]
name = "s1"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = "=k1"
damping = "=c1"
[[element]]
name = "s2"
type = "spring_damper"
from = "a"
to = "b"
stiffness = "=k2"
damping = {}
)",
                                                  machine.k1, machine.k2, machine.m1, machine.c1, machine.m2, machine.c2));
    const FiguresOf figures(folder / "model.toml", {"k1", "k2", "m1", "c1"}, {"*.largest"},
                            {{"--in", "b.z"}, {"--out", "b.position.z"}, {"--from", "2 Hz"}, {"--to", to}});
    LocalSensitivity found = room_for(figures);
    std::string reason;
    EXPECT_TRUE(differentiate_responses(figures.function(), 2, found, reason)) << reason;
    return found;
}

// Oracle: differences of peaks of the closed form. A peak is as sharp as 1/70 000 of its frequency; its slope is not that
// of the curve at a fixed frequency, which changes sign within the peak.
TEST(ResponseSlopesOf, PeaksMoveWithTheMachine) {
    const TemporaryFolder folder;
    for (const double c : {200.0, 20.0, 1.0, 0.01}) {
        const TwoMasses machine{.c1 = c, .c2 = c / 3};
        const LocalSensitivity found = of_peaks(folder, machine, "16 Hz");
        const double peak = machine.peak();
        EXPECT_NEAR(found.figures(0) / peak, 1, 1e-9);
        for (Eigen::Index p = 0; p < 4; ++p) {
            const double exact = slope_of(machine, p, [](const TwoMasses& one) { return one.peak(); });
            EXPECT_NEAR(found.slopes(0, p) / peak, exact / peak, 1e-6) << "parameter " << p << ", c = " << c;
            EXPECT_LT(found.errors(0, p), 1e-4 * peak);
        }
    }
}

// Oracle: the same for two peaks of which one is 0.3 % larger, as of a tuned absorber.
TEST(ResponseSlopesOf, TheNextPeakHasItsSlopeAndReach) {
    const TemporaryFolder folder;
    TwoMasses machine{.c1 = 0, .c2 = 1};
    for (double low = 0, high = 2000; high - low > 1e-9;) {
        machine.c1 = (low + high) / 2;
        (machine.peak() > 1.003 * machine.next_peak() ? low : high) = machine.c1;
    }
    const LocalSensitivity found = of_peaks(folder, machine, "60 Hz");
    const double peak = machine.peak();
    ASSERT_NEAR(found.figures(0) / peak, 1, 1e-9);
    EXPECT_NEAR(machine.second(found.competing_at(0)) / machine.next_peak(), 1, 1e-9);
    for (Eigen::Index p = 0; p < 4; ++p) {
        const double exact = slope_of(machine, p, [](const TwoMasses& one) { return one.next_peak(); });
        EXPECT_NEAR(found.competing(0, p) / peak, exact / peak, 1e-6);
        EXPECT_NEAR(found.reach(0, p) * std::abs(exact - found.slopes(0, p)) / (peak - machine.next_peak()), 1, 1e-4);
    }
}

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
