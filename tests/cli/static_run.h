// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "cli/process.h"

namespace dttmm::host {

/// Names and numbers of the one row of a CSV file, or of its last.
inline std::map<std::string, double> last_row(const fs::path& file) {
    std::istringstream lines(read_text(file));
    std::string names, units, line, last;
    std::getline(lines, names);
    std::getline(lines, units);
    while (std::getline(lines, line)) last = line;
    std::map<std::string, double> row;
    std::istringstream all_names(names), numbers(last);
    for (std::string name, number; std::getline(all_names, name, ',') && std::getline(numbers, number, ',');)
        row[name] = std::stod(number);
    return row;
}

struct AtRest {
    std::map<std::string, double> row;
    nlohmann::json summary;
    std::string told;  ///< on the screen, beside the table
};

inline AtRest rest_of(const std::string& text, std::vector<std::string> words = {}) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    words.insert(words.begin(), {"static", "model.toml", "-o", "out"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    if (ended.code != 0) return {};
    return {last_row(folder / "out/static.csv"), read_json(folder / "out/summary.json"), ended.err};
}

inline std::map<std::string, double> final_row(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    return ended.code == 0 ? last_row(folder / "out/history.csv") : std::map<std::string, double>();
}

}  // namespace dttmm::host
