// SPDX-License-Identifier: BSD-3-Clause
#include "identify/run_derivatives.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <regex>

#include "identify/figures_of.h"
#include "model/index.h"
#include "record/temporary_folder.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// Figures with their derivatives, or the reason why there are none.
class Derivatives : public FiguresOf {
public:
    Derivatives(const std::filesystem::path& file, const std::vector<std::string>& parameters,
                const std::vector<std::string>& figures,
                const std::vector<std::pair<std::string, std::string>>& options = {})
        : FiguresOf(file, parameters, figures, options), is_direct_(differentiate_run(function(), 2, found_, reason_)) {}
    bool is_direct() const { return is_direct_; }
    const std::string& reason() const { return reason_; }
    const LocalSensitivity& found() const { return found_; }

private:
    LocalSensitivity found_;
    std::string reason_;
    bool is_direct_;
};

struct Example {
    std::string name;
    std::vector<std::string> parameters, figures;
    std::string duration;
    double distance;  ///< of differences: larger where rounding counts, smaller where histories bend
};
void PrintTo(const Example& one, std::ostream* out) { *out << one.name; }

class DerivativesOfExamples : public testing::TestWithParam<Example> {};

// Oracle: differences of whole runs, over times in which their phases do not yet run apart. Cubic springs, a start in
// equilibrium, supports that move, beams between bodies, Maxwell series, joints with springs along lines.
TEST_P(DerivativesOfExamples, AreThoseOfDifferencesOfRuns) {
    const Example& given = GetParam();
    const Derivatives model(example(given.name), given.parameters, given.figures, {{"--duration", given.duration}});
    ASSERT_TRUE(model.is_direct()) << model.reason();
    const Eigen::MatrixXd slopes = model.differences(given.distance);
    for (Eigen::Index f = 0; f < slopes.rows(); ++f) {
        const double largest = std::max(slopes.row(f).cwiseAbs().maxCoeff(), std::abs(model.found().figures(f)));
        ASSERT_GT(largest, 1e-3) << model.figures()[as_size(f)].name << " has begun";
        for (Eigen::Index p = 0; p < slopes.cols(); ++p) {
            EXPECT_NEAR(model.found().slopes(f, p), slopes(f, p), 1e-6 * largest)
                << model.figures()[as_size(f)].name << " by " << given.parameters[as_size(p)];
            EXPECT_LT(model.found().errors(f, p), 5e-6 * largest) << model.figures()[as_size(f)].name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Of, DerivativesOfExamples,
    testing::Values(Example{"hardening_mount", {"m", "k", "k3"}, {"mount.force.z:rms,final,mean"}, "0.03 s", 1e-3},
                    Example{"engine_that_sags", {"k", "k3", "torque"}, {"mount*.force.z:rms,final"}, "0.1 s", 1e-3},
                    Example{"shock_table", {"height", "k"}, {"mount.force.z:rms,final"}, "20 ms", 1e-3},
                    Example{
                        "cylinder_head", {"gas", "k", "loose"}, {"shank1.force.x:rms", "shank*.force.x:rms"}, "20 ms", 1e-3},
                    Example{"compressor_on_rubber", {"Omega", "u"}, {"mount1.force.z:rms,final"}, "0.1 s", 1e-4},
                    Example{"andrews_squeezer", {"mom", "c0"}, {"spring.force:rms,final"}, "5 ms", 1e-4}),
    [](const testing::TestParamInfo<Example>& one) { return one.param.name; });

/// An undamped vibration of one mass that starts with a velocity.
std::string vibration(double k, const std::string& more = "") {
    return fmt::format(R"(format = "dttmm/1"
[parameters]
k = "{} N/m"
v = "0.7 m/s"
[simulation]
duration = "10 s"
step = "0.5 ms"
{}
[[body]]
name = "b"
mass = 2.5
inertia = [1, 1, 1]
velocity = [0, 0, "=v"]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = ["=k", "=k", "=k"]
)",
                       k, more);
}

// Oracle: the trapezoidal rule in closed form: x(n) = v/w sin(n q), q = 2 atan(w h/2). After 320 periods a difference at 1 %
// of the stiffness would be that of other phases.
TEST(DerivativesOfRuns, DoNotLoseALongVibration) {
    constexpr double k = 1e5, m = 2.5, v = 0.7, h = 5e-4, steps = 20000;
    const TemporaryFolder folder;
    write_text(folder / "model.toml", vibration(k));
    const Derivatives model(folder / "model.toml", {"k", "v"}, {"b.position.z:final"});
    ASSERT_TRUE(model.is_direct()) << model.reason();
    const double w = std::sqrt(k / m), q = 2 * std::atan(w * h / 2);
    const double q_by_ln_k = h / (1 + std::pow(w * h / 2, 2)) * w / 2;
    const double x = v / w * std::sin(steps * q), slope = -0.5 * x + v / w * std::cos(steps * q) * steps * q_by_ln_k;
    EXPECT_NEAR(model.found().figures(0), x, 1e-8 * v / w);
    EXPECT_NEAR(model.found().slopes(0, 0), slope, 1e-10 * std::abs(slope));
    EXPECT_LT(model.found().errors(0, 0), 1e-8 * std::abs(slope));
    EXPECT_LE(std::abs(model.found().slopes(0, 0) - slope), model.found().errors(0, 0)) << "what it is told to be";
    EXPECT_NEAR(model.found().slopes(0, 1), x, 1e-6 * std::abs(slope));
}

// Explicit schemes remember more than one step.
TEST(DerivativesOfRuns, OfExplicitSchemes) {
    const TemporaryFolder folder;
    for (const char* scheme : {"fox-euler", "houbolt", "park"}) {
        write_text(folder / "model.toml", vibration(1e5, fmt::format("coupling = \"explicit\"\nscheme = \"{}\"", scheme)));
        const Derivatives model(folder / "model.toml", {"k"}, {"b.position.z:final,rms"}, {{"--duration", "0.05 s"}});
        ASSERT_TRUE(model.is_direct()) << model.reason();
        const Eigen::MatrixXd slopes = model.differences(1e-3);
        for (Eigen::Index f = 0; f < 2; ++f)
            EXPECT_NEAR(model.found().slopes(f, 0), slopes(f, 0), 1e-6 * std::abs(slopes(f, 0))) << scheme;
    }
}

// A stop hit within the time: ODE has the last word on it, in the run and in its neighbours.
TEST(DerivativesOfRuns, PassAStop) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
[parameters]
k = "900 N/m"
v = "0.4 m/s"
[simulation]
duration = "0.2 s"
step = "1 ms"
[[body]]
name = "b"
mass = 2.5
inertia = [1, 1, 1]
velocity = [0, 0, "=v"]
[[joint]]
name = "guide"
type = "slider"
between = ["ground", "b"]
axis = [0, 0, 1]
limits = ["-1 m", "15.2 mm"]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = ["=k", "=k", "=k"]
)");
    const Derivatives model(folder / "model.toml", {"k", "v"}, {"b.position.z:final,maximum"});
    ASSERT_TRUE(model.is_direct()) << model.reason();
    EXPECT_NEAR(model.found().figures(1), 0.0152, 1e-9) << "it reaches the stop";
    const Eigen::MatrixXd slopes = model.differences(1e-5);
    for (Eigen::Index p = 0; p < 2; ++p)
        EXPECT_NEAR(model.found().slopes(0, p), slopes(0, p), 1e-5 * slopes.row(0).cwiseAbs().maxCoeff());
    EXPECT_NEAR(model.found().slopes(1, 1), 0, 1e-9) << "the stop stays where it is";
}

