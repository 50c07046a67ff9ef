// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cli/process.h"
#include "support/paths.h"

namespace dttmm::host {

inline std::string modes_model(const std::string& name) {
    return test::paths::source_dir() + "/tests/cli/models/" + name + ".toml";
}

/// What `dttmm modes MODEL --json words...` prints, of a model file; it must succeed and say nothing else.
inline nlohmann::json modes_of_file(const std::string& model, std::vector<std::string> words = {}) {
    const TemporaryFolder folder;
    words.insert(words.begin(), {"modes", model, "--json", "-o", "out"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err.find("warning"), std::string::npos) << ended.err;  // notes about gravity and loads are welcome
    return ended.code == 0 ? nlohmann::json::parse(ended.out) : nlohmann::json::object();
}

/// The same of the text of a model.
inline nlohmann::json modes_of(const std::string& text, const std::vector<std::string>& words = {}) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    return modes_of_file((folder / "model.toml").string(), words);
}

inline std::vector<double> frequencies_of(const nlohmann::json& modes) {
    return modes.value("frequencies_hz", std::vector<double>());
}

/// As many as expected, in order, each within a share of itself; zeros are zeros.
inline void expect_frequencies(const std::vector<double>& found, const std::vector<double>& expected, double relative) {
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(found[i], expected[i], relative * expected[i]) << "frequency " << i + 1;
}

inline std::vector<double> sorted(std::vector<double> values) {
    std::ranges::sort(values);
    return values;
}

}  // namespace dttmm::host
