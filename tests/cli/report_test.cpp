// SPDX-License-Identifier: BSD-3-Clause
//
// dttmm report as a user calls it. What the page shows is tested in a browser: tests/report/browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/process.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

void write_small_history(const fs::path& folder) {
    fs::create_directories(folder);
    write_text(folder / "history.csv", "time,a\ns,N\n0,1\n0.1,2\n");
}

TEST(Report, IsWrittenBesideTheResults) {
    const TemporaryFolder folder;
    write_small_history(folder / "results/pump");
    const Ended ended = run_dttmm(folder.path(), {"report", "results/pump/"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("results/pump.html: "), HasSubstr(" MB, 1 results folder\n")));
    EXPECT_TRUE(fs::exists(folder / "results/pump.html"));
    EXPECT_EQ(run_dttmm(folder.path(), {"report", "results/pump"}).code, 0) << "a report may be replaced";
}

// A file in the results folder would make it a foreign one: the next run into it would be refused.
TEST(Report, OfTheCurrentFolderStandsBesideIt) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    for (const std::vector<std::string>& words : {std::vector<std::string>{"report", "."}, {"plot", ".", "a"}}) {
        const Ended ended = run_dttmm(folder.path() / "pump", words);
        EXPECT_EQ(ended.code, 0) << ended.err;
    }
    EXPECT_TRUE(fs::exists(folder / "pump.html") && fs::exists(folder / "pump.svg"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "pump"), {}), 1);
}

TEST(Report, ReplacesNoOtherFile) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    write_text(folder / "thesis.html", "<!doctype html>years of work");
    const Ended ended = run_dttmm(folder.path(), {"report", "pump", "-o", "thesis.html"});
    EXPECT_EQ(ended.code, 5);
    EXPECT_THAT(ended.err, HasSubstr("thesis.html: is there and is no report of dttmm; choose another file with -o"));
    EXPECT_EQ(read_text(folder / "thesis.html"), "<!doctype html>years of work");
    EXPECT_THAT(run_dttmm(folder.path(), {"report", "pump", "-o", "pump"}).err, HasSubstr("pump: is a folder"));
}

TEST(Report, OfSeveralResultsOneForeignIsRefusedAndNothingWritten) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    fs::create_directory(folder / "photos");
    const Ended ended = run_dttmm(folder.path(), {"report", "pump", "photos", "-o", "both.html"});
    EXPECT_EQ(ended.code, 5);
    EXPECT_THAT(ended.err, HasSubstr("photos: these are no results of dttmm"));
    EXPECT_FALSE(fs::exists(folder / "both.html"));
}

TEST(Report, ResultsNamedTwiceAreRefused) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    for (const char* again : {"pump", "./pump/", "pump/history.csv"})
        for (const std::vector<std::string>& words :
             {std::vector<std::string>{"report", "pump", again}, {"plot", "pump", again, "a"}}) {
            const Ended ended = run_dttmm(folder.path(), words);
            EXPECT_EQ(ended.code, 2) << ended.out;
            EXPECT_EQ(ended.err,
                      "dttmm: \"pump\" and \"" + std::string(again) + "\" are the same results; name them once\n");
        }
    EXPECT_FALSE(fs::exists(folder / "pump.html") || fs::exists(folder / "pump.svg"));
}

TEST(Report, ChannelsAreThoseOfARun) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    fs::create_directory(folder / "sweep");
    write_text(folder / "sweep/sweep.csv", "case,k,curve1\n,N/m,Hz\ncase-000001,1,2\ncase-000002,2,3\n");
    const Ended ended = run_dttmm(folder.path(), {"report", "sweep", "--channels", "nosuch"});
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, HasSubstr("--channels chooses among the channels of a run, and these results are not of a run"));
    EXPECT_FALSE(fs::exists(folder / "sweep.html"));
    EXPECT_THAT(run_dttmm(folder.path(), {"report", "pump", "sweep", "--channels", "nosuch"}).err,
                HasSubstr("\"nosuch\" matches no channel"));
    EXPECT_EQ(run_dttmm(folder.path(), {"report", "pump", "sweep", "--channels", "a"}).code, 0);
}

