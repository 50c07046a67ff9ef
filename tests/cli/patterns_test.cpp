// SPDX-License-Identifier: BSD-3-Clause
//
// Patterns, sections and probes of the model file, from the file to the numbers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/modes_run.h"
#include "cli/process.h"
#include "cli/results_table.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// The history of a model that must run without a word.
std::string history_of(const TemporaryFolder& folder, const std::string& name, const std::string& model) {
    write_text(folder / (name + ".toml"), model);
    const Ended ended = run_dttmm(folder.path(), {"run", name + ".toml", "-q", "-o", name});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
    return read_text(folder / name / "history.csv");
}

/// A shaft of two sections, 0.3125 m and 0.9375 m long, clamped at its left end, hit at its right one: all numbers are
/// exact, so that the sections meet to the bit where the chain has its node. elements: the shaft.
std::string shaft(const std::string& elements) {
    return R"(format = "dttmm/1"
[simulation]
duration = "10 ms"
step = "50 us"
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.75, 0, 1]
[[load]]
on = "tip"
direction = [0, 1, 0]
force = { type = "haversine", peak = "70 N", start = "1 ms", width = "3 ms" }
[defaults.beam]
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3" }
)" + elements;
}

const std::string kOneShaft = R"([[element]]
name = "shaft"
type = "beam"
from = "root"
to = "tip"
section = { circle = "30 mm" }
sections = [{ length = 0.3125, segments = 6 }, { length = 0.9375, section = { tube = ["50 mm", "20 mm"] } }]
)";

const std::string kChainOfTwo = R"([[element]]
name = "shaft1"
type = "beam"
from = "root"
to = "shaft_1"
section = { circle = "30 mm" }
segments = 6
[[element]]
name = "shaft2"
type = "beam"
from = "shaft_1"
to = "tip"
section = { tube = ["50 mm", "20 mm"] }
[nodes.shaft_1]
position = [0.1875, 0, 0.25]
)";

// Oracle: the chain of beams written out by hand, in time byte by byte, and in frequency.
TEST(Sections, AreTheChainWrittenOut) {
    const TemporaryFolder folder;
    const std::string chain = history_of(folder, "chain", shaft(kChainOfTwo));
    EXPECT_THAT(chain, HasSubstr("shaft_1.position.y"));
    EXPECT_EQ(history_of(folder, "one", shaft(kOneShaft)), chain);
    EXPECT_EQ(frequencies_of(modes_of(shaft(kOneShaft))), frequencies_of(modes_of(shaft(kChainOfTwo))));
}

// Oracle: the same machine without the probe: at the end of a segment a cut changes neither the lumps nor the waves. And the
// balance of the probe: its force and moment are those of the segment's end in the machine without it. A cut link bends in
// two halves, of which each knows its shortening to second order: 5e-9 of the force here, growing with the square of the
// load. The pull along the shaft, which is part of the stress, is itself of second order: its difference counts 1e-7.
TEST(Probe, ChangesNothingAndShowsTheSection) {
    const TemporaryFolder folder;
    const std::string output = "[output]\nchannels = [\"tip\", \"shaft2.section4\", \"shaft2.force\"]\n";
    const std::string probe = "[[probe]]\nname = \"mid\"\non = \"shaft\"\nat = 0.6875\n";
    history_of(folder, "without", shaft(kOneShaft) + output);
    history_of(folder, "with",
               shaft(kOneShaft) + probe +
                   "[output]\nchannels = [\"tip\", \"shaft_mid.section0\", \"shaft_mid.force\", \"shaft2.force\"]\n");
    const ResultsTable without = read_table(folder / "without/history.csv"), with = read_table(folder / "with/history.csv");
    for (const auto& [there, here] : {std::pair("tip.position.y", "tip.position.y"),
                                      {"shaft2.force.y", "shaft2.force.y"},
                                      {"shaft2.section4.moment.z", "shaft_mid.section0.moment.z"},
                                      {"shaft2.section4.force.y", "shaft_mid.force.y"},
                                      {"shaft2.section4.stress", "shaft_mid.section0.stress"}}) {
        double largest = 0;
        for (size_t r = 0; r < without.rows.size(); ++r) largest = std::max(largest, std::abs(without.value(r, there)));
        EXPECT_GT(largest, 0) << there;
        const bool is_stress = std::string(here).ends_with("stress");  // of both signs alike, of which round-off chooses
        const auto signless = [&](double value) { return is_stress ? std::abs(value) : value; };
        for (size_t r = 0; r < without.rows.size(); ++r)
            ASSERT_NEAR(signless(with.value(r, here)), signless(without.value(r, there)),
                        (is_stress ? 1e-6 : 1e-7) * largest)
                << here << " " << r;
    }
    const std::string off = "[[probe]]\nname = \"mid\"\non = \"shaft\"\nat = \"837 mm\"\n";
    expect_frequencies(frequencies_of(modes_of(shaft(kOneShaft) + off)), frequencies_of(modes_of(shaft(kOneShaft))), 1e-9);
}

