// SPDX-License-Identifier: BSD-3-Clause
#include "measured/remarks.h"

#include <fmt/format.h>

namespace dttmm::host {

void Remarks::add(const std::string& place, const std::string& text) {
    const auto [known, is_new] = index_.emplace(text, remarks_.size());
    if (is_new)
        remarks_.push_back({place, text, 1});
    else
        ++remarks_[known->second].count;
}

std::vector<std::string> Remarks::notes() const {
    std::vector<std::string> notes;
    for (const auto& [place, text, count] : remarks_) {
        if (place.empty())
            notes.push_back(text);
        else
            notes.push_back(count == 1 ? fmt::format("{}: {}", place, text)
                                       : fmt::format("{} and {} more: {}", place, count - 1, text));
    }
    return notes;
}

}  // namespace dttmm::host
