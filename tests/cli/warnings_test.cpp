// SPDX-License-Identifier: BSD-3-Clause
//
// Warnings are results: on the standard error, in summary.json, and counted in the table of a sweep.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "cli/process.h"
#include "cli/small_model.h"
#include "cli/static_run.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// The codes of the warnings in a summary, in order.
std::vector<std::string> codes_in(const fs::path& summary) {
    std::vector<std::string> codes;
    const nlohmann::json json = read_json(summary);
    for (const auto& warning : json.at("warnings")) {
        codes.push_back(warning.at("code"));
        EXPECT_FALSE(warning.at("text").get<std::string>().empty());
    }
    return codes;
}

/// The small model whose second spring has no stiffness; k is a number of the file.
std::string model_with_a_free_element() { return small_model_with("\"6e4 N/m\"", "0"); }

const std::string kSpareBody = "\n[[body]]\nname = \"spare\"\nmass = 1\ninertia = [1, 1, 1]\n";

TEST(WarningsOf, ARunStandInItsSummary) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", model_with_a_free_element() + kSpareBody);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(codes_in(folder / "out/summary.json"), ElementsAre("free-element", "free-body"));
    const nlohmann::json summary = read_json(folder / "out/summary.json");
    for (const auto& warning : summary.at("warnings"))
        EXPECT_THAT(ended.err, HasSubstr("warning: " + warning.at("text").get<std::string>() + "\n"));
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out", "--tolerance", "1 %"}).code, 0);
    EXPECT_THAT(codes_in(folder / "out/summary.json"), ElementsAre("free-element", "free-body"));

    write_text(folder / "model.toml", kSmallModel);
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out", "--output-step", "1 ms"}).err, "");
    EXPECT_THAT(codes_in(folder / "out/summary.json"), ElementsAre());
}

TEST(WarningsOf, ModesAndFrfReadAsThoseOfARunAndStandInTheirSummaries) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", model_with_a_free_element());
    const std::string text =
        "warning: model.toml:33:1: element \"two\": free: every parameter is zero, it carries nothing\n";
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "run"}).err, text);
    const Ended modes = run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "modes"});
    EXPECT_EQ(modes.code, 0);
    EXPECT_EQ(modes.err, text +
                             "note: the frequencies are about the equilibrium under gravity, preloads, the loads and the "
                             "supports as they are "
                             "at the start (about = \"start\": about the machine as the file places it)\n");
    EXPECT_THAT(codes_in(folder / "modes/summary.json"), ElementsAre("free-element", "about-equilibrium"));
    const Ended about_start = run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "modes", "--about", "start"});
    EXPECT_EQ(about_start.err,
              text +
                  "note: model.toml:24:1: the frequencies are those without this lasting load: the stiffness "
                  "of its tension or pressure is not in them\n");

    const Ended frf = run_dttmm(folder.path(), {"frf", "model.toml", "-q", "-o", "frf", "--in", "plate.x", "--out",
                                                "plate.y", "--from", "1 Hz", "--to", "2 Hz", "--points", "3"});
    EXPECT_EQ(frf.code, 0);
    EXPECT_THAT(frf.err, AllOf(HasSubstr(text), HasSubstr("warning: plate.y does not move under plate.x")));
    EXPECT_THAT(codes_in(folder / "frf/summary.json"), ElementsAre("free-element", "about-equilibrium", "no-response"));
    EXPECT_EQ(read_json(folder / "frf/summary.json").at("largest_receptance"), 0);
}

