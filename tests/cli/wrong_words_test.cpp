// SPDX-License-Identifier: BSD-3-Clause
//
// What a user can get wrong on the command line: words, files, folders, plugins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/small_model.h"
#include "loader/faulty_plugin.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

struct WrongWord {
    const char* name;
    std::vector<std::string> words;
    int code;
    const char* says;
};
void PrintTo(const WrongWord& fault, std::ostream* out) { *out << fault.name; }

class WrongWords : public testing::TestWithParam<WrongWord> {};

// Oracle: the exit code of the design, the fault in words, and no new file beside the model.
TEST_P(WrongWords, AreRefusedBeforeAnythingIsWritten) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    write_text(folder / "file", "");
    write_text(folder / "cases.csv", "mass\nkg\n1\n2\n");
    fs::create_directory(folder / "foreign");
    write_text(folder / "foreign/thesis.txt", "years of work");
    const Ended ended = run_dttmm(folder.path(), GetParam().words);
    EXPECT_EQ(ended.code, GetParam().code) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(GetParam().says));
    EXPECT_FALSE(fs::exists(folder / "results"));
    EXPECT_EQ(read_text(folder / "foreign/thesis.txt"), "years of work");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "foreign"), fs::directory_iterator()), 1);
}

std::vector<std::string> run_with(const std::string& option, const std::string& value) {
    return {"run", "model.toml", option, value};
}

