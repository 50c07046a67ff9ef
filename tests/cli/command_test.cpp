// SPDX-License-Identifier: BSD-3-Clause
//
// The command as a user meets it when nothing is wrong, and where the physics sets the limit.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;

std::string example(const std::string& name) { return test::paths::source_dir() + "/examples/" + name + "/model.toml"; }

/// Runs an example into `out` of a fresh folder and hands back its summary.
nlohmann::json summary_of(std::vector<std::string> words) {
    const TemporaryFolder folder;
    words.insert(words.begin(), "run");
    words.insert(words.end(), {"-o", "out"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
    EXPECT_TRUE(fs::exists(folder / "out/history.h5"));
    return read_json(folder / "out/summary.json");
}

double force_z(const nlohmann::json& summary, const char* bolt, const char* statistic = "final") {
    return summary["elements"][bolt]["force"]["z"][statistic].get<double>();
}

void expect_at_rest(const nlohmann::json& summary, double F1, double F2, double tolerance) {
    EXPECT_EQ(summary["status"], "completed");
    EXPECT_NEAR(force_z(summary, "bolt1"), F1, tolerance * F1);
    EXPECT_NEAR(force_z(summary, "bolt2"), F2, tolerance * F2);
    EXPECT_NEAR(force_z(summary, "bolt3"), F1, tolerance * F1);
    EXPECT_NEAR(force_z(summary, "bolt4"), F2, tolerance * F2);
}

// ---- Examples -----------------------------------------------------------------------------------------------------------

// Oracle: statics. Four equal springs share 1000 N; with one softer, F1 = F3, F2 = F4, F1 + F2 = 500 N and the plate is
// flat, F1/k1 + F1/k = 2 F2/k, hence F1 = 235.294 N, F2 = 264.706 N for k1/k = 4/5.
TEST(Command, TheFourBoltPlateComesToRest) {
    expect_at_rest(summary_of({example("four_bolt_plate")}), 250, 250, 1e-3);
    expect_at_rest(summary_of({example("four_bolt_plate"), "--set", "k1=400 N/mm"}), 4000. / 17, 4500. / 17, 1e-4);
    expect_at_rest(summary_of({example("four_bolt_plate"), "--coupling", "explicit"}), 250, 250, 1e-3);
}

TEST(Command, ThePlateOnStiffBoltsComesToRest) {
    expect_at_rest(summary_of({example("stiff_bolts")}), 4000. / 17, 4500. / 17, 1e-4);
}

// Oracle: the same plate on the built-in springs without dampers.
TEST(Command, ThePluginInCGivesWhatTheBuiltInSpringGives) {
    const nlohmann::json plugin =
        summary_of({example("minimal_plugin"), "--plugin", test::paths::c_spring(), "--set", "k1=400 N/mm"});
    const nlohmann::json built_in = summary_of({example("four_bolt_plate"), "--set", "k1=400 N/mm", "--set", "c=0"});
    for (const char* bolt : {"bolt1", "bolt2", "bolt3", "bolt4"})
        for (const char* statistic : {"peak", "final"})
            EXPECT_NEAR(force_z(plugin, bolt, statistic), force_z(built_in, bolt, statistic), 1e-9) << bolt;  // N
}

// Oracle: the same plate on springs of one plugin. Two of four bolts are of another; both meet on one body.
TEST(Command, TwoPluginsServeOneModel) {
    const TemporaryFolder folder;
    std::string text = read_text(example("minimal_plugin"));
    const size_t second_half = text.find("name      = \"bolt3\"");
    for (size_t at; (at = text.find("\"c_spring\"", second_half)) != text.npos;)
        text.replace(at, std::string("\"c_spring\"").size(), "\"spring_damper\"");
    write_text(folder / "mixed.toml", text);
    const std::string mixed_model = (folder / "mixed.toml").string();
    const nlohmann::json one = summary_of(
                             {example("minimal_plugin"), "--plugin", test::paths::c_spring(), "--set", "k1=400 N/mm"}),
                         mixed = summary_of({mixed_model, "--plugin", test::paths::c_spring(), "--set", "k1=400 N/mm"});
    for (const char* bolt : {"bolt1", "bolt2", "bolt3", "bolt4"})
        for (const char* statistic : {"peak", "final"})
            EXPECT_NEAR(force_z(mixed, bolt, statistic), force_z(one, bolt, statistic), 1e-9) << bolt;  // N
}

// Oracle: the same inputs give the same bytes.
TEST(Command, ARunRepeatsItselfToTheByte) {
    const TemporaryFolder folder;
    for (const char* out : {"first", "second"})
        ASSERT_EQ(run_dttmm(folder.path(), {"run", example("four_bolt_plate"), "--set", "k1=400 N/mm", "-o", out}).code, 0);
    const std::string first = read_text(folder / "first/history.csv");
    EXPECT_EQ(read_history(folder / "first/history.csv").size(), 1001u);
    EXPECT_EQ(first, read_text(folder / "second/history.csv"));
}

TEST(Command, ResultsAreNamedAfterTheModel) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml", kSmallModel);
    const Ended ended = run_dttmm(folder.path(), {"run", "small.toml"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.out, AllOf(HasSubstr("small\n"), HasSubstr("force.z"), HasSubstr("results in results/small")));
    EXPECT_EQ(read_history(folder / "results/small/history.csv").size(), 11u);
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "small.toml", "--quiet"}).out, "");
}

