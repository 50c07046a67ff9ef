// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm study` as a user has it: cases, tables, what is left after kills and faults.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "cli/process.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// results.csv by the names of its columns.
struct StudyTable {
    std::vector<std::string> names, units;
    std::vector<std::vector<std::string>> rows;

    std::string cell(size_t row, const std::string& name) const {
        const auto found = std::ranges::find(names, name);
        if (found == names.end()) {
            ADD_FAILURE() << "no column " << name;
            return {};
        }
        return rows.at(row).at(static_cast<size_t>(found - names.begin()));
    }
    size_t count(const std::string& status) const {
        size_t number = 0;
        for (size_t i = 0; i < rows.size(); ++i) number += cell(i, "status") == status ? 1 : 0;
        return number;
    }
};

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    if (line.ends_with(',')) cells.emplace_back();
    return cells;
}

StudyTable read_study(const fs::path& file) {
    StudyTable table;
    std::istringstream in(read_text(file));
    std::string line;
    std::getline(in, line);
    table.names = cells_of(line);
    std::getline(in, line);
    table.units = cells_of(line);
    while (std::getline(in, line)) table.rows.push_back(cells_of(line));
    return table;
}

class Study : public testing::Test {
protected:
    Study() { write_text(folder_ / "model.toml", kSmallModel); }

    Ended study(std::vector<std::string> words) const {
        words.insert(words.begin(), "study");
        return run_dttmm(folder_.path(), words);
    }
    /// Of a model with so many cases that it takes a while.
    std::vector<std::string> long_study() const {
        return {"study", "model.toml", "--vary", "mass ~ uniform(1 kg, 3 kg)", "--cases", "600", "-o", "out", "-q"};
    }
    StudyTable results() const { return read_study(folder_ / "out/results.csv"); }
    size_t cases_done() const {
        std::error_code none;
        size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder_ / "out/journal", none)) {
            std::istringstream in(read_text(entry.path()));
            for (std::string line; std::getline(in, line);) count += line.starts_with("{\"end\"") ? 1 : 0;
        }
        return count;
    }
    const TemporaryFolder folder_;
};

// Oracle: a case is the run with its values: the figures have the same bits as those of the run's summary and history.
TEST_F(Study, ACaseHasTheFiguresOfItsRun) {
    const Ended ended = study({"model.toml", "--vary", "mass ~ normal(2 kg, 10 %)", "--cases", "7", "--seed", "5", "-o",
                               "out", "--figures", "one.force.z:peak,final", "--figures", "plate.position.z:final"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("7 of 7 cases completed, 0 failed, 0 not run"));
    const StudyTable table = results();
    EXPECT_THAT(table.names, testing::ElementsAre("case", "status", "warnings", "mass", "one.force.z.peak",
                                                  "one.force.z.final", "plate.position.z.final"));
    EXPECT_THAT(table.units, testing::ElementsAre("1", "", "1", "kg", "N", "N", "m"));
    ASSERT_EQ(table.rows.size(), 7u);
    for (const size_t row : {size_t{0}, size_t{4}}) {
        const std::string mass = "mass=" + table.cell(row, "mass") + " kg";
        ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "alone", "--set", mass}).code, 0);
        const nlohmann::json force = read_json(folder_ / "alone/summary.json")["elements"]["one"]["force"]["z"];
        EXPECT_EQ(table.cell(row, "case"), std::to_string(row + 1));
        EXPECT_EQ(std::stod(table.cell(row, "one.force.z.peak")), force["peak"].get<double>());
        EXPECT_EQ(std::stod(table.cell(row, "one.force.z.final")), force["final"].get<double>());
    }
}

// Oracle: the same bytes for any number of processes, and when it is collected again.
TEST_F(Study, ResultsDoNotDependOnTheProcesses) {
    std::string first;
    for (const char* jobs : {"1", "3"}) {
        fs::remove_all(folder_ / "out");
        ASSERT_EQ(
            study({"model.toml", "--vary", "mass ~ lognormal(2 kg, 10 %)", "--cases", "40", "-o", "out", "-j", jobs, "-q"})
                .code,
            0);
        if (first.empty()) first = read_text(folder_ / "out/results.csv");
        EXPECT_EQ(read_text(folder_ / "out/results.csv"), first);
    }
    ASSERT_EQ(study({"collect", "out"}).code, 0);
    EXPECT_EQ(read_text(folder_ / "out/results.csv"), first);
}

