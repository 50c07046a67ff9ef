// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm response` by kinds (--as), over sweeps (--sweep), `dttmm frf` as its case of one input, and wrong questions.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "cli/modes_run.h"
#include "cli/steady_vibration.h"

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A mass that moves along x and turns about x, on a spring from a foot that may be moved; a rod beside it to the ground.
std::string mass_on_foot() {
    return R"(format = "dttmm/1"
dofs = ["x", "rx"]
[parameters]
m = "2.5 kg"
c = "11 N*s/m"
[nodes]
foot = { position = [0.3, 0, 0], fixed = ["x", "rx"] }
top = [0.3, 0, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "foot"
to = "top"
stiffness = 9100
damping = "=c"
rotational_stiffness = 40
rotational_damping = 0.02
[[element]]
name = "mass"
type = "rigid_body"
at = "top"
mass = "=m"
inertia = { xx = 0.03, yy = 0.03, zz = 0.03 }
)";
}

const std::vector<std::string> kRange = {"--from", "2Hz", "--to", "30Hz", "--points", "5", "-q"};

std::vector<std::string> with_range(std::vector<std::string> words) {
    words.insert(words.end(), kRange.begin(), kRange.end());
    return words;
}

/// Names and units, the first two lines of a table.
std::map<std::string, std::string> units_of(const std::filesystem::path& file) {
    std::istringstream lines(read_text(file));
    std::string names, units, name, unit;
    std::getline(lines, names);
    std::getline(lines, units);
    std::istringstream all(names), their(units);
    std::map<std::string, std::string> found;
    while (std::getline(all, name, ',')) {
        std::getline(their, unit, ',');
        found[name] = unit;
    }
    return found;
}

// Oracle: closed form, H = 1/(k + iωc − mω²) of the force along x, the same of the moment about it; mobility iωH,
// accelerance −ω²H. A pattern without quantity is enough, and other channels than those of the kind are not there.
TEST_F(SteadyVibration, AKindOfResponseByItsName) {
    struct Kind {
        const char *name, *linear, *angular, *unit;
        int derivative;
    };
    for (const Kind& kind : {Kind{"receptance", "position", "rotation", "m/N", 0},
                             {"mobility", "velocity", "angular_velocity", "m/s/N", 1},
                             {"accelerance", "acceleration", "angular_acceleration", "m/s^2/N", 2}}) {
        const Table table =
            response(mass_on_foot(), with_range({"--in", "top.x", "--as", kind.name, "--out", "top.x", "--out", "top.rx"}));
        const std::string channel = fmt::format("top.{}.x", kind.linear), turn = fmt::format("top.{}.x", kind.angular);
        EXPECT_EQ(table.names.size(), 5u) << kind.name;
        const auto units = units_of(folder_ / fmt::format("out{}/response.csv", count_));
        EXPECT_EQ(units.at(channel + ".re"), kind.unit);
        EXPECT_EQ(read_json(folder_ / fmt::format("out{}/summary.json", count_))["kind"], kind.name);
        for (size_t i = 0; i < table.rows.size(); ++i) {
            const double f = table.value(i, "frequency");
            const Complex H = receptance(f) * std::pow(Complex(0, 2 * kHalfTurn * f), kind.derivative);
            EXPECT_LT(std::abs(table.amplitude(i, channel) - H), 1e-10 * std::abs(H)) << kind.name;
            EXPECT_EQ(table.amplitude(i, turn), 0.0) << kind.name;
        }
    }
    const Table moments = response(mass_on_foot(), with_range({"--in", "top.rx", "--as", "receptance", "--out", "top.rx"}));
    EXPECT_EQ(units_of(folder_ / fmt::format("out{}/response.csv", count_)).at("top.rotation.x.re"), "rad/(N*m)");
    for (size_t i = 0; i < moments.rows.size(); ++i) {
        const double w = 2 * kHalfTurn * moments.value(i, "frequency");
        const Complex H = 1.0 / Complex(40 - 0.03 * w * w, 0.02 * w);
        EXPECT_LT(std::abs(moments.amplitude(i, "top.rotation.x") - H), 1e-10 * std::abs(H));
    }
}