// ---- The limit of the explicit coupling ---------------------------------------------------------------------------------

// Oracle: theory: stable while omega*h < 2. The cure in the message is tried: it must work as it stands.
TEST(Command, AnExplicitRunBeyondItsLimitIsRefusedWithAStepThatWorks) {
    const TemporaryFolder folder;
    const std::string model = example("stiff_bolts");
    const Ended refused = run_dttmm(folder.path(), {"run", model, "--coupling", "explicit", "-o", "out"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_THAT(refused.err, AllOf(HasSubstr("omega*h = 21.4"), HasSubstr("body \"plate\""), HasSubstr("--step \"")));
    EXPECT_FALSE(fs::exists(folder / "out"));
    EXPECT_EQ(run_dttmm(folder.path(), {"check", model, "--coupling", "explicit"}).code, 4);

    const size_t begin = refused.err.find("--step \"") + 8;
    const std::string step = refused.err.substr(begin, refused.err.find('"', begin) - begin);
    const Ended cured = run_dttmm(folder.path(), {"run", model, "--coupling", "explicit", "--step", step, "-o", "out"});
    EXPECT_EQ(cured.code, 0) << cured.err;
    expect_at_rest(read_json(folder / "out/summary.json"), 4000. / 17, 4500. / 17, 1e-3);
}

TEST(Command, AForcedExplicitRunDivergesAndKeepsFiniteRows) {
    const TemporaryFolder folder;
    const Ended ended =
        run_dttmm(folder.path(), {"run", example("stiff_bolts"), "--coupling", "explicit", "--force", "-o", "out"});
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err,
                AllOf(HasSubstr("beyond the limit"), HasSubstr("worst at body \"plate\""), HasSubstr("omega*h = 21.4")));
    const size_t rows = read_history(folder / "out/history.csv").size();
    EXPECT_GT(rows, 0u);
    EXPECT_EQ(read_json(folder / "out/summary.json")["rows"], rows);
    EXPECT_EQ(read_json(folder / "out/summary.json")["status"], "failed");
}

// Oracle: by hand, for the translation: omega^2 = 55000, W h c/m = 4 · 1e-3 · 5000 = 20, of 20.055 in all.
TEST(Command, ADampedExplicitRunIsRefusedForItsDampersAndForcedStaysFinite) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml",
               small_model_with("stiffness = \"6e4 N/m\"", "stiffness = \"6e4 N/m\"\ndamping = \"10 N*s/mm\""));
    const Ended refused = run_dttmm(folder.path(), {"run", "small.toml", "--coupling", "explicit"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_THAT(refused.err, AllOf(HasSubstr("body \"plate\", made by two (100 %))"),
                                   HasSubstr("with the dampers, which make 100 % of its square; stable below 2")));
    const size_t begin = refused.err.find("--step \"") + 8;
    const std::string step = refused.err.substr(begin, refused.err.find('"', begin) - begin);
    const Ended cured = run_dttmm(folder.path(), {"run", "small.toml", "--coupling", "explicit", "--step", step});
    EXPECT_EQ(cured.code, 0) << cured.err;
    EXPECT_LT(read_json(folder / "results/small/summary.json")["fastest_vibration"]["explicit_limit"]["omega_h"], 2);

    const Ended forced =
        run_dttmm(folder.path(), {"run", "small.toml", "--coupling", "explicit", "--force", "-o", "forced"});
    EXPECT_EQ(forced.code, 4);
    EXPECT_THAT(forced.err, AllOf(HasSubstr("body \"plate\" has diverged"), HasSubstr("made by two (100 %)")));
    EXPECT_GT(read_history(folder / "forced/history.csv").size(), 0u);  // refuses a number that is not finite
    EXPECT_EQ(read_json(folder / "forced/summary.json")["fastest_vibration"]["explicit_limit"]["elements"].size(), 2u);
}

// ---- The energy ledger --------------------------------------------------------------------------------------------------

/// A long run of the small model without load, kicked; `rest` goes into its [simulation].
std::string kicked_model(const std::string& rest) {
    std::string text = small_model_with("markers.left = [-0.1, 0, 0]", "markers.left = [-0.1, 0, 0]\nvelocity = [0, 0, 3]");
    text.replace(text.find("100 N"), 5, "0 N");
    text.replace(text.find("50 ms"), 5, "2 s");
    text.replace(text.find("step = \"1 ms\""), 13, rest);
    return text;
}

// A step that is too long loses energy against our will, numerical damping because it was asked for.
TEST(Command, NumericalDampingIsToldByTheEnergyItTookAndNotAsAFault) {
    const TemporaryFolder folder;
    const auto run = [&](const std::string& radius) {
        write_text(folder / "small.toml", kicked_model("step = \"1 ms\"\nspectral_radius = " + radius));
        return run_dttmm(folder.path(), {"run", "small.toml", "--step", "0.2 ms", "--output-step", "1 ms"}).err;
    };
    EXPECT_EQ(run("1"), "");
    EXPECT_EQ(run("0.9999"), "");
    EXPECT_THAT(run("0.2"), AllOf(HasSubstr("note: numerical damping (spectral_radius = 0.2) took "),
                                  HasSubstr("J turned over"), Not(HasSubstr("too long"))));
    EXPECT_THAT(run_dttmm(folder.path(), {"check", "small.toml"}).out,
                HasSubstr("implicit coupling with numerical damping (spectral_radius = 0.2), 2000 steps"));
}

/// A bar that turns by 0.01 rad per step of 1 ms about a hinge of stiffness k, without anything that damps it.
std::string spinning_bar(double k) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
duration = 1
step = "1 ms"
[[body]]
name = "bar"
mass = 1
inertia = {{ xx = 1e-4, yy = 0.0076, zz = 0.0076 }}
position = [0.15, 0, 0]
markers.eye = [-0.15, 0, 0]
velocity = [0, 0, 1.5]
angular_velocity = [0, -10, 0]
[[element]]
name = "pin"
type = "elastic_hinge"
from = "ground"
to = "bar.eye"
stiffness = {{ x = {}, y = {}, z = {}, rx = "free", ry = "free", rz = "free" }}
)",
                       k, k, k);
}