const WrongWord kWrongWords[] = {
    {"NoSubcommand", {}, 2, "A subcommand is required"},
    {"UnknownSubcommand", {"rum", "model.toml"}, 2, "no subcommand \"rum\"; did you mean \"run\"?"},
    {"NoModel", {"run"}, 2, "MODEL is required"},
    {"UnknownOption", {"run", "model.toml", "--frob"}, 2, "run: --frob was not expected; known here: --help, MODEL, --set"},
    {"MistypedOption", {"run", "model.toml", "--quite"}, 2, "--quite was not expected; did you mean \"--quiet\"?"},
    {"TwoModels", {"run", "model.toml", "model.toml"}, 2, "model.toml"},
    {"MissingModel", {"run", "missing.toml"}, 5, "missing.toml: there is no such file"},
    {"FolderWithoutModel", {"run", "/"}, 5, "/model.toml: there is no such file"},
    {"SetUnknown", run_with("--set", "mas=1"), 2, "--set mas: the model has no such parameter; did you mean \"mass\"?"},
    {"SetWithoutValue", run_with("--set", "mass="), 2, "write --set mass=VALUE"},
    {"SetWithoutEquals", run_with("--set", "mass"), 2, "write name=value"},
    {"SetWrongDimension", run_with("--set", "mass=3 mm"), 3,
     "--set mass: parameter \"mass\": expected a value in kg, got \"3 mm\"; accepted here: kg, g, t"},
    {"SetWithoutUnit", run_with("--set", "mass=3"), 2, "--set mass=3: of which unit? the file gives kg; write --set mass="},
    {"SweepWithoutUnit", run_with("--sweep", "mass=1..3:3"), 2, "--sweep \"mass\": of which unit? the file gives kg; write"},
    {"StepWrongDimension", run_with("--step", "1 kg"), 3, "--step: "},
    {"StepNotDividing", run_with("--step", "3 ms"), 3, "whole number of steps"},
    {"DurationNegative", run_with("--duration", "-1 s"), 3, "--duration: "},
    {"UnknownCoupling", run_with("--coupling", "magic"), 3, "must be one of: implicit, explicit"},
    {"NoJobs", {"run", "model.toml", "--sweep", "mass=1 kg,2 kg", "-j", "0"}, 2, "--jobs"},
    {"JobsOfOneRun", run_with("--jobs", "2"), 2, "--jobs is for the cases of a sweep: one run has one; leave it out"},
    {"JobsOnSlurm",
     {"study", "model.toml", "--sweep", "mass=1 kg,2 kg", "--on", "slurm:-p long", "--jobs", "2"},
     2,
     "--jobs does not go with --on slurm"},
    {"SweepWithoutValues", run_with("--sweep", "mass="), 2, "write name=from..to:count or name=value,value"},
    {"SweepWithoutName", run_with("--sweep", "1..2:3"), 2, "write name=from..to:count or name=value,value"},
    {"SweepWithoutCount", run_with("--sweep", "mass=1 kg..2 kg"), 3, "a range wants a count"},
    {"SweepOfNoCase", run_with("--sweep", "mass=1 kg..2 kg:0"), 3, "a whole number from 1 to 100000"},
    {"SweepOf1e9Cases", run_with("--sweep", "mass=1 kg..2 kg:1000000000"), 3, "a whole number from 1 to 100000"},
    {"SweepOfOneOfTwoEnds", run_with("--sweep", "mass=1 kg..2 kg:1"), 3, "one value cannot be both ends"},
    {"SweepBesideSet",
     {"run", "model.toml", "--sweep", "mass=1 kg,2 kg", "--set", "mass=3 kg"},
     2,
     "--sweep \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"SweepOfModesBesideSet",
     {"modes", "model.toml", "--sweep", "mass=1 kg,2 kg", "--set", "mass=3 kg"},
     2,
     "--sweep \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"SweepOfResponsesBesideSet",
     {"response", "model.toml", "--in", "plate.z", "--sweep", "mass=1 kg,2 kg", "--set", "mass=3 kg"},
     2,
     "--sweep \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"StudyOfASweepBesideSet",
     {"study", "model.toml", "--sweep", "mass=1 kg,2 kg", "--set", "mass=3 kg"},
     2,
     "--sweep \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"VaryBesideSet",
     {"study", "model.toml", "--vary", "mass ~ normal(2 kg, 1 %)", "--cases", "3", "--set", "mass=3 kg"},
     2,
     "--vary \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"TableBesideSet",
     {"study", "model.toml", "--table", "cases.csv", "--set", "mass=3 kg"},
     2,
     "--table \"mass\": --set gives this parameter a value too; leave one of them out"},
    {"SweepOfTwoUnits", run_with("--sweep", "mass=1 kg..2 s:3"), 3, "different units"},
    {"SweepWithAHole", run_with("--sweep", "mass=1 kg,,2 kg"), 3, "empty text"},
    {"SweepUnknown", run_with("--sweep", "mas=1 kg,2 kg"), 2, "no such parameter; did you mean \"mass\"?"},
    {"SweepTwice", {"run", "model.toml", "--sweep", "mass=1 kg,2 kg", "--sweep", "mass=3 kg,4 kg"}, 2, "\"mass\" twice"},
    {"SweepWrongDimension", run_with("--sweep", "mass=1 s,2 s"), 3,
     "--sweep \"mass\": expected a value in kg, got \"1 s\"; accepted here: kg, g, t"},
    {"ResultsBelowAFile", run_with("-o", "file/results"), 5, "file/results: cannot make the folder"},
    {"ResultsAreAFile", run_with("-o", "file"), 5, "is a file, not a folder"},
    {"ResultsInProc", run_with("-o", "/proc/results"), 5, "/proc/results: cannot make the folder"},
    {"ResultsAreForeign", run_with("-o", "foreign"), 5, "holds \"thesis.txt\" and no results of dttmm"},
    {"SweepIntoForeign", {"run", "model.toml", "-o", "foreign", "--sweep", "mass=1 kg,2 kg"}, 5, "holds \"thesis.txt\""},
    {"PluginMissing", run_with("--plugin", "missing.so"), 7, "missing.so: there is no such file"},
    {"PluginIsText", run_with("--plugin", "model.toml"), 7, "invalid ELF header"},
    {"PluginIsEmpty", run_with("--plugin", "file"), 7, "file too short"},
    {"PluginWithoutEntry", run_with("--plugin", faulty_plugin("no_entry")), 7,
     "it exports neither dttmm_plugin_entry nor dttmm_law_entry"},
    {"PluginOfNoTable", run_with("--plugin", faulty_plugin("null_table")), 7, "does not support version 2"},
    {"PluginOfOtherVersion", run_with("--plugin", faulty_plugin("other_major")), 7, "built for version 3"},
    {"PluginNotWhole", run_with("--plugin", faulty_plugin("null_function")), 7, "null entry"},
    {"PluginForElements", {"elements", "--plugin", faulty_plugin("null_types")}, 7, "list of element types is null"},
};

INSTANTIATE_TEST_SUITE_P(Command, WrongWords, testing::ValuesIn(kWrongWords),
                         [](const auto& one) { return one.param.name; });

// ---- Plugins that fail when used ----------------------------------------------------------------------------------------

struct PluginFault {
    const char* fault;
    int code;
    const char* says;
    int rows;  ///< -1: it does not get as far as to write results
};
void PrintTo(const PluginFault& fault, std::ostream* out) { *out << fault.fault; }

class FaultyPlugin : public testing::TestWithParam<PluginFault> {};

// Oracle: the fault's exit code and words; the rows before it are kept, every one whole and finite: step 1000 fails, the
// output step is 5 time steps, so rows 0, 5, ... 995 are there.
TEST_P(FaultyPlugin, EndsTheRunInOrder) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    const Ended ended =
        run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin(GetParam().fault)});
    EXPECT_EQ(ended.code, GetParam().code) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("element \"one\""));
    EXPECT_THAT(ended.err, HasSubstr(GetParam().says));
    if (GetParam().rows < 0) {
        EXPECT_THAT(ended.err, HasSubstr("model.toml:26:1: "));
        EXPECT_FALSE(fs::exists(folder / "out"));
        return;
    }
    EXPECT_EQ(static_cast<int>(read_history(folder / "out/history.csv").size()), GetParam().rows);
    const nlohmann::json summary = read_json(folder / "out/summary.json");
    EXPECT_EQ(summary["status"], "failed");
    EXPECT_EQ(summary["rows"], GetParam().rows);
    EXPECT_THAT(summary["reason"].get<std::string>(), HasSubstr(GetParam().says));
}

