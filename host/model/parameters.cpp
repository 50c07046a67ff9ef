// SPDX-License-Identifier: BSD-3-Clause
#include "model/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/names.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

std::optional<std::string> find_missing_unit(const Parameter& in_file, const std::string& text) {
    if (in_file.unit.empty() || in_file.unit == "1" || text.starts_with("=")) return std::nullopt;
    const Quantity quantity = parse_quantity(text);
    if (quantity.unit != "1") {
        if (!measures(in_file.unit, quantity.unit)) parse_quantity(text, in_file.unit);  // says what is expected
        return std::nullopt;
    }
    if (quantity.value == 0) return std::nullopt;
    if (!in_file.text.starts_with("=") && parse_quantity(in_file.text).unit == "1")
        return std::nullopt;  // a plain coordinate
    return in_file.text.starts_with("=") ? in_file.unit : unit_text(in_file.text);
}

Parameters::Parameters(const TomlValue* table, const TomlValue* stations, const Overrides& overrides,
                       Diagnostics& diagnostics)
    : diagnostics_(diagnostics) {
    if (table && !table->is_table()) {
        diagnostics.error(table->place, "parameters must be a table: [parameters]");
        table = nullptr;
    }
    if (table)
        for (const TomlMember& member : table->members) read_entry(member);
    if (stations && !stations->is_table())
        diagnostics.error(stations->place, "stations must be a table of name = [x, y, z]: [stations]");
    else if (stations)
        for (const TomlMember& member : stations->members) read_station(member);
    for (const auto& [name, text] : overrides) override_entry(name, text);
    const Constants known = stand_ins();
    for (Entry& entry : entries_) find_needs(entry, known);
    resolve_all();
    report_circles();
}

void Parameters::read_entry(const TomlMember& member) {
    const std::string name = normalise_name(member.key);
    if (const auto fault = find_name_fault(name))
        return diagnostics_.error(member.place, fmt::format("parameter {} {}", quote(name), *fault));
    if (name == "t" || name == "pi")
        return diagnostics_.error(member.place,
                                  fmt::format("parameter \"{}\" has the name of {} in expressions; choose another", name,
                                              name == "t" ? "the time" : "a constant"));
    if (const Entry* other = find(name))
        return diagnostics_.error(
            member.place, fmt::format("parameter {} exists already, {}", quote(name), diagnostics_.line_text(other->place)));
    if (name.find('-') != name.npos)
        diagnostics_.warning(
            member.place, "unusable-parameter",
            fmt::format("parameter {} cannot be used: '-' is minus in an expression; use '_'", quote(name)));
    Entry entry;
    entry.parameter.name = name;
    entry.place = member.place;
    read_value(entry, member.value);
    index_[name] = entries_.size();
    entries_.push_back(std::move(entry));
}

void Parameters::read_station(const TomlMember& member) {
    const std::string name = normalise_name(member.key);
    const auto refuse = [&](Place place, const std::string& text) {
        diagnostics_.error(place, fmt::format("station {} {}", quote(name), text));
    };
    if (const auto fault = find_name_fault(name)) return refuse(member.place, *fault);
    if (bare_name(name) != name || name == "t" || name == "pi")
        return refuse(
            member.place,
            "cannot be used in expressions: it must begin with a letter, hold letters, digits and '_' only, and be "
            "neither t nor pi");
    if (const Entry* other = find(name))
        return refuse(member.place, fmt::format("has the name of a parameter, {}", diagnostics_.line_text(other->place)));
    if (const Entry* other = find(name + ".x"))
        return refuse(member.place, "exists already, " + diagnostics_.line_text(other->place));
    const TomlValue& value = member.value;
    if (!value.is_array() || value.items.size() != 3)
        return refuse(value.place,
                      fmt::format("wants three lengths, [x, y, z], got {}{}",
                                  value.is_array() ? std::to_string(value.items.size()) : kind_text(value.kind),
                                  value.is_text() ? "; another station is named by its coordinates: [\"=front.x\", "
                                                    "\"=front.y\", \"=front.z\"]"
                                                  : ""));
    for (std::size_t d = 0; d < 3; ++d) {
        Entry entry;
        entry.parameter.name = name + "." + "xyz"[d];
        entry.place = value.items[d].place;
        entry.is_coordinate = true;
        entry.parameter.unit = "m";
        read_value(entry, value.items[d]);
        index_[entry.parameter.name] = entries_.size();
        entries_.push_back(std::move(entry));
    }
}