// A rotor at speed: its first pair of frequencies splits by gyroscopic moments, which only a run has.
TEST(WarningsOf, WhatTurnsAtTheStartIsNotInModesFrfResponseAndStatic) {
    const TemporaryFolder folder;
    const auto told = [&](const std::string& velocity, const std::vector<std::string>& command) {
        write_text(folder / "model.toml", small_model_with("mass = \"=mass\"\n", "mass = \"=mass\"\n" + velocity + "\n"));
        std::vector<std::string> words = command;
        words.insert(words.begin() + 1, {"model.toml", "-q", "-o", "out"});
        const Ended ended = run_dttmm(folder.path(), words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.err;
    };
    const std::string note = "note: body \"plate\" turns at 628.319 rad/s at the start: ",
                      speed = "angular_velocity = [\"6000 rpm\", 0, 0]";
    const std::vector<std::string> frf = {"frf",  "--in", "plate.z", "--out",    "plate.z", "--from",
                                          "1 Hz", "--to", "2 Hz",    "--points", "3"},
                                   response = {"response", "--in", "plate.z", "--from", "1 Hz", "--to", "2 Hz"};
    for (const std::vector<std::string>& command : {{"modes"}, {"modes", "--about", "start"}, frf, response}) {
        EXPECT_THAT(told(speed, command), HasSubstr(note + "gyroscopic moments and centrifugal forces are not in the "
                                                           "frequencies and responses; a run has them\n"));
        EXPECT_THAT(codes_in(folder / "out/summary.json"), testing::Contains("velocities-not-in-modes"));
    }
    EXPECT_THAT(told(speed, {"static"}),
                HasSubstr(note + "everything is at rest here, and centrifugal forces and "
                                 "gyroscopic moments are not in the equilibrium; a run has them\n"));
    EXPECT_THAT(codes_in(folder / "out/summary.json"), testing::Contains("velocities-not-in-static"));
    for (const char* other : {"angular_velocity = [0, 0, 0]", "velocity = [0, 0, 1]"}) {
        EXPECT_THAT(told(other, {"modes"}), Not(HasSubstr("a run has them")));
        EXPECT_THAT(told(other, {"static"}), Not(HasSubstr("a run has them")));
    }
}

TEST(WarningsOf, AMovingNodeIsNamedBehindTheBodies) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml",
               small_model_with("\"100 N\"", "0") +
                   "[nodes]\ntip = { position = [3, 0, 1], velocity = [0, 2, 0] }\n[[element]]\nname = "
                   "\"girder\"\ntype = \"beam\"\nfrom = \"plate\"\nto = \"tip\"\nsection = { circle = "
                   "\"20 mm\" }\nmaterial = { E = \"210 GPa\", poisson = 0.3, density = 7850 }\n");
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out"}).err,
                HasSubstr("note: node \"tip\" moves at the start: "));
}

/// A clamped beam with a load on its free end.
std::string bar_with(const std::string& beam, const std::string& load) {
    return R"(format = "dttmm/1"
[nodes]
a = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
t = [1, 0, 0]
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "t"
)" + beam + "\n[[load]]\non = \"t\"\n" +
           load + "\n";
}

Ended told_of(const std::string& model, const std::vector<std::string>& command) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", model);
    std::vector<std::string> words = command;
    words.insert(words.begin() + 1, {"model.toml", "-q", "-o", "out"});
    return run_dttmm(folder.path(), words);
}

const std::string kNoShear = "theory = \"euler-bernoulli\"\n";

// By hand: N/EA = -1.5, of a limit of 0.5 three times as much. -1 leaves no length.
TEST(WarningsOf, ABeamThatIsPressedThroughItselfIsBeyondItsLimit) {
    const auto told = [](const std::string& force) {
        return told_of(
                   bar_with(kNoShear + "section = { EA = 1000, EIy = 1e4, EIz = 1e4, GJ = 1e4, mass = 1, inertia = 1e-4 }",
                            "direction = [-1, 0, 0]\nforce = " + force),
                   {"static"})
            .err;
    };
    EXPECT_THAT(told("1500"), HasSubstr("warning: \"bar.turn_to_limit\" is 3 at rest: beyond 1 the law of element \"bar\""));
    EXPECT_THAT(told("-501"), HasSubstr("warning: \"bar.turn_to_limit\" is 1 at rest"));
    for (const char* force : {"499", "-499"}) EXPECT_THAT(told(force), Not(HasSubstr("turn_to_limit")));
}

TEST(WarningsOf, ASectionWithoutShearNamesTheTheoryThatNeedsNone) {
    for (const char* command : {"static", "modes"}) {
        const Ended ended = told_of(bar_with("section = { EA = 1e6, EIy = 1, EIz = 1, GJ = 1, mass = 1, inertia = 1e-4 }",
                                             "direction = [0, 0, 1]\nforce = 1"),
                                    {command});
        EXPECT_EQ(ended.code, 3);
        EXPECT_THAT(ended.err, AllOf(HasSubstr("section.GAy is needed"), HasSubstr("write theory = \"euler-bernoulli\""),
                                     Not(HasSubstr("in time"))));
    }
}

TEST(WarningsOf, AVibratingLoadIsNotInTheEquilibrium) {
    const std::string beam = kNoShear + "section = { EA = 1e6, EIy = 1, EIz = 1, GJ = 1, mass = 1, inertia = 1e-4 }";
    EXPECT_THAT(
        told_of(bar_with(beam, "direction = [0, 0, 1]\nharmonic = { amplitude = 100, frequency = 10 }"), {"static"}).err,
        HasSubstr("note: model.toml:15:1: this load vibrates: it counts with 0, its mean, at every instant of --at; "
                  "`dttmm response` has it\n"));
    EXPECT_THAT(told_of(bar_with(beam, "direction = [0, 0, 1]\nforce = 1"), {"static"}).err, Not(HasSubstr("vibrates")));
}