// Oracle: killed at any time, the same command goes on, and the table is that of a study nobody killed.
TEST_F(Study, GoesOnAfterAnyKill) {
    ASSERT_EQ(run_dttmm(folder_.path(), long_study()).code, 0);
    const std::string whole = read_text(folder_ / "out/results.csv");
    fs::remove_all(folder_ / "out");
    for (const int signal : {SIGKILL, SIGINT, SIGKILL}) {
        Process running(long_study(), folder_.path());
        const size_t before = cases_done();
        ASSERT_TRUE(wait_until([&] { return cases_done() > before + 20; }));
        running.send(signal);
        const Ended ended = running.wait();
        EXPECT_EQ(ended.code, signal == SIGINT ? 130 : -SIGKILL) << ended.err;
        if (signal == SIGINT) {
            EXPECT_THAT(ended.err, HasSubstr("cases are kept, the same command goes on"));
            EXPECT_GT(results().count("missing"), 0u);
        }
    }
    const size_t done = cases_done();
    EXPECT_LT(done, 600u);
    ASSERT_EQ(run_dttmm(folder_.path(), long_study()).code, 0);
    EXPECT_EQ(read_text(folder_ / "out/results.csv"), whole);
    // Nothing twice but what the kills took out of hand
    EXPECT_LT(cases_done(), 600u + 3 * 2 + 20);
}

TEST_F(Study, IsFrozen) {
    const std::vector<std::string> words = {"model.toml", "--vary", "mass ~ normal(2 kg, 10 %)", "--cases", "3", "-o",
                                            "out",        "-q"};
    ASSERT_EQ(study(words).code, 0);
    const std::string journal = read_text(folder_ / "out/study.json");
    ASSERT_EQ(study(words).code, 0) << "the same again";
    for (const auto& [place, value, says] :
         {std::tuple(4, "4", "the number of cases"), {2, "mass ~ normal(2 kg, 20 %)", "the values of the cases"}}) {
        std::vector<std::string> others = words;
        others[static_cast<size_t>(place)] = value;
        const Ended ended = study(others);
        EXPECT_EQ(ended.code, 5);
        EXPECT_THAT(ended.err,
                    AllOf(HasSubstr("out: it holds another study, and a study is never changed"), HasSubstr(says)));
    }
    write_text(folder_ / "model.toml", small_model_with("100 N", "101 N"));
    EXPECT_THAT(study(words).err, HasSubstr("the model differs"));
    EXPECT_EQ(study({"collect", "out"}).code, 0) << "the copy of the model serves";
    EXPECT_EQ(read_text(folder_ / "out/study.json"), journal);
    fs::create_directory(folder_ / "other");
    write_text(folder_ / "other/diary.txt", "dear diary");
    std::vector<std::string> elsewhere = words;
    elsewhere[6] = "other";
    EXPECT_EQ(study(elsewhere).code, 5);
    EXPECT_EQ(read_text(folder_ / "other/diary.txt"), "dear diary");
}

// Oracle: by the masses of the table: 0 kg is no mass.
TEST_F(Study, FailuresAreCountedEverywhere) {
    write_text(folder_ / "cases.csv", "mass\nkg\n1\n0\n3\n-1\n");
    const Ended ended = study({"model.toml", "--table", "cases.csv", "-o", "out"});
    EXPECT_EQ(ended.code, 9);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("case 2: exit code 3: "), HasSubstr("case 4: exit code 3: ")));
    EXPECT_THAT(ended.out, HasSubstr("2 of 4 cases completed, 2 failed, 0 not run"));
    EXPECT_EQ(results().cell(1, "status"), "failed");
    EXPECT_EQ(results().cell(1, "one.force.z.peak"), "");
    EXPECT_EQ(results().cell(2, "status"), "completed");
    const nlohmann::json summary = read_json(folder_ / "out/summary.json");
    EXPECT_EQ(summary["failed"], 2);
    EXPECT_EQ(summary["statistics"]["one.force.z.peak"]["count"], 2);
    EXPECT_THAT(read_text(folder_ / "out/failures.csv"), HasSubstr("\n2,"));
    std::istringstream statistics(read_text(folder_ / "out/statistics.csv"));
    std::string line;
    for (int i = 0; i < 3; ++i) std::getline(statistics, line);
    EXPECT_THAT(line, StartsWith("one.force.x.peak,N,2,0,2,0,"));
    // Tried again they fail again, as a second attempt, and nothing else is done
    const size_t before = cases_done();
    EXPECT_EQ(study({"retry", "out", "-q"}).code, 9);
    EXPECT_EQ(cases_done(), before + 2);
    EXPECT_THAT(study({"status", "out"}).out, HasSubstr("2 of 4 cases completed, 2 failed, 0 not run"));
}

