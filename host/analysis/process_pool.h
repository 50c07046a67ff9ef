// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace dttmm::host {

/// Runs this program again, once for each of `count` tasks, in processes of their own, up to `jobs` at a time, until all
/// have ended or the user stops them. A process has the arguments command(task), the first of them its name; it says nothing
/// on the terminal and is ended by the kernel if this one is killed.
/// ended(task, wait status, last line on its standard error): of every process that ended by itself, in the order in which
/// they end. wait(): every millisecond or so.
/// Throws Error(resource_limit) where a process cannot be started.
void run_processes(size_t count, int jobs, const std::function<std::vector<std::string>(size_t task)>& command,
                   const std::function<void(size_t task, int wait_status, const std::string& last_line)>& ended,
                   const std::function<void()>& wait);

}  // namespace dttmm::host
