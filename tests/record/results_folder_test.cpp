// SPDX-License-Identifier: BSD-3-Clause
#include "record/results_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "record/child_process.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::MatchesRegex;

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// A folder as a run leaves it.
void make_old_results(const fs::path& path) {
    const ResultsFolder folder(path);
    for (const char* name : {"history.csv", "history.h5", "history.h5.part", "summary.json", "modes.csv", "sweep.csv.part"})
        write_text(folder.file(name), "old");
}

void expect_refused(const fs::path& path, const testing::Matcher<std::string>& text, Claim claim = Claim::replace) {
    expect_error([&] { ResultsFolder(path, claim); }, ExitCode::input_output, text);
}

// Oracle for all: the rules of the header, one test each; the names left in the folder.
TEST(ResultsFolder, AMissingFolderIsMadeWithItsParents) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "results/a/plate");
    EXPECT_THAT(names_in(folder.path()), ElementsAre(".dttmm-results"));
    EXPECT_EQ(folder.file("history.csv"), temporary / "results/a/plate/history.csv");
}

TEST(ResultsFolder, AnEmptyFolderIsTaken) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary.path());
    EXPECT_THAT(names_in(temporary.path()), ElementsAre(".dttmm-results"));
}

TEST(ResultsFolder, OldResultsAreRemovedButNotASweep) {
    const TemporaryFolder temporary;
    make_old_results(temporary.path());
    write_text(temporary / "sweep.csv", "old");
    make_old_results(temporary / "case-001");
    fs::create_directory(temporary / "case-003");  // killed before it was marked
    const ResultsFolder folder(temporary.path());
    EXPECT_THAT(names_in(temporary.path()), ElementsAre(".dttmm-results", "case-001", "case-003", "sweep.csv"));
    EXPECT_EQ(read_text(temporary / "case-001/history.csv"), "old");
}

// What `export` and `report` write beside the folder of a case is not in the way of the next sweep.
TEST(ResultsFolder, FilesBesideTheFolderOfACaseStay) {
    const TemporaryFolder folder;
    { const ResultsFolder sweep(folder / "sweep"); }
    fs::create_directories(folder / "sweep/case-000001.frames");
    std::ofstream(folder / "sweep/case-000001.frames/f000000.vtu") << "x";
    std::ofstream(folder / "sweep/case-000001.html") << "x";
    const ResultsFolder again(folder / "sweep");
    EXPECT_TRUE(fs::exists(folder / "sweep/case-000001.frames/f000000.vtu"));
    EXPECT_TRUE(fs::exists(folder / "sweep/case-000001.html"));
}

TEST(ResultsFolder, OldResultsAreKeptOnRequest) {
    const TemporaryFolder temporary;
    make_old_results(temporary.path());
    make_old_results(temporary / "case-001");
    const ResultsFolder folder(temporary.path(), Claim::keep);
    EXPECT_EQ(read_text(folder.file("sweep.csv.part")), "old");
    EXPECT_EQ(read_text(folder.file("case-001/history.csv")), "old");
}

TEST(ResultsFolder, AForeignFolderIsRefusedAndUntouched) {
    const TemporaryFolder temporary;
    write_text(temporary / "thesis.tex", "years of work");
    for (const Claim claim : {Claim::replace, Claim::keep})
        expect_refused(temporary.path(), AllOf(HasSubstr("holds \"thesis.tex\""), HasSubstr("-o")), claim);
    EXPECT_THAT(names_in(temporary.path()), ElementsAre("thesis.tex"));
}

// Its hidden files come first, and tell nobody what the folder is.
TEST(ResultsFolder, AStudyIsCalledAStudy) {
    const TemporaryFolder temporary;
    for (const char* file : {".collecting", "study.json", "results.csv"}) write_text(temporary / file, "");
    expect_refused(temporary.path(),
                   HasSubstr("holds a study, which no other command replaces; choose another folder with -o"));
    EXPECT_EQ(names_in(temporary.path()).size(), 3u);
}

TEST(ResultsFolder, ResultsWithoutOurMarkerAreForeign) {
    const TemporaryFolder temporary;
    write_text(temporary / "history.csv", "of another program");
    expect_refused(temporary.path(), HasSubstr("holds \"history.csv\" and no results of dttmm"));
    EXPECT_EQ(read_text(temporary / "history.csv"), "of another program");
}

TEST(ResultsFolder, OneForeignEntryAmongOursProtectsAll) {
    const auto refused_with = [](const std::string& name, const std::function<void(const fs::path&)>& add) {
        const TemporaryFolder temporary;
        make_old_results(temporary.path());
        add(temporary / name);
        expect_refused(temporary.path(), HasSubstr(fmt::format("\"{}\"", name)));
        EXPECT_EQ(read_text(temporary / "history.csv"), "old");
    };
    const auto add_file = [](const fs::path& path) { write_text(path, ""); };
    const auto add_folder = [](const fs::path& path) { fs::create_directories(path); };
    refused_with("notes.txt", add_file);
    refused_with("history.csv.bak", add_file);
    refused_with("case-1", add_file);
    refused_with("folder", add_folder);
    refused_with("summary.json.part", [](const fs::path& path) { fs::remove(path), fs::create_directory(path); });
    refused_with("sweep.csv", [](const fs::path& path) { ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0); });
    refused_with("case-2", [](const fs::path& path) { fs::create_directory_symlink("/tmp", path); });
    const TemporaryFolder temporary;
    make_old_results(temporary.path());
    make_old_results(temporary / "case-1");
    write_text(temporary / "case-1/notes.txt", "");
    expect_refused(temporary.path(), HasSubstr("case-1: holds \"notes.txt\""));
    EXPECT_EQ(read_text(temporary / "history.csv"), "old");
}

