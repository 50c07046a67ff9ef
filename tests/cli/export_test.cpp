// SPDX-License-Identifier: BSD-3-Clause
//
// dttmm export as a user calls it, of real results of small models. Oracle of every number: the CSV files of the results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/process.h"
#include "cli/small_model.h"
#include "record/history_file.h"
#include "report/glb_reader.h"
#include "report/uff_reader.h"
#include "report/vtu_reader.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// The small model on a beam, with a body that turns, and a name outside of ASCII.
std::string export_model() {
    return small_model_with("title = \"small\"", "title = \"Stäbe \\\"alt\\\"\"") + R"(
[nodes]
"fuß" = { position = [0.5, 0.25, -1], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
knee = { position = [0.5, 0, 0.125] }

[[element]]
name = "leg"
type = "beam"
from = "fuß"
to = "knee"
segments = 3
section = { tube = ["40 mm", "2 mm"] }
material = { E = "70 GPa", poisson = 0.3, density = 2700 }

[[element]]
name = "tie"
type = "spring_damper"
from = "knee"
to = "plate.right"
stiffness = [5e4, 6e4, 7e4]
damping = [10, 20, 30]
)";
}

/// Columns by name of a CSV file without quotes.
std::vector<double> column_of(const fs::path& file, const std::string& name) {
    std::istringstream lines(read_text(file));
    std::string line, cell;
    std::getline(lines, line);
    std::istringstream heads(line);
    std::size_t wanted = 0;
    while (std::getline(heads, cell, ',') && cell != name) ++wanted;
    EXPECT_EQ(cell, name);
    std::getline(lines, line);
    std::vector<double> values;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        for (std::size_t i = 0; i <= wanted; ++i) std::getline(cells, cell, ',');
        values.push_back(std::stod(cell));
    }
    return values;
}

void run_and_export(const TemporaryFolder& folder, const std::vector<std::string>& words,
                    const std::vector<std::string>& formats) {
    write_text(folder / "m.toml", export_model());
    std::vector<std::string> all = words;
    all.insert(all.end(), {"-q", "-o", "out"});
    const Ended ended = run_dttmm(folder.path(), all);
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::vector<std::string> exports = {"export", "out"};
    exports.insert(exports.end(), formats.begin(), formats.end());
    const Ended exported = run_dttmm(folder.path(), exports);
    ASSERT_EQ(exported.code, 0) << exported.err;
    EXPECT_THAT(exported.out, HasSubstr(" MB, "));
}

TEST(Export, ARunAsFunctionsAndAsAFilm) {
    const TemporaryFolder folder;
    run_and_export(folder, {"run", "m.toml"}, {"--uff58", "--gltf", "--vtu", "--mat"});
    const fs::path history = folder / "out/history.csv";
    int checked = 0;
    for (const UffSet& set : uff_sets_of(read_uff(read_text(folder / "out.uff")), 58)) {
        const std::string name = set.lines[0].substr(0, set.lines[0].find(" ["));
        EXPECT_EQ(set.lines[1], "Stäbe \"alt\"");
        EXPECT_EQ(set.whole(5, 1, 5), 1);
        EXPECT_EQ(set.whole(6, 21, 30), 1) << "rows at equal distances";
        const std::vector<double> times = column_of(history, "time"), values = column_of(history, name);
        const auto back = read_uff_values(set);
        ASSERT_EQ(back.size(), values.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            EXPECT_NEAR(back[i][0], times[i], 1e-8);
            EXPECT_NEAR(back[i][1], std::abs(values[i]) < 1e-99 ? 0 : values[i], 5e-13 * std::abs(values[i])) << name;
        }
        if (name == "plate.position.z") {
            EXPECT_EQ(set.whole(5, 42, 51), 1);
            EXPECT_EQ(set.whole(5, 52, 55), 3);
            ++checked;
        }
        if (name == "knee.rotation.y") {
            EXPECT_EQ(set.whole(5, 42, 51), 5) << "behind the plate, its two markers and the foot";
            EXPECT_EQ(set.whole(5, 52, 55), 5);
            ++checked;
        }
    }
    EXPECT_EQ(checked, 2);
    const GlbReader film(read_text(folder / "out.glb"));
    const auto& run = film.animation("run");
    const std::vector<double> times = column_of(history, "time");
    for (std::size_t i = 0; i < times.size(); ++i) {
        const auto position = film.at("plate", "translation", run, times[i]),
                   turn = film.at("plate", "rotation", run, times[i]);
        double dot = 0;
        for (std::size_t k = 0; k < 4; ++k)
            dot += turn[k] * column_of(history, std::string("plate.quaternion.") + "xyzw"[k])[i];
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(position[k], column_of(history, std::string("plate.position.") + "xyz"[k])[i], 1e-6);
        EXPECT_NEAR(std::abs(dot), 1, 1e-6);
    }
    EXPECT_TRUE(fs::exists(folder / "out.frames/f000010.vtu"));
    EXPECT_FALSE(fs::exists(folder / "out.frames/f000011.vtu"));
    EXPECT_TRUE(read_text(folder / "out.mat").starts_with("MATLAB 5.0 MAT-file, dttmm "));
}

