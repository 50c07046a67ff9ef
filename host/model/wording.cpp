// SPDX-License-Identifier: BSD-3-Clause
#include "model/wording.h"

#include <fmt/compile.h>
#include <fmt/format.h>
#include <utf8proc.h>

#include <algorithm>
#include <numeric>

#include "model/index.h"

namespace dttmm::host {
namespace {

constexpr std::size_t kLongestQuote = 100;
constexpr std::size_t kLongestName = 100;
constexpr std::size_t kLongestList = 20;

bool is_visible(utf8proc_int32_t character) {
    switch (utf8proc_category(character)) {
        case UTF8PROC_CATEGORY_CC:
        case UTF8PROC_CATEGORY_CF:
        case UTF8PROC_CATEGORY_CS:
        case UTF8PROC_CATEGORY_CO:
        case UTF8PROC_CATEGORY_CN:
        case UTF8PROC_CATEGORY_ZL:
        case UTF8PROC_CATEGORY_ZP:
            return false;
        default:
            return true;
    }
}

bool is_plain(char c) { return c >= ' ' && c <= '~'; }

/// `most`: characters.
std::string make_visible(std::string_view text, std::size_t most) {
    if (text.size() <= most && std::ranges::all_of(text, is_plain)) return std::string(text);
    std::string result;
    std::size_t characters = 0;
    while (!text.empty()) {
        if (characters++ == most) return result + "…";
        utf8proc_int32_t character = 0;
        const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(text.data());
        const auto length = utf8proc_iterate(bytes, static_cast<utf8proc_ssize_t>(text.size()), &character);
        const std::size_t used = length > 0 ? as_size(length) : 1;
        if (length <= 0) {
            result += fmt::format("\\x{:02x}", bytes[0]);
        } else if (is_visible(character)) {
            result += text.substr(0, used);
        } else {
            result += fmt::format("\\u{{{:x}}}", character);
        }
        text.remove_prefix(used);
    }
    return result;
}

}  // namespace

std::string quote(std::string_view text) { return "\"" + make_visible(text, kLongestQuote) + "\""; }

std::string printable(std::string_view text) { return make_visible(text, text.size()); }

bool is_printable(std::string_view text) { return std::ranges::all_of(text, is_plain) || printable(text) == text; }

std::string number_text(double value) { return fmt::format(FMT_COMPILE("{}"), value); }

std::string counted(std::size_t count, const char* one, const char* many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

int compute_edit_distance(std::string_view a, std::string_view b) {
    a = a.substr(0, kLongestName);
    b = b.substr(0, kLongestName);
    // row[j]: distance between the first i + 1 bytes of a and the first j of b; `above` and `two_above` the same for i, i
    // - 1.
    std::vector<int> two_above, above(b.size() + 1), row(b.size() + 1);
    std::iota(above.begin(), above.end(), 0);
    for (std::size_t i = 0; i < a.size(); ++i) {
        row[0] = as_int(i) + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const int replaced = above[j] + (a[i] == b[j] ? 0 : 1);
            row[j + 1] = std::min({replaced, row[j] + 1, above[j + 1] + 1});
            const bool is_swap = i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j];
            if (is_swap) row[j + 1] = std::min(row[j + 1], two_above[j - 1] + 1);
        }
        two_above = above;
        std::swap(above, row);
    }
    return above.back();
}

std::optional<std::string> find_nearest(std::string_view name, const std::vector<std::string>& candidates) {
    const std::string* nearest = nullptr;
    int distance = std::max(1, as_int(std::min(name.size(), kLongestName)) / 3) + 1;
    for (const std::string& candidate : candidates) {
        const int d = compute_edit_distance(name, candidate);
        if (d >= distance || d >= as_int(candidate.size())) continue;
        distance = d;
        nearest = &candidate;
    }
    return nearest ? std::optional(*nearest) : std::nullopt;
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
    if (candidates.empty()) return {};
    if (const auto nearest = find_nearest(name, candidates)) return fmt::format("; did you mean {}?", quote(*nearest));
    return "; known here: " + listed(candidates);
}

std::string listed(const std::vector<std::string>& items) {
    std::string result;
    for (std::size_t i = 0; i < std::min(items.size(), kLongestList); ++i) result += (i ? ", " : "") + items[i];
    if (items.size() > kLongestList) result += fmt::format(" and {} more", items.size() - kLongestList);
    return result;
}

}  // namespace dttmm::host