// Above Euler's load, pi^2 EI/4 = 2.467 N, a motion grows in each plane.
TEST(WarningsOf, ModesAboutAnUnstableEquilibrium) {
    const auto told = [](const std::string& force, const std::string& about) {
        return told_of(bar_with(kNoShear + "section = { EA = 1e6, EIy = 1, EIz = 1, GJ = 1, mass = 1, inertia = 1e-4 }",
                                "direction = [-1, 0, 0]\nforce = " + force),
                       {"modes", "--about", about})
            .err;
    };
    EXPECT_THAT(told("3", "equilibrium"), HasSubstr("note: the equilibrium is unstable: 2 motions grow from it"));
    EXPECT_THAT(told("2", "equilibrium"), Not(HasSubstr("unstable")));
    EXPECT_THAT(told("3", "start"), Not(HasSubstr("unstable")));
}

// Bent by its load: one note for all beams, of the one that is bent most.
TEST(WarningsOf, BentBeamsAreNotedOnce) {
    std::string model =
        "format = \"dttmm/1\"\n[nodes]\na = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", "
        "\"ry\", \"rz\"] }\n";
    for (int i = 1; i <= 3; ++i) model += fmt::format("t{} = [1, {}, 0]\n", i, i);
    for (int i = 1; i <= 3; ++i)
        model += fmt::format(
            "[[element]]\nname = \"e{0}\"\ntype = \"beam\"\nfrom = \"a\"\nto = \"t{0}\"\nsection = "
            "{{ circle = \"20 mm\" }}\nmaterial = {{ E = \"210 GPa\", poisson = 0.3, density = 7850 }}\n"
            "[[load]]\non = \"t{0}\"\ndirection = [0, 0, 1]\nforce = {1}\n",
            i, i == 2 ? 20 : 5);
    const std::string err = told_of(model, {"modes"}).err;
    const size_t at = err.find("is bent at rest by");
    ASSERT_NE(at, std::string::npos) << err;
    EXPECT_EQ(err.find("is bent at rest by", at + 1), std::string::npos) << err;
    EXPECT_THAT(err, AllOf(HasSubstr("element \"e2\" is bent at rest by"), HasSubstr("and 2 more less, which is in")));
}

