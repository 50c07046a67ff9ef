// SPDX-License-Identifier: BSD-3-Clause
#include "model/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "model/index.h"

namespace dttmm::host {

Place Diagnostics::option_place(std::string option) {
    options_.push_back(std::move(option));
    return {0, as_int(options_.size())};
}

int Diagnostics::add_file(std::string file) {
    files_.push_back(std::move(file));
    return as_int(files_.size()) - 1;
}

std::string Diagnostics::place_text(Place place) const {
    if (place.line > 0) return fmt::format("{}:{}:{}", files_.at(as_size(place.file)), place.line, place.column);
    return place.column > 0 ? options_.at(as_size(place.column) - 1) : files_.at(as_size(place.file));
}

std::string Diagnostics::line_text(Place place) const {
    if (place.line <= 0) return place_text(place);
    return fmt::format("line {}{}", place.line, place.file > 0 ? " of " + files_.at(as_size(place.file)) : "");
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
    std::stable_sort(diagnostics.begin(), diagnostics.end(), [](const auto& a, const auto& b) {
        const auto order = [](const Place& p) { return std::tuple(p.file, p.line, p.column, p.copy); };
        return order(a.place) < order(b.place);
    });
    std::vector<Warning> result;
    for (auto first = diagnostics.begin(); first != diagnostics.end();) {
        const auto is_elsewhere = [&](const Diagnostic& d) { return !d.place.is_same_text(first->place); };
        const auto end = std::find_if(first, diagnostics.end(), is_elsewhere);
        std::set<int> copies;
        for (auto d = first; d != end; ++d) copies.insert(d->place.copy);
        const std::size_t others = copies.size() - 1;
        const std::string note =
            others == 0 ? "" : fmt::format(" (and in {} more cop{} of this)", others, others == 1 ? "y" : "ies");
        for (auto d = first; d != end && d->place.copy == first->place.copy; ++d)
            result.push_back({d->code, place_text(d->place) + ": " + d->text + note});
        first = end;
    }
    return result;
}

}  // namespace dttmm::host
