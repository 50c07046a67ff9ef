// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/stop_signals.h"

#include <csignal>

namespace dttmm {

namespace {

volatile std::sig_atomic_t received = 0;

void on_signal(int number) {
    if (received == SIGINT && number == SIGINT) {
        std::signal(SIGINT, SIG_DFL);
        std::raise(SIGINT);
    }
    received = number;
}

constexpr int kHandled[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};

}  // namespace

StopSignals::StopSignals() {
    received = 0;
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
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

bool StopSignals::requested() { return received != 0; }

ExitCode StopSignals::exit_code() { return received == SIGXCPU ? ExitCode::resource_limit : ExitCode::stopped_by_user; }

const char* StopSignals::reason() {
    return received == SIGXCPU ? "the limit of processor time was reached" : "stopped by the user";
}

}  // namespace dttmm
