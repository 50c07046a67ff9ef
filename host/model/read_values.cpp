// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <sstream>

#include "model/element_catalogue.h"
#include "model/error.h"
#include "model/index.h"
#include "model/table_file.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

std::span<const dttmm_parameter> parameters_of(const dttmm_element_type& type) {
    return {type.parameters, type.parameter_count};
}

/// "section.tube": the table `section`, empty for the element's own, and the key `tube` in it; parts of the text given.
struct Path {
    explicit Path(std::string_view name) {
        const std::size_t dot = name.find('.');
        if (dot != name.npos) table = name.substr(0, dot);
        key = dot == name.npos ? name : name.substr(dot + 1);
    }
    std::string_view table, key;
};

std::vector<std::string> words_of(const dttmm_parameter& parameter) {
    std::vector<std::string> words;
    for (std::uint32_t w = 0; w < parameter.word_count; ++w) words.emplace_back(parameter.words[w].name);
    return words;
}

/// Whether a text is meant as a quantity or an expression, however faulty.
bool is_numeric(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    return first != text.npos && std::string_view("=+-.0123456789").find(text[first]) != std::string_view::npos;
}

std::optional<double> read_word(const TableReader& table, const TomlMember& member, const dttmm_parameter& parameter) {
    const TomlValue& value = member.value;
    const std::vector<std::string> words = words_of(parameter);
    if (value.is_text()) {
        const auto word = std::find(words.begin(), words.end(), value.string);
        if (word != words.end()) return parameter.words[word - words.begin()].value;
    }
    const bool words_only = parameter.flags & DTTMM_PARAMETER_WORDS_ONLY;
    const auto nearest = value.is_text() ? find_nearest(value.string, words) : std::nullopt;
    const bool is_law = words_only && std::string_view(parameter.name).ends_with("law");
    table.error(value.place, fmt::format("{} must be {}one of: {}; got {}{}{}", member.key,
                                         words_only ? "" : fmt::format("a number in {} or ", parameter.unit), listed(words),
                                         value.is_text() ? quote(value.string) : kind_text(value.kind),
                                         nearest ? fmt::format("; did you mean {}?", quote(*nearest)) : "",
                                         is_law ? "; a law of your own is known with --plugin and its library" : ""));
    return std::nullopt;
}

bool check_whole(const TableReader& table, const TomlMember& member, const std::vector<double>& numbers) {
    const auto broken = std::find_if(numbers.begin(), numbers.end(), [](double x) { return x != std::round(x); });
    if (broken == numbers.end()) return true;
    const TomlValue& value = member.value;
    const Place place = value.is_array() ? value.items[as_size(broken - numbers.begin())].place : value.place;
    table.error(place, fmt::format("{} must be a whole number, got {}", member.key, number_text(*broken)));
    return false;
}

/// "frequency [Hz]; stiffness [N/m]; angle [rad]" of a parameter with rows.
std::vector<TableColumn> columns_of(const dttmm_parameter& parameter) {
    std::vector<TableColumn> columns;
    std::istringstream fields(parameter.unit);
    for (std::string field; std::getline(fields, field, ';');) {
        const std::size_t begin = field.find_first_not_of(' '), bracket = field.find(" [");
        const std::string word = field.substr(begin, bracket - begin);
        columns.push_back({word, word == "frequency" ? "frequencies" : word,
                           field.substr(bracket + 2, field.size() - bracket - 3), field.substr(begin)});
    }
    return columns;
}

/// The rows of a file, or [[..], [..]]. Nothing where one has a fault, which is reported.
std::optional<std::vector<std::vector<double>>> read_rows(const TableReader& table, const TomlMember& member,
                                                          const std::vector<TableColumn>& columns) {
    const TomlValue& value = member.value;
    const ReadContext& context = table.context();
    if (value.is_text()) {
        try {
            const std::filesystem::path& folder = context.folder_of(value.place);
            auto rows = read_columns_file(folder, value.string, columns);
            context.inputs.read.push_back(folder / value.string);
            return rows;
        } catch (const Error& error) {
            table.error(value.place, error.what());
            return std::nullopt;
        }
    }
    std::vector<std::vector<double>> rows;
    bool is_whole = value.is_array() && !value.items.empty();
    for (const TomlValue& item : value.items) {
        is_whole = is_whole && item.is_array() && item.items.size() == columns.size();
        if (!is_whole) break;
        std::vector<double>& row = rows.emplace_back();
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const auto number = read_numbers(context, item.items[c], table.what(member.key), columns[c].unit, 1);
            if (!number) return std::nullopt;
            row.push_back(number->front());
        }
    }
    if (is_whole) return rows;
    std::string words;
    for (const TableColumn& column : columns) words += (words.empty() ? "" : ", ") + column.word;
    table.error(value.place, fmt::format("{} must be the name of a file, or rows [[{}], ..]", member.key, words));
    return std::nullopt;
}