// Oracle: m ω² r = 15 N, and twice that as it sets in at once. k h²/m = 1e6 turning by 0.01 rad per step feeds a vibration
// that no step sees; in so stiff a hinge it holds no energy to speak of.
TEST(Command, AForceThatRingsFromStepToStepIsToldWithItsElement) {
    const TemporaryFolder folder;
    const auto complaint = [&](double k) {
        write_text(folder / "spin.toml", spinning_bar(k));
        const Ended ended = run_dttmm(folder.path(), {"run", "spin.toml"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.err;
    };
    EXPECT_THAT(complaint(1e12), AllOf(HasSubstr("warning: the force of element \"pin\" alternates from step to step, by"),
                                       HasSubstr("a vibration that the step of 0.001 s does not follow"),
                                       HasSubstr("a shorter step or damping of the element, or a spectral_radius of 0.9")));
    EXPECT_EQ(complaint(1e5), "");
    // It falls on a damper that stops it within 1 us: what the run has already is not advised
    write_text(folder / "damped.toml", R"(format = "dttmm/1"
[simulation]
duration = 0.01
step = "1 ms"
gravity = [2, -9.5, 1]
spectral_radius = 0.9
[[body]]
name = "b"
mass = 0.24
inertia = [0.003, 0.004, 0.005]
[[element]]
name = "e"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 6e8
rotational_stiffness = 2e7
damping = 3e5
rotational_damping = 1e4
)");
    EXPECT_THAT(run_dttmm(folder.path(), {"run", "damped.toml"}).err,
                AllOf(HasSubstr("element \"e\" alternates"), testing::Not(HasSubstr("spectral_radius"))));
}

// Oracle: a mass released on k h²/m = 1e4 swings by g about its rest, a = g cos(θ n) with θ = 2 atan(ω h/2), π but for 0.04.
// Its spring carries a hundred times as much across. A push that sets in over many steps makes nothing swing.
TEST(Command, AnAccelerationThatRingsFromStepToStepIsToldWithItsBody) {
    const TemporaryFolder folder;
    const auto complaint = [&](double g, const std::string& more, const std::string& load, double k = 2e10) {
        write_text(folder / "mass.toml", fmt::format(R"(format = "dttmm/1"
[simulation]
duration = 0.2
step = "1 ms"
gravity = [0, 0, {}]
{}
[[body]]
name = "mass"
mass = 2
inertia = [0.003, 0.004, 0.005]
[[element]]
name = "bolt"
type = "spring_damper"
from = "ground"
to = "mass"
stiffness = {}
rotational_stiffness = 2e7
[[load]]
on = "mass"
direction = [0, 1, 0]
force = {}
)",
                                                     g, more, k, load));
        const Ended ended = run_dttmm(folder.path(), {"run", "mass.toml", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.err;
    };
    const std::string push = "{ type = \"haversine\", peak = 2000, start = 0, width = 0.1 }";
    const std::string text = complaint(-9.81, "", push);
    EXPECT_THAT(text, AllOf(HasSubstr("warning: the acceleration of \"mass\" alternates from step to step, by"),
                            HasSubstr("and is 9.81 m/s^2 at most, though no force of an element alternates by a tenth"),
                            HasSubstr("a vibration of something light or stiff that the step of 0.001 s does not follow"),
                            HasSubstr("try a shorter step, or a spectral_radius of 0.9")));
    EXPECT_NEAR(std::stod(text.substr(text.find("step, by ") + 9)), 9.81, 0.08 * 9.81) << "a mean over ten rows";
    // 0.028 m/s^2 has a warning, 0.011 has none
    EXPECT_THAT(complaint(-0.03, "", push), HasSubstr("\"mass\" alternates"));
    EXPECT_EQ(complaint(-0.012, "", push), "");
    // The bolt's force alternates by 18.3 N: more than a tenth of 120 N, less than one of 260 N
    EXPECT_THAT(complaint(-9.81, "", "{ type = \"haversine\", peak = 120, start = 0, width = 0.1 }"),
                HasSubstr("the force of element \"bolt\" alternates"));
    EXPECT_THAT(complaint(-9.81, "", "{ type = \"haversine\", peak = 260, start = 0, width = 0.1 }"),
                HasSubstr("the acceleration of \"mass\" alternates"));
    // With the advice it dies out
    EXPECT_THAT(complaint(-9.81, "spectral_radius = 0.9", push),
                testing::MatchesRegex("note: the acceleration of [^;]*; it has died out at the end\n"));
    EXPECT_EQ(complaint(-9.81, "start = \"equilibrium\"", push), "");
    // A load faster than the step does the same: the warning names the load
    EXPECT_THAT(complaint(0, "", "{ type = \"sine\", amplitude = 100, frequency = 450 }", 1000),
                AllOf(HasSubstr("load number 1 has a part at 450 Hz"), testing::Not(HasSubstr("the acceleration of"))));
}

// Oracle: under Newmark's rule the ledger of small vibrations closes at every step; the explicit scheme's is off by
// (omega h)²/4 or so.
TEST(Command, AnEnergyThatDoesNotCloseIsToldWithItsCause) {
    const TemporaryFolder folder;
    const auto complaint = [&](const std::string& step, const std::string& more) {
        std::string text = kicked_model(fmt::format("step = \"{}\"\n{}", step, more));
        write_text(folder / "small.toml",
                   text.replace(text.find("step = \"5 ms\"\n\n"), 13, fmt::format("step = \"{}\"", step)));
        const Ended ended = run_dttmm(folder.path(), {"run", "small.toml"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.err;
    };
    EXPECT_EQ(complaint("1 ms", ""), "");
    EXPECT_EQ(complaint("5 ms", ""), "");
    EXPECT_THAT(complaint("8 ms", "coupling = \"explicit\""),
                AllOf(HasSubstr("unaccounted for"),
                      HasSubstr("J at most: near the limit of the explicit coupling or beyond it, omega*h = 1.8")));
}

// A stiff pendulum that turns 0.6 rad per step, 6 over omega*h. Both cures of the message are tried.
TEST(Command, AStiffPendulumThatFeedsItsPinIsToldHowToBeCalmed) {
    const TemporaryFolder folder;
    const std::string text =
        "format = \"dttmm/1\"\n[simulation]\nduration = 2\nstep = 0.001\n[[body]]\nname = \"arm\"\nmass = 2\ninertia = "
        "[0.02, 0.2, "
        "0.2]\nposition = [0.3, 0, 0]\nvelocity = [0, 0, -180]\nangular_velocity = [0, 600, 0]\nmarkers.pin = [-0.3, 0, 0]\n"
        "[[element]]\nname = \"pin\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"arm.pin\"\nstiffness = 1e8\n";
    write_text(folder / "small.toml", text);
    const std::string err = run_dttmm(folder.path(), {"run", "small.toml"}).err;
    EXPECT_THAT(err, AllOf(HasSubstr("body \"arm\" turns 0."), HasSubstr("rad per step on elements of omega*h = 9.747 ("),
                           HasSubstr("made by pin (100 %)"), HasSubstr(", or a spectral_radius of 0.9")));
    const size_t begin = err.find("--step \"") + 8;
    const std::string step = err.substr(begin, err.find('"', begin) - begin);
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "small.toml", "--step", step}).err, "");
    std::string damped = text;
    write_text(folder / "small.toml",
               damped.replace(damped.find("step = 0.001"), 12, "step = 0.001\nspectral_radius = 0.9"));
    EXPECT_THAT(run_dttmm(folder.path(), {"run", "small.toml"}).err, Not(HasSubstr("warning")));
}

// ---- Questions ----------------------------------------------------------------------------------------------------------

// Oracle: omega*h by hand: the fastest mode of the plate is the vertical one or a tilt; 109.84 Hz times 2 pi times 1 ms.
TEST(Command, CheckSaysWhatWouldBeSolvedAndWritesNothing) {
    const TemporaryFolder folder;
    const Ended ended = run_dttmm(folder.path(), {"check", example("four_bolt_plate")});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(
        ended.out,
        AllOf(HasSubstr(": valid\n"), HasSubstr("1 body"), HasSubstr("4 elements"),
              HasSubstr("implicit coupling, 1000 steps"), HasSubstr("omega*h = 0.690"),
              HasSubstr("109.84 Hz at body \"plate\", made by bolt1 (25 %), bolt2 (25 %), bolt3 (25 %) and 1 more")));
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Command, AChannelPatternThatMatchesNothingIsNamedWithItsPlace) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", small_model_with("step = \"5 ms\"", "step = \"5 ms\"\nchannels = [\"two.forse\"]"));
    const Ended ended = run_dttmm(folder.path(), {"check", "model.toml"});
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("model.toml:13:12: "), HasSubstr("two.forse"), HasSubstr("matches no channel")));
}