// Oracle: the plugin crashes at its step 1000, which three of the five durations reach.
TEST_F(Study, ACrashTakesItsCaseAlone) {
    std::string text = faulty_model();
    text.replace(text.find("\"2 s\""), 5, "\"=until\"");
    text.replace(text.find("mass = \"2 kg\""), 13, "mass = \"2 kg\"\nuntil = \"2 s\"");
    write_text(folder_ / "model.toml", text);
    const std::string plugin = test::paths::faulty_plugins() + "/segmentation_at_step_1000.so";
    const Ended ended =
        study({"model.toml", "--plugin", plugin, "--sweep", "until=0.1s,2s,0.3s,3s,1.5s", "-o", "out", "-j", "1"});
    EXPECT_EQ(ended.code, 9) << ended.err;
    EXPECT_EQ(results().count("completed"), 2u);
    EXPECT_EQ(results().count("failed"), 3u);
#ifndef __SANITIZE_ADDRESS__  // the sanitizer reports faults of the processor itself
    EXPECT_THAT(ended.err, HasSubstr("case 2: exit code 7: "));
#endif
}

// A plugin that does not return, and a run that is only long.
TEST_F(Study, ACaseThatHangsIsStoppedAtItsLimit) {
    std::string text = faulty_model();
    text.replace(text.find("\"2 s\""), 5, "\"=until\"");
    text.replace(text.find("mass = \"2 kg\""), 13, "mass = \"2 kg\"\nuntil = \"2 s\"");
    write_text(folder_ / "model.toml", text);
    const Ended ended = study({"model.toml", "--plugin", test::paths::faulty_plugins() + "/endless.so", "--sweep",
                               "until=0.1s,2s,0.3s", "-o", "out", "--limit", "2 s"});
    EXPECT_EQ(ended.code, 9) << ended.err;
    EXPECT_EQ(results().count("completed"), 2u);
    EXPECT_THAT(ended.err, HasSubstr("case 2: exit code 6: it took longer than its limit of 2 s"));
}

// Oracle: no new file can grow beyond a limit: as on a full disk the study ends with code 5 and keeps what is whole.
TEST_F(Study, AFullDiskEndsItInOrder) {
    Process running(long_study(), folder_.path());
    ASSERT_TRUE(wait_until([&] { return cases_done() > 20; }));
    rlimit small{2000, 2000};
    ::prlimit(running.id(), RLIMIT_FSIZE, &small, nullptr);  // of the processes it starts from now on
    const Ended ended = running.wait();
    EXPECT_EQ(ended.code, 5) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("cannot be written"));
    ASSERT_EQ(run_dttmm(folder_.path(), long_study()).code, 0);
    EXPECT_EQ(results().count("completed"), 600u);
}

// Oracle: two at once share the work and disturb nobody.
TEST_F(Study, TwoAtOnceAndTwoCollects) {
    Process one(long_study(), folder_.path());
    ASSERT_TRUE(wait_until([&] { return cases_done() > 5; }));
    Process two(long_study(), folder_.path()), collect({"study", "collect", "out", "-q"}, folder_.path()),
        again({"study", "collect", "out", "-q"}, folder_.path());
    EXPECT_EQ(collect.wait().code, 0);
    EXPECT_EQ(again.wait().code, 0);
    EXPECT_EQ(one.wait().code, 0);
    EXPECT_EQ(two.wait().code, 0);
    EXPECT_EQ(results().count("completed"), 600u);
    EXPECT_EQ(results().rows.size(), 600u);
}

// Oracle: what `dttmm run` writes for the same values.
TEST_F(Study, KeptResultsAreThoseOfTheRun) {
    ASSERT_EQ(study({"model.toml", "--sweep", "mass=1 kg,3 kg", "-o", "out", "--keep", "-q"}).code, 0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "alone", "--set", "mass=3 kg"}).code, 0);
    EXPECT_EQ(read_text(folder_ / "out/case-000002/history.csv"), read_text(folder_ / "alone/history.csv"));
    const nlohmann::json kept = read_json(folder_ / "out/case-000002/summary.json"),
                         alone = read_json(folder_ / "alone/summary.json");
    EXPECT_EQ(kept["elements"], alone["elements"]);
    EXPECT_EQ(kept["inputs"]["model_text"], alone["inputs"]["model_text"]);
}

