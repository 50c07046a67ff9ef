// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace dttmm::host {

/// What the process says to its caller when it ends (design: exit codes).
enum class ExitCode : int {
    ok = 0,
    usage = 2,
    model_invalid = 3,
    numerical_failure = 4,
    input_output = 5,
    resource_limit = 6,
    plugin_failure = 7,
    internal_error = 8,
    cases_failed = 9,
    stopped_by_user = 130,
};

/// Every failure the host reports. The text names the place, the fault and the cure.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

}  // namespace dttmm::host