// A load is looked at once per step: a pulse between two steps would vanish without a word.
TEST(Command, WarnsOfAPulseThatIsShorterThanAStep) {
    const TemporaryFolder folder;
    write_text(
        folder / "model.toml",
        small_model_with("\"100 N\"", "{ type = \"haversine\", peak = 1e6, start = \"0.3 ms\", width = \"0.4 ms\" }"));
    const Ended ended = run_dttmm(folder.path(), {"check", "model.toml"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("warning: "), HasSubstr("model.toml:24:1: "),
                                 HasSubstr("load number 1 has a part at 2500 Hz, 0.4 steps per period"),
                                 HasSubstr("or it is lost between two steps")));
}

// What the ledger cannot account for is told: a stiff pendulum that turns 0.9 rad per step.
TEST(Command, WarnsOfAnEnergyBalanceThatDoesNotClose) {
    const TemporaryFolder folder;
    write_text(folder / "pendulum.toml", R"(format = "dttmm/1"
simulation = { duration = 1, step = 1e-3, gravity = [0, 0, -9.81] }
[[body]]
name = "rod"
mass = 1
inertia = [0.01, 0.05, 0.06]
center_of_mass = [0.5, 0, 0]
angular_velocity = [0, 900, 0]
[[element]]
name = "pivot"
type = "spring_damper"
from = "ground"
to = "rod"
stiffness = 1e8
)");
    const Ended ended = run_dttmm(folder.path(), {"run", "pendulum.toml", "-o", "out"});
    EXPECT_THAT(ended.err, HasSubstr("energy balance leaves"));
    read_history(folder / "out/history.csv");  // whole rows, every number finite
}