TEST(WarningsOf, ModesWithoutGravityAndLastingLoads) {
    const TemporaryFolder folder;
    const auto codes = [&](const std::string& force, const std::string& simulation) {
        std::string text = small_model_with("\"100 N\"", force);
        if (simulation.empty())
            text.erase(text.find("[simulation]"), text.find("[[body]]") - text.find("[simulation]"));
        else
            text.replace(text.find("step = \"1 ms\""), 13, "step = \"1 ms\"\n" + simulation);
        write_text(folder / "model.toml", text);
        EXPECT_EQ(run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out", "--about", "start"}).code, 0);
        return codes_in(folder / "out/summary.json");
    };
    EXPECT_THAT(codes("0", "gravity = [0, 0, -9.81]"), ElementsAre("gravity-not-in-modes"));
    EXPECT_THAT(codes("{ type = \"haversine\", peak = 9, start = \"20 ms\", width = \"2 ms\" }", "gravity = [0, 0, 0]"),
                ElementsAre());
    EXPECT_THAT(codes("{ type = \"sine\", amplitude = 9, frequency = 331 }", "gravity = [0, 0, 0]"), ElementsAre());
    EXPECT_THAT(codes("{ type = \"sine\", amplitude = 9, offset = 4, frequency = 331 }", "gravity = [0, 0, 0]"),
                ElementsAre("load-not-in-modes"));
    EXPECT_THAT(codes("7", ""), ElementsAre("load-not-in-modes"));
}

// A force per length stiffens and softens as other loads do: one that lasts at either end is told of, and changes nothing.
TEST(WarningsOf, ModesAndFrfWithoutForcesPerLength) {
    const TemporaryFolder folder;
    const std::string girder =
        "\n[nodes]\ntip = [3, 0, 1]\n[[element]]\nname = \"girder\"\ntype = \"beam\"\nfrom = \"plate\"\nto = \"tip\"\n"
        "section = { circle = \"20 mm\" }\nmaterial = { E = \"210 GPa\", poisson = 0.3, density = 7850 }\n";
    const auto codes = [&](const std::string& load, const std::vector<std::string>& command) {
        write_text(folder / "model.toml", small_model_with("\"100 N\"", "0") + girder + load);
        std::vector<std::string> words = command;
        words.insert(words.begin() + 1, {"model.toml", "-q", "-o", "out", "--about", "start"});
        const Ended ended = run_dttmm(folder.path(), words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        return codes_in(folder / "out/summary.json");
    };
    const auto load = [](const std::string& value) {
        return "[[load]]\nelement = \"girder\"\ndirection = [0, 0, 1]\nforce_per_length = " + value + "\n";
    };
    const std::vector<std::string> modes = {"modes"}, frf = {"frf",  "--in", "plate.z", "--out",    "plate.z", "--from",
                                                             "1 Hz", "--to", "2 Hz",    "--points", "3"};
    EXPECT_THAT(codes("", modes), ElementsAre());
    const nlohmann::json without = read_json(folder / "out/summary.json").at("modes");
    EXPECT_THAT(codes(load("7"), modes), ElementsAre("load-not-in-modes"));
    EXPECT_EQ(read_json(folder / "out/summary.json").at("modes"), without);
    EXPECT_THAT(codes(load("[0, \"2 kN/m\"]"), modes), ElementsAre("load-not-in-modes"));
    EXPECT_THAT(codes(load("{ type = \"sine\", amplitude = 9, frequency = 331 }"), modes), ElementsAre());
    EXPECT_THAT(codes(load("[0, \"2 kN/m\"]"), frf), ElementsAre("load-not-in-modes"));
}

TEST(WarningsOf, ModesOfSpringsThatAreNotLinear) {
    const TemporaryFolder folder;
    const auto modes = [&](const std::string& spring) {
        std::string text = small_model_with("\"100 N\"", "0");
        text.replace(text.find("stiffness = \"6e4 N/m\""), 21, spring);
        write_text(folder / "model.toml", text);
        const Ended ended = run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return codes_in(folder / "out/summary.json");
    };
    EXPECT_THAT(modes("z = { law = \"cubic\", stiffness = 6e4, cubic = 1e9 }"), ElementsAre("law-linearised"));
    EXPECT_THAT(modes("z = { law = \"linear\", stiffness = 6e4 }"), ElementsAre());
}

// A spring that has a force at the start is told with the force; one that has none is not.
TEST(WarningsOf, ModesOfSpringsWithAForceAtTheStart) {
    const TemporaryFolder folder;
    for (const char* natural : {"0.5", "0.8"}) {
        const std::string model = R"(format = "dttmm/1"
[simulation]
duration = 1
[nodes]
a = { position = [0, 0, 0.8], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[body]]
name = "b"
mass = 2
box = [0.1, 0.2, 0.3]
[[element]]
name = "s"
type = "axial_spring"
from = "a"
to = "b"
stiffness = 1000
natural_length = )" + std::string(natural);
        write_text(folder / "model.toml", model);
        for (const char* command : {"modes", "frf"}) {
            std::vector<std::string> words = {command, "model.toml", "-q", "-o", "out"};
            if (command == std::string("frf"))
                words.insert(words.end(), {"--in", "b.z", "--out", "b.z", "--from", "1", "--to", "2", "--points", "2"});
            words.insert(words.end(), {"--about", "start"});
            const Ended ended = run_dttmm(folder.path(), words);
            EXPECT_EQ(ended.code, 0) << ended.err;
            const auto codes = codes_in(folder / "out/summary.json");
            if (natural == std::string("0.8")) {
                EXPECT_THAT(codes, testing::Not(testing::Contains("force-at-start"))) << command;
            } else {
                EXPECT_THAT(codes, testing::Contains("force-at-start")) << command;
            }
        }
    }
    write_text(folder / "model.toml", read_text(folder / "model.toml") + "\nlaw = \"cubic\"\ncubic = 5\n");
    run_dttmm(folder.path(), {"modes", "model.toml", "-q", "-o", "out"});
    EXPECT_THAT(codes_in(folder / "out/summary.json"), testing::Contains("law-linearised"));
}

// Oracle: the numbers of cases with a stiffness of zero.
TEST(WarningsOf, ASweepAreCountedPerCaseAndInItsLastLine) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\nk = 7"));
    std::string text = read_text(folder / "model.toml");
    write_text(folder / "model.toml", text.replace(text.find("\"6e4 N/m\""), 9, "\"=k\""));
    const std::vector<std::string> words = {"run",       "model.toml",    "-o",  "out", "--sweep",
                                            "k=0,5,6e4", "--output-step", "1 ms"};
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.out, HasSubstr("3 of 3 cases completed (0 of them reused), 0 failed, 0 not run, 1 with warnings "
                                     "(free-element)\n"));
    std::istringstream table(read_text(folder / "out/sweep.csv"));
    std::string heading, units, first, second;
    std::getline(table, heading);
    std::getline(table, units);
    std::getline(table, first);
    std::getline(table, second);
    EXPECT_THAT(heading, StartsWith("case,mass,k,status,reason,warnings,"));
    EXPECT_THAT(first, StartsWith("case-000001,2,0,completed,,1,"));
    EXPECT_THAT(second, StartsWith("case-000002,2,5,completed,,0,"));
    EXPECT_THAT(run_dttmm(folder.path(), words).out, HasSubstr("(3 of them reused), 0 failed, 0 not run, 1 with warnings"));
}

