// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/error.h"

namespace dttmm::host {

/// Signals that end a command early but in order: what was recorded is kept. SIGINT, SIGTERM and SIGHUP are the user's (exit
/// code 130), SIGXCPU is a resource limit (6). The first asks: requested() is true. The second ends the process at once,
/// with one line: the command may be inside a plugin that does not return. Rows that wait in memory are written first.
/// SIGXFSZ is ignored, so that a full file is an error of the call that meets it. The handlers live as long as this object;
/// one at a time.
class StopSignals {
public:
    enum class First : unsigned char {
        asks,
        ends,  ///< the process at once: there is nothing to keep
    };
    explicit StopSignals(First first = First::asks);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    static bool requested();
    /// Exit code and reason of the signal that came; only when requested().
    static ExitCode exit_code();
    static const char* reason();
};

}  // namespace dttmm::host
