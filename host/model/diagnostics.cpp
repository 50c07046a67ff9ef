// SPDX-License-Identifier: BSD-3-Clause
#include "model/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/index.h"

namespace dttmm::host {

Place Diagnostics::option_place(std::string option) {
    options_.push_back(std::move(option));
    return {0, as_int(options_.size())};
}

std::string Diagnostics::place_text(Place place) const {
    if (place.line > 0) return fmt::format("{}:{}:{}", file_, place.line, place.column);
    return place.column > 0 ? options_.at(as_size(place.column) - 1) : file_;
}

std::string Diagnostics::line_text(Place place) const {
    return place.line > 0 ? fmt::format("line {}", place.line) : place_text(place);
}

void Diagnostics::throw_if_errors() const {
    if (errors_.empty()) return;
    const std::vector<Warning> lines = in_order(errors_);
    const std::size_t shown = std::min<std::size_t>(lines.size(), kMostShown);
    std::string text;
    for (std::size_t i = 0; i < shown; ++i) text += (i ? "\n" : "") + lines[i].text;
    if (lines.size() > shown)
        text += fmt::format("\nand {} more error{}", lines.size() - shown, lines.size() - shown == 1 ? "" : "s");
    throw ModelError(text);
}

std::vector<Warning> Diagnostics::warnings() const { return in_order(warnings_); }

std::vector<Warning> Diagnostics::in_order(std::vector<Diagnostic> diagnostics) const {
    std::stable_sort(diagnostics.begin(), diagnostics.end(), [](const auto& a, const auto& b) { return a.place < b.place; });
    std::vector<Warning> result;
    for (const Diagnostic& d : diagnostics) result.push_back({d.code, place_text(d.place) + ": " + d.text});
    return result;
}

}  // namespace dttmm::host
