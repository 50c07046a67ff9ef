// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "model/channel.h"

namespace dttmm::host {

/// Indices into `all` of the channels to record, ascending; channel 0, the time, is always the first.
/// No patterns: the channels recorded by default. A pattern is a glob (*, ?, [abc]) and selects a channel when it matches
/// the whole name or a leading part that ends at a dot: "bolt*.force" selects bolt1.force.x, "plate" all of the plate's.
/// Throws Error(model_invalid) for a pattern that selects nothing; the text names the nearest and lists what there is.
std::vector<int> select_channels(const std::vector<Channel>& all, const std::vector<std::string>& patterns);

}  // namespace dttmm::host
