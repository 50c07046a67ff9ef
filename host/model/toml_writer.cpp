// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_writer.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/wording.h"

namespace dttmm::host {
namespace {

std::string toml_text(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += fmt::format("\\{}", c);
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            result += fmt::format("\\u{:04X}", static_cast<int>(c));
        else
            result += c;
    }
    return result + "\"";
}

std::string toml_key(const std::string& key) {
    const auto is_bare = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    };
    return !key.empty() && std::ranges::all_of(key, is_bare) ? key : toml_text(key);
}

std::string toml_value(const TomlValue& value) {
    std::vector<std::string> parts;
    switch (value.kind) {
        case TomlValue::Kind::boolean:
            return value.number != 0 ? "true" : "false";
        case TomlValue::Kind::integer:
        case TomlValue::Kind::real:
            return number_text(value.number);
        case TomlValue::Kind::text:
            return toml_text(value.string);
        case TomlValue::Kind::date:  // no key takes one
            return "0";
        case TomlValue::Kind::array:
            for (const TomlValue& item : value.items) parts.push_back(toml_value(item));
            return fmt::format("[{}]", fmt::join(parts, ", "));
        case TomlValue::Kind::table:
            for (const TomlMember& member : value.members)
                parts.push_back(fmt::format("{} = {}", toml_key(member.key), toml_value(member.value)));
            return parts.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(parts, ", "));
    }
    return {};
}

bool is_list_of_tables(const TomlValue& value) {
    return value.is_array() && !value.items.empty() && std::ranges::all_of(value.items, &TomlValue::is_table);
}

void write_members(std::string& out, const TomlValue& table) {
    for (const TomlMember& member : table.members)
        out += fmt::format("{} = {}\n", toml_key(member.key), toml_value(member.value));
}

}  // namespace

std::string write_toml(const TomlValue& document) {
    std::string out;
    for (const TomlMember& member : document.members)
        if (!member.value.is_table() && !is_list_of_tables(member.value))
            out += fmt::format("{} = {}\n", toml_key(member.key), toml_value(member.value));
    for (const TomlMember& member : document.members) {
        if (member.value.is_table()) {
            out += fmt::format("\n[{}]\n", toml_key(member.key));
            write_members(out, member.value);
        } else if (is_list_of_tables(member.value)) {
            for (const TomlValue& item : member.value.items) {
                out += fmt::format("\n[[{}]]\n", toml_key(member.key));
                write_members(out, item);
            }
        }
    }
    return out;
}

}  // namespace dttmm::host