// Oracle: closed form. What follows a moved foot and the force in the spring per force on the mass are the same ratio,
// (k + iωc)/(k + iωc − mω²), without a unit; rotations have theirs.
TEST_F(SteadyVibration, TransmissibilityOfMotionAndOfForce) {
    const Table motion =
        response(mass_on_foot(), with_range({"--in", "foot.x", "--as", "transmissibility", "--out", "top"}));
    EXPECT_THAT(motion.names, ElementsAre("frequency", "top.position.x.re", "top.position.x.im", "top.position.y.re",
                                          "top.position.y.im", "top.position.z.re", "top.position.z.im"));
    EXPECT_EQ(units_of(folder_ / "out1/response.csv").at("top.position.x.re"), "1");
    const Table force =
        response(mass_on_foot(), with_range({"--in", "top.x", "--as", "transmissibility", "--out", "spring.x"}));
    EXPECT_THAT(force.names, ElementsAre("frequency", "spring.force.x.re", "spring.force.x.im"));
    EXPECT_EQ(units_of(folder_ / "out2/response.csv").at("spring.force.x.re"), "1");
    const Table turn =
        response(mass_on_foot(), with_range({"--in", "foot.rx", "--as", "transmissibility", "--out", "top.rotation.x"}));
    for (size_t i = 0; i < motion.rows.size(); ++i) {
        const double f = motion.value(i, "frequency"), w = 2 * kHalfTurn * f;
        const Complex ratio = Complex(kSpring, kDamper * w) * receptance(f),
                      of_turn = Complex(40, 0.02 * w) / Complex(40 - 0.03 * w * w, 0.02 * w);
        EXPECT_LT(std::abs(motion.amplitude(i, "top.position.x") - ratio), 1e-10 * std::abs(ratio));
        EXPECT_LT(std::abs(force.amplitude(i, "spring.force.x") - ratio), 1e-10 * std::abs(ratio));
        EXPECT_LT(std::abs(turn.amplitude(i, "top.rotation.x") - of_turn), 1e-10 * std::abs(of_turn));
    }
}

TEST_F(SteadyVibration, WrongKindsAreRefused) {
    const auto asked = [&](std::vector<std::string> words, int code = 2) {
        return fault(mass_on_foot(), with_range(std::move(words)), code);
    };
    EXPECT_THAT(asked({"--in", "top.x", "--as", "receptence"}), HasSubstr("did you mean \"receptance\"?"));
    EXPECT_THAT(asked({"--in", "top.x", "--in", "foot.x", "--in", "top.x"}),
                HasSubstr("--in \"top.x\" and --in \"top.x\" are the same input; give it once"));
    EXPECT_THAT(asked({"--in", "foot.x", "--as", "mobility"}), HasSubstr("--in foot.x is fixed in this direction"));
    EXPECT_THAT(asked({"--in", "foot.x", "--in", "top.x", "--as", "transmissibility"}),
                HasSubstr("--in foot.x is a motion and --in top.x a force"));
    EXPECT_THAT(asked({"--in", "top.x", "--as", "receptance", "--out", "tip.x"}, 3), HasSubstr("the nearest is \"top"));
    EXPECT_THAT(asked({"--in", "top.x", "--as", "receptance", "--out", "spring.force"}, 3), HasSubstr("matches no channel"));
    EXPECT_THAT(fault(kMassOnSpring + "harmonic = { amplitude = 1 }\n", with_range({"--as", "receptance"}), 2),
                HasSubstr("of which input? give it with --in"));
}

