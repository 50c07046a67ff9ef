// SPDX-License-Identifier: BSD-3-Clause
#include "record/atomic_file.h"

#include <gtest/gtest.h>

#include "record/child_process.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

// Oracle: the file as read back; the names in the folder.
TEST(WriteAtomically, WritesAndReplaces) {
    const TemporaryFolder folder;
    write_atomically(folder / "summary.json", "{\"steps\": 1}");
    write_atomically(folder / "summary.json", "{}");
    EXPECT_EQ(read_text(folder / "summary.json"), "{}");
    EXPECT_FALSE(std::filesystem::exists(folder / "summary.json.part"));
}

TEST(WriteAtomically, AFullDiskLeavesTheOldFileAndNoPart) {
    const TemporaryFolder folder;
    write_atomically(folder / "summary.json", "old");
    const std::string text(10'000, 'x');
    for (const rlim_t bytes : {0u, 1u, 4096u, 9'999u})
        EXPECT_EQ(run_in_child([&] {
                      limit_file_size(bytes);
                      write_atomically(folder / "summary.json", text);
                  }),
                  static_cast<int>(ExitCode::input_output));
    EXPECT_EQ(read_text(folder / "summary.json"), "old");
    EXPECT_FALSE(std::filesystem::exists(folder / "summary.json.part"));
}

TEST(WriteAtomically, AFolderInTheWayIsAnError) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "summary.json");
    expect_error([&] { write_atomically(folder / "summary.json", "{}"); }, ExitCode::input_output,
                 HasSubstr("cannot rename to summary.json"));
    EXPECT_FALSE(std::filesystem::exists(folder / "summary.json.part"));
}

TEST(PartFile, IsRemovedUnlessPublished) {
    const TemporaryFolder folder;
    {
        const PartFile part(folder / "a");
        write_text(part.path(), "half");
        EXPECT_EQ(part.path(), folder / "a.part");
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    {
        PartFile part(folder / "a");
        write_text(part.path(), "whole");
        part.publish();
    }
    EXPECT_EQ(read_text(folder / "a"), "whole");
}

}  // namespace
}  // namespace dttmm::host