// Oracle: the plugins' own tables.
TEST(Command, ElementsPrintsThePluginsTables) {
    const Ended ended = run_dttmm("/", {"elements", "--plugin", test::paths::c_spring()});
    EXPECT_EQ(ended.code, 0);
    for (const char* word : {"plugin built in: ", "spring_damper", "rotational_stiffness", "N*m*s/rad", "c_spring",
                             "required", "minimal plugin 1.0"})
        EXPECT_THAT(ended.out, HasSubstr(word));
}

TEST(Command, AnswersVersionAndHelp) {
    EXPECT_THAT(
        run_dttmm("/", {"--version"}).out,
        MatchesRegex("dttmm " DTTMM_VERSION "\nODE [0-9.]+, Eigen 3[0-9.]+, HDF5 [0-9.]+, fmt [0-9.]+\nBSD-3-Clause\n"));
    const Ended help = run_dttmm("/", {"--help"}), run_help = run_dttmm("/", {"run", "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, AllOf(HasSubstr("run "), HasSubstr("check "), HasSubstr("elements ")));
    EXPECT_EQ(run_help.code, 0);
    for (const char* option : {"--output", "--set", "--sweep", "--jobs", "--step", "--tolerance", "--duration", "--coupling",
                               "--plugin", "--force", "--quiet"})
        EXPECT_THAT(run_help.out, HasSubstr(option));
}

// Oracle: the rows and columns asked for; a value that does not fit is refused under the option's name.
TEST(Command, RowsAndChannelsCanBeChosenWithoutChangingTheFile) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml", kSmallModel);
    const auto run = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"run", "small.toml", "-q", "-o", "out"});
        return run_dttmm(folder.path(), words);
    };
    EXPECT_EQ(run({"--output-step", "10 ms", "--channels", "two.force", "--channels", "plate.pos*"}).code, 0);
    EXPECT_EQ(read_history(folder / "out/history.csv").size(), 6u);
    EXPECT_THAT(read_text(folder / "out/history.csv"),
                testing::StartsWith("time,two.force.x,two.force.y,two.force.z,plate.position.x,plate.position.y,plate."
                                    "position.z\ns,N,N,N,m,m,m\n"));
    const Ended uneven = run({"--output-step", "1.5 ms"});
    EXPECT_EQ(uneven.code, 3);
    EXPECT_THAT(uneven.err, testing::StartsWith("--output-step: output-step must be a whole multiple of the time "
                                                "step (0.001 s), got 0.0015 s; 0.001 s or 0.002 s would fit"));
    const Ended nothing = run({"--channels", "three"});
    EXPECT_EQ(nothing.code, 3);
    EXPECT_THAT(nothing.err, testing::StartsWith("--channels: the pattern \"three\" matches no channel; the nearest is"));
}

