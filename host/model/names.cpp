// SPDX-License-Identifier: BSD-3-Clause
#include "model/names.h"

#include <fmt/format.h>
#include <utf8proc.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "model/index.h"

namespace dttmm::host {
namespace {

constexpr int kLongestName = 100;

constexpr const char* kBrace = "a brace (braces hold the index of a [[repeat]], and this is in none)";

bool is_name_character(utf8proc_int32_t character) {
    if (character == '_' || character == '-') return true;
    const auto category = utf8proc_category(character);
    return (category >= UTF8PROC_CATEGORY_LU && category <= UTF8PROC_CATEGORY_LO) ||
           (category >= UTF8PROC_CATEGORY_MN && category <= UTF8PROC_CATEGORY_ME) || category == UTF8PROC_CATEGORY_ND;
}

std::string character_text(utf8proc_int32_t character) {
    if (character == '.') return "a dot (it separates body from marker)";
    if (character == '{' || character == '}') return kBrace;
    if (character > ' ' && character < 0x7f) return fmt::format("'{}'", static_cast<char>(character));
    return fmt::format("the character U+{:04X}", character);
}

}  // namespace

std::string normalise_name(std::string_view name) {
    const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x80; };
    if (std::ranges::all_of(name, is_ascii)) return std::string(name);
    utf8proc_uint8_t* buffer = nullptr;
    const auto length =
        utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(name.data()), static_cast<utf8proc_ssize_t>(name.size()),
                     &buffer, static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE));
    const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(buffer, &std::free);
    if (length < 0) return std::string(name);
    return std::string(reinterpret_cast<const char*>(buffer), as_size(length));
}

std::optional<std::string> find_brace(std::string_view name) {
    if (name.find_first_of("{}") == name.npos) return std::nullopt;
    return fmt::format("holds {}", kBrace);
}

std::optional<std::string> find_name_fault(std::string_view name) {
    if (name.empty()) return "is empty";
    if (name.starts_with("-")) return "begins with '-', which a spreadsheet takes for a formula; begin with a letter";
    int characters = 0;
    while (!name.empty()) {
        utf8proc_int32_t character = 0;
        const auto length = utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(name.data()),
                                             static_cast<utf8proc_ssize_t>(name.size()), &character);
        if (length <= 0) return "is not UTF-8 text";
        if (!is_name_character(character))
            return fmt::format("holds {}; a name is made of letters, digits, '_' and '-'", character_text(character));
        if (++characters > kLongestName) return fmt::format("is longer than {} characters", kLongestName);
        name.remove_prefix(as_size(length));
    }
    return std::nullopt;
}

}  // namespace dttmm::host
