// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugin_library.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "loader/faulty_plugin.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

/// Oracle of every refusal: the exit code of a plugin's failure, and a text that names the file and the fault.
void expect_refused(const fs::path& file, const std::string& fault) {
    expect_error([&] { PluginLibrary::load(file); }, ExitCode::plugin_failure,
                 testing::AllOf(StartsWith("plugin " + file.string() + ": "), HasSubstr(fault)));
}

// Oracle: what the C file declares. The copy keeps the library loaded when the original is gone.
TEST(PluginLibrary, APluginInOrderIsLoadedAndStaysAsLongAsACopyLives) {
    auto original = std::make_unique<PluginLibrary>(PluginLibrary::load(faulty_plugin("none")));
    const PluginLibrary copy = *original;
    original.reset();
    EXPECT_EQ(copy.name(), faulty_plugin("none").string());
    EXPECT_STREQ(copy.table().name, "faulty");
    EXPECT_STREQ(copy.table().element_types[0].name, "faulty");
}

TEST(PluginLibrary, TheBuiltInPluginIsInOrder) {
    EXPECT_EQ(PluginLibrary::built_in().name(), "built in");
    EXPECT_EQ(PluginLibrary::built_in().table().major, DTTMM_PLUGIN_MAJOR);
}

TEST(PluginLibrary, WhatIsNoLibraryIsRefused) {
    const TemporaryFolder folder;
    write_text(folder / "text.so", "This is a text, longer than the header of a library, and not a library at all.\n");
    write_text(folder / "empty.so", "");
    write_text(folder / "cut.so", read_text(faulty_plugin("none")).substr(0, 50));
    expect_refused(folder / "missing.so", "there is no such file");
    expect_refused(folder.path(), "no regular file");
    expect_refused("/dev/null", "no regular file");
    expect_refused(folder / "text.so", "invalid ELF header");
    expect_refused(folder / "empty.so", "file too short");
    expect_refused(folder / "cut.so", "file too short");
}

// A bare name is a file of the current folder, not one of the system's libraries.
TEST(PluginLibrary, ABareNameIsNotSearchedOnTheLibraryPath) { expect_refused("libc.so.6", "there is no such file"); }

TEST(PluginLibrary, ALibraryThatIsNoPluginOfThisVersionIsRefused) {
    expect_refused(faulty_plugin("no_entry"), "it exports neither dttmm_plugin_entry nor dttmm_law_entry");
    expect_refused(faulty_plugin("null_table"), "does not support version 2");
    expect_refused(faulty_plugin("other_major"), "built for version 3");
}

// Oracle: dttmm_plugin.h, "a host reads only what `size` covers".
TEST(PluginLibrary, ATableOfAnEarlierMinorVersionIsCompleted) {
    const PluginLibrary old = PluginLibrary::load(faulty_plugin("old_extension"));
    ASSERT_NE(old.modal(), nullptr);
    EXPECT_NE(old.modal()->overall, nullptr);
    EXPECT_EQ(old.modal()->force_at_start, nullptr) << "it stands behind the end of the table";
    EXPECT_EQ(old.modal()->count_free, nullptr);
    EXPECT_EQ(old.response(), nullptr);
}

TEST(PluginLibrary, ATableThatIsNotWholeIsRefused) {
    expect_refused(faulty_plugin("small_table"), "bytes, version 2.0 wants at least");
    expect_refused(faulty_plugin("null_function"), "null entry");
    expect_refused(faulty_plugin("small_extension"), "its table of extension dttmm.modal has 8 bytes, at least ");
    expect_refused(faulty_plugin("null_types"), "list of element types is null");
    for (const char* fault : {"bad_parameter", "bad_words", "bad_default"})
        expect_refused(faulty_plugin(fault), "element type \"faulty\": parameter 0 is not well declared");
    expect_refused(faulty_plugin("bad_ends"), "element type \"faulty\": there is no kind 4 of ends");
    expect_refused(faulty_plugin("bad_key"),
                   "element type \"faulty\": the name \".number\" of parameter 0 is taken, or no key");
    expect_refused(faulty_plugin("taken_key"),
                   "element type \"faulty\": the name \"to\" of parameter 0 is taken, or no key");
}

// Oracle: a constructor in the library makes a marker file if the library is so much as opened. The copy that nobody else
// may write to shows that the constructor works.
TEST(PluginLibrary, AFileThatEverybodyMayWriteToIsNotRun) {
    const TemporaryFolder folder;
    const fs::path closed = folder / "closed.so", open = folder / "open.so", marker = folder / "marker";
    fs::copy_file(faulty_plugin("none"), closed);
    fs::copy_file(faulty_plugin("none"), open);
    fs::permissions(closed, fs::perms::others_write | fs::perms::group_write, fs::perm_options::remove);
    fs::permissions(open, fs::perms::others_write, fs::perm_options::add);
    ::setenv("DTTMM_LOADED_MARKER", marker.c_str(), 1);

    PluginLibrary::load(closed);
    EXPECT_TRUE(fs::exists(marker)) << "the constructor leaves a marker";
    fs::remove(marker);
    expect_refused(open, "everybody may write to this file");
    EXPECT_FALSE(fs::exists(marker)) << "the library was opened";
    ::unsetenv("DTTMM_LOADED_MARKER");
}

}  // namespace
}  // namespace dttmm::host