void Parameters::override_entry(const std::string& given_name, const std::string& text) {
    const std::string name = normalise_name(given_name);
    const auto found = index_.find(name);
    if (found == index_.end())
        throw Error(ExitCode::usage,
                    fmt::format("--set {}: the model has no such parameter{}", name, suggestion(name, names())));
    if (text.empty()) throw Error(ExitCode::usage, fmt::format("--set {0}: no value; write --set {0}=VALUE", name));
    Entry& entry = entries_[found->second];
    entry.place = diagnostics_.option_place("--set " + name);
    const Parameter in_file = named_by(entry).parameter;
    const bool was_faulty = named_by(entry).is_faulty;
    entry.expression.clear();
    entry.is_faulty = false;
    read_text(entry, text);
    if (entry.is_faulty || was_faulty) return;
    std::optional<std::string> unit;
    try {
        unit = find_missing_unit(in_file, text);
    } catch (const Error& error) {
        return fail(entry, error.what());
    }
    if (unit)
        throw Error(
            ExitCode::usage,
            fmt::format("--set {0}={1}: of which unit? the file gives {2}; write --set {0}=\"{1} {2}\"", name, text, *unit));
}

void Parameters::read_value(Entry& entry, const TomlValue& value) {
    if (value.is_text()) return read_text(entry, value.string);
    entry.parameter.text = number_text(value.number);
    entry.parameter.unit = entry.is_coordinate ? "m" : "1";
    entry.parameter.value = value.number;
    if (!value.is_number())
        return fail(entry, fmt::format("must be a number, a quantity or an expression, not {}", kind_text(value.kind)));
    if (!std::isfinite(value.number)) fail(entry, "must be finite, got " + number_text(value.number));
}

void Parameters::read_text(Entry& entry, const std::string& text) {
    entry.parameter.text = text;
    if (text.starts_with("=")) {
        entry.expression = text.substr(1);
        if (entry.expression.empty()) fail(entry, "nothing follows the \"=\"");
        return;
    }
    try {
        const Quantity quantity = parse_quantity(text);
        entry.parameter.value = quantity.value;
        entry.parameter.unit = quantity.unit;
        if (!entry.is_coordinate) return;
        if (quantity.unit != "1" && !measures(quantity.unit, "m"))
            fail(entry, fmt::format("expected a length, got {}", quote(text)));
        entry.parameter.unit = "m";
    } catch (const Error& error) {
        if (error.code() != ExitCode::model_invalid) throw;
        fail(entry, error.what());
    }
}

Constants Parameters::stand_ins() const {
    Constants result;
    for (const std::string& name : names()) result[name] = 1;
    return result;
}

void Parameters::find_needs(Entry& entry, const Constants& known) {
    if (entry.expression.empty() || entry.is_faulty) return;
    try {
        Expression(entry.expression, known);  // names and syntax are checked before any value is known
    } catch (const Error& error) {
        return fail(entry, error.what());
    }
    for (const std::string& name : expression_names(entry.expression))
        if (const auto found = index_.find(name); found != index_.end()) entry.needs.push_back(found->second);
}

void Parameters::resolve_all() {
    // Kahn (1962): whoever needs nothing unresolved is next.
    std::vector<std::size_t> missing(entries_.size());
    std::vector<std::vector<std::size_t>> needed_by(entries_.size());
    std::vector<std::size_t> ready;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        missing[i] = entries_[i].needs.size();
        for (const std::size_t need : entries_[i].needs) needed_by[need].push_back(i);
        if (missing[i] == 0) ready.push_back(i);
    }
    while (!ready.empty()) {
        const std::size_t next = ready.back();
        ready.pop_back();
        resolve(entries_[next]);
        for (const std::size_t dependent : needed_by[next])
            if (--missing[dependent] == 0) ready.push_back(dependent);
    }
}

void Parameters::resolve(Entry& entry) {
    entry.is_resolved = true;
    const auto is_faulty = [&](std::size_t need) { return entries_[need].is_faulty; };
    if (std::any_of(entry.needs.begin(), entry.needs.end(), is_faulty)) entry.is_faulty = true;
    if (entry.is_faulty) return;
    if (!entry.expression.empty()) {
        try {
            entry.parameter.value = evaluate_expression(entry.expression, constants_);
        } catch (const Error& error) {
            return fail(entry, error.what());
        }
        const Entry* same = find(bare_name(entry.expression));
        entry.parameter.unit = same ? same->parameter.unit : std::string();
        if (entry.is_coordinate) {
            const std::string& unit = entry.parameter.unit;
            if (!unit.empty() && unit != "1" && !measures(unit, "m"))
                return fail(entry, fmt::format("expected a length, got {}, which is {}", quote("=" + entry.expression),
                                               quote(same->parameter.text)));
            entry.parameter.unit = "m";
        }
    }
    constants_[entry.parameter.name] = entry.parameter.value;
}