// Oracle: the same numbers by the other command, to the bit: both have their rows from one engine.
TEST_F(SteadyVibration, AFrfIsTheResponseOfOneInput) {
    const std::string text = turned_block("", 1, 1e-3);
    for (const auto& [in, out, channel] : {std::tuple("block.top.z", "block.three.y", "block.three.position.y"),
                                           {"block.rx", "block.two.rz", "block.rotation.z"}}) {
        for (const bool is_adaptive : {false, true}) {
            std::vector<std::string> words = {"--in", in, "--from", "1Hz", "--to", "25Hz", "-q"};
            if (!is_adaptive) words.insert(words.end(), {"--points", "7"});
            auto frf = words;
            words.insert(words.end(), {"--out", channel});
            frf.insert(frf.begin(), {"frf", "model.toml", "-o", fmt::format("frf{}{}", out, is_adaptive), "--out", out});
            const Table table = response(text, words);
            const Ended ended = run_dttmm(folder_.path(), frf);
            ASSERT_EQ(ended.code, 0) << ended.err;
            if (is_adaptive) {
                EXPECT_EQ(ended.err, "");
            }
            const Table same = read_table(folder_ / fmt::format("frf{}{}/frf.csv", out, is_adaptive));
            ASSERT_EQ(same.rows.size(), table.rows.size());
            EXPECT_GT(table.rows.size(), is_adaptive ? 20u : 6u);
            for (size_t i = 0; i < table.rows.size(); ++i) {
                EXPECT_EQ(same.value(i, "frequency"), table.value(i, "frequency"));
                EXPECT_EQ(same.amplitude(i, "receptance"), table.amplitude(i, channel));
            }
        }
    }
}

// ---- Sweeps --------------------------------------------------------------------------------------------------------------

std::vector<std::vector<std::string>> sweep_cells(const std::filesystem::path& file) {
    std::istringstream lines(read_text(file));
    std::vector<std::vector<std::string>> cells;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line);
        cells.emplace_back();
        for (std::string cell; std::getline(fields, cell, ',');) cells.back().push_back(cell);
    }
    return cells;
}

// Oracle: a case is the response with its values set, to the byte; the largest of each is the closed form,
// 1/(2 ζ √(1 − ζ²) k) at f0 √(1 − 2ζ²). Two axes span a grid, the last fastest.
TEST_F(SteadyVibration, ASweepHasACasePerValue) {
    const std::vector<std::string> words = {"--in", "top.x", "--from",         "1Hz", "--to",
                                            "60Hz", "--out", "top.position.x", "-q"};
    auto swept = words, alone = words;
    swept.insert(swept.end(), {"--sweep", "m=2 kg,3 kg", "--sweep", "c=10 N*s/m..30 N*s/m:3"});
    alone.insert(alone.end(), {"--set", "m=2 kg", "--set", "c=30 N*s/m"});
    const Ended ended = ask(mass_on_foot(), swept);
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto cells = sweep_cells(folder_ / "out1/sweep.csv");
    ASSERT_EQ(cells.size(), 8u);
    EXPECT_THAT(cells[0], ElementsAre("case", "m", "c", "status", "reason", "warnings", "top.position.x.largest",
                                      "top.position.x.frequency"));
    EXPECT_EQ(cells[1][6], "m/N");
    for (size_t i = 0; i < 6; ++i) {
        const auto& row = cells[2 + i];
        const double m = i < 3 ? 2 : 3, c = 10 + 10.0 * static_cast<double>(i % 3), zeta = c / (2 * std::sqrt(kSpring * m)),
                     f0 = std::sqrt(kSpring / m) / (2 * kHalfTurn);
        EXPECT_EQ(row[0], fmt::format("case-{:06}", i + 1));
        EXPECT_NEAR(std::stod(row[1]), m, 1e-12);
        EXPECT_NEAR(std::stod(row[2]), c, 1e-12);
        EXPECT_EQ(row[3], "completed");
        const double peak = 1 / (2 * zeta * std::sqrt(1 - zeta * zeta) * kSpring);
        EXPECT_NEAR(std::stod(row[6]), peak, 2e-5 * peak);
        EXPECT_NEAR(std::stod(row[7]), f0 * std::sqrt(1 - 2 * zeta * zeta), 2e-3 * f0);
    }
    ASSERT_EQ(ask(mass_on_foot(), alone).code, 0);
    EXPECT_EQ(read_text(folder_ / "out1/case-000003/response.csv"), read_text(folder_ / "out2/response.csv"));
}

