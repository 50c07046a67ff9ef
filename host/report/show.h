// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// Three views of a model at its start as an SVG picture: bodies, nodes, elements with their axes, joints, loads, names.
/// Throws Error for a model that cannot be read.
ExitCode show_model(const Request& request);

}  // namespace dttmm::host
