// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace dttmm::host {

/// What one task gave: its numbers, or why it has none.
struct TaskResult {
    std::vector<double> numbers;
    std::string reason = {};  ///< empty: it succeeded
};

/// Why the first task that failed did; empty: none did.
std::string first_reason(const std::vector<TaskResult>& results);

/// Calls work(task) for the tasks 0 … count−1 in copies of this process, `jobs` of them at a time (0: one per core), and
/// returns what each gave, in their order. A task that throws Error, or whose process crashes, has a reason instead of
/// numbers. A task's own maps stay in its process. Throws Error with the code of a stop when the user stops it, and
/// Error(resource_limit) where no process can be made.
std::vector<TaskResult> map_in_processes(std::size_t count, int jobs,
                                         const std::function<std::vector<double>(std::size_t task)>& work);

}  // namespace dttmm::host
