// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// One recorded quantity: a column of history.csv and a dataset of history.h5. Its name is made of what it is; nobody takes
/// a name apart.
struct Channel {
    /// What it belongs to.
    enum class Of : unsigned char { nothing, element, joint, body, marker, node, energy };

    std::string name;          ///< "bolt1.force.x": owner, quantity, axis
    std::string unit;          ///< of the SI value, as text; "1" for a pure number
    bool by_default = true;    ///< recorded when the user asks for nothing in particular
    Of of = Of::nothing;       ///< then it has a name only, as "time" has
    uint32_t owner_size = 0;   ///< of the owner in the name
    uint32_t before_axis = 0;  ///< owner and quantity, with the point between them

    std::string_view owner() const { return std::string_view(name).substr(0, owner_size); }
    std::string_view quantity() const {
        return before_axis == 0 ? std::string_view()
                                : std::string_view(name).substr(owner_size + 1, before_axis - owner_size - 1);
    }
    /// Empty where it has none.
    std::string_view axis() const {
        return before_axis == 0 ? std::string_view()
                                : std::string_view(name).substr(std::min<size_t>(before_axis + 1, name.size()));
    }
    /// Owner and quantity: what its axes have in common.
    std::string_view without_axis() const { return std::string_view(name).substr(0, before_axis); }
};

/// axis: may be empty.
Channel make_channel(Channel::Of of, std::string_view owner, std::string_view quantity, std::string_view axis,
                     std::string unit, bool by_default = true);

/// What every writer relies on: channel 0 is "time", names differ and are not empty, no control character in a name or unit,
/// no slash in a name (HDF5 would make a group of it). Throws Error(internal_error) otherwise.
void check_channels(std::span<const Channel> all);

/// Indices into `all` of the channels to record, ascending; channel 0, the time, is always the first.
/// No patterns: the channels recorded by default. A pattern is a glob (*, ?, [abc]) and selects a channel when it matches
/// the whole name or a leading part that ends at a dot: "bolt*.force" selects bolt1.force.x, "plate" all of the plate's.
/// Throws Error(model_invalid) for a pattern that selects nothing; the text names the nearest and lists what there is.
std::vector<int> select_channels(const std::vector<Channel>& all, const std::vector<std::string>& patterns);

}  // namespace dttmm::host