/// A mass that a force of 80 N and 125 Hz, 8 steps per period, moves along z from rest. The springs hold it next to not at
/// all; with an element the loads have the weights of the coupling.
std::string driven_mass(const std::string& force, const std::string& simulation = "step = \"1 ms\"") {
    return "format = \"dttmm/1\"\n[parameters]\nf = \"125 Hz\"\n[simulation]\nduration = \"0.4 s\"\n" + simulation +
           "\n[[body]]\nname = \"m\"\nmass = 2\ninertia = [1, 1, 1]\n[[load]]\non = \"m\"\ndirection = [0, 0, 1]\nforce = " +
           force +
           "\n[[element]]\nname = \"k\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"m\"\nstiffness = 1e-3\n";
}

// Oracle: the position in the run itself: F/(m ω²) (1 − cos ωt), of which (a/tan a)² is left, a = pi/8; its acceleration is
// that of the instant, F/m.
TEST(WarningsOf, ALoadThatIsTooFastForTheStepSayWhatTheRunLoses) {
    const TemporaryFolder folder;
    const double pi = 3.14159265358979;
    for (const char* force :
         {"{ type = \"sine\", amplitude = 80, frequency = \"=f\", phase = \"90 deg\" }", "\"=80*cos(2*pi*f*t)\""}) {
        write_text(folder / "model.toml", driven_mass(force));
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        const auto summary = read_json(folder / "out/summary.json");
        const double omega = 2 * pi * 125, exact = 2 * 80 / (2 * omega * omega);
        EXPECT_NEAR(summary.at(nlohmann::json::json_pointer("/positions/m/position/z/peak")).get<double>() / exact,
                    std::pow((pi / 8) / std::tan(pi / 8), 2), 0.005)
            << force;
        EXPECT_NEAR(summary.at(nlohmann::json::json_pointer("/accelerations/m/acceleration/z/peak")).get<double>(), 40, 1e-3)
            << force;
        EXPECT_THAT(ended.err, AllOf(StartsWith("warning: model.toml:14:1: load number 1 has a part at 125 Hz, 8 steps per "
                                                "period: at a step of 0.001 s its effect is about 10 % too small"),
                                     HasSubstr("use --step \"0.00025 s\" for 1 %")))
            << force;
        EXPECT_THAT(codes_in(folder / "out/summary.json"), ElementsAre("load-too-fast"));
        EXPECT_THAT(run_dttmm(folder.path(), {"check", "model.toml"}).err, HasSubstr("load number 1 has a part at 125 Hz"));
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--step", "0.25 ms"}).err, "");
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--tolerance", "1 %"}).err, "");
    }
}

// Oracle: the position in the run itself: F/(m ω²) (1 − cos ωt), of which the explicit recurrence makes (a/sin a)² = 1.053.
// On a hinge velocities are the means over two steps, and the ledger shows what these lose: the load is to blame, not the
// fastest vibration.
TEST(WarningsOf, ALoadThatIsTooFastIsWhatTheEnergyWarningBlames) {
    const TemporaryFolder folder;
    const auto run_at = [&](const char* frequency) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = "0.2 s"
step = "1 ms"
[[body]]
name = "b"
mass = 2
inertia = [0.02, 0.03, 0.04]
[[joint]]
name = "h"
type = "hinge"
between = ["ground", "b"]
anchor = [0.2, 0, 0]
axis = [0, 0, 1]
[[load]]
on = "b"
direction = [0, 1, 0]
force = {{ type = "sine", amplitude = 100, frequency = "{}" }}
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 20000
)toml",
                                                      frequency));
        return run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"}).err;
    };
    EXPECT_THAT(
        run_at("200 Hz"),
        AllOf(HasSubstr("unaccounted for"),
              HasSubstr(": load number 1 at model.toml:18:1 is too fast for the step of 0.001 s; use --step \"0.000125 s\""),
              Not(HasSubstr("fastest vibration"))));
    EXPECT_EQ(codes_in(folder / "out/summary.json"), (std::vector<std::string>{"load-too-fast", "energy-balance"}));
    EXPECT_EQ(run_at("5 Hz"), "");
}