TEST(ResultsFolder, LinksAreRemovedNotFollowed) {
    const TemporaryFolder temporary;
    fs::create_directory(temporary / "precious");
    write_text(temporary / "precious/a", "precious");
    make_old_results(temporary / "plate");
    fs::remove(temporary / "plate/history.csv");
    fs::create_symlink("../precious/a", temporary / "plate/history.csv");
    fs::remove(temporary / "plate/modes.csv");
    fs::create_directory_symlink("../precious", temporary / "plate/modes.csv");
    const ResultsFolder folder(temporary / "plate");
    EXPECT_THAT(names_in(folder.path()), ElementsAre(".dttmm-results"));
    EXPECT_EQ(read_text(temporary / "precious/a"), "precious");
}

TEST(ResultsFolder, AMarkerThatIsALinkIsForeign) {
    const TemporaryFolder temporary;
    write_text(temporary / "precious", "precious");
    fs::create_directory(temporary / "plate");
    fs::create_symlink("../precious", temporary / "plate/.dttmm-results");
    expect_refused(temporary / "plate", HasSubstr("\".dttmm-results\""));
    EXPECT_EQ(read_text(temporary / "precious"), "precious");
}

TEST(ResultsFolder, AFileInTheWayIsRefused) {
    const TemporaryFolder temporary;
    write_text(temporary / "plate", "");
    expect_refused(temporary / "plate", AllOf(HasSubstr("plate: is a file, not a folder"), HasSubstr("-o")));
    expect_refused(temporary / "plate/below", HasSubstr("Not a directory"));
}

TEST(ResultsFolder, APlaceThatCannotBeWrittenIsRefused) {
    if (fs::exists("/proc/self")) {
        expect_refused("/proc/self/fdinfo", HasSubstr("/proc/self/fdinfo"));
        expect_refused("/proc/dttmm_results", HasSubstr("/proc/dttmm_results"));
    }
    if (::geteuid() == 0) return;  // the rest does not bind the superuser
    const TemporaryFolder temporary;
    fs::create_directory(temporary / "locked");
    fs::permissions(temporary / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    expect_refused(temporary / "locked", HasSubstr("Permission denied"));
    expect_refused(temporary / "locked/plate", HasSubstr("Permission denied"));
    fs::permissions(temporary / "locked", fs::perms::owner_all);
}

TEST(ResultsFolder, ATooLongNameIsRefused) {
    const TemporaryFolder temporary;
    expect_refused(temporary / std::string(5000, 'x'), HasSubstr("File name too long"));
}

TEST(ResultsFolder, ASecondRunIsRefusedAndToldWhoHoldsIt) {
    const TemporaryFolder temporary;
    const ResultsFolder first(temporary / "plate");
    write_text(first.file("history.csv"), "running");
    const std::string holder = "process " + std::to_string(::getpid()) + " on host ";
    expect_refused(temporary / "plate",
                   AllOf(HasSubstr(holder), HasSubstr("wait for it to end, or choose another folder with -o")));
    EXPECT_EQ(run_in_child([&] { ResultsFolder(temporary / "plate"); }), static_cast<int>(ExitCode::input_output));
    EXPECT_EQ(read_text(first.file("history.csv")), "running");
}

TEST(ResultsFolder, AKilledRunFreesItsFolder) {
    const TemporaryFolder temporary;
    EXPECT_EQ(run_in_child([&] {
                  const ResultsFolder folder(temporary / "plate");
                  write_text(folder.file("history.csv"), "half");
                  ::kill(::getpid(), SIGKILL);
              }),
              -SIGKILL);
    const ResultsFolder folder(temporary / "plate");
    EXPECT_THAT(names_in(folder.path()), ElementsAre(".dttmm-results"));
    EXPECT_THAT(read_text(folder.file(".dttmm-results")), MatchesRegex("process [0-9]+ on host [^\n]+\n"));
}

TEST(ResultsFolder, ASweepHoldsItsFolderWhileItsCasesClaimTheirs) {
    const TemporaryFolder temporary;
    const ResultsFolder sweep(temporary.path(), Claim::keep);
    make_old_results(sweep.file("case-1"));
    const ResultsFolder again(sweep.file("case-1"));
    EXPECT_THAT(names_in(again.path()), ElementsAre(".dttmm-results"));
}

TEST(DefaultResultsPath, IsNamedAfterTheModel) {
    EXPECT_EQ(default_results_path("examples/four_bolt_plate/model.toml"), "results/four_bolt_plate");
    EXPECT_EQ(default_results_path("gun.toml"), "results/gun");
    EXPECT_EQ(default_results_path("/a/b/gun.v2.toml"), "results/gun.v2");
    EXPECT_EQ(default_results_path("/a/b/./c/../model.toml"), "results/b");
    EXPECT_EQ(default_results_path("/model.toml"), "results/model");
    EXPECT_EQ(default_results_path("model.toml"), fs::path("results") / fs::current_path().filename());
}

}  // namespace
}  // namespace dttmm::host
