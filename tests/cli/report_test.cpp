// SPDX-License-Identifier: BSD-3-Clause
//
// dttmm report as a user calls it. What the page shows is tested in a browser: tests/report/browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

}  // namespace
}  // namespace dttmm::host
