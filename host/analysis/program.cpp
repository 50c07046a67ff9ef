// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>

#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void refuse_start(const char* program) {
    throw Error(ExitCode::resource_limit, fmt::format("{} could not be started: {}", program, std::strerror(errno)));
}

struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

/// A file in memory with a text, to be read from its beginning.
std::unique_ptr<std::FILE, Closer> hold(const std::string& text, const char* program) {
    const int descriptor = ::memfd_create("input", MFD_CLOEXEC);
    std::unique_ptr<std::FILE, Closer> file(descriptor < 0 ? nullptr : ::fdopen(descriptor, "w+"));
    if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() || std::fflush(file.get()) != 0)
        refuse_start(program);
    std::rewind(file.get());
    return file;
}

}  // namespace

std::string ProgramEnd::last_words() const {
    std::string text = output.size() > 500 ? output.substr(output.size() - 500) : output;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return printable(text);
}

ProgramEnd run_program(const std::vector<std::string>& words, const std::string& input) {
    const char* const program = words.front().c_str();
    const auto text = hold(input, program);
    std::array<int, 2> pipe_ends{};
    if (::pipe2(pipe_ends.data(), O_CLOEXEC) != 0) refuse_start(program);
    std::vector<char*> arguments;
    for (const std::string& one : words) arguments.push_back(const_cast<char*>(one.c_str()));  // exec does not write to it
    arguments.push_back(nullptr);
    const pid_t child = ::fork();
    if (child < 0) refuse_start(program);
    if (child == 0) {
        ::dup2(::fileno(text.get()), STDIN_FILENO);
        ::dup2(pipe_ends[1], STDOUT_FILENO);
        ::dup2(pipe_ends[1], STDERR_FILENO);
        ::execvp(arguments[0], arguments.data());
        ::_exit(127);
    }
    ::close(pipe_ends[1]);
    ProgramEnd ended;
    std::array<char, 4096> buffer{};
    bool is_told = false;
    for (;;) {
        if (StopSignals::requested() && !is_told) {
            ::kill(child, SIGTERM);
            is_told = true;
        }
        const ssize_t size = ::read(pipe_ends[0], buffer.data(), buffer.size());
        if (size < 0 && errno == EINTR) continue;
        if (size <= 0) break;
        ended.output.append(buffer.data(), as_size(size));
    }
    ::close(pipe_ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return ended;
}

void refuse_failed(const ProgramEnd& ended, const char* program, const char* package) {
    if (ended.status == 127)
        throw Error(ExitCode::input_output, fmt::format("{} is not installed: sudo apt-get install {}", program, package));
    throw Error(ExitCode::input_output, fmt::format("{} ended with code {}: {}", program, ended.status, ended.last_words()));
}

}  // namespace dttmm::host