// Oracle: the codes of sweeps of runs. What fails is named, the others go on; a fault of all is that of the command.
TEST_F(SteadyVibration, AFailingCaseLeavesTheOthers) {
    const std::vector<std::string> words = with_range({"--in", "top.x", "--out", "top.position.x"});
    auto some = words, all = words, unknown = words;
    some.insert(some.end(), {"--sweep", "m=1 kg,-1 kg,3 kg"});
    all.insert(all.end(), {"--sweep", "m=-1 kg,-2 kg"});
    unknown.insert(unknown.end(), {"--sweep", "mm=1 kg,3 kg"});
    const Ended ended = ask(mass_on_foot(), some);
    EXPECT_EQ(ended.code, 9);
    EXPECT_THAT(ended.err, HasSubstr("case-000002 m=-1 kg: model.toml:"));
    const auto cells = sweep_cells(folder_ / "out1/sweep.csv");
    ASSERT_EQ(cells.size(), 5u);
    EXPECT_EQ(cells[2][3], "completed");
    EXPECT_EQ(cells[3][3], "failed");
    EXPECT_EQ(cells[4][3], "completed");
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out1/case-000003/response.csv"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out1/case-000002"));
    EXPECT_THAT(fault(mass_on_foot(), all), HasSubstr("model.toml:"));
    EXPECT_THAT(fault(mass_on_foot(), unknown, 2), HasSubstr("\"mm\""));
}

// Oracle: closed form, RMS √(S/(4 k c)) under white noise, and the sweep's printed table. Speeds have their column.
TEST_F(SteadyVibration, ASweepOfRandomLoadsAndOfSpeeds) {
    std::string text = kMassOnSpring + "psd = { frequencies = [0, 400], values = [3, 3] }\n";
    text.replace(text.find("damping = 11"), 12, "damping = \"=c\"");
    text.replace(text.find("F = "), 0, "c = \"11 N*s/m\"\n");
    const Ended ended = ask(text, {"--out", "m.position.x", "--sweep", "c=11 N*s/m,44 N*s/m"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("RMS of m.position.x"));
    EXPECT_THAT(ended.out, HasSubstr("2 of 2 cases completed"));
    const auto cells = sweep_cells(folder_ / "out1/sweep.csv");
    ASSERT_EQ(cells.size(), 4u);
    EXPECT_EQ(cells[0].back(), "m.position.x.rms");
    const double expected = std::sqrt(3 / (4 * kSpring * 11.0));
    EXPECT_NEAR(std::stod(cells[2].back()), expected, 5e-4 * expected);
    EXPECT_NEAR(std::stod(cells[3].back()), expected / 2, 5e-4 * expected);
    text.replace(text.find("psd = "), std::string::npos, "harmonic = { amplitude = 1, order = 2 }\n");
    ASSERT_EQ(ask(text, {"--rpm", "100..200:3", "--out", "m.position.x", "--sweep", "c=11 N*s/m,44 N*s/m", "-q"}).code, 0);
    const auto speeds = sweep_cells(folder_ / "out2/sweep.csv");
    EXPECT_EQ(speeds[0].back(), "m.position.x.rpm");
    EXPECT_NEAR(std::stod(speeds[2].back()), 200, 1e-9);
}

// A turned plate on four equal mounts, shaken through its centre: it does not turn, and two of its frequencies are equal.
// Oracle: what its rotations show is rounding, so that all channels ask for no more points than the forces.
TEST_F(SteadyVibration, WhatIsZeroBesideOtherMotionsIsNotDrawn) {
    std::string text = R"(format = "dttmm/1"
[[body]]
name = "plate"
mass = 14
inertia = [0.11, 0.1, 0.21]
quaternion = [0.5, 0.7, 0.1, -0.5]
markers = { a = [0.1, 0.1, 0], b = [-0.1, 0.1, 0], c = [-0.1, -0.1, 0], d = [0.1, -0.1, 0] }
[[load]]
on = "plate"
direction = [0.3, 0.2, 1]
harmonic = { amplitude = 3 }
)";
    for (const char* corner : {"a", "b", "c", "d"})
        text += fmt::format(R"([[element]]
name = "mount_{0}"
type = "spring_damper"
from = "ground"
to = "plate.{0}"
stiffness = [3e5, 3e5, 5e5]
damping = 100
)",
                            corner);
    const std::vector<std::string> range = {"--from", "5Hz", "--to", "300Hz", "-q"};
    const auto rows = [&](std::vector<std::string> words) {
        words.insert(words.end(), range.begin(), range.end());
        const Table found = response(text, words);
        EXPECT_THAT(err_, testing::Not(testing::AnyOf(HasSubstr("nothing damps"), HasSubstr("still not straight"))));
        return found.rows.size();
    };
    const size_t of_forces = rows({"--out", "mount_*.force"});
    EXPECT_GT(of_forces, 20u);
    EXPECT_LT(rows({"--out", "*"}), 2 * of_forces);
    EXPECT_LT(rows({"--out", "plate.rotation.z"}), of_forces);
}