const PluginFault kPluginFaults[] = {
    {"create_error", 3, "this spring is made of butter; take steel", -1},
    {"linearise_error", 7, "the spring does not know its stiffness", -1},
    {"create_nothing", 7, "create returned no instance", -1},
    {"bad_block", 7, "block 0 of its matrices is no pair of bodies, or is there twice", -1},
    {"twice_a_block", 7, "block 1 of its matrices is no pair of bodies, or is there twice", -1},
    {"bad_channel", 7, "output channel 0 is not well declared: it has no unit", -1},
    {"slash_channel", 7, "output channel 0 is not well declared: its name has a slash", -1},
    {"nan_output", 7, " says force.x is nan", 0},
    {"nan_at_step_1000", 4, "on body \"plate\" at t = 1 s: force (0, nan, 0) N", 200},
    {"error_at_step_1000", 7, "the spring has melted", 200},
    {"huge", 4, "beyond the cap of 1e+15", 0},
    {"large", 4, "beyond the cap of 1e+15", 0},
    {"overrun", 7, "wrote past the end of the wrench array", 0},
    {"silent_error", 7, "status -99 without a text", 0},
    {"always_rough", 4, "the motion inside was not found in 50 passes (last correction 1.0e+00 m/s)", 0},
    {"nan_progress", 7, "the progress of its iteration is nan", 0},
    {"progress_overrun", 7, "it wrote more of its progress than its parts have", 0},
    {"too_many_parts", 7, "it has 4000000000 parts that iterate; at most 1000000 are taken", -1},
    {"throw_create", 7, "it threw a C++ exception across the interface: the spring has been thrown", -1},
    {"throw_linearise", 7, "it threw a C++ exception across the interface: the spring has been thrown", -1},
    {"throw_at_step_1000", 7, "t = 1 s: element \"one\"", 200},
    {"model_error_at_step_1000", 7, "the spring was never there", 200},
    {"many_channels", 7, "it declares 4294967295 output channels; at most 10000000 are taken", -1},
    {"traps_at_step_1000", 7, "t = 1 s: element \"one\"", 200},
    {"underrun", 7, "wrote past the start of the wrench array", 0},
    {"stiffness_overrun", 7, "wrote past the end of the stiffness array", -1},
    {"stiffness_underrun", 7, "wrote past the start of the stiffness array", -1},
    {"damping_overrun", 7, "wrote past the end of the damping array", -1},
    {"output_overrun", 7, "wrote past the end of the output array", 0},
    {"output_underrun", 7, "wrote past the start of the output array", 0},
    {"nan_stiffness", 7, "it says that its stiffness at the start is nan", -1},
    {"infinite_damping", 7, "it says that its damping at the start is inf", -1},
    {"terminal_text", 7, R"(\u{1b}[2J\u{1b}]0;title\u{7}red\u{1b}[31m \u{9b}31m \xff\u{d}\u{a})", -1},
};

INSTANTIATE_TEST_SUITE_P(Command, FaultyPlugin, testing::ValuesIn(kPluginFaults),
                         [](const auto& one) { return one.param.fault; });

// What no element is to blame for is told of the plugin.
TEST(Plugin, ThatBreaksTheHouseIsRefused) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    for (const auto& [fault, says] :
         {std::pair{"heavy_weights", "by 0, 15 and 0; weights lie within 0 and 1 and add up to one"},
          {"weights_overrun", "it wrote more than three weights of loads"},
          {"uneven_weights", "by 5, -9 and 5; weights lie within 0 and 1 and add up to one"},
          {"throw_entry", "throw_entry.so: it threw a C++ exception across the interface: the spring has been thrown"},
          {"rounding_mode", "changed the rounding mode"},
#ifdef __SSE2__
          {"flush_to_zero", "numbers below 2.2e-308 become zero"},
#endif
          {"decimal_comma", "the locale in which numbers are written"}}) {
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin(fault)});
        EXPECT_EQ(ended.code, 7) << fault;
        EXPECT_THAT(ended.err, HasSubstr(says));
    }
}

