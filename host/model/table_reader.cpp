// SPDX-License-Identifier: BSD-3-Clause
#include "model/table_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

std::string with_unit(double value, std::string_view unit) {
    return unit == "1" ? number_text(value) : fmt::format("{} {}", number_text(value), unit);
}

/// The value as the user wrote it, with the number it stands for where that does not show.
std::string written(const TomlValue& value, double number, std::string_view unit) {
    if (!value.is_text()) return number_text(number);
    if (value.string.starts_with("=")) return fmt::format("{} = {}", quote(value.string), with_unit(number, unit));
    const std::string text = quote(value.string);
    return text.substr(1, text.size() - 2);
}

/// The SI value of a number, quantity or expression; throws Error with the fault.
std::optional<double> evaluate(const ReadContext& context, const TomlValue& value, std::string_view unit) {
    if (value.is_number()) return value.number;
    if (!value.is_text())
        throw Error(ExitCode::model_invalid,
                    fmt::format("expected a number{}, got {}", unit == "1" ? std::string() : fmt::format(" in {}", unit),
                                kind_text(value.kind)));
    if (!value.string.starts_with("=")) return parse_quantity(value.string, unit);
    return context.parameters.evaluate(std::string_view(value.string).substr(1), unit);
}

/// "=front" for the three coordinates of a station.
TomlValue coordinates_of(const TomlValue& station) {
    TomlValue list;
    list.kind = TomlValue::Kind::array;
    list.place = station.place;
    for (const char* coordinate : {".x", ".y", ".z"}) {
        TomlValue& item = list.items.emplace_back(station);
        item.string = "=" + bare_name(std::string_view(station.string).substr(1)) + coordinate;
    }
    return list;
}

/// Where an expression stands for three lengths.
std::string cure_for(const ReadContext& context, std::string_view expression) {
    for (const std::string& name : expression_names(expression))
        if (context.parameters.is_station(name))
            return fmt::format(
                "; a station stands alone, \"={0}\", or by its coordinates, [\"={0}.x\", \"={0}.y\", "
                "\"={0}.z\"]",
                name);
    const std::vector<std::string> stations = context.parameters.stations();
    const std::string name = bare_name(expression);
    return name.empty() || stations.empty() ? "" : "; no station has this name" + suggestion(name, stations);
}

}  // namespace

std::string broken_bound(double number, const Bounds& bounds, std::string_view unit) {
    if (number > bounds.maximum) return "≤ " + with_unit(bounds.maximum, unit);
    if (number < bounds.minimum && bounds.minimum == std::numeric_limits<double>::min()) return "> " + with_unit(0, unit);
    if (number < bounds.minimum || (bounds.excludes_minimum && number == bounds.minimum))
        return (bounds.excludes_minimum ? "> " : "≥ ") + with_unit(bounds.minimum, unit);
    return {};
}

std::optional<double> read_number(const ReadContext& context, const TomlValue& value, const std::string& what,
                                  std::string_view unit, const Bounds& bounds) {
    const auto fail = [&](const std::string& text) {
        context.diagnostics.error(value.place, what + text);
        return std::nullopt;
    };
    try {
        const std::optional<double> number = evaluate(context, value, unit);
        if (!number) return std::nullopt;
        if (!std::isfinite(*number)) return fail(fmt::format(" must be finite, got {}", number_text(*number)));
        if (const std::string bound = broken_bound(*number, bounds, unit); !bound.empty())
            return fail(fmt::format(" must be {}, got {}", bound, written(value, *number, unit)));
        return *number + 0.0;  // no negative zero
    } catch (const Error& error) {
        if (error.code() != ExitCode::model_invalid) throw;
        return fail(fmt::format(": {}", error.what()));
    }
}

std::optional<std::vector<double>> read_numbers(const ReadContext& context, const TomlValue& value, const std::string& what,
                                                std::string_view unit, std::size_t count, bool spreads,
                                                const Bounds& bounds) {
    const bool is_expression = value.is_text() && value.string.starts_with("=");
    const std::string_view expression = is_expression ? std::string_view(value.string).substr(1) : std::string_view();
    if (is_expression && count == 3 && context.parameters.is_station(expression))
        return read_numbers(context, coordinates_of(value), what, unit, count, spreads, bounds);
    if (!value.is_array() && (count == 1 || spreads)) {
        const auto number = read_number(context, value, what, unit, bounds);
        return number ? std::optional(std::vector<double>(count, *number)) : std::nullopt;
    }
    if (!value.is_array() || value.items.size() != count) {
        const std::string got = value.is_array() ? std::to_string(value.items.size()) : std::string(kind_text(value.kind));
        const bool has_more = value.is_array() && value.items.size() > count;
        const bool is_place = is_expression && count == 3 && unit == "m";
        const std::string cure = has_more   ? " (a number has a decimal point, 0.8)"
                                 : is_place ? cure_for(context, expression)
                                            : "";
        context.diagnostics.error(
            value.place, fmt::format("{} wants {} number{}, got {}{}", what, count, count == 1 ? "" : "s", got, cure));
        return std::nullopt;
    }
    std::vector<double> numbers;
    for (const TomlValue& item : value.items)
        if (const auto number = read_number(context, item, what, unit, bounds)) numbers.push_back(*number);
    return numbers.size() == count ? std::optional(numbers) : std::nullopt;
}

