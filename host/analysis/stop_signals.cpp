// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/stop_signals.h"

#include <unistd.h>

#include <csignal>
#include <ctime>

#include "model/index.h"
#include "model/stop_request.h"
#include "record/csv_writer.h"

namespace dttmm::host {

namespace {

volatile std::sig_atomic_t first_ends = 0;
timespec received_at{};  // written and read by the handler alone, which no other signal of ours interrupts

/// A second signal sooner than this is the same one: `timeout` sends SIGTERM to the process and to its group.
constexpr double kSameSignal = 0.2;  // s

double seconds_since(const timespec& then) {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec - then.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - then.tv_nsec);
}

template <size_t n>
void say(const char (&text)[n]) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, n - 1);
}

[[noreturn]] void end_now(int number) {
    CsvWriter::rescue_rows();
    if (first_ends)
        say("dttmm: stopped by a signal; no results\n");
    else
        say("dttmm: stopped at once by a second signal; the rows written stay\n");
    ::_exit(static_cast<int>(number == SIGXCPU ? ExitCode::resource_limit : ExitCode::stopped_by_user));
}

void on_signal(int number) {
    if (first_ends || (StopRequest::is_made() && seconds_since(received_at) > kSameSignal)) end_now(number);
    if (StopRequest::is_made()) return;
    clock_gettime(CLOCK_MONOTONIC, &received_at);
    StopRequest::set(number);
}

constexpr int kHandled[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};

}  // namespace

StopSignals::StopSignals(First first) {
    StopRequest::set(0);
    first_ends = first == First::ends;
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    for (int number : kHandled) sigaddset(&action.sa_mask, number);
    for (int number : kHandled) {
        struct sigaction inherited {};
        sigaction(number, nullptr, &inherited);
        if (inherited.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);  // else nohup: the caller wants it ignored
    }
    std::signal(SIGXFSZ, SIG_IGN);
}

StopSignals::~StopSignals() {
    for (int number : kHandled) {
        struct sigaction present {};
        sigaction(number, nullptr, &present);
        if (present.sa_handler == on_signal) std::signal(number, SIG_DFL);
    }
    std::signal(SIGXFSZ, SIG_DFL);
}

bool StopSignals::requested() { return StopRequest::is_made(); }

ExitCode StopSignals::exit_code() { return StopRequest::exit_code(); }

const char* StopSignals::reason() { return StopRequest::reason(); }

}  // namespace dttmm::host