TEST(DerivativesOfRuns, SayWhyThereAreNone) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", vibration(1e5));
    const Derivatives to_a_tolerance(folder / "model.toml", {"k"}, {"b.position.z:final"},
                                     {{"--tolerance", "1 %"}, {"--duration", "10 ms"}});
    EXPECT_FALSE(to_a_tolerance.is_direct());
    EXPECT_THAT(to_a_tolerance.reason(), HasSubstr("tolerance"));
    write_text(folder / "model.toml",
               std::regex_replace(vibration(1e5), std::regex("duration = \"10 s\""), "duration = \"=k/10000\""));
    const Derivatives of_the_duration(folder / "model.toml", {"k"}, {"b.position.z:final"});
    EXPECT_FALSE(of_the_duration.is_direct());
    EXPECT_THAT(of_the_duration.reason(), HasSubstr("duration"));
    const Derivatives law(example("minimal_law"), {"slip"}, {"damper.force.z:peak"}, {{"--plugin", test::paths::jenkins()}});
    EXPECT_FALSE(law.is_direct());
    EXPECT_THAT(law.reason(), testing::AllOf(HasSubstr("model.toml:32"), HasSubstr("damper"), HasSubstr("remembers")));
    const Derivatives plugin(example("minimal_plugin"), {"k1"}, {}, {{"--plugin", test::paths::c_spring()}});
    EXPECT_FALSE(plugin.is_direct());
    EXPECT_THAT(plugin.reason(), HasSubstr(DTTMM_DERIVATIVE));
}

}  // namespace
}  // namespace dttmm::host
