// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

namespace dttmm::host {

/// One recorded quantity: a column of history.csv and a dataset of history.h5.
struct Channel {
    std::string name;        ///< "bolt1.force.x"
    std::string unit;        ///< of the SI value, as text; "1" for a pure number
    bool by_default = true;  ///< recorded when the user asks for nothing in particular
};

/// What every writer relies on: channel 0 is "time", names differ and are not empty, no control character in a name or unit,
/// no slash in a name (HDF5 would make a group of it). Throws Error(internal_error) otherwise.
void check_channels(std::span<const Channel> all);

/// Indices into `all` of the channels to record, ascending; channel 0, the time, is always the first.
/// No patterns: the channels recorded by default. A pattern is a glob (*, ?, [abc]) and selects a channel when it matches
/// the whole name or a leading part that ends at a dot: "bolt*.force" selects bolt1.force.x, "plate" all of the plate's.
/// Throws Error(model_invalid) for a pattern that selects nothing; the text names the nearest and lists what there is.
std::vector<int> select_channels(const std::vector<Channel>& all, const std::vector<std::string>& patterns);

}  // namespace dttmm::host
