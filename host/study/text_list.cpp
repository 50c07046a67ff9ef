// SPDX-License-Identifier: BSD-3-Clause
#include "study/text_list.h"

#include <algorithm>

namespace dttmm::host {

std::string without_blanks_around(std::string_view text) {
    constexpr const char* kBlanks = " \t";
    const size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
    return std::string(text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin));
}

std::vector<std::string> split_list(std::string_view text) {
    std::vector<std::string> parts;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t comma = std::min(text.find(',', begin), text.size());
        parts.push_back(without_blanks_around(text.substr(begin, comma - begin)));
        begin = comma + 1;
    }
    return parts;
}

}  // namespace dttmm::host