// Oracle: closed form: a clamped Timoshenko beam under a force at its tip, P a^2 (3 L - a)/(6 EI) + P a/GA, M = P (L - a).
TEST(Probe, OfACantileverAtRestIsTheClosedForm) {
    const TemporaryFolder folder;
    const double P = 70, L = 1.2, EI = 9e3, GA = 2e6, a = 0.37;
    write_text(folder / "model.toml", fmt::format(R"(format = "dttmm/1"
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [{}, 0, 0]
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "tip"
section = {{ EA = 6e7, EIy = 8e3, EIz = {}, GJ = 7e3, GAy = {}, GAz = 1.1e6, mass = 2.2 }}
[[load]]
on = "tip"
direction = [0, 1, 0]
force = {}
[[probe]]
name = "mid"
on = "beam"
at = {}
)",
                                                  L, EI, GA, P, a));
    const Ended ended = run_dttmm(folder.path(), {"static", "model.toml", "-q", "-o", "out"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const ResultsTable table = read_table(folder / "out/static.csv");
    const double deflection = P * a * a * (3 * L - a) / (6 * EI) + P * a / GA;
    EXPECT_NEAR(table.value(0, "mid.position.y"), deflection, 1e-4 * deflection);  // and the second order of the bending
    EXPECT_NEAR(std::abs(table.value(0, "beam_mid.moment.z")), P * (L - a), 1e-4 * P * L);
    EXPECT_NEAR(std::abs(table.value(0, "beam_mid.force.y")), P, 1e-4 * P);
}

const std::string kRing = R"toml(format = "dttmm/1"
[parameters]
k = "500 N/mm"
n = 5
[simulation]
duration = "20 ms"
step = "1 ms"
[defaults.spring_damper]
damping = "100 N*s/m"
[[body]]
name = "plate"
density = "7850 kg/m^3"
box = ["300 mm", "200 mm", "20 mm"]
[[body.repeat]]
index = "i"
count = "=n"
[body.repeat.markers]
"b{i}" = ["=0.1*cos(2*pi*i/n)", "=0.07*sin(2*pi*i/n)", 0]
[[repeat]]
index = "i"
count = "=n"
[[repeat.element]]
name = "bolt{i}"
type = "spring_damper"
from = "plate.b{i}"
to = "ground"
stiffness = "=k*(i == 2 ? 0.2 : 1)"
[[bolt_circle]]
name = "ring"
count = 3
radius = "50 mm"
from = "plate"
to = "ground"
start_angle = "20 deg"
element = { type = "spring_damper", stiffness = ["=k", "=0.3*k", "=2*k"] }
[[load]]
on = "plate"
direction = [1, 2, 3]
force = "300 N"
)toml";

// Oracle: what the command prints is a model without patterns, and it runs to the same history, byte by byte.
TEST(Check, PrintsTheModelWrittenOut) {
    const TemporaryFolder folder;
    const std::string history = history_of(folder, "ring", kRing);
    const Ended printed = run_dttmm(folder.path(), {"check", "ring.toml", "--expanded"});
    EXPECT_EQ(printed.code, 0) << printed.err;
    EXPECT_THAT(printed.out, testing::Not(HasSubstr("repeat")));
    EXPECT_THAT(printed.out, testing::Not(HasSubstr("bolt_circle")));
    EXPECT_THAT(printed.out, testing::Not(HasSubstr("defaults")));
    EXPECT_THAT(printed.out, HasSubstr("\n[[element]]\nname = \"bolt5\"\n"));
    EXPECT_THAT(history, HasSubstr("ring3.force.x"));
    EXPECT_EQ(history_of(folder, "written", printed.out), history);
    const Ended set = run_dttmm(folder.path(), {"check", "ring.toml", "--expanded", "--set", "n=7"});
    EXPECT_THAT(set.out, HasSubstr("\n[[element]]\nname = \"bolt7\"\n"));
    EXPECT_THAT(set.out, HasSubstr("\nn = \"7\"\n"));
}

// Oracle: the case of a sweep is new where an included file has changed, and the old one otherwise.
TEST(IncludedFiles, AreInputsOfTheResults) {
    const TemporaryFolder folder;
    write_text(folder / "parts.toml", "[defaults.spring_damper]\nstiffness = \"=k\"\n");
    write_text(folder / "model.toml", R"(include = ["parts.toml"]
format = "dttmm/1"
parameters = { k = 5e4 }
simulation = { duration = "50 ms", step = "1 ms" }
body = [{ name = "ball", mass = 2.5, sphere = 0.1 }]
element = [{ name = "spring", type = "spring_damper", from = "ground", to = "ball" }]
load = [{ on = "ball", direction = [1, 0, 0], force = 3 }]
)");
    const auto sweep = [&] {
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "--sweep", "k=4e4,5e4", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return read_text(folder / "out/sweep.csv");
    };
    const std::string first = sweep();
    const auto time = fs::last_write_time(folder / "out/case-000001/summary.json");
    EXPECT_EQ(sweep(), first);
    EXPECT_EQ(fs::last_write_time(folder / "out/case-000001/summary.json"), time);
    write_text(folder / "parts.toml", "[defaults.spring_damper]\nstiffness = \"=2*k\"\n");
    EXPECT_NE(sweep(), first);
}

}  // namespace
}  // namespace dttmm::host
