// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_simulation.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::Contains;
using testing::HasSubstr;

Model with(const std::string& text, const ModelOverrides& overrides = {}) { return parse(simulation_with(text), overrides); }
std::string simulation_fault(const std::string& text, const ModelOverrides& overrides = {}) {
    return errors_of(simulation_with(text), overrides);
}

ModelOverrides with_options(std::optional<std::string> step, std::optional<std::string> duration = {},
                            std::optional<std::string> coupling = {}) {
    ModelOverrides overrides;
    overrides.step = step;
    overrides.duration = duration;
    overrides.coupling = coupling;
    return overrides;
}

TEST(ReadSimulation, SettingsAndDefaults) {
    const SimulationSettings s = with("duration = \"1 s\"\nstep = \"1 ms\"\n").simulation;
    EXPECT_EQ(s.duration, 1);
    EXPECT_EQ(s.step, 0.001);
    EXPECT_EQ(s.coupling, Coupling::implicit);
    EXPECT_EQ(s.scheme, ExplicitScheme::fox_euler);
    EXPECT_EQ(s.spectral_radius, 1);
    EXPECT_EQ(s.gravity, Eigen::Vector3d(0, 0, 0));
    const SimulationSettings t =
        with("duration = 1\nstep = 0.25\ncoupling = \"explicit\"\nscheme = \"houbolt\"\ngravity = [0, 0, \"-9.81 m/s^2\"]\n")
            .simulation;
    EXPECT_EQ(t.coupling, Coupling::explicit_);
    EXPECT_EQ(t.scheme, ExplicitScheme::houbolt);
    EXPECT_EQ(t.gravity.z(), -9.81);
}

TEST(ReadSimulation, StepMustBeReasonable) {
    for (const char* step : {"0", "-1", "1e-300", "1e-10", "1.1"})
        EXPECT_THAT(simulation_fault("duration = 2\nstep = " + std::string(step) + "\n"),
                    HasSubstr("m.toml:6:8: simulation: step must be "))
            << step;
    for (const char* step : {"nan", "inf"})
        EXPECT_THAT(simulation_fault("duration = 1\nstep = " + std::string(step) + "\n"), HasSubstr("step must be finite"))
            << step;
    EXPECT_THAT(simulation_fault("duration = 1\nstep = 1e-10\n"), HasSubstr("must be ≥ 1e-09 s"));
    EXPECT_THAT(simulation_fault("step = 1\n"), HasSubstr("m.toml:4:1: simulation: missing key \"duration\""));
    EXPECT_THAT(errors_of(std::string(kStart) + kBody), HasSubstr("missing table [simulation] with a duration"));
}

TEST(ReadSimulation, DurationIsAWholeNumberOfSteps) {
    EXPECT_THAT(simulation_fault("duration = 0.1\nstep = 0.25\n"),
                HasSubstr("m.toml:5:12: simulation: duration must be at least one step (0.25 s), got 0.1 s"));
    EXPECT_THAT(simulation_fault("duration = \"1e6 s\"\nstep = 1e-5\n"),
                HasSubstr("duration is 1e+11 steps; at most 1e+10 are allowed"));
    EXPECT_THAT(simulation_fault("duration = 1.1\nstep = 0.25\n"),
                HasSubstr("duration must be a whole number of steps, got 1.1 s / 0.25 s = 4.4; a duration of 1 s or 1.25 s "
                          "would fit, or a step of 0.22 s or 0.275 s"));
    EXPECT_NO_THROW(with("duration = 1\nstep = 0.333333333333\n"));  // within 1e-6 of a step
    EXPECT_NO_THROW(with("duration = \"18.4 ms\"\nstep = \"0.1 ms\"\n"));
}

TEST(ReadSimulation, OptionsReplaceTheFile) {
    const SimulationSettings s = with("duration = 1\nstep = 0.1\nscheme = \"park\"\ncoupling = \"explicit\"\n",
                                      with_options("2 ms", "0.5", "implicit"))
                                     .simulation;
    EXPECT_EQ(s.step, 0.002);
    EXPECT_EQ(s.duration, 0.5);
    EXPECT_EQ(s.coupling, Coupling::implicit);
    EXPECT_EQ(parse(std::string(kStart) + kBody, with_options("1 ms", "1 s")).simulation.step, 0.001);
}

