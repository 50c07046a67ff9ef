// SPDX-License-Identifier: BSD-3-Clause
//
// Runs that do not come to their own end: signals, and readers that go away.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>

#include "cli/process.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// The small model for a day, with few numbers in a row.
std::string long_model() {
    std::string text = small_model_with("step = \"5 ms\"", "step = \"20 ms\"\nchannels = [\"one.force\"]");
    return text.replace(text.find("50 ms"), 5, "1e5 s");
}

class Interruption : public testing::Test {
protected:
    Interruption() { write_text(folder_ / "model.toml", long_model()); }
    bool has_rows(const char* history) const {
        std::error_code none;
        return fs::file_size(folder_ / history, none) > 500 && !none;
    }
    const TemporaryFolder folder_;
};

struct Signal {
    int number, code;
};
class StoppedRun : public Interruption, public testing::WithParamInterface<Signal> {};

// Oracle: the exit codes of the design; the rows up to the signal are whole, and the summary counts them.
TEST_P(StoppedRun, KeepsItsRowsAndSaysSo) {
    Process run({"run", "model.toml", "-o", "out"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/history.csv"); }));
    run.send(GetParam().number);
    const Ended ended = run.wait();
    EXPECT_EQ(ended.code, GetParam().code) << ended.err;
    const auto rows = read_history(folder_ / "out/history.csv");
    const nlohmann::json summary = read_json(folder_ / "out/summary.json");
    EXPECT_EQ(summary["status"], "stopped");
    EXPECT_EQ(summary["rows"], rows.size());
    EXPECT_DOUBLE_EQ(rows.back()[0], 0.02 * static_cast<double>(rows.size() - 1));
    EXPECT_TRUE(fs::exists(folder_ / "out/history.h5"));
    EXPECT_THAT(ended.err, HasSubstr(std::to_string(rows.size()) + " rows are kept"));
}

INSTANTIATE_TEST_SUITE_P(Command, StoppedRun,
                         testing::Values(Signal{SIGINT, 130}, Signal{SIGTERM, 130}, Signal{SIGHUP, 130}, Signal{SIGXCPU, 6}),
                         [](const auto& one) { return std::string("Signal") + std::to_string(one.param.number); });

// Oracle: no signal can be caught here: the rows streamed so far are whole but perhaps the last, nothing has its final name,
// and the folder is free for the next run.
TEST_F(Interruption, AKilledRunLeavesItsRowsAndFreesItsFolder) {
    Process run({"run", "model.toml", "-o", "out"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/history.csv"); }));
    run.send(SIGKILL);
    EXPECT_EQ(run.wait().code, -SIGKILL);
    std::string history = read_text(folder_ / "out/history.csv");
    history.resize(history.rfind('\n') + 1);
    write_text(folder_ / "whole.csv", history);
    EXPECT_GT(read_history(folder_ / "whole.csv").size(), 0u);
    EXPECT_FALSE(fs::exists(folder_ / "out/history.h5"));
    EXPECT_FALSE(fs::exists(folder_ / "out/summary.json"));
    EXPECT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-o", "out", "--duration", "1 s"}).code, 0);
    EXPECT_FALSE(fs::exists(folder_ / "out/history.h5.part"));
}

TEST_F(Interruption, ASecondRunIntoTheSameFolderIsRefused) {
    Process run({"run", "model.toml", "-o", "out"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/history.csv"); }));
    const Ended second = run_dttmm(folder_.path(), {"run", "model.toml", "-o", "out"});
    EXPECT_EQ(second.code, 5);
    EXPECT_THAT(second.err, HasSubstr("another run is writing into it (process " + std::to_string(run.id())));
    run.send(SIGINT);
    EXPECT_EQ(run.wait().code, 130);
}

// Oracle: orphans of the sweep would become children of this process, which collects them.
TEST_F(Interruption, AStoppedSweepLeavesNoChild) {
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);
    Process sweep({"run", "model.toml", "-o", "out", "--sweep", "mass=1 kg..5 kg:5", "-j", "2"}, folder_.path());
    ASSERT_TRUE(
        wait_until([&] { return has_rows("out/case-000001/history.csv") && has_rows("out/case-000002/history.csv"); }));
    sweep.send(SIGINT);
    const Ended ended = sweep.wait();
    EXPECT_EQ(ended.code, 130);
    EXPECT_THAT(ended.out, HasSubstr("0 of 5 cases completed (0 of them reused), 0 failed, 5 not run"));
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
    EXPECT_THAT(read_text(folder_ / "out/sweep.csv"), HasSubstr("case-000002,2,missing,"));
    EXPECT_EQ(read_json(folder_ / "out/case-000001/summary.json")["status"], "stopped");
    EXPECT_FALSE(fs::exists(folder_ / "out/case-000003"));

    const Ended resumed =
        run_dttmm(folder_.path(), {"run", "model.toml", "-o", "out", "--sweep", "mass=1 kg..5 kg:5", "--duration", "1 s"});
    EXPECT_EQ(resumed.code, 0) << resumed.err;
}

// Oracle: of two cases the long one is killed from outside: it is named with the signal, the other is done.
TEST_F(Interruption, AKilledCaseIsNamed) {
    std::string text = long_model();
    text.replace(text.find("\"1e5 s\""), 7, "\"=T\"");
    write_text(folder_ / "model.toml", text.replace(text.find("mass = \"2 kg\""), 0, "T = \"1 s\"\n"));
    Process sweep({"run", "model.toml", "-o", "out", "--sweep", "T=1 s,1e5 s", "-j", "2"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/case-000002/history.csv"); }));
    int number = 0;  // the marker begins: process <number> on host <name>
    ASSERT_EQ(std::sscanf(read_text(folder_ / "out/case-000002/.dttmm-results").c_str(), "process %d", &number), 1);
    ::kill(number, SIGKILL);
    const Ended ended = sweep.wait();
    EXPECT_EQ(ended.code, 9);
    EXPECT_THAT(ended.err, HasSubstr("case-000002 T=1e5 s: killed by signal 9"));
    EXPECT_THAT(ended.out, HasSubstr("1 of 2 cases completed"));
}

// ---- Natural frequencies and frequency response --------------------------------------------------------------------------

class StoppedModes : public Interruption, public testing::WithParamInterface<int> {};

// Oracle: as many whole lines as the message says, the first those of a response of few points.
TEST_P(StoppedModes, AResponseKeepsItsLines) {
    const std::vector<std::string> words = {"frf",   "model.toml", "--in",     "plate.z", "--out", "plate.z", "--from",
                                            "10 Hz", "--to",       "20000 Hz", "-o",      "out",   "--points"};
    auto many = words;
    many.push_back("5000000");
    Process response(many, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/frf.csv"); }));
    response.send(GetParam());
    const Ended ended = response.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    const auto rows = read_history(folder_ / "out/frf.csv");
    EXPECT_THAT(ended.err, HasSubstr("stopped by the user at "));
    EXPECT_THAT(ended.err, HasSubstr(std::to_string(rows.size()) + " of 5000000 rows are kept"));
    auto few = words;
    few.push_back("2");
    ASSERT_EQ(run_dttmm(folder_.path(), few).code, 0);
    EXPECT_EQ(read_history(folder_ / "out/frf.csv").front(), rows.front());
}

// Oracle: the same of `dttmm response`.
TEST_P(StoppedModes, ASteadyResponseKeepsItsRows) {
    const std::vector<std::string> words = {"response", "model.toml", "--in", "plate.z",  "--out", "plate.position.z",
                                            "--from",   "10 Hz",      "--to", "20000 Hz", "-o",    "out",
                                            "--points"};
    auto many = words;
    many.push_back("5000000");
    Process response(many, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/response.csv"); }));
    response.send(GetParam());
    const Ended ended = response.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    const auto rows = read_history(folder_ / "out/response.csv");
    ASSERT_FALSE(rows.empty());
    EXPECT_THAT(ended.err, HasSubstr(std::to_string(rows.size()) + (rows.size() == 1 ? " row is kept" : " rows are kept")));
    EXPECT_THAT(read_text(folder_ / "out/summary.json"), HasSubstr("\"stopped\""));
    auto few = words;
    few.push_back("2");
    ASSERT_EQ(run_dttmm(folder_.path(), few).code, 0);
    EXPECT_EQ(read_history(folder_ / "out/response.csv").front(), rows.front());
}

TEST_P(StoppedModes, ASweepKeepsItsCases) {
    Process sweep({"modes", "model.toml", "--sweep", "mass=1kg..5kg:100000", "-o", "out"}, folder_.path());
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    sweep.send(GetParam());
    const Ended ended = sweep.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("stopped by the user; "));
    int kept = -1;
    ASSERT_EQ(std::sscanf(ended.err.c_str() + ended.err.find("; ") + 2, "%d of 100000 cases are kept", &kept), 1);
    const std::string table = read_text(folder_ / "out/sweep.csv");
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), kept + 2);
}

INSTANTIATE_TEST_SUITE_P(Command, StoppedModes, testing::Values(SIGINT, SIGTERM, SIGHUP),
                         [](const auto& one) { return "Signal" + std::to_string(one.param); });

// ---- A plugin that does not return ---------------------------------------------------------------------------------------

// Oracle: the first signal waits for the plugin, the second ends the process; all 999 rows before the step are there.
TEST_F(Interruption, TheSecondSignalEndsAPluginThatDoesNotReturn) {
    std::string text = faulty_model();
    write_text(folder_ / "model.toml", text.replace(text.find("step = \"5 ms\""), 13, "step = \"1 ms\""));
    Process run({"run", "model.toml", "-o", "out", "--plugin", test::paths::faulty_plugins() + "/endless.so"},
                folder_.path());
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    run.send(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    int status = 0;
    ASSERT_EQ(::waitpid(run.id(), &status, WNOHANG), 0);
    run.send(SIGTERM);
    const Ended ended = run.wait(10);
    EXPECT_EQ(ended.code, 130);
    EXPECT_THAT(ended.err, HasSubstr("dttmm: stopped at once by a second signal; the rows written stay\n"));
    EXPECT_EQ(read_history(folder_ / "out/history.csv").size(), 1000u);
}

// Oracle: `timeout` sends its signal to the process and to its group: two at a time are one.
TEST_F(Interruption, TwoSignalsAtATimeAreOne) {
    Process run({"run", "model.toml", "-o", "out"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return has_rows("out/history.csv"); }));
    run.send(SIGTERM);
    run.send(SIGINT);
    EXPECT_EQ(run.wait().code, 130);
    EXPECT_EQ(read_json(folder_ / "out/summary.json")["status"], "stopped");
}

// ---- Standard output ----------------------------------------------------------------------------------------------------

// Oracle: as `dttmm run ... | true`: what is read is the reader's business, the results are whole.
TEST_F(Interruption, AReaderThatGoesAwayIsNoFailure) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    ::close(ends[0]);
    EXPECT_EQ(Process({"run", "model.toml", "-o", "out", "--duration", "1 s"}, folder_.path(), ends[1]).wait().code, 0);
    EXPECT_EQ(Process({"elements"}, folder_.path(), ends[1]).wait().code, 0);
    ::close(ends[1]);
    EXPECT_EQ(read_json(folder_ / "out/summary.json")["status"], "completed");
}

TEST_F(Interruption, AStandardOutputThatIsFullIsAFailure) {
    const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
    const Ended ended = Process({"elements"}, folder_.path(), full).wait();
    ::close(full);
    EXPECT_EQ(ended.code, 5);
    EXPECT_THAT(ended.err, HasSubstr("cannot write to the standard output"));
}

}  // namespace
}  // namespace dttmm::host
