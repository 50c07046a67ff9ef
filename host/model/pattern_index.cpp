// SPDX-License-Identifier: BSD-3-Clause
#include "model/pattern_index.h"
#include "model/digits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"
#include "model/names.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

[[noreturn]] void fail_text(const std::string& text) { throw Error(ExitCode::model_invalid, text); }

const PatternIndex* find_index(const PatternIndices& indices, std::string_view name) {
    const auto found = std::ranges::find(indices, name, &PatternIndex::name);
    return found == indices.end() ? nullptr : &*found;
}

[[noreturn]] void fail_in_expression(const PatternIndex& index) {
    fail_text(fmt::format("the index \"{0}\" stands for texts and cannot be calculated with; write \"{{{0}}}\" in a text",
                          index.name));
}

/// The value of what stands between two braces.
std::string in_braces(std::string_view inner, const PatternIndices& indices, const Constants& constants) {
    if (const PatternIndex* alone = find_index(indices, bare_name(inner))) return alone->text;
    Constants known = constants;
    for (const PatternIndex& index : indices)
        if (index.number) known[index.name] = *index.number;
    for (const std::string& name : expression_names(inner))
        if (const PatternIndex* index = find_index(indices, name); index && !index->number) fail_in_expression(*index);
    if (inner.find_first_not_of(" \t") == inner.npos)
        fail_text("nothing stands between the braces; write an index, as \"{i}\"");
    return number_text(evaluate_expression(inner, known) + 0.0);
}

/// Of names and numbers in an expression.
bool is_of_word(char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
           static_cast<unsigned char>(c) >= 0x80;
}

/// What the braces around `inner` become in an expression, behind `before`: the end of a name, as in "k{i}", or else the
/// operand that an index itself would be.
std::string in_expression(std::string_view before, std::string_view inner, const std::string& value) {
    std::size_t begin = before.size();
    while (begin > 0 && is_of_word(before[begin - 1])) --begin;
    const std::string word(before.substr(begin));
    const bool is_plain = std::ranges::all_of(value, is_of_word);
    if (word.empty()) return is_plain ? value : "(" + value + ")";
    const std::string whole = fmt::format("{}{{{}}}", word, inner);
    const bool is_number = is_digit(word.front()) || word.front() == '.';
    if (is_number && (is_digit(word.back()) || word.back() == '.'))
        fail_text(fmt::format("{} would put digits together to {}{}; write {}*{} for a product", quote(whole), word, value,
                              word, bare_name(inner).empty() ? fmt::format("({})", inner) : std::string(inner)));
    if (!is_number && !is_plain)
        fail_text(
            fmt::format("{} would be {}{}, which is no name; in a name the index is a whole number from 0 on, or a text "
                        "of letters, digits and '_'",
                        quote(whole), word, value));
    return value;
}

}  // namespace

PatternIndex numbered_index(const std::string& name, double number) { return {name, number, number_text(number + 0.0)}; }

std::optional<std::string> find_index_fault(const std::string& name, const PatternIndices& outer,
                                            const Constants& constants) {
    if (const auto fault = find_name_fault(name)) return fault;
    if (bare_name(name) != name) return "must begin with a letter and hold letters, digits and '_' only";
    const auto functions = expression_functions();
    if (name == "pi" || name == "t" || std::ranges::find(functions, name) != functions.end())
        return "has another meaning in expressions; choose another name";
    if (find_index(outer, name)) return "is the index of the pattern around it already; choose another name";
    if (constants.contains(name)) return "is the name of a parameter already; choose another name";
    if (constants.contains(name + ".x")) return "is the name of a station already; choose another name";
    return std::nullopt;
}

std::string with_indices(std::string_view text, const PatternIndices& indices, const Constants& constants) {
    std::string result;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t brace = text.find_first_of("{}", at);
        result += text.substr(at, brace - at);
        if (brace == text.npos) break;
        const std::size_t end = text.find_first_of("{}", brace + 1);
        if (text[brace] == '}') fail_text(fmt::format("no brace opens before the '}}' of {}", quote(text)));
        if (end == text.npos || text[end] == '{')
            fail_text(
                fmt::format("the brace is not closed in {}; an index stands in braces, as \"bolt{{i}}\"", quote(text)));
        const std::string_view inner = text.substr(brace + 1, end - brace - 1);
        const std::string value = in_braces(inner, indices, constants);
        result += text.starts_with('=') ? in_expression(result, inner, value) : value;
        at = end + 1;
    }
    if (!result.starts_with("=")) return result;
    return replace_names(result, [&](const std::string& name) {
        const PatternIndex* index = find_index(indices, name);
        if (index && !index->number) fail_in_expression(*index);
        return !index ? name : *index->number < 0 ? "(" + index->text + ")" : index->text;
    });
}

std::optional<std::string> read_index_name(const TableReader& table, const PatternIndices& outer) {
    const auto given = table.text("index");
    if (!given) return std::nullopt;
    const std::string name = normalise_name(*given);
    const auto fault = find_index_fault(name, outer, table.context().parameters.constants());
    if (!fault) return name;
    table.error(table.find("index")->value.place, fmt::format("index {} {}", quote(name), *fault));
    return std::nullopt;
}

std::optional<int> read_count(const TableReader& table) {
    const auto count = table.number("count");
    if (!count || *count == std::round(*count)) return count ? std::optional(static_cast<int>(*count)) : std::nullopt;
    table.error(table.find("count")->value.place, fmt::format("count must be a whole number, got {}", number_text(*count)));
    return std::nullopt;
}

std::optional<PatternIndices> read_indices(const TableReader& table, const PatternIndices& outer) {
    const auto name = read_index_name(table, outer);
    const TomlMember* how = table.require_one({"count", "values"});
    if (!how) return std::nullopt;
    PatternIndices indices;
    if (how->key == "count") {
        const auto count = read_count(table);
        for (int k = 1; k <= count.value_or(0); ++k) indices.push_back(numbered_index(name.value_or(""), k));
        return name && count ? std::optional(indices) : std::nullopt;
    }
    if (!how->value.is_array() || how->value.items.empty()) {
        table.error(how->value.place, "values must be a list of one or more numbers or texts, as [1, 3, 4]");
        return std::nullopt;
    }
    for (const TomlValue& item : how->value.items) {
        if (item.is_text() && !item.string.starts_with("=")) {
            indices.push_back({name.value_or(""), std::nullopt, item.string});
            continue;
        }
        const auto number = read_number(table.context(), item, table.what("values"), "1");
        if (!number) return std::nullopt;
        indices.push_back(numbered_index(name.value_or(""), *number));
    }
    return name ? std::optional(indices) : std::nullopt;
}

}  // namespace dttmm::host
