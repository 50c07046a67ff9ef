// SPDX-License-Identifier: BSD-3-Clause
//
// Runs every example as a user would and holds the numbers of its expected.csv against summary.json.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

/// "options | pointer into summary.json | expected | tolerance | why"; options are those of `run` unless they begin with
/// the name of another command
struct Expectation {
    std::string options, pointer;
    double value = NAN, tolerance = NAN;
};

std::string trimmed(const std::string& text) {
    const size_t begin = text.find_first_not_of(' ');
    return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::vector<Expectation> read_expectations(const fs::path& path) {
    std::vector<Expectation> expectations;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::vector<std::string> fields;
        std::stringstream parts(line);
        for (std::string field; std::getline(parts, field, '|');) fields.push_back(trimmed(field));
        EXPECT_EQ(fields.size(), 5u) << path << ": " << line;
        if (fields.size() == 5) expectations.push_back({fields[0], fields[1], std::stod(fields[2]), std::stod(fields[3])});
    }
    return expectations;
}

std::vector<std::string> words_of(const std::string& options) {
    std::vector<std::string> words;
    std::stringstream parts(options);
    for (std::string word; parts >> word;) words.push_back(word);
    return words;
}

nlohmann::json run_example(const std::string& name, const std::string& options) {
    const TemporaryFolder folder;
    const fs::path model = fs::path(test::paths::source_dir()) / "examples" / name / "model.toml";
    std::vector<std::string> words = words_of(options);
    if (words.empty() || words.front().starts_with("-")) words.insert(words.begin(), "run");
    words.insert(words.begin() + 1, {model, "-q", "-o", folder.path() / "results"});
    if (name == "minimal_law") words.insert(words.end(), {"--plugin", test::paths::jenkins()});
    if (name == "minimal_plugin") words.insert(words.end(), {"--plugin", test::paths::c_spring()});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    return read_json(folder.path() / "results" / "summary.json");
}

class Examples : public ::testing::TestWithParam<std::string> {};

TEST_P(Examples, GiveTheNumbersTheyPromise) {
    const fs::path example = fs::path(test::paths::source_dir()) / "examples" / GetParam();
    EXPECT_TRUE(fs::exists(example / "README.md"));
    const std::vector<Expectation> expectations = read_expectations(example / "expected.csv");
    ASSERT_FALSE(expectations.empty()) << example;
    std::map<std::string, nlohmann::json> summaries;  // by options: each set is run once
    for (const Expectation& expected : expectations) {
        nlohmann::json& summary = summaries[expected.options];
        if (summary.is_null()) summary = run_example(GetParam(), expected.options);
        EXPECT_NEAR(summary.at(nlohmann::json::json_pointer(expected.pointer)).get<double>(), expected.value,
                    expected.tolerance)
            << expected.options << " " << expected.pointer;
    }
}

std::vector<std::string> folders() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(fs::path(test::paths::source_dir()) / "examples"))
        if (entry.is_directory()) names.push_back(entry.path().filename());
    return names;
}

INSTANTIATE_TEST_SUITE_P(All, Examples, ::testing::ValuesIn(folders()), [](const auto& example) { return example.param; });

}  // namespace
}  // namespace dttmm::host
