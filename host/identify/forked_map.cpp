// SPDX-License-Identifier: BSD-3-Clause
#include "identify/forked_map.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <thread>

#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// In front of what a task sends: numbers, or the characters of its reason.
struct Head {
    std::uint64_t task, count;
    std::uint64_t is_reason;
};

void send(int pipe, const void* data, size_t size) {
    for (const char* at = static_cast<const char*>(data); size > 0;) {
        const ssize_t sent = write(pipe, at, size);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) _exit(1);
        at += sent;
        size -= as_size(sent);
    }
}

bool is_server = false;  // this process serves tasks: it makes no others

/// Of a process: tasks first, first + stride, ... of `count`.
[[noreturn]] void serve_tasks(int pipe, size_t first, size_t stride, size_t count,
                              const std::function<std::vector<double>(size_t)>& work) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    is_server = true;
    // What a trial says of itself is no message to the user
    if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) {
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
        close(nowhere);
    }
    for (size_t task = first; task < count && !StopSignals::requested(); task += stride) {
        try {
            const std::vector<double> numbers = work(task);
            const Head head{task, numbers.size(), 0};
            send(pipe, &head, sizeof head);
            send(pipe, numbers.data(), numbers.size() * sizeof(double));
        } catch (const std::exception& error) {
            const std::string reason = error.what();
            const Head head{task, reason.size(), 1};
            send(pipe, &head, sizeof head);
            send(pipe, reason.data(), reason.size());
        }
    }
    _exit(0);
}

/// A process and what has come from it.
struct Server {
    pid_t process = -1;
    int pipe = -1;
    std::vector<char> received = {};

    /// Takes whole messages out of what came.
    void deliver(std::vector<TaskResult>& results) {
        size_t at = 0;
        while (received.size() - at >= sizeof(Head)) {
            Head head{};
            std::memcpy(&head, received.data() + at, sizeof head);
            const size_t size = head.count * (head.is_reason ? 1 : sizeof(double));
            if (received.size() - at < sizeof head + size) break;
            const char* body = received.data() + at + sizeof head;
            TaskResult& result = results[head.task];
            result.reason.clear();
            if (head.is_reason) {
                result.reason.assign(body, head.count);
            } else {
                result.numbers.resize(head.count);
                if (size > 0) std::memcpy(result.numbers.data(), body, size);
            }
            at += sizeof head + size;
        }
        received.erase(received.begin(), received.begin() + as_row(at));
    }
};

/// All processes of one map; they end with it.
class Servers {
public:
    Servers() = default;
    Servers(const Servers&) = delete;
    Servers& operator=(const Servers&) = delete;
    ~Servers() {
        for (const Server& one : all_) {
            if (one.pipe >= 0) close(one.pipe);
            kill(one.process, SIGKILL);
            while (waitpid(one.process, nullptr, 0) < 0 && errno == EINTR) {
            }
        }
    }

    void start(size_t first, size_t stride, size_t count, const std::function<std::vector<double>(size_t)>& work) {
        int ends[2];
        if (pipe(ends) != 0) throw Error(ExitCode::resource_limit, fmt::format("no pipe: {}", std::strerror(errno)));
        const pid_t process = fork();
        if (process == 0) {
            close(ends[0]);
            serve_tasks(ends[1], first, stride, count, work);
        }
        close(ends[1]);
        if (process < 0) {
            close(ends[0]);
            throw Error(ExitCode::resource_limit, fmt::format("no process can be made: {}", std::strerror(errno)));
        }
        all_.push_back({process, ends[0]});
    }

    /// Waits for messages. False: all have ended.
    bool receive(std::vector<TaskResult>& results) {
        std::vector<pollfd> waited;
        for (const Server& one : all_)
            if (one.pipe >= 0) waited.push_back({one.pipe, POLLIN, 0});
        if (waited.empty()) return false;
        constexpr int kPatience = 100;  // [ms] until a stop is looked for
        poll(waited.data(), waited.size(), kPatience);
        for (const pollfd& ready : waited)
            if (ready.revents != 0) take(*std::ranges::find(all_, ready.fd, &Server::pipe), results);
        return true;
    }

private:
    static void take(Server& server, std::vector<TaskResult>& results) {
        char block[1 << 16];
        const ssize_t size = read(server.pipe, block, sizeof block);
        if (size < 0 && (errno == EINTR || errno == EAGAIN)) return;
        if (size <= 0) {
            close(server.pipe);
            server.pipe = -1;
            return;
        }
        server.received.insert(server.received.end(), block, block + size);
        server.deliver(results);
    }

    std::vector<Server> all_;
};

[[noreturn]] void throw_stop() { throw Error(StopSignals::exit_code(), StopSignals::reason()); }

}  // namespace

std::string first_reason(const std::vector<TaskResult>& results) {
    for (const TaskResult& result : results)
        if (!result.reason.empty()) return result.reason;
    return "";
}

std::vector<TaskResult> map_in_processes(size_t count, int jobs, const std::function<std::vector<double>(size_t)>& work) {
    std::vector<TaskResult> results(count, {{}, "its process crashed"});
    const size_t cores = std::max(1u, std::thread::hardware_concurrency());
    const size_t servers = std::min(count, jobs > 0 ? as_size(jobs) : cores);
    if (is_server || count == 0) {
        for (size_t task = 0; task < count; ++task) {
            try {
                results[task] = {work(task)};
            } catch (const Error& error) {
                results[task].reason = error.what();
            }
            if (StopSignals::requested()) throw_stop();
        }
        return results;
    }
    Servers all;
    for (size_t s = 0; s < servers; ++s) all.start(s, servers, count, work);
    while (all.receive(results))
        if (StopSignals::requested()) throw_stop();
    if (StopSignals::requested()) throw_stop();
    return results;
}

}  // namespace dttmm::host