TEST(ReadSimulation, ToleranceIsAShareWrittenAsANumberOrWithAUnit) {
    const std::string settings = "duration = 1\nstep = 0.1\n";
    EXPECT_FALSE(with(settings).simulation.tolerance.has_value());
    for (const char* text : {"1e-3", "\"0.1 %\"", "\"0.1%\"", "\"1e-3\"", "\"=0.001\""})
        EXPECT_DOUBLE_EQ(with(settings + "tolerance = " + text + "\n").simulation.tolerance.value_or(0), 1e-3) << text;
    ModelOverrides overrides;
    overrides.tolerance = "2 %";
    EXPECT_DOUBLE_EQ(with(settings + "tolerance = 0.1\n", overrides).simulation.tolerance.value_or(0), 0.02);
    EXPECT_DOUBLE_EQ(with(settings, overrides).simulation.tolerance.value_or(0), 0.02);
    overrides.step = "1 ms";
    overrides.duration = "1 s";
    EXPECT_DOUBLE_EQ(parse(std::string(kStart) + kBody, overrides).simulation.tolerance.value_or(0), 0.02);
}

TEST(ReadSimulation, ToleranceMustBeReasonable) {
    const std::string settings = "duration = 1\nstep = 0.1\n";
    const std::string place = "m.toml:7:13: simulation: tolerance ";
    for (const char* text : {"0", "-1", "1e-10", "\"0 %\""})
        EXPECT_THAT(simulation_fault(settings + "tolerance = " + text + "\n"), HasSubstr(place + "must be ≥ 1e-09")) << text;
    for (const char* text : {"2", "0.51", "\"200 %\""})
        EXPECT_THAT(simulation_fault(settings + "tolerance = " + text + "\n"), HasSubstr(place + "must be ≤ 0.5")) << text;
    EXPECT_THAT(simulation_fault(settings + "tolerance = nan\n"), HasSubstr("tolerance must be finite"));
    EXPECT_THAT(simulation_fault(settings + "tolerance = \"3 kg\"\n"), HasSubstr("got \"3 kg\""));
    EXPECT_THAT(simulation_fault(settings + "tolerance = \"0,1 %\"\n"), HasSubstr("m.toml:7:13: simulation: tolerance"));
    EXPECT_THAT(simulation_fault(settings + "tolerance = true\n"), HasSubstr("m.toml:7:13: simulation: tolerance"));
    EXPECT_THAT(simulation_fault(settings + "tollerance = 0.1\n"), HasSubstr("did you mean \"tolerance\"?"));
    ModelOverrides overrides;
    overrides.tolerance = "3 kg";
    EXPECT_THAT(simulation_fault(settings, overrides), HasSubstr("--tolerance: tolerance"));
    overrides.tolerance = "0";
    EXPECT_THAT(simulation_fault(settings, overrides), HasSubstr("--tolerance: tolerance must be ≥ 1e-09"));
}

TEST(ReadSimulation, FaultsOfOptionsNameThem) {
    const std::string settings = "duration = 1\nstep = 0.1\n";
    EXPECT_EQ(simulation_fault(settings, with_options("0")), "--step: step must be ≥ 1e-09 s, got 0");
    EXPECT_THAT(simulation_fault(settings, with_options("1 kg")),
                HasSubstr("--step: step: expected a value in s, got \"1 kg\""));
    EXPECT_THAT(simulation_fault(settings, with_options({}, "0.15")),
                HasSubstr("--duration: duration must be a whole number of steps"));
    EXPECT_THAT(simulation_fault(settings, with_options({}, {}, "implizit")),
                HasSubstr("--coupling: must be one of: implicit, explicit; got \"implizit\""));
}

TEST(ReadSimulation, SchemeBelongsToTheExplicitCoupling) {
    const std::string settings = "duration = 1\nstep = 0.1\n";
    EXPECT_THAT(simulation_fault(settings + "scheme = \"park\"\n"),
                HasSubstr("m.toml:7:1: simulation: scheme belongs to coupling = \"explicit\""));
    EXPECT_THAT(simulation_fault(settings + "coupling = \"explicit\"\nscheme = \"newmark\"\n"),
                HasSubstr("scheme must be one of: fox-euler, bdf1, bdf2, houbolt, park; got \"newmark\""));
    EXPECT_THAT(simulation_fault(settings + "coupling = 3\n"), HasSubstr("coupling must be a text, got a number"));
    EXPECT_THAT(simulation_fault(settings + "solver = 3\n"),
                HasSubstr("simulation: unknown key \"solver\"; known here: duration, "
                          "step, tolerance, coupling, scheme, spectral_radius, gravity"));
}

