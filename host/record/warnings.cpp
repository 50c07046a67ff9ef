// SPDX-License-Identifier: BSD-3-Clause
#include "record/warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "record/tell.h"

namespace dttmm::host {

void Warnings::add(const std::vector<Warning>& warnings) {
    for (const Warning& warning : warnings) print("warning", warning);
}

void Warnings::print(const char* kind, const Warning& warning) {
    if (!seen_.emplace(warning.code, warning.text).second) return;
    all_.push_back(warning);
    if (is_silent_) return;
    if (whole_)
        whole_->print(kind, warning);
    else if (all_.size() <= kMostPrinted)
        tell(fmt::format("{}: {}", kind, warning.text));
    else
        ++unprinted_[warning.code];
}

void Warnings::print_rest(const std::string& where) const {
    if (whole_ || all_.size() <= kMostPrinted) return;
    std::string codes;
    for (const auto& [code, count] : unprinted_) codes += fmt::format("{}{} {}", codes.empty() ? "" : ", ", count, code);
    const std::size_t rest = all_.size() - kMostPrinted;
    tell(fmt::format("and {} more warning{} ({}){}", rest, rest == 1 ? "" : "s", codes, where));
}

bool Warnings::has(const std::string& code) const { return std::ranges::find(all_, code, &Warning::code) != all_.end(); }

}  // namespace dttmm::host