TEST(WarningsOf, ALoadThatIsTooFastForTheExplicitCouplingSayWhatTheRunGains) {
    const TemporaryFolder folder;
    const double pi = 3.14159265358979, omega = 2 * pi * 125;
    write_text(folder / "model.toml",
               driven_mass("{ type = \"sine\", amplitude = 80, frequency = \"=f\", phase = \"90 deg\" }",
                           "step = \"1 ms\"\ncoupling = \"explicit\""));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out"});
    const double peak =
        read_json(folder / "out/summary.json").at(nlohmann::json::json_pointer("/positions/m/position/z/peak"));
    EXPECT_NEAR(peak / (80 / (2 * omega * omega) * 2), std::pow((pi / 8) / std::sin(pi / 8), 2), 0.003);
    EXPECT_THAT(ended.err, HasSubstr("its effect is about 5.3 % too large"));
}

TEST(WarningsOf, ALoadThatIsTooFastIsCountedInASweep) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml",
               driven_mass("{ type = \"sine\", amplitude = 80, frequency = \"=f\", phase = \"90 deg\" }"));
    EXPECT_THAT(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--sweep", "f=5Hz,125Hz,250Hz"}).out,
                HasSubstr(", 2 with warnings (alternating-force, load-too-fast)"));
}

// A body that a fixed joint holds does not move: 1e-15 J and 5e-8 N beside 100 N are rounding.
TEST(WarningsOf, NothingIsSaidOfWhatOnlyRoundingMoves) {
    const TemporaryFolder folder;
    std::string text = kSmallModel;
    text += "\n[[joint]]\nname = \"clamp\"\ntype = \"fixed\"\nbetween = [\"ground\", \"plate\"]\n";
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out", "--duration", "2 s"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.err, "");
}

TEST(WarningsOf, ManyDoNotFillTheTerminal) {
    const TemporaryFolder folder;
    std::string text = small_model_with("step = \"5 ms\"", "step = \"1 ms\"");
    for (int i = 0; i < 60; ++i)
        text += fmt::format(
            "\n[[element]]\nname = \"spare{1}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate\"\n"
            "stiffness = 0\naxes = {{ axis = [0, 0, 1], angle = {0} }}\n",
            0.01 * (i + 1), i);
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 51);
    EXPECT_THAT(ended.err, HasSubstr("and 10 more warnings (10 free-element); summary.json has all of them\n"));
    EXPECT_EQ(codes_in(folder / "out/summary.json").size(), 60u);
    EXPECT_THAT(run_dttmm(folder.path(), {"check", "model.toml"}).err,
                HasSubstr("and 11 more warnings (1 about-equilibrium, 10 free-element)\n"));
}

// A constant force on the free end of a beam. With damping, with a mass, or rising from zero, it is no jump.
TEST(WarningsOf, ALoadThatIsThereAtOnceOnANodeWithoutMassIsAJump) {
    const TemporaryFolder folder;
    const auto codes_of = [&](const char* force, const std::string& damping, const std::string& more) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = 0.01
step = 1e-4
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [0.73, 0.2, 0]
[[element]]
name = "arm"
type = "beam"
from = "root"
to = "tip"
section = {{ rectangle = ["13 mm", "21 mm"] }}
material = {{ E = "71 GPa", poisson = 0.33, density = 2710{} }}
[[load]]
on = "tip"
direction = [0, 0, 1]
force = {}
{})toml",
                                                      damping, force, more));
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"}).code, 0);
        return codes_in(folder / "out/summary.json");
    };
    const std::string mass = "[[element]]\nname = \"m\"\ntype = \"point_mass\"\nat = \"tip\"\nmass = 0.1\n";
    EXPECT_THAT(codes_of("37", "", ""), testing::Contains("load-jumps"));
    EXPECT_THAT(codes_of("37", ", stiffness_damping = 2e-5", ""), Not(testing::Contains("load-jumps")));
    EXPECT_THAT(codes_of("37", "", mass), Not(testing::Contains("load-jumps")));
    EXPECT_THAT(codes_of("\"=37*sin(60*t)\"", "", ""), Not(testing::Contains("load-jumps")));
}

// Oracle: rows of a vibration of 50 Hz, by hand: 8 per period miss up to 1 − cos(π/8), 7.6 %, of its peak; 40 miss 0.3 %.
TEST(WarningsOf, APeakBetweenRowsIsTold) {
    const TemporaryFolder folder;
    for (const char* row : {"2.5 ms", "0.5 ms"}) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
simulation = {{ duration = 0.1, step = 1e-4 }}
output = {{ step = "{}" }}
body = [{{ name = "ball", mass = 2, sphere = 0.1, velocity = [0.3, 0, 0] }}]
element = [{{ name = "spring", type = "spring_damper", from = "ground", to = "ball", stiffness = [{}, 1e4, 1e4] }}]
)toml",
                                                      row, 2 * std::pow(2 * M_PI * 50, 2)));
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0);
        const bool is_coarse = row == std::string_view("2.5 ms");
        EXPECT_EQ(codes_in(folder / "out/summary.json"),
                  is_coarse ? std::vector<std::string>{"peaks-between-rows"} : std::vector<std::string>{});
        EXPECT_THAT(ended.err, is_coarse ? HasSubstr("rows every 0.0025 s are too far apart") : HasSubstr(""));
        if (!is_coarse) continue;
        const size_t advice = ended.err.find("--output-step \"") + 15;
        const std::string advised = ended.err.substr(advice, ended.err.find('"', advice) - advice);
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out", "--output-step", advised}).code, 0)
            << advised;
    }
}