// ---- Wrong questions -----------------------------------------------------------------------------------------------------

// Oracle: the wanted responses: a code, the rule, the cure; no folder is made.
TEST_F(SteadyVibration, WrongRangesAndFreeDirections) {
    const std::string text = mass_on_foot();
    const auto asked = [&](const std::vector<std::string>& words, int code) { return fault(text, words, code); };
    EXPECT_THAT(asked({"--in", "top.x", "--from", "9Hz", "--to", "2Hz"}, 2), HasSubstr("--to must be more than --from"));
    EXPECT_THAT(asked({"--in", "tip.x", "--from", "1Hz", "--to", "2Hz"}, 2), HasSubstr("did you mean \"top\"?"));
    EXPECT_THAT(asked({"--in", "top.x", "--from", "1Hz", "--to", "2Hz", "--points", "10000001"}, 2), HasSubstr("--points"));
    EXPECT_THAT(asked({"--in", "top.x", "--from", "0Hz", "--to", "2Hz", "--points", "3", "--log"}, 2), HasSubstr("--log"));
    EXPECT_THAT(asked({"--in", "top.x", "--from", "-1Hz", "--to", "2Hz"}, 2), HasSubstr("--from"));
    std::string free = text;
    free.replace(free.find("rotational_stiffness = 40\n"), 26, "");
    EXPECT_THAT(fault(free, {"--in", "top.rx", "--out", "top", "--from", "0Hz", "--to", "2Hz"}, 4),
                HasSubstr("0 Hz: the machine is free to move in 1 direction, and the force moves it (node \"top\" in rx)"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / fmt::format("out{}", count_)));
    const Table still =
        response(free, {"--in", "top.x", "--out", "top.position.x", "--from", "0Hz", "--to", "2Hz", "--points", "2", "-q"});
    EXPECT_NEAR(still.value(0, "top.position.x.re"), 1 / kSpring, 1e-9 / kSpring);
    std::string unfixed = text;
    unfixed.replace(unfixed.find("top = [0.3, 0, 0]"), 17,
                    "top = { position = [0.3, 0, 0], motion = { x = { type = \"harmonic\", amplitude = 1e-3 } } }");
    EXPECT_THAT(fault(unfixed, {"--from", "1Hz", "--to", "2Hz"}), HasSubstr("fixed"));
}

}  // namespace
}  // namespace dttmm::host
