// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"

namespace dttmm::host {

/// Prints the channels of a model that the patterns of the request select (all without a pattern): name, unit, and whether a
/// run records it unless asked. Throws Error for a model that cannot run and for a pattern that selects nothing.
void print_channels(const Request& request);

}  // namespace dttmm::host
