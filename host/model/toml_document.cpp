// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_document.h"

// toml++ 3.3.0 asserts where bad input should be an error, e.g. on `[[[body]]`: behind each of these assertions stands the
// check that reports it. NDEBUG is not enough: it turns them into promises to the optimiser with some compilers.
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#define TOML_MAX_NESTED_VALUES 64
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <toml++/toml.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <algorithm>

#include "model/toml_text.h"

namespace dttmm {
namespace {

using Kind = TomlValue::Kind;

Place make_place(const toml::source_position& position) {
    return {static_cast<int>(position.line), static_cast<int>(position.column)};
}

Place place_of(const toml::key& key) {
    return make_place(key.source().begin);
}

TomlValue make_value(const toml::node& node);

std::vector<TomlMember> make_members(const toml::table& table) {
    std::vector<TomlMember> members;
    members.reserve(table.size());
    for (const auto& [key, value] : table) members.push_back({std::string(key.str()), place_of(key), make_value(value)});
    std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) { return a.place < b.place; });
    return members;
}

TomlValue make_value(const toml::node& node) {
    TomlValue value;
    value.place = make_place(node.source().begin);
    if (const auto* table = node.as_table()) {
        value.members = make_members(*table);
    } else if (const auto* array = node.as_array()) {
        value.kind = Kind::array;
        value.items.reserve(array->size());
        for (const toml::node& item : *array) value.items.push_back(make_value(item));
    } else if (const auto* text = node.as_string()) {
        value.kind = Kind::text;
        value.string = text->get();
    } else if (const auto* integer = node.as_integer()) {
        value.kind = Kind::integer;
        value.number = static_cast<double>(integer->get());
    } else if (const auto* real = node.as_floating_point()) {
        value.kind = Kind::real;
        value.number = real->get();
    } else {
        value.kind = node.is_boolean() ? Kind::boolean : Kind::date;
    }
    return value;
}

/// Line `line` (counted from 1) without its end, and what stands before it.
struct Line {
    std::string_view before, content;
};

Line line_of(std::string_view text, int line) {
    std::size_t begin = 0;
    for (int i = 1; i < line && begin < text.size(); ++i) begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
    std::string_view content = text.substr(begin, text.find('\n', begin) - begin);
    if (content.ends_with('\r')) content.remove_suffix(1);
    return {text.substr(0, begin), content};
}

int first_column(std::string_view line) {
    return static_cast<int>(std::min(line.find_first_not_of(" \t"), line.size())) + 1;
}

constexpr const char* kProbe = "\001";  // no key of a user: TOML forbids it unescaped

/// The table into which the last key of the document went, given that this key is kProbe.
const toml::table* find_probed_table(const toml::node& node) {
    if (const auto* array = node.as_array()) return array->empty() ? nullptr : find_probed_table(array->back());
    const auto* table = node.as_table();
    if (!table || table->contains(kProbe)) return table;
    for (const auto& [key, value] : *table)
        if (const auto* found = find_probed_table(value)) return found;
    return nullptr;
}

/// Where the path of keys in `path` (a document of one key) first ends in `table`.
std::optional<Place> find_path(const toml::table* table, const toml::table* path) {
    std::optional<Place> found;
    while (table && path && path->size() == 1) {
        const auto step = path->begin();
        const auto member = table->find(step->first.str());
        if (member == table->end()) break;
        found = place_of(member->first);
        const toml::node* value = &member->second;
        if (const auto* array = value->as_array(); array && !array->empty()) value = &array->back();
        table = value->as_table();
        path = step->second.as_table();
    }
    return found;
}

/// Where the key on `line`, which toml++ refused as redefined, was first defined: the text before that line and the line
/// alone are both documents, and the path of keys in the second is looked up in the first. Nothing if they are not.
std::optional<Place> find_first_definition(const Line& line) {
    const bool is_header = line.content.substr(static_cast<std::size_t>(first_column(line.content)) - 1).starts_with('[');
    try {
        const toml::table before = toml::parse(std::string(line.before) + (is_header ? "" : "\"\\u0001\" = 0"));
        const toml::table path = toml::parse(line.content);
        return find_path(is_header ? &before : find_probed_table(before), &path);
    } catch (const toml::parse_error&) {
        return std::nullopt;
    }
}

/// What toml++ says, without the part of its grammar it was in.
std::string message_of(const toml::parse_error& error) {
    const std::string text(error.description());
    const std::size_t colon = text.find(": ");
    return text.starts_with("Error while parsing") && colon != text.npos ? text.substr(colon + 2) : text;
}

/// The first text between single quotes in a message.
std::string quoted_part(const std::string& message) {
    const std::size_t begin = message.find('\'') + 1;
    return message.substr(begin, message.find('\'', begin) - begin);
}

void report(const toml::parse_error& error, std::string_view text, Diagnostics& diagnostics) {
    Place place = make_place(error.source().begin);
    std::string message = message_of(error);
    const auto says = [&](const char* words) { return message.find(words) != message.npos; };
    const Line line = line_of(text, place.line);
    if (says("cannot redefine")) {
        if (const auto first = find_first_definition(line)) {
            place.column = first_column(line.content);
            message += fmt::format("; first defined on line {}, column {}", first->line, first->column);
        }
    } else if (says("not representable") || says("could not be interpreted as a value")) {
        const std::string number = quoted_part(message);
        const std::size_t at = line.content.find(number);
        if (at != line.content.npos) place.column = static_cast<int>(at) + 1;
        message = fmt::format(
            "{} is out of range: an integer must fit into 64 bits, any other number lie within 1e-307 and 1e308", number);
    }
    diagnostics.error(place, message);
}

}  // namespace

const TomlMember* TomlValue::find(std::string_view key) const {
    for (const TomlMember& member : members)
        if (member.key == key) return &member;
    return nullptr;
}

std::string_view kind_text(Kind kind) {
    switch (kind) {
        case Kind::boolean:
            return "true or false";
        case Kind::integer:
        case Kind::real:
            return "a number";
        case Kind::text:
            return "a text";
        case Kind::date:
            return "a date or time";
        case Kind::array:
            return "a list";
        case Kind::table:
            return "a table";
    }
    return "a value";
}

std::optional<TomlValue> parse_toml(std::string_view text, Diagnostics& diagnostics) {
    if (const auto fault = find_text_fault(text)) {
        diagnostics.error(fault->place, fault->text);
        return std::nullopt;
    }
    try {
        return make_value(toml::parse(text));
    } catch (const toml::parse_error& error) {
        report(error, text, diagnostics);
        return std::nullopt;
    }
}

}  // namespace dttmm