TEST(Export, ModesWithTheirBeams) {
    const TemporaryFolder folder;
    run_and_export(folder, {"modes", "m.toml", "--damped"}, {"--uff55"});
    const auto sets = read_uff(read_text(folder / "out.uff"));
    const auto modes = uff_sets_of(sets, 55);
    const std::vector<double> frequencies = read_json(folder / "out/summary.json")["frequencies_hz"];
    ASSERT_GT(modes.size(), frequencies.size());
    const std::vector<double> uz = column_of(folder / "out/modes.csv", "uz"),
                              mass = column_of(folder / "out/modes.csv", "modal_mass"),
                              station = column_of(folder / "out/shapes.csv", "urx");
    for (std::size_t m = 0; m < frequencies.size(); ++m) {
        EXPECT_EQ(modes[m].whole(5, 11, 20), 2);
        EXPECT_NEAR(modes[m].number_at(7, 1, 13), frequencies[m], 5e-6 * frequencies[m]);
        EXPECT_NEAR(modes[m].number_at(7, 14, 26), mass[5 * m], 5e-6 * mass[5 * m]);
        EXPECT_EQ(modes[m].lines.size(), 8 + 2 * 26u) << "5 places and 21 stations";
        for (std::size_t p = 0; p < 5; ++p)
            EXPECT_NEAR(modes[m].number_at(9 + 2 * p, 27, 39), uz[5 * m + p], 5e-6 * std::abs(uz[5 * m + p]));
        for (std::size_t n = 0; n < 26; ++n) EXPECT_EQ(modes[m].whole(8 + 2 * n, 1, 10), static_cast<int>(n) + 1);
        for (std::size_t s = 0; s < 21; ++s)
            EXPECT_NEAR(modes[m].number_at(19 + 2 * s, 40, 52), station[21 * m + s], 5e-6 * std::abs(station[21 * m + s]));
    }
    const std::vector<double> turns = column_of(folder / "out/damped.csv", "damped_frequency"),
                              decay = column_of(folder / "out/damped.csv", "decay");
    ASSERT_EQ(modes.size(), frequencies.size() + turns.size());
    for (std::size_t m = 0; m < turns.size(); ++m) {
        const UffSet& damped = modes[frequencies.size() + m];
        EXPECT_EQ(damped.whole(5, 11, 20), 3);
        EXPECT_NEAR(damped.number_at(7, 1, 13), -decay[m], 5e-6 * std::abs(decay[m]));
        EXPECT_NEAR(damped.number_at(7, 14, 26), 2 * M_PI * turns[m], 5e-6 * 2 * M_PI * turns[m]);
        EXPECT_EQ(damped.lines.size(), 8 + 3 * 5u);
    }
    EXPECT_GT(decay.back(), 0);
    const UffSet nodes = uff_sets_of(sets, 2411).front();
    ASSERT_EQ(nodes.lines.size(), 52u);
    const std::vector<double> height = column_of(folder / "out/shapes.csv", "z");
    for (std::size_t s = 0; s < 21; ++s) {
        EXPECT_EQ(nodes.whole(10 + 2 * s, 1, 10), static_cast<int>(s) + 6);
        EXPECT_EQ(nodes.number_at(11 + 2 * s, 51, 75), height[s]) << "17 digits";
    }
    EXPECT_EQ(uff_sets_of(sets, 15).front().lines.size(), 26u);
}

