// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/process_pool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <map>
#include <thread>
#include <utility>

#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// A file without a name that takes what a child says.
class Capture {
public:
    Capture() : descriptor_(memfd_create("dttmm-task", MFD_CLOEXEC)) {
        if (descriptor_ < 0)
            throw Error(ExitCode::resource_limit, fmt::format("no memory file for a process: {}", std::strerror(errno)));
    }
    ~Capture() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    Capture(Capture&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    Capture(const Capture&) = delete;
    Capture& operator=(const Capture&) = delete;
    Capture& operator=(Capture&&) = delete;
    int descriptor() const { return descriptor_; }

    /// The last line that is no warning.
    std::string last_line() const {
        std::string text(16384, '\0');
        const ssize_t size = ::pread(descriptor_, text.data(), text.size(), 0);
        text.resize(size > 0 ? as_size(size) : 0);
        while (!text.empty() && text.back() == '\n') text.pop_back();
        const size_t begin = text.rfind('\n');
        return begin == std::string::npos ? text : text.substr(begin + 1);
    }

private:
    int descriptor_;
};

/// Starts `words` in a process of its own: out of the terminal's process group, so that Ctrl-C reaches this process alone,
/// which then stops the others; and ended by the kernel if this one is killed.
pid_t spawn(const std::vector<std::string>& words, int error_descriptor) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));  // exec does not write to it
    arguments.push_back(nullptr);
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child < 0)
        throw Error(ExitCode::resource_limit, fmt::format("a process could not be started: {}", std::strerror(errno)));
    if (child > 0) return child;
    // Between fork and exec: system calls only.
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(static_cast<int>(ExitCode::stopped_by_user));
    ::setpgid(0, 0);
    ::dup2(::open("/dev/null", O_WRONLY | O_CLOEXEC), STDOUT_FILENO);
    ::dup2(error_descriptor, STDERR_FILENO);
    ::execv("/proc/self/exe", arguments.data());
    ::_exit(static_cast<int>(ExitCode::internal_error));
}

struct Running {
    size_t task;
    Capture said;
};

}  // namespace

void run_processes(size_t count, int jobs, const std::function<std::vector<std::string>(size_t task)>& command,
                   const std::function<void(size_t task, int wait_status, const std::string& last_line)>& ended,
                   const std::function<void()>& wait) {
    std::map<pid_t, Running> running;
    size_t next = 0;
    while (next < count || !running.empty()) {
        if (StopSignals::requested()) {
            for (const auto& [child, one] : running) ::kill(child, SIGTERM);
            for (const auto& [child, one] : running)
                while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
                }
            return;
        }
        for (; next < count && as_int(running.size()) < jobs; ++next) {
            Capture said;
            const pid_t child = spawn(command(next), said.descriptor());
            running.emplace(child, Running{next, std::move(said)});
        }
        // Not a wait without end: a signal that comes just before it would go unnoticed until a process ends
        int status = 0;
        const pid_t child = ::waitpid(-1, &status, WNOHANG);
        if (child == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (const auto found = running.find(child); found != running.end()) {
            ended(found->second.task, status, found->second.said.last_line());
            running.erase(found);
        }
        wait();
    }
}

}  // namespace dttmm::host
