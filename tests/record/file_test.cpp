// SPDX-License-Identifier: BSD-3-Clause
#include "record/file.h"

#include <gtest/gtest.h>

#include <cerrno>

#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// Oracle: the file as read back with the standard library.
TEST(File, CreateEmptiesAndOpenKeeps) {
    const TemporaryFolder folder;
    write_text(folder / "a", "old text");
    File::open(folder / "a").write("OLD");
    EXPECT_EQ(read_text(folder / "a"), "OLD text");
    File::create(folder / "a").write("new");
    EXPECT_EQ(read_text(folder / "a"), "new");
}

TEST(File, TruncateMovesTheEnd) {
    const TemporaryFolder folder;
    File file = File::create(folder / "a");
    file.write("one\ntwo\nthr");
    file.truncate(8);
    file.write("four\n");
    file.sync();
    file.close();
    EXPECT_EQ(read_text(folder / "a"), "one\ntwo\nfour\n");
}

TEST(File, NeverWritesThroughALink) {
    const TemporaryFolder folder;
    write_text(folder / "precious", "precious");
    std::filesystem::create_symlink("precious", folder / "link");
    expect_error([&] { File::create(folder / "link"); }, ExitCode::input_output, HasSubstr("remove the symbolic link"));
    EXPECT_EQ(read_text(folder / "precious"), "precious");
}

TEST(File, AFailureNamesPlaceFaultAndCure) {
    const TemporaryFolder folder;
    expect_error(
        [&] { File::create(folder / "missing/a"); }, ExitCode::input_output,
        AllOf(StartsWith((folder / "missing/a").string() + ": cannot open for writing: No such file"), HasSubstr("-o")));
    EXPECT_STREQ(
        file_error("results/history.csv", "cannot write", ENOSPC).what(),
        "results/history.csv: cannot write: No space left on device; free some space or choose another folder with -o");
}

TEST(File, AFullDeviceIsReported) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    File full = File::open("/dev/full");
    expect_error([&] { full.write("x"); }, ExitCode::input_output, HasSubstr("No space left on device"));
}

}  // namespace
}  // namespace dttmm::host