TEST(Export, AResponseToAUnitForceIsAFrequencyResponse) {
    const TemporaryFolder folder;
    run_and_export(
        folder, {"response", "m.toml", "--in", "plate.left.z", "--out", "plate.position", "--from", "1 Hz", "--to", "90 Hz"},
        {"--uff58", "--channels", "plate.position.z"});
    const auto sets = uff_sets_of(read_uff(read_text(folder / "out.uff")), 58);
    ASSERT_EQ(sets.size(), 1u) << "of three";
    EXPECT_EQ(sets[0].whole(5, 1, 5), 4);
    EXPECT_EQ(sets[0].whole(5, 67, 76), 2);
    EXPECT_EQ(sets[0].whole(5, 77, 80), 3);
    const std::vector<double> frequency = column_of(folder / "out/response.csv", "frequency"),
                              real = column_of(folder / "out/response.csv", "plate.position.z.re"),
                              imaginary = column_of(folder / "out/response.csv", "plate.position.z.im");
    const auto back = read_uff_values(sets[0]);
    ASSERT_EQ(back.size(), frequency.size());
    for (std::size_t i = 0; i < frequency.size(); ++i) {
        EXPECT_NEAR(back[i][0], frequency[i], 5e-11 * frequency[i]);
        EXPECT_NEAR(back[i][1], real[i], 5e-13 * std::abs(real[i]));
        EXPECT_NEAR(back[i][2], imaginary[i], 5e-13 * std::abs(imaginary[i]));
    }
}

TEST(Export, ReplacesItsOwnFilesAndNoOthers) {
    const TemporaryFolder folder;
    fs::create_directories(folder / "pump");
    write_text(folder / "pump/history.csv", "time,a\ns,N\n0,1\n0.1,2\n");
    for (const char* ending : {"mat", "uff"}) {
        const std::string format = ending == std::string("mat") ? "--mat" : "--uff58", file = std::string("pump.") + ending;
        EXPECT_EQ(run_dttmm(folder.path(), {"export", "pump/", format}).code, 0);
        EXPECT_EQ(run_dttmm(folder.path(), {"export", "pump", format}).code, 0) << "its own file may be replaced";
        for (const char* work :
             {"years of dttmm", "MATLAB 5.0 MAT-file, years of work", "    -1\n   151\nyears of work\n"}) {
            write_text(folder / file, work);
            const Ended ended = run_dttmm(folder.path(), {"export", "pump", format});
            EXPECT_EQ(ended.code, 5);
            EXPECT_THAT(ended.err,
                        HasSubstr(file + ": is there and was not exported by dttmm; choose another file with -o"));
            EXPECT_EQ(read_text(folder / file), work);
        }
    }
    const Ended named = run_dttmm(folder.path(), {"export", "pump/history.csv", "--mat", "-o", "b.mat", "-q"});
    EXPECT_EQ(named.code, 0) << named.err;
    EXPECT_EQ(named.out, "");
    EXPECT_TRUE(fs::exists(folder / "b.mat"));
}

