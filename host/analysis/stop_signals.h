// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/error.h"

namespace dttmm {

/// Signals that end a run early but in order: what was recorded is kept. SIGINT, SIGTERM and SIGHUP are the user's (exit
/// code 130), SIGXCPU is a resource limit (6). A second SIGINT ends the process at once. SIGXFSZ is ignored, so that a full
/// file is an error of the call that meets it. The handlers live as long as this object; one at a time.
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    static bool requested();
    /// Exit code and reason of the signal that came; only when requested().
    static ExitCode exit_code();
    static const char* reason();
};

}  // namespace dttmm
