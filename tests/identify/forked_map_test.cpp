// SPDX-License-Identifier: BSD-3-Clause
#include "identify/forked_map.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "model/error.h"

namespace dttmm::host {
namespace {

// Sizes differ, one is far beyond a pipe's room, and the order is that of the tasks.
TEST(ForkedMap, EveryTaskHasItsOwnNumbersWhateverTheProcesses) {
    for (const int jobs : {1, 2, 5}) {
        const auto results = map_in_processes(7, jobs, [](size_t task) {
            return std::vector<double>(task == 3 ? 300000 : task, static_cast<double>(task) + 0.25);
        });
        ASSERT_EQ(results.size(), 7u);
        for (size_t task = 0; task < 7; ++task) {
            EXPECT_EQ(results[task].reason, "");
            ASSERT_EQ(results[task].numbers.size(), task == 3 ? 300000 : task) << jobs;
            for (const double number : results[task].numbers) ASSERT_EQ(number, static_cast<double>(task) + 0.25);
        }
    }
}

TEST(ForkedMap, AFaultOrACrashIsThatOfItsTask) {
    const auto results = map_in_processes(4, 4, [](size_t task) -> std::vector<double> {
        if (task == 1) throw Error(ExitCode::numerical_failure, "diverged");
        if (task == 2) ::kill(::getpid(), SIGKILL);
        return {1.5};
    });
    EXPECT_EQ(results[0].numbers.size(), 1u);
    EXPECT_EQ(results[1].reason, "diverged");
    EXPECT_NE(results[2].reason, "");
    EXPECT_EQ(results[3].numbers.size(), 1u);
    EXPECT_TRUE(map_in_processes(0, 3, [](size_t) { return std::vector<double>(); }).empty());
}

TEST(ForkedMap, ATasksOwnMapStaysInItsProcess) {
    const auto results = map_in_processes(2, 2, [](size_t) {
        const auto own = static_cast<double>(::getpid());
        const auto inner =
            map_in_processes(1, 4, [](size_t) { return std::vector<double>{static_cast<double>(::getpid())}; });
        return std::vector<double>{own - inner[0].numbers[0]};
    });
    for (const TaskResult& result : results) EXPECT_EQ(result.numbers.at(0), 0);
}

}  // namespace
}  // namespace dttmm::host