// A file in the results folder would be a foreign one there, and a new run would refuse the folder.
TEST(Export, StandsBesideTheFolderInWhichItIsCalled) {
    const TemporaryFolder folder;
    fs::create_directories(folder / "pump");
    write_text(folder / "pump/history.csv", "time,a\ns,N\n0,1\n0.1,2\n");
    for (const char* name : {".", "./", "history.csv"}) {
        const Ended ended = run_dttmm(folder / "pump", {"export", name, "--mat"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_TRUE(fs::remove(folder / "pump.mat")) << name;
        EXPECT_EQ(std::distance(fs::directory_iterator(folder / "pump"), {}), 1) << name;
    }
}

TEST(Export, RefusesWhatCannotBe) {
    const TemporaryFolder folder;
    fs::create_directories(folder / "pump");
    write_text(folder / "pump/history.csv", "time,a\ns,N\n0,1\n0.1,2\n");
    const auto expect = [&](std::vector<std::string> words, int code, const char* text) {
        words.insert(words.begin(), {"export", "pump"});
        const Ended ended = run_dttmm(folder.path(), words);
        EXPECT_EQ(ended.code, code) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(text));
    };
    expect({}, 2, "say which format: one or more of --gltf, --vtu, --mat, --uff58, --uff55");
    expect({"--mat", "--uff58", "-o", "a.mat"}, 2, "-o names one file");
    expect({"--uff58", "--uff55"}, 2, "are both files .uff");
    expect({"--uff55"}, 2, "modes have shapes; export the results of dttmm modes");
    expect({"--gltf"}, 2, "there is no summary.json");
    expect({"--gltf", "--channels", "a"}, 2, "--channels chooses the curves of --mat and --uff58");
    expect({"--mat", "--channels", "bolt"}, 2, "--channels: the pattern \"bolt\" matches no channel");
    expect({"--mat", "-o", "a.txt"}, 2, "a.txt: --mat writes a file whose name ends with .mat");
    expect({"--mat", "-o", "none/a.mat"}, 5, "none/a.mat: cannot write");
    write_text(folder / "pump/summary.json", "{\"format\": \"dttmm-modes/1\", \"modes\": [{\"frequency_hz\": \"x\"}]}");
    expect({"--uff55"}, 5, "summary.json: damaged: ");
    EXPECT_FALSE(fs::exists(folder / "pump.uff"));
    write_text(folder / "pump/summary.json",
               "{\"format\": \"dttmm-modes/1\", \"inputs\": {\"model_text\": 3}, \"modes\": []}");
    expect({"--mat"}, 5, "summary.json: damaged: ");
    write_text(folder / "pump/summary.json", "{\"format\": \"dttmm-modes/1\", \"modes\": []");
    expect({"--uff55"}, 5, "summary.json: damaged: ");
}

// A model that asks for one channel: nothing of it moves in a picture, until the run records for one.
TEST(Export, ForReportRecordsWhatMoves) {
    const TemporaryFolder folder;
    write_text(folder / "pump.toml",
               small_model_with("step = \"5 ms\"\n", "step = \"5 ms\"\nchannels = [\"one.force.z\"]\n"));
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "pump.toml", "-q", "-o", "few"}).code, 0);
    const Ended refused = run_dttmm(folder.path(), {"export", "few", "--gltf"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr("run with --for-report"));
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "pump.toml", "-q", "-o", "all", "--for-report"}).code, 0);
    const std::string history = read_text(folder / "all/history.csv");
    EXPECT_EQ(
        history.substr(0, history.find('\n')),
        "time,one.force.x,one.force.y,one.force.z,two.force.x,two.force.y,two.force.z,plate.position.x,"
        "plate.position.y,plate.position.z,plate.quaternion.w,plate.quaternion.x,plate.quaternion.y,plate.quaternion.z");
    EXPECT_EQ(run_dttmm(folder.path(), {"export", "all", "--gltf"}).code, 0);
}

// A clamped beam under its own weight moves in its middle, where no node is.
TEST(Export, ForReportRecordsBeamsBetweenTheirEnds) {
    const TemporaryFolder folder;
    write_text(folder / "beam.toml", R"(format = "dttmm/1"
[simulation]
duration = "20 ms"
step = "1 ms"
gravity = [0, -3, -9]
[nodes]
left = { position = [0.1, 0.2, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
right = { position = [0.7, 0.5, 0.9], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[element]]
name = "arm"
type = "beam"
from = "left"
to = "right"
segments = 20
section = { tube = ["12 mm", "8 mm"] }
material = { E = "70 GPa", poisson = 0.33, density = 2700 }
)");
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "beam.toml", "-q", "-o", "bent", "--for-report"}).code, 0);
    const Ended ended = run_dttmm(folder.path(), {"export", "bent", "--vtu"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const HistoryFile history(folder / "bent/history.csv");
    const auto column = [&](const std::string& name) {
        const auto found = std::ranges::find(history.columns(), name, &Column::name);
        return history.read({static_cast<int>(found - history.columns().begin())}).front();
    };
    const std::vector<double> middle = column("arm.station5.position.z");
    EXPECT_NEAR(middle.front(), 0.6, 1e-12);
    EXPECT_LT(middle.back(), 0.6 - 1e-5);
    std::vector<fs::path> frames(fs::directory_iterator(folder / "bent.frames"), {});
    const VtuReader last(read_text(std::ranges::max(frames)));
    const std::vector<double> points = last.doubles("Points");
    double nearest = 1;
    for (std::size_t i = 2; i < points.size(); i += 3) nearest = std::min(nearest, std::abs(points[i] - middle.back()));
    EXPECT_LT(nearest, 1e-7) << "the middle of the beam is where the run had it";
}

}  // namespace
}  // namespace dttmm::host
