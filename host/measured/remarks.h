// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

namespace dttmm::host {

/// What a reader says of a file. What is said of many places alike is one note.
class Remarks {
public:
    /// place: "blow.uff:12"; empty for the whole file.
    void add(const std::string& place, const std::string& text);
    /// "blow.uff:12: text", or "blow.uff:12 and 41 more: text", in the order in which the texts came first.
    std::vector<std::string> notes() const;

private:
    struct Remark {
        std::string place, text;
        std::size_t count;
    };
    std::vector<Remark> remarks_;
    std::unordered_map<std::string, std::size_t> index_;  ///< of remarks by their text
};

}  // namespace dttmm::host