TEST(Plot, EquilibriaHaveNoCurves) {
    const TemporaryFolder folder;
    write_text(
        folder / "m.toml",
        "format = \"dttmm/1\"\n[[body]]\nname = \"b\"\nmass = 2\ninertia = [1, 1, 1]\n[[element]]\nname = \"e\"\ntype "
        "= \"spring_damper\"\nfrom = \"ground\"\nto = \"b\"\nstiffness = 1e3\nrotational_stiffness = 20\n");
    ASSERT_EQ(run_dttmm(folder.path(), {"static", "m.toml", "-q", "-o", "rest"}).code, 0);
    const Ended ended = run_dttmm(folder.path(), {"plot", "rest", "e.force"});
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, HasSubstr("these results have no curves over time, frequency or speed"));
}

TEST(Plot, DrawsTheChosenCurvesByUnit) {
    const TemporaryFolder folder;
    fs::create_directories(folder / "results/pump");
    write_text(folder / "results/pump/history.csv", "time,a.x,a.y,b\ns,N,N,m\n0,1,2,3\n0.1,2,4,5\n");
    const Ended ended = run_dttmm(folder.path(), {"plot", "results/pump", "a", "b"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, "results/pump.svg\n");
    const std::string svg = read_text(folder / "results/pump.svg");
    EXPECT_THAT(svg, AllOf(HasSubstr(">a.x</text>"), HasSubstr(">a.y</text>"), HasSubstr(">b</text>"),
                           HasSubstr(">time [s]</text>"), HasSubstr(">N</text>"), HasSubstr(">m</text>")));
    const Ended printed = run_dttmm(folder.path(), {"plot", "results/pump", "b", "-o", "-"});
    EXPECT_TRUE(printed.out.starts_with("<svg ")) << printed.err;
    EXPECT_THAT(printed.out, Not(HasSubstr(">a.x<")));
}

TEST(Plot, OfSeveralResultsCurvesAreDrawnTogether) {
    const TemporaryFolder folder;
    write_small_history(folder / "tight");
    write_small_history(folder / "loose");
    const Ended ended = run_dttmm(folder.path(), {"plot", "tight", "loose/history.csv", "a", "-o", "-"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr(">a, tight</text>"), HasSubstr(">a, loose</text>")));
}

TEST(Plot, DrawsInTheTerminalAndAsPng) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    const Ended text = run_dttmm(folder.path(), {"plot", "pump", "a", "--text"});
    EXPECT_EQ(text.code, 0) << text.err;
    EXPECT_THAT(text.out, AllOf(HasSubstr("time [s]"), HasSubstr("***"), HasSubstr("a ")));
    const Ended png = run_dttmm(folder.path(), {"plot", "pump", "a", "-o", "a.png"});
    EXPECT_EQ(png.out, "a.png\n") << png.err;
    EXPECT_TRUE(read_text(folder / "a.png").starts_with("\x89PNG"));
}

// A search path without gnuplot: the message says how to get it, and no file is left.
TEST(Plot, WithoutGnuplotSaysHowToGetIt) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    const std::string path = std::getenv("PATH");
    ::setenv("PATH", folder.path().c_str(), 1);
    const Ended ended = run_dttmm(folder.path(), {"plot", "pump", "a", "-o", "a.png"});
    ::setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(ended.code, 5);
    EXPECT_THAT(ended.err, HasSubstr("gnuplot is not installed: sudo apt-get install gnuplot-nox"));
    EXPECT_FALSE(fs::exists(folder / "a.png") || fs::exists(folder / "a.png.part"));
}

TEST(Plot, RefusesWhatItCannotDraw) {
    const TemporaryFolder folder;
    write_small_history(folder / "pump");
    const Ended unknown = run_dttmm(folder.path(), {"plot", "pump", "bolt"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("bolt"));
    const Ended other = run_dttmm(folder.path(), {"plot", "pump", "a", "-o", "a.pdf"});
    EXPECT_EQ(other.code, 2);
    EXPECT_THAT(other.err, HasSubstr("a.pdf: the picture is SVG or PNG; give a name that ends with .svg or .png"));
    EXPECT_EQ(run_dttmm(folder.path(), {"plot", "nothing", "a"}).code, 5);
    EXPECT_EQ(run_dttmm(folder.path(), {"plot", "pump"}).code, 2);
}

}  // namespace
}  // namespace dttmm::host