// Oracle: two springs on a body: the frequencies that `dttmm modes` finds for the same values, and the peak that `dttmm
// response` finds.
TEST_F(Study, OfModesAndOfResponses) {
    write_text(folder_ / "model.toml", small_model_with("direction = [0, 0, 1]\nforce = \"100 N\"",
                                                        "direction = [0, 0, 1]\nharmonic = { amplitude = \"3 N\" }"));
    ASSERT_EQ(study({"model.toml", "--command", "modes", "--sweep", "mass=1 kg,3 kg", "-o", "out", "-q", "--figures",
                     "mode*.frequency"})
                  .code,
              0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"modes", "model.toml", "-q", "-o", "modes", "--set", "mass=3 kg"}).code, 0);
    const nlohmann::json modes = read_json(folder_ / "modes/summary.json")["modes"];
    ASSERT_GT(modes.size(), 2u);
    for (size_t m = 0; m < modes.size(); ++m)
        EXPECT_EQ(std::stod(results().cell(1, "mode" + std::to_string(m + 1) + ".frequency")),
                  modes[m]["frequency_hz"].get<double>());
    fs::remove_all(folder_ / "out");
    const std::vector<std::string> range = {"--from", "5 Hz", "--to", "60 Hz", "--points", "50"};
    std::vector<std::string> words = {"model.toml", "--command", "response", "--sweep", "mass=1 kg,3 kg",
                                      "-o",         "out",       "-q",       "--out",   "one.force.z"};
    words.insert(words.end(), range.begin(), range.end());
    const Ended ended = study(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    words = {"response", "model.toml", "--sweep", "mass=1 kg,3 kg", "-o", "swept", "-q", "--out", "one.force.z"};
    words.insert(words.end(), range.begin(), range.end());
    ASSERT_EQ(run_dttmm(folder_.path(), words).code, 0);
    const StudyTable swept = read_study(folder_ / "swept/sweep.csv");
    for (const size_t row : {size_t{0}, size_t{1}})
        EXPECT_EQ(results().cell(row, "one.force.z.largest"), swept.cell(row, "one.force.z.largest"));
    EXPECT_FALSE(fs::exists(folder_ / "out/case-000001"));
}

// Oracle: the same study by options, byte for byte; an option on the command line counts instead.
TEST_F(Study, TheModelFileMayDescribeIt) {
    const std::vector<std::string> by_options = {
        "model.toml", "--vary",    "mass ~ normal(2 kg, 10 %)", "--cases", "12",  "--seed", "4", "--design",
        "sobol",      "--figures", "one.force.z:rms",           "-o",      "out", "-q"};
    ASSERT_EQ(study(by_options).code, 0);
    const std::string wanted = read_text(folder_ / "out/results.csv");
    const std::string model = read_text(folder_ / "model.toml");
    write_text(folder_ / "model.toml",
               model +
                   "[study]\nvary = \"mass ~ normal(2 kg, 10 %)\"\ncases = 12\nseed = 4\ndesign = \"sobol\"\n"
                   "figures = [\"one.force.z:rms\"]\n");
    ASSERT_EQ(study({"model.toml", "-o", "by_file", "-q"}).code, 0);
    EXPECT_EQ(read_text(folder_ / "by_file/results.csv"), wanted);
    ASSERT_EQ(study({"model.toml", "-o", "grid", "-q", "--sweep", "mass=1 kg,2 kg"}).code, 0);
    EXPECT_EQ(read_study(folder_ / "grid/results.csv").rows.size(), 2u);
    EXPECT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "alone"}).code, 0) << "others leave it alone";
    for (const auto& [line, says] : {std::pair("vary = 3", "vary must be a text or a list of texts"),
                                     {"cases = 2.5", "cases must be a whole number"},
                                     {"design = \"latn\"", "latin"},
                                     {"colour = 1", "colour"}}) {
        write_text(folder_ / "model.toml", model + "[study]\n" + line + "\n");
        const Ended ended = study({"model.toml", "-o", "bad", "-q"});
        EXPECT_EQ(ended.code, 3) << line;
        EXPECT_THAT(ended.err, AllOf(HasSubstr("model.toml:40:"), HasSubstr(says)));
    }
}