TEST(ReadSimulation, SpectralRadiusBelongsToTheImplicitCoupling) {
    const std::string settings = "duration = 1\nstep = 0.1\nspectral_radius = ";
    EXPECT_EQ(with(settings + "0.8\n").simulation.spectral_radius, 0.8);
    EXPECT_EQ(with(settings + "0\n").simulation.spectral_radius, 0);
    EXPECT_THAT(simulation_fault(settings + "1.01\n"),
                HasSubstr("m.toml:7:19: simulation: spectral_radius must be ≤ 1, got 1.01"));
    EXPECT_THAT(simulation_fault(settings + "-0.1\n"), HasSubstr("spectral_radius must be ≥ 0, got -0.1"));
    EXPECT_THAT(simulation_fault(settings + "nan\n"), HasSubstr("spectral_radius must be finite"));
    const std::string is_explicit = settings + "0.8\ncoupling = \"explicit\"\n";
    EXPECT_THAT(simulation_fault(is_explicit),
                HasSubstr("m.toml:7:1: simulation: spectral_radius belongs to coupling = \"implicit\"; the explicit"));
    EXPECT_EQ(with(is_explicit, with_options({}, {}, "implicit")).simulation.spectral_radius, 0.8);
    EXPECT_EQ(with(settings + "0.8\n", with_options({}, {}, "explicit")).simulation.coupling, Coupling::explicit_);
}

TEST(ReadSimulation, GravityInMillimetresIsWarnedOf) {
    EXPECT_THAT(with("duration = 1\nstep = 0.1\ngravity = [0, 0, -9810]\n").warnings,
                testing::Contains(
                    WarningIs("gravity-unit", HasSubstr("m.toml:7:11: simulation: gravity of 9810 m/s² looks like mm/s²"))));
    EXPECT_THAT(simulation_fault("duration = 1\nstep = 0.1\ngravity = [0, 0, 1e300]\n"),
                HasSubstr("m.toml:7:11: simulation: gravity must be 1e+07 m/s² at most, got 1e+300 m/s²"));
    EXPECT_THAT(simulation_fault("duration = 1\nstep = 0.1\ngravity = 9.81\n"),
                HasSubstr("gravity wants 3 numbers, got a number"));
}

// A model without a step is one to a tolerance, whose first step is found later.
TEST(ReadSimulation, WithoutAStepThereIsATolerance) {
    EXPECT_EQ(with("duration = 1\n").simulation.step, 0);
    EXPECT_EQ(with("duration = 1\n").simulation.tolerance, kDefaultTolerance);
    EXPECT_EQ(with("duration = 1\ntolerance = \"0.2 %\"\n").simulation.tolerance, 0.002);
    EXPECT_EQ(with("duration = 1\nstep = 0.25\n").simulation.tolerance, std::nullopt);
    EXPECT_EQ(with("duration = 1\n", with_options("0.25 s")).simulation.tolerance, std::nullopt);
    const std::string rows = "duration = 1\n[output]\nstep = ";
    EXPECT_EQ(with(rows + "0.125\n").output.step, 0.125);
    EXPECT_THAT(simulation_fault(rows + "0.3\n"),
                HasSubstr("the duration (1 s) must be a whole multiple of the output step (0.3 s): the end is a row"));
}

TEST(ReadOutput, RowsFallOnStepsAndOnTheEnd) {
    const auto output = [](const std::string& text) { return model_with("[output]\n" + text); };
    EXPECT_EQ(parse(model_with("")).output.every, 1);
    EXPECT_EQ(parse(output("step = \"20 ms\"\nchannels = [\"bolt*.force\", \"plate.position\"]\n")).output.every, 20);
    EXPECT_THAT(parse(output("channels = [\"bolt*.force\", \"q\"]\n")).output.channels,
                testing::ElementsAre("bolt*.force", "q"));
    EXPECT_THAT(errors_of(output("step = \"1.5 ms\"\n")),
                HasSubstr("m.toml:13:8: output: step must be a whole multiple of the time step (0.001 s), got 0.0015 s; "
                          "0.001 s or 0.002 s "
                          "would fit, or leave it out to record every step"));
    EXPECT_THAT(errors_of(output("step = \"0.1 us\"\n")), HasSubstr("got 1e-07 s; 0.001 s or 0.002 s would fit"));
    EXPECT_THAT(errors_of(output("step = \"30 ms\"\n")),
                HasSubstr("the duration (1 s) must be a whole multiple of the output step (0.03 s): the end is a row"));
    EXPECT_THAT(errors_of(output("channels = \"bolt\"\n")), HasSubstr("channels must be a list of texts"));
    EXPECT_THAT(errors_of(output("chanels = []\n")), HasSubstr("unknown key \"chanels\"; did you mean \"channels\"?"));
}

}  // namespace
}  // namespace dttmm::host
