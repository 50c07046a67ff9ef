// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm {

/// The command `dttmm`: parses the words, runs what they ask for, prints an error as one message on stderr. Returns the exit
/// code of the process; nothing escapes.
int run_command(int argc, char** argv);

}  // namespace dttmm