// Only who draws the machine asks a plugin where its elements are.
TEST(Plugin, ThatLosesItsElementsIsRefused) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    for (const auto& [fault, says] : {std::pair{"nan_position", "element \"one\" at t = 0 s: plugin "},
                                      {"nan_position", "gives nan as a coordinate of one of its points"},
                                      {"position_overrun", "wrote past the end of the position array"},
                                      {"bends_twice", "lines() names an element that does not exist, or one element twice"},
                                      {"bends_elsewhere", "lines() names an element that does not exist"}}) {
        const Ended ended =
            run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--for-report", "--plugin", faulty_plugin(fault)});
        EXPECT_EQ(ended.code, 7) << fault << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(says));
    }
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin("nan_position")}).code,
              0);
}

// ---- Plugins that end the process ---------------------------------------------------------------------------------------

class CrashingPlugin : public testing::TestWithParam<std::pair<const char*, const char*>> {};

// Oracle: plugin, element and time as the file of the plugin has them; all rows before step 1000 are on the disk.
TEST_P(CrashingPlugin, IsNamedAndItsRowsStay) {
    const auto [fault, says] = GetParam();
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    const std::string plugin = faulty_plugin(fault);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", plugin});
    EXPECT_EQ(ended.code, 7) << ended.err;
    EXPECT_EQ(ended.err, "dttmm: plugin " + plugin + ", element \"one\", t = 1 s: " + says + "; the rows written stay\n");
    EXPECT_EQ(read_history(folder / "out/history.csv").size(), 200u);
    EXPECT_FALSE(fs::exists(folder / "out/summary.json"));
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin("none")}).code, 0)
        << "the folder is free";

    const Ended sweep = run_dttmm(
        folder.path(), {"run", "model.toml", "-o", "sweep", "--plugin", plugin, "--sweep", "mass=1kg,2kg", "-j", "1"});
    EXPECT_EQ(sweep.code, 9);
    EXPECT_THAT(sweep.err,
                HasSubstr("case-000002 mass=2kg: exit code 7: dttmm: plugin " + plugin + ", element \"one\", t = 1 s"));
}

#ifdef __SANITIZE_ADDRESS__  // the sanitizer reports faults of the processor itself
constexpr bool kHasFaults = false;
#else
constexpr bool kHasFaults = true;
#endif
std::vector<std::pair<const char*, const char*>> crashes() {
    std::vector<std::pair<const char*, const char*>> list = {{"exit_at_step_1000", "it ended the process"},
                                                             {"quick_exit_at_step_1000", "it ended the process"}};
    if (!kHasFaults) return list;
    const char* memory = "it touched memory that is not its own, or its stack ran over (SIGSEGV)";
    list.insert(list.end(), {{"segmentation_at_step_1000", memory},
                             {"stack_at_step_1000", memory},
                             {"abort_at_step_1000", "it called abort (SIGABRT)"},
                             {"division_at_step_1000", "arithmetic fault (SIGFPE)"},
                             {"instruction_at_step_1000", "illegal instruction (SIGILL)"},
                             {"bus_at_step_1000", "it touched memory that is not there (SIGBUS)"}});
    return list;
}

INSTANTIATE_TEST_SUITE_P(Command, CrashingPlugin, testing::ValuesIn(crashes()),
                         [](const auto& one) { return one.param.first; });

// Oracle: a plugin in order, in the folder asked for; nothing in the folder that the plugin has changed to.
TEST(Plugin, ThatChangesTheFolderLosesNothing) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    const Ended ended =
        run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin("root_folder")});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("results in out\n"));
    for (const char* name : {"history.csv", "history.h5", "summary.json"})
        EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
    EXPECT_FALSE(fs::exists("/out"));
}

// Oracle: asked once, it has one channel; asked again, none.
TEST(Plugin, IsAskedForItsChannelsOnce) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model().substr(0, faulty_model().rfind("[[element]]")));
    const Ended ended =
        run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin("shrinking_channels")});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(read_text(folder / "out/history.csv"), HasSubstr("one.force.x"));
    EXPECT_EQ(read_history(folder / "out/history.csv").size(), 401u);
}

TEST(Plugin, ThatFailsOnTheWaySaysWhen) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", faulty_model());
    const Ended ended =
        run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin("error_at_step_1000")});
    EXPECT_THAT(ended.err, HasSubstr("t = 1 s: element \"one\" (plugin "));
}

// Oracle: the body falls freely, as the plugin's element never pulls: without a fault the same plugin is in order. It falls
// as it is expected to, so that one trial a step would be enough for the host: who wants to be told again is told again.
TEST(Plugin, InOrderRunsToTheEnd) {
    for (const char* way : {"none", "rough"}) {
        const TemporaryFolder folder;
        write_text(folder / "model.toml", faulty_model());
        const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--plugin", faulty_plugin(way)});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(read_history(folder / "out/history.csv").size(), 401u) << way;
    }
}

}  // namespace
}  // namespace dttmm::host