// Oracle: the quantiles of the definition: 2 kg, then 5 % and 95 % of uniform(1 kg, 3 kg).
TEST_F(Study, OneAtATime) {
    write_text(folder_ / "model.toml", small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\nn = 7"));
    ASSERT_EQ(study({"model.toml", "--vary", "mass ~ uniform(1 kg, 3 kg)", "--vary", "n ~ list(5, 6, 8)", "--design",
                     "one-at-a-time", "-o", "out", "-q"})
                  .code,
              0);
    const StudyTable table = results();
    ASSERT_EQ(table.rows.size(), 6u);
    const std::vector<std::pair<double, double>> wanted = {{2, 7}, {1.1, 7}, {2.9, 7}, {2, 5}, {2, 6}, {2, 8}};
    for (size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_DOUBLE_EQ(std::stod(table.cell(i, "mass")), wanted[i].first);
        EXPECT_DOUBLE_EQ(std::stod(table.cell(i, "n")), wanted[i].second);
    }
}

// Oracle: Ishigami's function as a load: the final force of the springs is proportional to it, so its indices are known:
// 0.3139, 0.4424, 0 alone; 0.5576, 0.4424, 0.2437 in all.
TEST_F(Study, TellsWhatIsBehindTheVariance) {
    write_text(folder_ / "model.toml",
               small_model_with("mass = \"2 kg\"",
                                "mass = \"2 kg\"\na = 0\nb = 0\nd = 0\nf = \"=sin(a) + 7*sin(b)^2 + 0.1*d^4*sin(a)\""));
    std::string text = read_text(folder_ / "model.toml");
    write_text(folder_ / "model.toml", text.replace(text.find("\"100 N\""), 7, "\"=f\""));
    const std::vector<std::string> words = {"model.toml",
                                            "--vary",
                                            "a, b, d ~ uniform(-3.141592653589793, 3.141592653589793)",
                                            "--figures",
                                            "one.force.z:final",
                                            "-o",
                                            "out",
                                            "--cases"};
    const auto with = [&](const std::string& cases, const std::string& design) {
        std::vector<std::string> all = words;
        all.insert(all.end(), {cases, "--design", design});
        fs::remove_all(folder_ / "out");
        return study(all);
    };
    const Ended ended = with("5123", "sobol-indices");
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("5120 of 5120 cases completed")) << "whole blocks of five";
    const StudyTable table = read_study(folder_ / "out/sensitivities.csv");
    ASSERT_EQ(table.rows.size(), 3u);
    const double first[] = {0.3139, 0.4424, 0}, total[] = {0.5576, 0.4424, 0.2437};
    for (size_t p = 0; p < 3; ++p) {
        EXPECT_NEAR(std::stod(table.cell(p, "first")), first[p], 0.04);
        EXPECT_NEAR(std::stod(table.cell(p, "total")), total[p], 0.04);
    }
    EXPECT_EQ(with("400", "morris").code, 0);
    EXPECT_GT(std::stod(read_study(folder_ / "out/sensitivities.csv").cell(0, "size")), 0);
    EXPECT_THAT(with("30", "morris").err, HasSubstr("takes 40 cases at least, ten blocks of 4"));
}

/// Words that are refused before a folder is made.
struct WrongStudy {
    std::vector<std::string> words;
    int code;
    const char* says;
};

