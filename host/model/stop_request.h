// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/error.h"

namespace dttmm::host {

/// The signal that asks the command to end, if one has come. The handlers of the command set it; what takes long asks.
class StopRequest {
public:
    /// 0: none. Safe in a signal handler.
    static void set(int signal);
    static bool is_made();
    /// Of the signal; only when one is made.
    static ExitCode exit_code();
    static const char* reason();
    /// Throws Error(exit_code()) where one is made: "stopped by the user " and `when`.
    static void throw_if_made(const char* when);
};

}  // namespace dttmm::host
