// SPDX-License-Identifier: BSD-3-Clause
//
// What the documents show: every command runs, every link leads somewhere, every option and command is described.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

#include "analysis/request.h"
#include "cli/process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

const fs::path kTree = test::paths::source_dir();

std::vector<fs::path> documents() {
    std::vector<fs::path> found = {kTree / "README.md"};
    for (const char* folder : {"host", "plugin", "tests", "examples"})
        for (const auto& entry : fs::recursive_directory_iterator(kTree / folder))
            if (entry.path().filename() == "README.md") found.push_back(entry.path());
    return found;
}

/// The commands of a document: indented lines, and what stands in backticks with more than the command's name.
std::vector<std::string> commands_in(const std::string& text) {
    std::vector<std::string> commands;
    std::istringstream lines(text);
    const std::regex in_backticks("`(dttmm [a-z]+ [^`]+)`");
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("    dttmm ")) {
            commands.push_back(line.substr(4, line.find("  #") == line.npos ? line.npos : line.find("  #") - 4));
            continue;
        }
        for (std::sregex_iterator found(line.begin(), line.end(), in_backticks), end; found != end; ++found)
            commands.push_back((*found)[1]);
    }
    return commands;
}

std::string replaced(std::string text, const std::string& what, const std::string& instead) {
    for (size_t at = text.find(what); at != text.npos; at = text.find(what, at + instead.size()))
        text.replace(at, what.size(), instead);
    return text;
}

TEST(Documents, EveryCommandRuns) {
    const TemporaryFolder folder;
    fs::create_directory_symlink(kTree / "examples", folder / "examples");
    std::set<std::string> commands;
    for (const fs::path& document : documents())
        for (const std::string& command : commands_in(read_text(document))) commands.insert(command);
    EXPECT_GT(commands.size(), 30u);
    std::vector<std::string> in_order(commands.begin(), commands.end());
    // Others read what these write
    for (const char* writer : {"dttmm modes ", "dttmm run "})
        std::ranges::stable_partition(in_order, [&](const std::string& command) { return command.starts_with(writer); });
    for (const std::string& command : in_order) {
        std::string words = replaced(command, "MODEL", "examples/four_bolt_plate/model.toml");
        words = replaced(words, "RESULTS", "results/soft");
        words = replaced(replaced(words, "check-law FILE", "check-law .build/jenkins.so"), ".build/jenkins.so",
                         test::paths::jenkins());
        words = replaced(replaced(words, "FILE", test::paths::c_spring()), ".build/c_spring.so", test::paths::c_spring());
        words.replace(0, std::string("dttmm").size(), test::paths::command());
        const int status = std::system(fmt::format("cd {} && {} > out 2> err", folder.path().string(), words).c_str());
        EXPECT_EQ(status, 0) << command << "\n" << read_text(folder / "err");
    }
}

TEST(Documents, EveryLinkLeadsSomewhere) {
    const std::regex link("\\]\\(([^)#]+)(#[^)]*)?\\)");
    for (const fs::path& document : documents()) {
        const std::string text = read_text(document);
        for (std::sregex_iterator found(text.begin(), text.end(), link), end; found != end; ++found) {
            const std::string target = (*found)[1];
            EXPECT_TRUE(target.starts_with("http") || fs::exists(document.parent_path() / target))
                << document << ": " << target;
        }
    }
}

TEST(Documents, EveryOptionIsDescribed) {
    const std::string text = read_text(kTree / "host/README.md");
    for (const Option& option : options()) EXPECT_THAT(text, testing::HasSubstr("`" + option.name())) << option.name();
}

TEST(Documents, TheFrontPageIsShort) {
    const std::string text = read_text(kTree / "README.md");
    EXPECT_LE(std::ranges::count(text, '\n'), 150);
}

TEST(Documents, EveryExampleIsListed) {
    const std::string text = read_text(kTree / "examples/README.md");
    for (const auto& entry : fs::directory_iterator(kTree / "examples")) {
        if (!entry.is_directory()) continue;
        EXPECT_THAT(text, testing::HasSubstr(fmt::format("]({})", entry.path().filename().string())));
    }
}

// Oracle: the file. The front page shows the model of the example, and the numbers that the example's test proves.
TEST(Documents, TheFirstModelIsTheExample) {
    const std::string page = read_text(kTree / "README.md"), model = read_text(kTree / "examples/pump_on_mounts/model.toml");
    // Without the line for editors and the comment
    EXPECT_THAT(page, testing::HasSubstr(model.substr(model.find("format ="))));
}

}  // namespace
}  // namespace dttmm::host