TEST_F(Study, WrongWordsAreRefused) {
    const std::string vary = "mass ~ uniform(1 kg, 3 kg)";
    const std::vector<WrongStudy> all = {
        {{"model.toml"}, 2, "nothing varies"},
        {{"model.toml", "--vary", vary}, 2, "how many cases?"},
        {{"model.toml", "--vary", vary, "--sweep", "mass=1 kg,2 kg", "--cases", "2"}, 2, "exclude each other"},
        {{"model.toml", "--sweep", "mass=1 kg,2 kg", "--cases", "2"}, 2, "go with --vary only"},
        {{"model.toml", "--vary", vary, "--vary", vary, "--cases", "2"}, 2, "twice"},
        {{"model.toml", "--vary", vary, "--cases", "0"}, 2, "--cases"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--design", "lattin"}, 2, "did you mean \"latin\"?"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--command", "mode"}, 2, "did you mean \"modes\"?"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--command", "modes", "--step", "1 ms"},
         2,
         "--step is no option of modes"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--figures", "three.force.z:peak"}, 3, "three"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--figures", "one.force.z:peek"}, 2, "did you mean \"peak\"?"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--limit", "0 s"}, 2, "--limit"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--on", "slurn"}, 2, "did you mean \"slurm\"?"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--correlate", "mass = 0.5"}, 2, "two parameters or more"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--correlate", "mass = 1.5"}, 2, "between -1 and 1"},
        {{"-", "--vary", vary, "--cases", "2"}, 2, "give a file instead of the standard input"},
        {{"status"}, 2, "study status: give the folder of the study"},
        {{"status", "nowhere"}, 5, "this is no folder of a study"},
        {{"status", "out", "more"}, 2, "\"more\" was not expected"},
        {{"model.toml", "--vary", "mass ~ lognormal(1 kg, 1e200 kg)", "--cases", "2"}, 2, "too large"},
        {{"model.toml", "--vary", "mass ~ uniform(-1e308 kg, 1e308 kg)", "--cases", "2"}, 2, "beyond the largest number"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--correlate", "mass,mass = 0.5"}, 2, "named twice"},
        {{"model.toml", "--vary", vary, "--cases", "2", "--figures", "sum = one.force.z + three.force.z"},
         2,
         "there is no channel \"three.force.z\"; did you mean \"one.force.z\"?"},
        {{"model.toml", "more", "--vary", vary, "--cases", "2"}, 2, "\"more\" was not expected"},
    };
    for (const WrongStudy& one : all) {
        std::vector<std::string> words = one.words;
        words.insert(words.end(), {"-o", "made"});
        const Ended ended = study(words);
        EXPECT_EQ(ended.code, one.code) << testing::PrintToString(one.words) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(one.says)) << testing::PrintToString(one.words);
        EXPECT_FALSE(fs::exists(folder_ / "made"));
    }
}

// A model with a table of loads beside it: workers have both from the folder of the study.
TEST_F(Study, KeepsACopyOfWhatTheModelReads) {
    fs::create_directories(folder_ / "machine/loads");
    write_text(folder_ / "machine/loads/pulse.csv", "time,force\ns,N\n0,0\n0.01,50\n0.05,0\n");
    write_text(folder_ / "machine/model.toml",
               small_model_with("force = \"100 N\"", "force = { type = \"table\", file = \"loads/pulse.csv\" }"));
    const Ended ended = study({"machine", "--sweep", "mass=1 kg,2 kg", "-o", "out", "-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const std::string whole = read_text(folder_ / "out/results.csv");
    fs::remove_all(folder_ / "machine");
    fs::remove_all(folder_ / "out/journal");
    fs::create_directory(folder_ / "out/journal");
    ASSERT_EQ(study({"retry", "out", "-q"}).code, 0);
    EXPECT_EQ(read_text(folder_ / "out/results.csv"), whole);
}

// What a study does is fixed: options that would change it are refused, not passed over.
TEST_F(Study, OptionsOfAStudyThatIsThereAreRefused) {
    ASSERT_EQ(study({"model.toml", "--sweep", "mass=1 kg,2 kg", "-o", "out", "-q"}).code, 0);
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"retry", "out", "--limit", "1 min"},
                                                                                       {"collect", "out", "--figures", "x"},
                                                                                       {"status", "out", "--on", "slurm"}}) {
        const Ended ended = study(words);
        EXPECT_EQ(ended.code, 2);
        EXPECT_THAT(ended.err, HasSubstr(words[2] + " was not expected: what a study does is fixed when it is made"));
    }
    EXPECT_EQ(study({"serve", "out", "1-2", "../evil", "1"}).code, 2);
    EXPECT_EQ(study({"serve", "out", "1-2", "j", "99999999999"}).code, 2);
    EXPECT_EQ(study({"retry", "out", "-j", "1"}).code, 0);
}

TEST_F(Study, AParameterMayNotBeCalledAsAColumnOfTheResults) {
    write_text(folder_ / "model.toml", small_model_with("mass = \"2 kg\"", "mass = \"2 kg\"\nstatus = 3"));
    const Ended ended = study({"model.toml", "--sweep", "status=1,2", "-o", "out"});
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, HasSubstr("a column \"status\" of their own: give the parameter another name"));
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