void Parameters::report_circles() {
    std::vector<bool> is_seen(entries_.size());
    for (std::size_t start = 0; start < entries_.size(); ++start) {
        if (entries_[start].is_resolved || is_seen[start]) continue;
        // Whoever is left needs someone who is left: following these ends in a circle.
        std::vector<std::size_t> way;
        std::size_t at = start;
        while (!is_seen[at]) {
            is_seen[at] = true;
            way.push_back(at);
            const auto& needs = entries_[at].needs;
            at = *std::find_if(needs.begin(), needs.end(), [&](std::size_t need) { return !entries_[need].is_resolved; });
        }
        const auto circle = std::find(way.begin(), way.end(), at);
        if (circle == way.end()) continue;  // leads into a circle told before
        std::vector<std::string> names;
        for (auto i = circle; i != way.end(); ++i) names.push_back(entries_[*i].parameter.name);
        names.push_back(entries_[at].parameter.name);
        fail(entries_[at], fmt::format("depends on itself: {}", fmt::join(names, " -> ")));
    }
    for (Entry& entry : entries_) entry.is_faulty |= !entry.is_resolved;
}

void Parameters::fail(Entry& entry, const std::string& text) {
    entry.is_faulty = true;
    diagnostics_.error(entry.place, fmt::format("{} {}: {}", entry.is_coordinate ? "station" : "parameter",
                                                quote(entry.parameter.name), text));
}

std::optional<double> Parameters::evaluate(std::string_view expression, std::string_view wanted) const {
    if (rests_on_fault(expression)) return std::nullopt;
    const double value = evaluate_expression(expression, constants_);
    for (const std::string& name : expression_names(expression)) used_.insert(name);
    check_unit(expression, wanted);
    return value;
}

void Parameters::check_unit(std::string_view expression, std::string_view wanted) const {
    const Entry* same = find(bare_name(expression));
    const bool has_unit = same && !same->parameter.unit.empty() && same->parameter.unit != "1";
    if (has_unit && !measures(same->parameter.unit, wanted))
        throw Error(ExitCode::model_invalid,
                    fmt::format("expected a value in {}, got {}, which is {} ({}); accepted here: {}", wanted,
                                quote("=" + std::string(expression)), quote(same->parameter.text),
                                diagnostics_.line_text(same->place), listed(accepted_units(wanted))));
}

bool Parameters::rests_on(std::string_view expression, const std::string& name) const {
    std::vector<bool> seen(entries_.size());
    std::vector<std::string> waiting = expression_names(expression);
    while (!waiting.empty()) {
        const std::string next = std::move(waiting.back());
        waiting.pop_back();
        if (next == name) return true;
        const auto found = index_.find(next);
        if (found == index_.end() || seen[found->second]) continue;
        seen[found->second] = true;
        const std::vector<std::string> more = expression_names(entries_[found->second].expression);
        waiting.insert(waiting.end(), more.begin(), more.end());
    }
    return false;
}

std::string Parameters::written_out(std::string_view expression, const std::string& name, int depth) const {
    if (depth > kDeepestBrackets)
        throw Error(ExitCode::model_invalid,
                    fmt::format("it rests on {} through more than {} parameters, one after the other", quote(name),
                                kDeepestBrackets));
    std::string text = replace_names(expression, [&](const std::string& other) {
        const Entry* entry = other == name ? nullptr : find(other);
        const bool rests = entry && !entry->is_faulty && rests_on(entry->expression, name);
        return rests ? "(" + written_out(entry->expression, name, depth + 1) + ")" : other;
    });
    check_expression_size(text);
    return text;
}

bool Parameters::has_used(const std::string& name) const {
    return std::ranges::any_of(used_, [&](const std::string& used) { return rests_on(used, name); });
}

bool Parameters::rests_on_fault(std::string_view expression) const {
    const auto names = expression_names(expression);
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
        const Entry* entry = find(name);
        return entry && entry->is_faulty;
    });
}

bool Parameters::is_station(std::string_view expression) const {
    const std::string name = bare_name(expression);
    return !name.empty() && find(name + ".x");
}

std::vector<std::string> Parameters::stations() const {
    std::vector<std::string> stations;
    for (const Entry& entry : entries_)
        if (entry.is_coordinate && entry.parameter.name.ends_with(".x"))
            stations.push_back(entry.parameter.name.substr(0, entry.parameter.name.size() - 2));
    return stations;
}

std::vector<Parameter> Parameters::all() const {
    std::vector<Parameter> result;
    for (const Entry& entry : entries_) result.push_back(entry.parameter);
    return result;
}

const Parameters::Entry& Parameters::named_by(const Entry& entry) const {
    const Entry* at = &entry;
    for (std::size_t hops = 0; hops < entries_.size(); ++hops) {  // names may go in a circle
        const Entry* next = at->expression.empty() ? nullptr : find(bare_name(at->expression));
        if (!next) break;
        at = next;
    }
    return *at;
}

const Parameters::Entry* Parameters::find(std::string_view name) const {
    const auto found = index_.find(name);
    return found == index_.end() ? nullptr : &entries_[found->second];
}

std::vector<std::string> Parameters::names() const {
    std::vector<std::string> result;
    for (const auto& [name, index] : index_) result.push_back(name);
    return result;
}

}  // namespace dttmm::host
