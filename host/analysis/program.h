// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace dttmm::host {

struct ProgramEnd {
    int status = 0;      ///< exit code; 127: there is no such program; 128 + n: ended by the signal n
    std::string output;  ///< what it wrote on its standard output and error
    /// Its last lines, fit for a message.
    std::string last_words() const;
};

/// Runs another program of the search path, without a shell, to its end. words: its name and arguments; input: what it reads
/// on its standard input. A stop by the user reaches it as SIGTERM. Throws Error(resource_limit) where it cannot be started.
ProgramEnd run_program(const std::vector<std::string>& words, const std::string& input = {});

/// Throws Error(input_output) with the last words of a program that failed, or with the command that installs it.
[[noreturn]] void refuse_failed(const ProgramEnd& ended, const char* program, const char* package);

}  // namespace dttmm::host