/// Rows one after the other, in their ranges, then nothing for those that there might be.
std::optional<std::vector<double>> read_table(const TableReader& table, const TomlMember& member,
                                              const dttmm_parameter& parameter) {
    const std::vector<TableColumn> columns = columns_of(parameter);
    const auto rows = read_rows(table, member, columns);
    if (!rows) return std::nullopt;
    const auto fail = [&](const std::string& fault) {
        table.error(member.value.place, fmt::format("{}: {}", member.key, fault));
        return std::nullopt;
    };
    const std::size_t most = parameter.count / columns.size();
    if (rows->size() > most) return fail(fmt::format("{} rows: at most {} are taken", rows->size(), most));
    if (rows->size() < 2) return fail("one row: two or more are needed, between which it is interpolated");
    std::vector<double> numbers;
    for (const std::vector<double>& row : *rows) {
        if (!numbers.empty() && row[0] <= numbers[numbers.size() - columns.size()])
            return fail(fmt::format("the {} must increase from row to row", columns[0].plural));
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (const std::string bound = broken_bound(row[c], bounds_of(parameter), columns[c].unit); !bound.empty())
                return fail(
                    fmt::format("{} must be {}, got {} {}", columns[c].word, bound, number_text(row[c]), columns[c].unit));
        numbers.insert(numbers.end(), row.begin(), row.end());
    }
    numbers.resize(parameter.count, std::numeric_limits<double>::quiet_NaN());
    return numbers;
}

std::optional<std::vector<double>> read_value(const TableReader& table, const TomlMember& member,
                                              const dttmm_parameter& parameter) {
    if (parameter.flags & DTTMM_PARAMETER_TABLE) return read_table(table, member, parameter);
    const bool is_word = parameter.word_count > 0 && member.value.is_text() && !is_numeric(member.value.string);
    if (is_word || parameter.flags & DTTMM_PARAMETER_WORDS_ONLY) {
        const auto word = read_word(table, member, parameter);
        return word ? std::optional(std::vector{*word}) : std::nullopt;
    }
    auto numbers = read_numbers(table.context(), member.value, table.what(member.key), parameter.unit, parameter.count,
                                parameter.flags & DTTMM_PARAMETER_SPREADS, {parameter.minimum, parameter.maximum});
    if (numbers && parameter.flags & DTTMM_PARAMETER_INTEGER && !check_whole(table, member, *numbers)) return std::nullopt;
    return numbers;
}

/// The element's table and those within it.
class ParameterTables {
public:
    ParameterTables(const TableReader& own, const dttmm_element_type& type) : own_(own) {
        std::map<std::string_view, std::vector<std::string>> keys;
        for (const dttmm_parameter& parameter : parameters_of(type)) {
            const Path path(parameter.name);
            if (!path.table.empty()) keys[path.table].emplace_back(path.key);
        }
        for (const auto& [name, inner] : keys)
            if (const TomlMember* member = own.find(name))
                inner_.try_emplace(name, own.context(), member->value, own.what(name), inner);
    }

    std::optional<std::vector<double>> read(const dttmm_parameter& parameter) const {
        const Path path(parameter.name);
        const auto inner = inner_.find(path.table);
        const TableReader* table = path.table.empty() ? &own_ : inner == inner_.end() ? nullptr : &inner->second;
        if (table && !table->is_valid()) return std::nullopt;
        if (table)
            if (const TomlMember* member = table->find(path.key)) return read_value(*table, *member, parameter);
        if (!(parameter.flags & DTTMM_PARAMETER_REQUIRED)) return std::vector(parameter.count, parameter.default_value);
        if (table)
            table->require(path.key);
        else
            own_.error(own_.place(), fmt::format("missing key \"{}\"", parameter.name));
        return std::nullopt;
    }

private:
    const TableReader& own_;
    std::map<std::string_view, TableReader> inner_;
};

}  // namespace

std::vector<std::string> parameter_keys(const dttmm_element_type& type) {
    std::vector<std::string> keys;
    for (const dttmm_parameter& parameter : parameters_of(type)) {
        const Path path(parameter.name);
        const std::string_view key = path.table.empty() ? path.key : path.table;
        if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.emplace_back(key);
    }
    return keys;
}

std::optional<std::vector<double>> read_values(const TableReader& table, const dttmm_element_type& type) {
    const ParameterTables tables(table, type);
    std::vector<double> values;
    bool is_complete = true;
    for (const dttmm_parameter& parameter : parameters_of(type)) {
        const auto numbers = tables.read(parameter);
        if (numbers) values.insert(values.end(), numbers->begin(), numbers->end());
        is_complete &= numbers.has_value();
    }
    return is_complete ? std::optional(values) : std::nullopt;
}

}  // namespace dttmm::host
