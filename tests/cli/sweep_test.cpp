// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "analysis/request.h"
#include "cli/process.h"
#include "cli/small_model.h"
#include "support/csv_line.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class Sweep : public testing::Test {
protected:
    Sweep() { write_text(folder_ / "model.toml", kSmallModel); }

    Ended sweep(const std::vector<std::string>& axes, const std::string& jobs = "2") {
        std::vector<std::string> words = {"run", "model.toml", "-o", "out", "-j", jobs};
        for (const std::string& axis : axes) words.insert(words.end(), {"--sweep", axis});
        return run_dttmm(folder_.path(), words);
    }
    fs::path case_file(int number, const std::string& name) const {
        return folder_ / ("out/case-00000" + std::to_string(number)) / name;
    }
    std::vector<std::string> table() const {
        std::istringstream text(read_text(folder_ / "out/sweep.csv"));
        std::vector<std::string> lines;
        for (std::string line; std::getline(text, line);) lines.push_back(line);
        return lines;
    }

    const TemporaryFolder folder_;
};

// Oracle: a case is the run with these values set: the same bytes of history, and its final force in sweep.csv.
TEST_F(Sweep, ACaseIsTheRunWithItsValues) {
    write_text(folder_ / "model.toml", small_model_with("step = \"5 ms\"", "step = \"1 ms\""));
    const Ended ended = sweep({"mass=1 kg..5 kg:3"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("3 of 3 cases completed (0 of them reused), 0 failed, 0 not run"));
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-o", "alone", "--set", "mass=3 kg"}).code, 0);
    EXPECT_EQ(read_text(case_file(2, "history.csv")), read_text(folder_ / "alone/history.csv"));
    ASSERT_EQ(table().size(), 5u);
    EXPECT_THAT(table()[0], StartsWith("case,mass,status,reason,warnings,one.force.x.peak,"));
    EXPECT_THAT(table()[1], StartsWith(",kg,,,,N,N,"));
    EXPECT_THAT(table()[1], testing::EndsWith(",m/s^2"));
    EXPECT_THAT(table()[3], StartsWith("case-000002,3,completed,,0,"));
    EXPECT_THAT(table()[4], StartsWith("case-000003,5,completed,,0,"));
}

// Oracle: the columns of the table on the screen: an element for each that has a force.
TEST_F(Sweep, MassesHaveNoForceToShow) {
    write_text(folder_ / "model.toml", R"(format = "dttmm/1"
[parameters]
k = 1e5
[simulation]
duration = 0.01
step = "1 ms"
[nodes]
tip = [0.3, 0, 0]
[[body]]
name = "b"
mass = 3
inertia = [0.02, 0.03, 0.025]
velocity = [1, 0, 0]
[[element]]
name = "weight"
type = "rigid_body"
at = "tip"
mass = 0.5
inertia = { xx = 0.001, yy = 0.001, zz = 0.001 }
[[element]]
name = "mount"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = "=k"
rotational_stiffness = 500
[[element]]
name = "arm"
type = "spring_damper"
from = "b"
to = "tip"
stiffness = 1e4
rotational_stiffness = 1e3
)");
    const Ended ended = sweep({"k=1e5,2e5"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("mount [N]"));
    EXPECT_THAT(ended.out, HasSubstr("arm [N]"));
    EXPECT_THAT(ended.out, testing::Not(HasSubstr("weight")));
}

// Oracle: the folder: it keeps the third case of the sweep before.
TEST_F(Sweep, CasesOfAnEarlierSweepAreTold) {
    EXPECT_THAT(sweep({"mass=1 kg..5 kg:3"}).err, testing::Not(HasSubstr("earlier")));
    EXPECT_THAT(sweep({"mass=1 kg..5 kg:2"}).err, HasSubstr("case-000003 and the cases behind it are of an earlier sweep"));
    EXPECT_TRUE(fs::exists(case_file(3, "history.csv")));
    ASSERT_EQ(table().size(), 4u);
}

TEST_F(Sweep, TwoAxesSpanAGridTheLastFastest) {
    write_text(folder_ / "model.toml", small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\nk = 7"));
    EXPECT_EQ(sweep({"mass=1 kg,2 kg", "k=3..5:3"}).code, 0);
    ASSERT_EQ(table().size(), 8u);
    EXPECT_THAT(table()[2], StartsWith("case-000001,1,3,"));
    EXPECT_THAT(table()[4], StartsWith("case-000003,1,5,"));
    EXPECT_THAT(table()[5], StartsWith("case-000004,2,3,"));
}

// Oracle: 60 kN/m over 30, and what the model gives to the parameter that is not swept.
TEST_F(Sweep, TheTableShowsAllParameters) {
    write_text(folder_ / "model.toml",
               small_model_with("mass = \"2 kg\"", "k = \"60 kN/m\"\nmass = \"2 kg\"\nderived = \"=k/30\""));
    ASSERT_EQ(sweep({"mass=1 kg,0 kg"}).code, 9);
    EXPECT_THAT(table()[0], StartsWith("case,k,mass,derived,status,reason,"));
    EXPECT_THAT(table()[1], StartsWith(",N/m,kg,,,,,N,"));
    EXPECT_THAT(table()[2], StartsWith("case-000001,60000,1,2000,completed,,"));
    EXPECT_THAT(table()[3], StartsWith("case-000002,,0,,failed,"));
    ASSERT_EQ(run_dttmm(folder_.path(), {"modes", "model.toml", "-o", "modes", "--sweep", "mass=1 kg,2 kg", "-q"}).code, 0);
    EXPECT_THAT(read_text(folder_ / "modes/sweep.csv"), StartsWith("case,k,mass,derived,curve1,"));
    EXPECT_THAT(read_text(folder_ / "modes/sweep.csv"), HasSubstr("\n,N/m,kg,,Hz,"));
    EXPECT_THAT(read_text(folder_ / "modes/sweep.csv"), HasSubstr("\ncase-000002,60000,2,2000,"));
}

TEST_F(Sweep, AParameterCalledLikeAColumnIsRefused) {
    for (const char* name : {"case", "status", "reason", "warnings", "curve3", "mac1"}) {
        write_text(folder_ / "model.toml",
                   small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\n" + std::string(name) + " = 7"));
        for (const char* command : {"run", "modes"}) {
            const Ended ended = run_dttmm(folder_.path(), {command, "model.toml", "-o", "out", "--sweep", "mass=1 kg,2 kg"});
            EXPECT_EQ(ended.code, 3) << name;
            EXPECT_THAT(ended.err, testing::EndsWith("dttmm: model.toml: the parameter \"" + std::string(name) +
                                                     "\" is called like a column of sweep.csv; call it \"" + name +
                                                     "_\", or anything else\n"));
        }
        EXPECT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-o", "alone"}).code, 0) << "without a sweep it may";
    }
}

// Oracle: the same keys in the summaries of all three commands, with the same numbers.
TEST_F(Sweep, TheModelInASummaryHasOneForm) {
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-o", "run"}).code, 0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"modes", "model.toml", "-o", "modes"}).code, 0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"frf", "model.toml", "-o", "frf", "--in", "plate.z", "--out", "plate.z", "--from",
                                         "1 Hz", "--to", "2 Hz", "--points", "2"})
                  .code,
              0);
    const nlohmann::json model = read_json(folder_ / "run/summary.json")["model"];
    EXPECT_EQ(model["bodies"]["plate"]["mass"], 2);
    EXPECT_EQ(read_json(folder_ / "modes/summary.json")["model"], model);
    EXPECT_EQ(read_json(folder_ / "frf/summary.json")["model"], model);
}

TEST_F(Sweep, AFailingCaseIsNamedAndTheOthersGoOn) {
    const Ended ended = sweep({"mass=1 kg,0 kg,3 kg"});
    EXPECT_EQ(ended.code, 9);
    EXPECT_THAT(ended.err, AllOf(StartsWith("case-000002 mass=0 kg: exit code 3: "), HasSubstr("mass must lie within")));
    EXPECT_THAT(ended.out, HasSubstr("2 of 3 cases completed (0 of them reused), 1 failed"));
    EXPECT_THAT(table()[3], StartsWith("case-000002,0,failed,\"exit code 3: "));
    EXPECT_TRUE(fs::exists(case_file(3, "summary.json")));
    EXPECT_FALSE(fs::exists(case_file(2, "history.h5")));
}

// Oracle: the printed counts and the files' times: what is whole is not touched.
TEST_F(Sweep, ARerunComputesOnlyWhatIsMissing) {
    const std::vector<std::string> axes = {"mass=1 kg..5 kg:5"};
    ASSERT_EQ(sweep(axes).code, 0);
    const std::string whole = read_text(folder_ / "out/sweep.csv");
    fs::remove_all(case_file(2, ""));
    fs::resize_file(case_file(4, "summary.json"), 100);
    const auto untouched = fs::last_write_time(case_file(3, "summary.json"));

    const Ended again = sweep(axes);
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(again.out, HasSubstr("5 of 5 cases completed (3 of them reused)"));
    EXPECT_EQ(fs::last_write_time(case_file(3, "summary.json")), untouched);
    EXPECT_EQ(read_text(folder_ / "out/sweep.csv"), whole);
}

// Oracle: another model text is another sweep; nothing old may be taken for new.
TEST_F(Sweep, AChangedModelIsComputedAnew) {
    ASSERT_EQ(sweep({"mass=1 kg,2 kg"}).code, 0);
    write_text(folder_ / "model.toml", small_model_with("100 N", "120 N"));
    const Ended again = sweep({"mass=1 kg,2 kg"});
    EXPECT_EQ(again.code, 0);
    EXPECT_THAT(again.out, HasSubstr("(0 of them reused)"));
}

// Oracle: a case that says it was made by another build, or by one that did not say, is computed anew.
TEST_F(Sweep, CasesOfAnotherBuildAreComputedAnew) {
    ASSERT_EQ(sweep({"mass=1 kg..3 kg:3"}).code, 0);
    nlohmann::ordered_json other = nlohmann::ordered_json::parse(read_text(case_file(1, "summary.json")));
    EXPECT_EQ(other["inputs"]["version"], "0.1.0");
    other["inputs"]["build"] = "0123456789abcdef-1 0123456789abcdef-2";
    write_text(case_file(1, "summary.json"), other.dump());
    other = nlohmann::ordered_json::parse(read_text(case_file(2, "summary.json")));
    other["inputs"].erase("build");
    write_text(case_file(2, "summary.json"), other.dump());
    EXPECT_THAT(sweep({"mass=1 kg..3 kg:3"}).out, HasSubstr("3 of 3 cases completed (1 of them reused)"));
}

// Oracle: the order in which cases end does not matter: one at a time or four, the same table.
TEST_F(Sweep, TheNumberOfJobsChangesNothing) {
    ASSERT_EQ(sweep({"mass=1 kg..7 kg:7"}, "1").code, 0);
    const std::string one = read_text(folder_ / "out/sweep.csv");
    fs::remove_all(folder_ / "out");
    ASSERT_EQ(sweep({"mass=1 kg..7 kg:7"}, "4").code, 0);
    EXPECT_EQ(read_text(folder_ / "out/sweep.csv"), one);
}

// Oracle: the table of options. Whatever changes the results of a run is handed to the cases of a sweep, which name it among
// their inputs with the value given. A new option wants a value here.
TEST_F(Sweep, EveryOptionReachesItsCases) {
    std::string text = small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\nk = 7");
    text.replace(text.find("on = \"plate\""), 0, "name = \"push\"\n");
    write_text(folder_ / "model.toml", text + "[[case]]\nname = \"pushed\"\nloads = [\"push\"]\n");
    const std::map<std::string, std::string> values = {{"--set", "k=9"},
                                                       {"--step", "0.5 ms"},
                                                       {"--tolerance", "20 %"},
                                                       {"--duration", "40 ms"},
                                                       {"--coupling", "implicit"},
                                                       {"--output-step", "10 ms"},
                                                       {"--channels", "one"},
                                                       {"--plugin", test::paths::c_spring()},
                                                       {"--force", ""},
                                                       {"--for-report", ""},
                                                       {"--case", "pushed"}};
    std::vector<std::string> words = {"run", "model.toml", "-q", "-o", "out", "--sweep", "mass=1 kg,3 kg"};
    size_t given = 0;
    for (const Option& option : options()) {
        if (!(option.commands & kRun) || !option.changes_results) continue;
        ASSERT_TRUE(option.reaches_cases) << option.name();
        ASSERT_TRUE(values.contains(option.name())) << option.name() << ": give it a value in this test";
        ++given;
        words.push_back(option.name());
        if (option.kind != Option::Kind::flag) words.push_back(values.at(option.name()));
    }
    ASSERT_EQ(given, values.size());
    const Ended ended = run_dttmm(folder_.path(), words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json summary = read_json(case_file(2, "summary.json")), inputs = summary["inputs"]["options"];
    for (const auto& [name, value] : values) {
        ASSERT_TRUE(inputs.contains(name)) << name;
        EXPECT_EQ(inputs[name][0], value) << name;
    }
    EXPECT_EQ(inputs["--set"][1], "mass=3 kg");
    EXPECT_EQ(summary["rows"], 5);
    EXPECT_THAT(read_text(case_file(2, "history.csv")), StartsWith("time,one.force.x,"));
    EXPECT_THAT(run_dttmm(folder_.path(), words).code, 0);
    words.erase(std::find(words.begin(), words.end(), "-q"));
    EXPECT_THAT(run_dttmm(folder_.path(), words).out, HasSubstr("(2 of them reused)"));
    *(std::find(words.begin(), words.end(), "--output-step") + 1) = "20 ms";
    EXPECT_THAT(run_dttmm(folder_.path(), words).out, HasSubstr("(0 of them reused)"));
}

/// n masses on springs from the ground, with a spring from each to the next.
constexpr const char* kRow = R"(format = "dttmm/1"
[parameters]
n = 3
[simulation]
duration = "20 ms"
step = "1 ms"
[[repeat]]
index = "i"
count = "=n"
[[repeat.body]]
name = "b{i}"
mass = "=1+i"
inertia = [0.1, 0.2, 0.15]
markers.top = [0, 0, 0.05]
position = ["=0.3*i", "=0.1*i*i", 0.05]
[[repeat.element]]
name = "s{i}"
type = "spring_damper"
from = "ground"
to = "b{i}.top"
stiffness = 2e4
rotational_stiffness = "=1000*i"
[[repeat.load]]
on = "b{i}"
direction = [1, 2, 3]
force = "=10*sin(300*t)*i"
[[repeat]]
index = "i"
count = "=n-1"
[[repeat.element]]
name = "t{i}"
type = "spring_damper"
from = "b{i}"
to = "b{i+1}"
stiffness = "=2e4/i"
)";

/// Cells of sweep.csv by column, of the row of a case counted from 1.
std::map<std::string, std::string> cells_of_case(const std::vector<std::string>& table, size_t number) {
    const std::vector<std::string> names = test::split_csv_line(table.at(0)),
                                   cells = test::split_csv_line(table.at(number + 1));
    EXPECT_EQ(names.size(), cells.size());
    std::map<std::string, std::string> row;
    for (size_t c = 0; c < std::min(names.size(), cells.size()); ++c) row[names[c]] = cells[c];
    return row;
}

// Oracle: a run of each case by itself: its summary has the same forces. Whichever case comes first, the columns are those
// of the largest, in its order, and a case leaves empty what it does not have.
TEST_F(Sweep, CasesMayHaveDifferentElements) {
    write_text(folder_ / "model.toml", kRow);
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-o", "alone", "--set", "n=4"}).code, 0);
    const nlohmann::json alone = read_json(folder_ / "alone/summary.json");
    std::string heads;
    for (const auto& [axis, largest] : {std::pair{"n=4,3,2", 1u}, {"n=2..4:3", 3u}}) {
        fs::remove_all(folder_ / "out");
        const Ended ended = sweep({axis});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.out, AllOf(HasSubstr("s4 [N]"), HasSubstr("t3 [N]"), HasSubstr("  -")));
        if (heads.empty()) heads = table()[0];
        EXPECT_EQ(table()[0], heads);
        EXPECT_THAT(table()[0],
                    AllOf(HasSubstr("s4.force.z.final,t1.force.x.peak"), HasSubstr("b3.top.acceleration.z.peak,"
                                                                                   "b4.top.acceleration.x.peak")));
        const auto all = cells_of_case(table(), largest), fewest = cells_of_case(table(), 4 - largest);
        EXPECT_EQ(all.at("n"), "4");
        for (const char* name : {"s1", "s3", "s4", "t2", "t3"})
            EXPECT_EQ(std::stod(all.at(std::string(name) + ".force.y.final")),
                      alone["elements"][name]["force"]["y"]["final"]);
        for (const char* name : {"s3.force.x.peak", "s4.force.z.final", "t2.force.x.peak", "b3.top.acceleration.x.peak"})
            EXPECT_EQ(fewest.at(name), "") << name;
        EXPECT_NE(fewest.at("s2.force.x.peak"), "");
        EXPECT_NE(cells_of_case(table(), 2).at("s3.force.x.peak"), "");
        EXPECT_EQ(cells_of_case(table(), 2).at("s4.force.x.peak"), "");
    }
}

