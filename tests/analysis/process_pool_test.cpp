// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/process_pool.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <set>

namespace dttmm::host {
namespace {

/// What a process of the next test does.
TEST(ProcessPool, DISABLED_Task) {
    std::fputs("first line\nlast line\n", stderr);
    FAIL();
}

// Oracle: what the processes do, told by hand; never more at a time than asked for.
TEST(ProcessPool, RunsEveryTaskOnceAndTellsHowItEnded) {
    std::multiset<size_t> started, finished;
    size_t most = 0;
    run_processes(
        7, 3,
        [&](size_t task) -> std::vector<std::string> {
            started.insert(task);
            most = std::max(most, started.size() - finished.size());
            if (task == 4) return {"test", "--gtest_filter=None"};
            return {"test", "--gtest_also_run_disabled_tests", "--gtest_filter=ProcessPool.DISABLED_Task"};
        },
        [&](size_t task, int status, const std::string& last_line) {
            finished.insert(task);
            EXPECT_TRUE(WIFEXITED(status));
            EXPECT_EQ(WEXITSTATUS(status), task == 4 ? 0 : 1) << task;
            EXPECT_EQ(last_line, task == 4 ? "" : "last line");
        },
        [] {});
    EXPECT_EQ(started, (std::multiset<size_t>{0, 1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(finished, started);
    EXPECT_EQ(most, 3u);
}

}  // namespace
}  // namespace dttmm::host
