// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// What a command is given besides options.
enum class Given : unsigned char {
    nothing,
    model,
    models,
    model_and_patterns,
    topic,
    folder,
    shell,
    library,
    results,
    several_results,
    results_and_patterns,
    study
};

/// A command: its bit among those of the options, and what it does.
struct CommandLine {
    Command bit;
    const char* name;
    const char* help;
    Given given;
    ExitCode (*run)(const Request& request);
};

std::span<const CommandLine> commands();

/// The command `dttmm`: parses the words, runs what they ask for, prints an error as one message on stderr. Returns the exit
/// code of the process; nothing escapes.
int run_command(int argc, char** argv);

}  // namespace dttmm::host
