// SPDX-License-Identifier: BSD-3-Clause
#include "model/element_defaults.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/wording.h"

namespace dttmm::host {
namespace {

/// A copy whose faults count as those of one text.
TomlValue copied(const TomlValue& value, int copy) {
    TomlValue result = value;
    result.place.copy = copy;
    for (TomlValue& item : result.items) item = copied(item, copy);
    for (TomlMember& member : result.members) {
        member.place.copy = copy;
        member.value = copied(member.value, copy);
    }
    return result;
}

bool has_type(const TomlValue& entry, const std::string& type) {
    const TomlMember* given = entry.find("type");
    return given && given->value.is_text() && given->value.string == type;
}

bool is_table_name(std::string_view name) { return name == "body" || name == "joint" || name == "load"; }

/// No two have the same name, and the type of an element is that of its defaults.
bool may_be_default(const TomlMember& defaults, const TomlMember& key) {
    return key.key != "name" && (key.key != "type" || is_table_name(defaults.key));
}

/// The entries that a table of defaults counts for, by its name; those of an element type stand under [[element]].
std::vector<TomlValue*> entries_of(TomlValue& document, const std::string& name) {
    const bool is_table = is_table_name(name);
    const auto found = std::ranges::find(document.members, is_table ? name : "element", &TomlMember::key);
    std::vector<TomlValue*> entries;
    if (found == document.members.end()) return entries;
    for (TomlValue& entry : found->value.items)
        if (entry.is_table() && (is_table || has_type(entry, name))) entries.push_back(&entry);
    return entries;
}

void apply(TomlValue& document, const TomlMember& defaults, Diagnostics& diagnostics) {
    const std::vector<TomlValue*> entries = entries_of(document, defaults.key);
    if (entries.empty())
        diagnostics.warning(defaults.place, "unused-defaults",
                            fmt::format("defaults of {}: the model has none of these", quote(defaults.key)));
    int copy = 0;
    for (TomlValue* entry : entries) {
        ++copy;
        for (const TomlMember& member : defaults.value.members) {
            if (entry->find(member.key) || !may_be_default(defaults, member)) continue;
            TomlMember own{member.key, member.place, copied(member.value, copy)};
            own.place.copy = copy;
            entry->members.push_back(std::move(own));
        }
    }
}

}  // namespace

void apply_defaults(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue) {
    const TomlMember* defaults = document.find("defaults");
    if (!defaults) return;
    const std::vector<std::string> tables = names_of(key_table("defaults"));
    std::vector<std::string> names = tables;
    for (const dttmm_element_type* type : catalogue.types) names.emplace_back(type->name);
    const TableReader table(context, defaults->value, "defaults", names);
    if (!table.is_valid()) return;
    for (const TomlMember& member : std::vector(defaults->value.members)) {  // the document grows below
        if (std::ranges::find(names, member.key) == names.end()) continue;
        if (!member.value.is_table())
            table.error(member.place, fmt::format("{0} must be a table; write [defaults.{0}]", member.key));
        for (const TomlMember& key : member.value.members)
            if (!may_be_default(member, key))
                table.error(key.place, fmt::format("{} belongs to each element alone; leave it out of [defaults.{}]",
                                                   key.key, member.key));
        if (std::ranges::find(tables, member.key) != tables.end()) apply(document, member, context.diagnostics);
    }
}

void apply_element_defaults(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue) {
    const auto found = std::ranges::find(document.members, "defaults", &TomlMember::key);
    if (found == document.members.end()) return;
    const TomlMember defaults = std::move(*found);
    document.members.erase(found);
    for (const TomlMember& member : defaults.value.members)
        if (catalogue.find(member.key) >= 0) apply(document, member, context.diagnostics);
}

}  // namespace dttmm::host
