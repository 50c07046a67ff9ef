// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/request.h"

namespace dttmm::host {

/// Prints the script that makes a shell ask `dttmm complete` for words. Throws Error(usage) for a shell it does not know.
void print_completion(const Request& request);

/// Prints what the last of the words after "dttmm" may become, one per line: commands, options, topics, parameters of the
/// model after --set and --sweep, channels, places after --in and --out. Prints nothing where files are wanted, and where
/// the model cannot be read.
void complete(const std::vector<std::string>& words);

}  // namespace dttmm::host
