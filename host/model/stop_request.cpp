// SPDX-License-Identifier: BSD-3-Clause
#include "model/stop_request.h"

#include <fmt/format.h>

#include <csignal>

namespace dttmm::host {

namespace {
volatile std::sig_atomic_t stop_signal = 0;
}

void StopRequest::set(int signal) { stop_signal = signal; }

bool StopRequest::is_made() { return stop_signal != 0; }

ExitCode StopRequest::exit_code() { return stop_signal == SIGXCPU ? ExitCode::resource_limit : ExitCode::stopped_by_user; }

const char* StopRequest::reason() {
    return stop_signal == SIGXCPU ? "the limit of processor time was reached" : "stopped by the user";
}

void StopRequest::throw_if_made(const char* when) {
    if (is_made()) throw Error(exit_code(), fmt::format("{} {}", reason(), when));
}

}  // namespace dttmm::host
