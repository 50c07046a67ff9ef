// SPDX-License-Identifier: BSD-3-Clause
//
// Runs every example as a user would and holds the numbers of its expected.csv against its results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "process.h"
#include "support/csv_line.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

/// "options | value | expected | tolerance | why"; options are those of `run` unless they begin with the name of another
/// command. The value is a pointer into summary.json (of identify into identify.json and so on), or a place in a CSV file of
/// the results, "members.csv case=snow element=girder position=2.5 Mz": a column in the last row whose fields are these.
struct Expectation {
    std::string options, value_at;
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

bool is_cell(const std::string& cell, const std::string& wanted) {
    if (cell == wanted) return true;
    char* end = nullptr;
    const double number = std::strtod(wanted.c_str(), &end);
    return *end == '\0' && !cell.empty() && std::abs(std::strtod(cell.c_str(), nullptr) - number) < 1e-9;
}

/// A value in a CSV file. The name of a case has _ for its spaces.
double csv_value(const fs::path& results, const std::string& place) {
    const std::vector<std::string> words = words_of(place);
    std::istringstream lines(read_text(results / words.front()));
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> names = test::split_csv_line(line);
    const auto column = [&](const std::string& name) {
        const auto found = std::ranges::find(names, name);
        EXPECT_NE(found, names.end()) << place;
        return static_cast<size_t>(found - names.begin()) % names.size();
    };
    std::getline(lines, line);
    double value = NAN;
    while (std::getline(lines, line)) {
        const std::vector<std::string> cells = test::split_csv_line(line);
        bool is_wanted = true;
        for (size_t w = 1; w + 1 < words.size(); ++w) {
            const size_t equals = words[w].find('=');
            std::string field = cells[column(words[w].substr(0, equals))];
            std::ranges::replace(field, ' ', '_');
            is_wanted = is_wanted && is_cell(field, words[w].substr(equals + 1));
        }
        if (is_wanted) value = std::stod(cells[column(words.back())]);
    }
    return value;
}

struct ExampleResults {
    std::unique_ptr<TemporaryFolder> folder = std::make_unique<TemporaryFolder>();
    nlohmann::json summary;
    double at(const std::string& place) const {
        if (place.starts_with('/')) return summary.at(nlohmann::json::json_pointer(place)).get<double>();
        return csv_value(folder->path() / "results", place);
    }
};

ExampleResults run_example(const std::string& name, const std::string& options) {
    ExampleResults results;
    const TemporaryFolder& folder = *results.folder;
    const fs::path model = fs::path(test::paths::source_dir()) / "examples" / name / "model.toml";
    std::vector<std::string> words = words_of(options);
    if (words.empty() || words.front().starts_with("-")) words.insert(words.begin(), "run");
    words.insert(words.begin() + 1, {model, "-q", "-o", folder.path() / "results"});
    if (name == "minimal_law") words.insert(words.end(), {"--plugin", test::paths::jenkins()});
    if (name == "minimal_plugin") words.insert(words.end(), {"--plugin", test::paths::c_spring()});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    // Commands that look at measured data call their summary as they are called
    const fs::path summary = folder.path() / "results" / "summary.json";
    results.summary = read_json(fs::exists(summary) ? summary : folder.path() / "results" / (words.front() + ".json"));
    return results;
}

class Examples : public ::testing::TestWithParam<std::string> {};

TEST_P(Examples, GiveTheNumbersTheyPromise) {
    const fs::path example = fs::path(test::paths::source_dir()) / "examples" / GetParam();
    EXPECT_TRUE(fs::exists(example / "README.md"));
    const std::vector<Expectation> expectations = read_expectations(example / "expected.csv");
    ASSERT_FALSE(expectations.empty()) << example;
    std::map<std::string, ExampleResults> all;  // by options: each set is run once
    for (const Expectation& expected : expectations) {
        const auto [results, is_new] = all.try_emplace(expected.options);
        if (is_new) results->second = run_example(GetParam(), expected.options);
        EXPECT_NEAR(results->second.at(expected.value_at), expected.value, expected.tolerance)
            << expected.options << " " << expected.value_at;
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
