// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include "model/error.h"

namespace dttmm::host {

/// Runs `work` in a process of its own, which ends as the command would: exit code 0, that of an Error, or 99.
inline pid_t start_child(const std::function<void()>& work) {
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child != 0) return child;
#ifdef __SANITIZE_ADDRESS__
    __lsan_disable();  // HDF5 1.10 keeps its own memory after a write has failed, and a leak would be the exit code
#endif
    int code = 0;
    try {
        work();
    } catch (const Error& error) {
        code = static_cast<int>(error.code());
    } catch (const std::exception&) {
        code = 99;
    }
    std::exit(code);  // not _exit: what libraries do at exit is part of the test
}

/// The exit code, or minus the signal that ended the child.
inline int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

inline int run_in_child(const std::function<void()>& work) { return wait_for(start_child(work)); }

/// From now on no file of this process grows beyond `bytes`: a write that would fails with EFBIG, as on a full disk.
inline void limit_file_size(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
}

}  // namespace dttmm::host