// Oracle: an arc of a circle, 1.9 rad of it; half links at the ends. So a whole link turns by 1.9 rad over the segments.
// Without the spectral radius rounding keeps its stiff, damped bar alternating by 9 to 11 % of the force: another warning.
TEST(WarningsOf, ABendThatSegmentsAreTooLongForIsTold) {
    const TemporaryFolder folder;
    const double EI = 71e9 * M_PI / 64 * std::pow(0.012, 4), length = 0.83, angle = 1.9;
    for (int segments : {3, 5}) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = 3
step = 2e-3
spectral_radius = 0.9
[output]
channels = ["bar.turn_to_limit"]
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [0, {}, 0]
[[element]]
name = "bar"
type = "beam"
from = "root"
to = "tip"
segments = {}
section = {{ circle = "12 mm" }}
material = {{ E = "71 GPa", poisson = 0.33, density = 2710, stiffness_damping = 1e-2 }}
[[load]]
on = "tip"
direction = [0, 0, 1]
moment = {{ type = "step", from = 0, to = {}, start = 0, end = 1 }}
)toml",
                                                      length, segments, EI * angle / length));
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0);
        EXPECT_EQ(codes_in(folder / "out/summary.json"),
                  segments == 3 ? std::vector<std::string>{"beyond-limit"} : std::vector<std::string>{});
        EXPECT_THAT(ended.err, segments == 3 ? HasSubstr("the law of element \"bar\" does not hold") : HasSubstr(""));
        const std::string history = read_text(folder / "out/history.csv");
        const std::string last = history.substr(history.rfind('\n', history.size() - 2) + 1);
        EXPECT_NEAR(std::stod(last.substr(last.find(',') + 1)), angle / segments / 0.5, 1e-3) << segments;
    }
}

// Oracle: a disc spinning about its axis z nutates at Iz/Ix times its spin. Its springs alone vibrate at 1/70 of that.
TEST(WarningsOf, ABodyThatSpinsTooFastForTheStepIsTold) {
    const TemporaryFolder folder;
    for (const double step : {1e-3, 2e-4, 1e-4}) {
        for (const bool is_on_a_joint : {false, true}) {
            write_text(folder / "model.toml",
                       fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = 0.02
step = {}
[[body]]
name = "disc"
mass = 5.3
inertia = {{ xx = 0.011, yy = 0.011, zz = 0.019 }}
angular_velocity = [{}, 0, 1256.6]
markers = {{ top = [0, 0, 0.1], bottom = [0, 0, -0.1] }}
{}
[[element]]
name = "one"
type = "spring_damper"
from = "ground"
to = "disc.top"
stiffness = 2e4
[[element]]
name = "other"
type = "spring_damper"
from = "ground"
to = "disc.bottom"
stiffness = 2e4
)toml",
                                   step, is_on_a_joint ? 0 : 6,
                                   is_on_a_joint ? "[[joint]]\nname = \"axle\"\ntype = \"hinge\"\nbetween = "
                                                   "[\"ground\", \"disc\"]\nanchor = [0, 0, 0]\naxis "
                                                   "= [0, 0, 1]\n"
                                                 : ""));
            const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
            EXPECT_EQ(ended.code, 0) << ended.err;
            const bool is_told = step > 1.5e-4 && !is_on_a_joint;
            EXPECT_EQ(std::ranges::count(codes_in(folder / "out/summary.json"), "gyroscopic-step"), is_told) << step;
            EXPECT_THAT(ended.err, HasSubstr(is_told ? fmt::format("nutates at about 345.4 Hz, {:.3g} steps per period",
                                                                   1 / (345.44 * step))
                                                     : ""));
        }
    }
}

// Oracle: a body of three equal moments of inertia has no axis that nutates. One that differs by a tenth counts.
TEST(WarningsOf, ASphereThatSpinsIsNotTold) {
    const TemporaryFolder folder;
    for (const double ratio : {0.93, 1.0, 1.08, 1.15}) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
simulation = {{ duration = 0.01, step = 1e-3 }}
body = [{{ name = "ball", mass = 2, inertia = {{ xx = 0.01, yy = 0.01, zz = {} }}, angular_velocity = [0, 0, 900] }}]
element = [{{ name = "spring", type = "spring_damper", from = "ground", to = "ball", stiffness = 1e4 }}]
)toml",
                                                      0.01 * ratio));
        EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"}).code, 0);
        EXPECT_EQ(std::ranges::count(codes_in(folder / "out/summary.json"), "gyroscopic-step"), ratio > 1.1) << ratio;
    }
}