// What is not readable was perhaps done; what is not as it was made would be another study.
TEST_F(Study, ADamagedFolderIsRefusedAndItsTablesStay) {
    ASSERT_EQ(study({"model.toml", "--sweep", "mass=1 kg,2 kg,3 kg", "-o", "out", "-q"}).code, 0);
    const std::string results = read_text(folder_ / "out/results.csv");
    const auto refuses = [&](const char* says) {
        for (const char* word : {"status", "collect", "retry"}) {
            const Ended ended = study({word, "out"});
            EXPECT_EQ(ended.code, 5) << word << ended.err;
            EXPECT_THAT(ended.err, HasSubstr(says)) << word;
        }
        EXPECT_EQ(read_text(folder_ / "out/results.csv"), results);
    };
    fs::rename(folder_ / "out/journal", folder_ / "away");
    refuses("journal: cannot be read");
    write_text(folder_ / "out/journal", "no folder");
    refuses("journal: cannot be read");
    fs::remove(folder_ / "out/journal");
    fs::rename(folder_ / "away", folder_ / "out/journal");
    for (const char* place : {"model/model.toml", "cases.csv"}) {
        const fs::path file = folder_ / "out" / place;
        const std::string text = read_text(file);
        std::string other = text;
        other[other.size() - 2] = other[other.size() - 2] == '4' ? '5' : '4';
        write_text(file, other);
        refuses("it is not what it was when the study was made");
        fs::rename(file, folder_ / "away");
        refuses("it is not what it was when the study was made");
        fs::create_directory(file);
        refuses("it is not what it was when the study was made");
        fs::remove(file);
        write_text(file, text);
        fs::remove(folder_ / "away");
    }
    const std::string plan = read_text(folder_ / "out/study.json");
    const auto changed = [&](const std::string& what, const std::string& instead) {
        std::string text = plan;
        write_text(folder_ / "out/study.json", text.replace(text.find(what), what.size(), instead));
    };
    changed("\"limit_s\": 0", "\"limit_s\": -5");
    refuses("study.json is damaged");
    changed("\"command\": \"run\"", "\"command\": \"rm\"");
    refuses("study.json is damaged");
    changed("\"options\": [", "\"options\": [[\"--bogus\", \"1\"]");
    refuses("an option \"--bogus\" that this version of dttmm does not have");
    changed("\"inputs\": {", "\"inputs\": 5, \"x\": {");
    EXPECT_EQ(study({"model.toml", "--sweep", "mass=1 kg,2 kg,3 kg", "-o", "out", "-q"}).code, 5);
    write_text(folder_ / "out/study.json", plan);
    EXPECT_EQ(study({"collect", "out", "-q"}).code, 0);
    EXPECT_EQ(read_text(folder_ / "out/results.csv"), results);
}

// A machine of 1 to 3 springs: the third is in no column, as the model of the file has two; one case lacks the second. A
// figure that is no number in some row is none.
TEST_F(Study, FiguresThatCasesLackAreCounted) {
    write_text(folder_ / "model.toml", R"(format = "dttmm/1"
parameters = { n = 2 }
simulation = { duration = "20 ms", step = "1 ms" }
body = [{ name = "plate", mass = 2, inertia = [0.2, 0.3, 0.4] }]
load = [{ on = "plate", direction = [0, 0, 1], force = 100 }]
[[repeat]]
index = "i"
count = "=n"
element = [{ name = "spring{i}", type = "spring_damper", from = "ground", to = "plate", stiffness = 5e4 }]
)");
    const Ended ended = study({"model.toml", "--sweep", "n=1,2,3", "-o", "out", "--figures", "spring*.force.z:peak",
                               "--figures", "root = sqrt(30 - spring1.force.z): peak"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out,
                AllOf(HasSubstr("spring2.force.z.peak: 1 of 3 completed cases have no such number; they do not count"),
                      HasSubstr("root.peak: 3 of 3 completed cases have no such number"),
                      HasSubstr("1 case with figures that the model as the file has it lacks")));
    EXPECT_THAT(read_text(folder_ / "out/statistics.csv"), HasSubstr("spring2.force.z.peak,N,2,1,0,0,"));
    const nlohmann::json summary = read_json(folder_ / "out/summary.json");
    EXPECT_EQ(summary["with_more_figures"], 1);
    EXPECT_EQ(summary["statistics"]["spring2.force.z.peak"]["without"], 1);
}

}  // namespace
}  // namespace dttmm::host