// Oracle: a response of each case by itself: its curves.
TEST_F(Sweep, ResponsesOfDifferentMachines) {
    std::string text = kRow;
    const std::string force = "force = \"=10*sin(300*t)*i\"";
    write_text(folder_ / "model.toml", text.replace(text.find(force), force.size(), "harmonic = { amplitude = \"=10*i\" }"));
    for (const auto& [axis, largest] : {std::pair{"n=4,2", 1u}, {"n=2,4", 2u}}) {
        const Ended ended = run_dttmm(folder_.path(), {"response", "model.toml", "-o", "out", "--from", "1Hz", "--to",
                                                       "60Hz", "--out", "b*.position.x", "--points", "7", "--sweep", axis});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.out, HasSubstr("b4.position.x"));
        const auto all = cells_of_case(table(), largest), fewest = cells_of_case(table(), 3 - largest);
        for (const char* body : {"b1", "b2", "b3", "b4"}) {
            const std::string name = std::string(body) + ".position.x.largest";
            ASSERT_TRUE(all.contains(name)) << table()[0];
            EXPECT_NE(all.at(name), "");
            EXPECT_EQ(fewest.at(name) == "", body[1] > '2') << name;
        }
    }
}

// Oracle: masses that are not connected: the modes of a mass are the same in every case, and no mode of b1 or b2 goes on as
// one of b3, which only the second case has.
TEST_F(Sweep, ModesOfDifferentMachines) {
    std::string text = kRow;
    text.erase(text.rfind("[[repeat]]"));
    write_text(folder_ / "model.toml", text);
    for (const auto& [axis, largest] : {std::pair{"n=3,2", 1u}, {"n=2,3", 2u}}) {
        const Ended ended =
            run_dttmm(folder_.path(), {"modes", "model.toml", "-o", "out", "--count", "18", "--sweep", axis, "-q"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        const auto more = cells_of_case(table(), largest), fewer = cells_of_case(table(), 3 - largest);
        size_t followed = 0;
        for (int k = 1; k <= 18; ++k) {
            const std::string curve = "curve" + std::to_string(k);
            ASSERT_TRUE(more.contains(curve)) << table()[0];
            if (fewer.at(curve) == "") continue;
            ++followed;
            EXPECT_NEAR(std::stod(fewer.at(curve)), std::stod(more.at(curve)), 1e-6 * std::stod(fewer.at(curve))) << curve;
        }
        EXPECT_EQ(followed, 12u);
        EXPECT_THAT(ended.err, testing::Not(HasSubstr("likeness")));
    }
}

}  // namespace
}  // namespace dttmm::host