// A motor whose angle is a table. Oracle: 1 rad in 0.2 s, so its speed jumps by 5 rad/s at two points.
TEST(WarningsOf, AMotorWhoseSpeedJumpsIsTold) {
    const TemporaryFolder folder;
    const auto told = [&](const char* angle) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = 0.5
step = 1e-3
[[body]]
name = "arm"
mass = 2.3
inertia = [0.031, 0.027, 0.011]
position = [0.4, 0, 0]
[[joint]]
name = "motor"
type = "hinge"
between = ["ground", "arm"]
anchor = [0, 0, 0]
axis = [0, 1, 0]
angle = {}
)toml",
                                                      angle));
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.err;
    };
    EXPECT_THAT(told("{ type = \"table\", times = [0, 0.1, 0.3, 0.5], values = [0, 0, 1, 1] }"),
                testing::AllOf(HasSubstr("the motor of joint \"motor\" jumps in speed by "),
                               HasSubstr("jumps, which a shorter step does not help"), Not(HasSubstr("networks"))));
    EXPECT_THAT(told("{ type = \"step\", from = 0, to = 1, start = 0.1, end = 0.3 }"), Not(HasSubstr("jumps")));
    EXPECT_THAT(told("\"=sin(4*t)^2\""), Not(HasSubstr("jumps")));
    EXPECT_THAT(told("{ type = \"table\", times = [0, 1e-3, 0.5], values = [0, 0, 1] }"),
                HasSubstr("jumps in speed by 2 rad/s at t = 0.00"));  // not at the end
    for (const char* angle : {"\"=t^2+0.001*(t>0.25)\"", "\"=t^3+0.001*(t>=0.2)\"", "\"=t^3+0.001*(t>0.2)\""})
        EXPECT_THAT(told(angle), HasSubstr("the motor of joint \"motor\" jumps by 0.001 rad at t = 0.2")) << angle;
}

// Oracle: x = F/k (1 − cos ω(t − τ)) after a jump of F at τ. What a fixed step makes of that errs by up to π f h.
TEST(WarningsOf, ALoadThatJumpsBetweenStepsIsToldWithItsError) {
    const TemporaryFolder folder;
    constexpr double kMass = 3.3, kStiffness = 4e3, kForce = 20, kStart = 0.1;
    const double omega = std::sqrt(kStiffness / kMass);
    const auto run = [&](const std::string& force, double step) {
        write_text(folder / "model.toml", fmt::format(R"toml(format = "dttmm/1"
[simulation]
duration = 0.2
step = {}
[[body]]
name = "a"
mass = {}
inertia = [0.01, 0.01, 0.01]
[[load]]
on = "a"
direction = [1, 0, 0]
force = {}
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = {}
)toml",
                                                      step, kMass, force, kStiffness));
        return run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
    };
    for (const double step : {2e-3, 5e-4}) {
        const Ended ended = run(fmt::format("\"={}*(t>={})\"", kForce, kStart), step);
        EXPECT_EQ(ended.code, 0);
        const double bound = M_PI * step;
        EXPECT_THAT(ended.err, testing::AllOf(HasSubstr("load number 1 jumps by 20 N at t = 0.1 s"),
                                              HasSubstr(fmt::format("errs by up to {:.2g} f", bound))));
        const double error = last_row(folder / "out/history.csv").at("a.position.x") -
                             kForce / kStiffness * (1 - std::cos(omega * (0.2 - kStart)));
        EXPECT_LT(std::abs(error), 1.01 * bound * omega / (2 * M_PI) * kForce / kStiffness);
        EXPECT_GT(std::abs(error), 0.1 * bound * omega / (2 * M_PI) * kForce / kStiffness);
    }
    EXPECT_THAT(run("{ type = \"sine\", amplitude = 20, frequency = 20 }", 5e-4).err, Not(HasSubstr("jumps")));
    EXPECT_THAT(run("{ type = \"step\", from = 0, to = 20, start = 0.1, end = 0.1 }", 5e-4).err, HasSubstr("jumps by 20 N"));
    EXPECT_THAT(run("\"=20*(t>=0.2)\"", 5e-4).err, Not(HasSubstr("jumps")));  // in the last row only
    EXPECT_THAT(run("20", 5e-4).err, Not(HasSubstr("jumps")));
}

}  // namespace
}  // namespace dttmm::host