std::optional<Eigen::Vector3d> read_vector(const ReadContext& context, const TomlValue& value, const std::string& what,
                                           std::string_view unit, const Bounds& bounds) {
    const auto numbers = read_numbers(context, value, what, unit, 3, false, bounds);
    return numbers ? std::optional(Eigen::Vector3d(numbers->data())) : std::nullopt;
}

TableReader::TableReader(const ReadContext& context, const TomlValue& value, std::string label, const KeyTable& table,
                         std::string note, std::string_view unit)
    : context_(context), value_(value), label_(std::move(label)), table_(&table), unit_(unit) {
    check_keys(names_of(table), note);
}

TableReader::TableReader(const ReadContext& context, const TomlValue& value, std::string label,
                         std::vector<std::string> keys, const KeyTable* table, std::string note)
    : context_(context), value_(value), label_(std::move(label)), table_(table) {
    check_keys(keys, note);
}

void TableReader::check_keys(const std::vector<std::string>& keys, const std::string& note) {
    if (!value_.is_table()) {
        error(value_.place,
              fmt::format("expected a table such as {{ {} = ... }}, got {}", keys.front(), kind_text(value_.kind)));
        return;
    }
    for (const TomlMember& member : value_.members) {
        if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
        error(member.place, fmt::format("unknown key {}{}{}", quote(member.key), note, suggestion(member.key, keys)));
        if (const auto nearest = find_nearest(member.key, keys)) meant_.push_back(*nearest);
    }
}

const Key& TableReader::key(std::string_view name) const {
    const Key* found = table_ ? find_key(*table_, name) : nullptr;
    if (!found) throw Error(ExitCode::internal_error, fmt::format("the tables of keys have no \"{}\"", name));
    return *found;
}

const TomlMember* TableReader::require(std::string_view key) const {
    const TomlMember* member = value_.find(key);
    const bool is_meant = std::find(meant_.begin(), meant_.end(), key) != meant_.end();
    if (!member && is_valid() && !is_meant) error(value_.place, fmt::format("missing key \"{}\"", key));
    return member;
}

const TomlMember* TableReader::require_one(const std::vector<std::string>& keys) const {
    const TomlMember* first = nullptr;
    for (const std::string& key : keys) {
        const TomlMember* member = value_.find(key);
        if (member && first)
            error(member->place,
                  fmt::format("\"{}\" and \"{}\" exclude each other; give one of: {}", first->key, key, listed(keys)));
        if (!first) first = member;
    }
    if (!first && is_valid()) error(value_.place, fmt::format("missing key: one of {}", listed(keys)));
    return first;
}

std::optional<double> TableReader::number(std::string_view name) const {
    const TomlMember* member = require(name);
    return member ? read_number(context_, member->value, what(name), unit_of(key(name)), key(name).bounds) : std::nullopt;
}

std::optional<double> TableReader::number(std::string_view name, double fallback) const {
    return find(name) ? number(name) : fallback;
}

std::optional<std::vector<double>> TableReader::numbers(std::string_view name) const {
    const TomlMember* member = require(name);
    if (!member) return std::nullopt;
    const auto count = as_size(key(name).count);
    return read_numbers(context_, member->value, what(name), unit_of(key(name)),
                        count > 0 ? count : std::max<std::size_t>(member->value.items.size(), 1), false, key(name).bounds);
}

std::optional<Eigen::Vector3d> TableReader::vector(std::string_view name) const {
    const auto three = numbers(name);
    return three ? std::optional(Eigen::Vector3d(three->data())) : std::nullopt;
}

std::optional<Eigen::Vector3d> TableReader::vector(std::string_view name, const Eigen::Vector3d& fallback) const {
    return find(name) ? vector(name) : fallback;
}

std::optional<std::string> TableReader::text(std::string_view key) const {
    const TomlMember* member = require(key);
    if (!member) return std::nullopt;
    if (member->value.is_text()) return member->value.string;
    error(member->value.place, fmt::format("{} must be a text, got {}", key, kind_text(member->value.kind)));
    return std::nullopt;
}

std::optional<std::string> TableReader::text(std::string_view key, const std::string& fallback) const {
    return find(key) ? text(key) : fallback;
}

std::optional<int> TableReader::choice(std::string_view name, int fallback) const {
    if (!find(name)) return fallback;
    const auto word = text(name);
    if (!word) return std::nullopt;
    const std::vector<std::string> words = words_of(key(name));
    const auto found = std::find(words.begin(), words.end(), *word);
    if (found != words.end()) return as_int(found - words.begin());
    error(find(name)->value.place, fmt::format("{} must be one of: {}; got {}", name, listed(words), quote(*word)));
    return std::nullopt;
}

std::string TableReader::what(std::string_view key) const { return labelled(std::string(key)); }

void TableReader::error(Place place, const std::string& text) const { context_.diagnostics.error(place, labelled(text)); }

void TableReader::warning(Place place, const std::string& code, const std::string& text) const {
    context_.diagnostics.warning(place, code, labelled(text));
}

std::string TableReader::labelled(const std::string& text) const { return label_.empty() ? text : label_ + ": " + text; }

}  // namespace dttmm::host
