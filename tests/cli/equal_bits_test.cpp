// SPDX-License-Identifier: BSD-3-Clause
//
// The plugin has what takes most time compiled for processors with AVX2 and with AVX-512, too. The results must not depend
// on which of them runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "cli/process.h"
#include "support/paths.h"

#ifndef __SANITIZE_ADDRESS__  // then neither has AVX: there is nothing to compare
namespace dttmm::host {
namespace {

/// Of a command whose results go to `out` in the folder.
void run_with(const fs::path& folder, std::vector<std::string> words, const std::string& out) {
    words.insert(words.end(), {"-q", "-o", out});
    const Ended ended = run_dttmm(folder, words);
    ASSERT_EQ(ended.code, 0) << words[1] << "\n" << ended.err;
}

// Oracle: the same sources compiled for none of these processors. A step with joints by four, chains of a beam, rigid
// directions and laws; static equilibrium; modes.
TEST(EqualBits, ResultsAreTheSameWithoutWideRegisters) {
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor has no AVX2: both would run the same";
#endif
    const std::string examples = test::paths::source_dir() + "/examples/";
    const std::vector<std::pair<std::vector<std::string>, std::string>> commands = {
        {{"run", examples + "four_bolt_plate/model.toml", "--duration", "2"}, "history.csv"},
        {{"run", examples + "beam_and_body/model.toml", "--duration", "0.05"}, "history.csv"},
        {{"run", examples + "pendulum_on_bolts/model.toml", "--duration", "0.5"}, "history.csv"},
        {{"static", examples + "portal_frame/model.toml", "--case", "wind"}, "static.csv"},
        {{"modes", examples + "hydroplane/model.toml"}, "modes.csv"},
    };
    for (const auto& [words, table] : commands) {
        const TemporaryFolder folder;
        run_with(folder.path(), words, "wide");
        ASSERT_EQ(setenv("LD_LIBRARY_PATH", (test::paths::binary_dir() + "/tests/narrow").c_str(), 1), 0);
        run_with(folder.path(), words, "narrow");
        ASSERT_EQ(unsetenv("LD_LIBRARY_PATH"), 0);
        EXPECT_EQ(read_text(folder / "wide" / table), read_text(folder / "narrow" / table)) << words[1];
        const auto build = [&](const char* out) {
            return read_json(folder / out / "summary.json")["inputs"]["build"].get<std::string>();
        };
        EXPECT_NE(build("wide"), build("narrow")) << "the same library ran twice";
    }
}

}  // namespace
}  // namespace dttmm::host
#endif
