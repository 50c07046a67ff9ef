// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "record/temporary_folder.h"
#include "support/paths.h"

extern char** environ;

namespace dttmm::host {

namespace fs = std::filesystem;

/// How a command ended and what it said.
struct Ended {
    int code = 0;  ///< exit code, or minus the signal that killed it
    std::string out, err;
    double seconds = 0;
    double processor_seconds = 0;  ///< its own, not that of the system for it
    double memory = 0;             ///< most it had [bytes]
};

/// The command `dttmm` in a process of its own, as a user starts it: words, current folder, standard output and error.
class Process {
public:
    /// standard_output: where it goes instead of being kept, e.g. a closed pipe.
    Process(const std::vector<std::string>& words, const fs::path& folder, int standard_output = -1)
        : start_(Clock::now()), out_(memfd_create("out", MFD_CLOEXEC)), err_(memfd_create("err", MFD_CLOEXEC)) {
        std::vector<char*> arguments = {const_cast<char*>("dttmm")};
        for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
        posix_spawn_file_actions_adddup2(&actions, standard_output < 0 ? out_ : standard_output, STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, err_, STDERR_FILENO);
        if (posix_spawn(&id_, test::paths::command().c_str(), &actions, nullptr, arguments.data(), environ) != 0)
            ADD_FAILURE() << "cannot start " << test::paths::command();
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Process() {
        if (!has_ended_) wait(0);
        ::close(out_);
        ::close(err_);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t id() const { return id_; }
    void send(int signal) const { ::kill(id_, signal); }
    /// Processor time that it has taken so far [s]: how far it is does not depend on what else the machine does.
    double processor_time() const {
        clockid_t clock;
        timespec time{};
        if (clock_getcpuclockid(id_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }

    /// Its end; after `limit` seconds it is killed, and the test has failed.
    Ended wait(double limit = 120) {
        int status = 0;
        rusage used{};
        while (::wait4(id_, &status, WNOHANG, &used) == 0) {
            if (std::chrono::duration<double>(Clock::now() - start_).count() > limit) {
                ADD_FAILURE() << "not ended after " << limit << " s";
                send(SIGKILL);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        has_ended_ = true;
        const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
        const double processor =
            static_cast<double>(used.ru_utime.tv_sec) + 1e-6 * static_cast<double>(used.ru_utime.tv_usec);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
                text(out_),
                text(err_),
                seconds,
                processor,
                1024.0 * static_cast<double>(used.ru_maxrss)};
    }

private:
    using Clock = std::chrono::steady_clock;
    static std::string text(int descriptor) {
        std::string all(static_cast<size_t>(::lseek(descriptor, 0, SEEK_END)), '\0');
        all.resize(static_cast<size_t>(::pread(descriptor, all.data(), all.size(), 0)));
        return all;
    }
    Clock::time_point start_;
    int out_, err_;
    pid_t id_ = 0;
    bool has_ended_ = false;
};

/// Runs `dttmm words...` in `folder` to its end.
inline Ended run_dttmm(const fs::path& folder, const std::vector<std::string>& words) {
    return Process(words, folder).wait();
}

/// Waits for `done`, at most half a minute; whether it came true.
inline bool wait_until(const std::function<bool()>& done) {
    for (int i = 0; i < 30000; ++i) {
        if (done()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

inline nlohmann::json read_json(const fs::path& file) { return nlohmann::json::parse(read_text(file)); }

/// A history.csv: its rows of numbers. Every line must be whole and every number finite, or the test has failed.
inline std::vector<std::vector<double>> read_history(const fs::path& file) {
    const std::string text = read_text(file);
    EXPECT_TRUE(text.ends_with('\n')) << "the last row is whole";
    std::istringstream lines(text);
    std::string names, units, line;
    std::getline(lines, names);
    std::getline(lines, units);
    const auto count = static_cast<size_t>(std::count(names.begin(), names.end(), ',') + 1);
    std::vector<std::vector<double>> rows;
    while (std::getline(lines, line)) {
        std::vector<double> row;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) {
            row.push_back(std::stod(cell));
            EXPECT_TRUE(std::isfinite(row.back())) << line;
        }
        EXPECT_EQ(row.size(), count) << line;
        rows.push_back(row);
    }
    return rows;
}

}  // namespace dttmm::host