// Oracle: the columns of a run; what is recorded on request only is marked.
TEST(Command, ChannelsAreListed) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml", kSmallModel);
    const Ended two = run_dttmm(folder.path(), {"channels", "small.toml", "two.force"});
    EXPECT_EQ(two.code, 0) << two.err;
    EXPECT_EQ(two.out, "two.force.x  N\ntwo.force.y  N\ntwo.force.z  N\n");
    const Ended all = run_dttmm(folder.path(), {"channels", "small.toml"});
    EXPECT_THAT(all.out, testing::StartsWith("time "));
    EXPECT_THAT(all.out, testing::ContainsRegex("\nplate.left.position.x +m +.on request.\n"));
    EXPECT_THAT(all.out, testing::ContainsRegex("\nplate.left.acceleration.x +m/s.2\n"));
    EXPECT_EQ(run_dttmm(folder.path(), {"channels", "small.toml", "three"}).code, 3);
    // A model for statics and modes has no duration
    write_text(folder / "resting.toml", small_model_with("duration = ", "# duration = "));
    const Ended resting = run_dttmm(folder.path(), {"channels", "resting.toml"});
    EXPECT_EQ(resting.code, 0) << resting.err;
    EXPECT_EQ(resting.out, all.out);
}

}  // namespace
}  // namespace dttmm::host
