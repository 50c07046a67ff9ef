// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"

namespace dttmm::host {

/// Prints the manual page dttmm(1) in the macros of man(7), from the tables of commands, options and exit codes.
void print_manual(const Request& request);

}  // namespace dttmm::host
