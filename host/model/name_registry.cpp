// SPDX-License-Identifier: BSD-3-Clause
#include "model/name_registry.h"

#include <fmt/format.h>

#include "model/names.h"
#include "model/wording.h"

namespace dttmm::host {

std::string NameRegistry::add(const ReadContext& context, Place place, const std::string& name) {
    const std::string normal = normalise_name(name);
    if (const auto fault = find_name_fault(normal)) {
        context.diagnostics.error(place, fmt::format("{} name {} {}", kind_, quote(name), *fault));
        return normal;
    }
    const auto [other, is_new] = places_.emplace(normal, place);
    if (is_new) return normal;
    if (place.copy > 0 && place.is_same_text(other->second))
        context.diagnostics.error(
            place, fmt::format("{} name {} is the same in every copy; put the index in braces into it, as \"{}{{i}}\"",
                               kind_, quote(normal), normal));
    else
        context.diagnostics.error(
            place, fmt::format("{} name {} on {} is taken already, on {}", kind_, quote(normal),
                               context.diagnostics.line_text(place), context.diagnostics.line_text(other->second)));
    return normal;
}

std::string NameRegistry::add_from(const TableReader& table) {
    const auto name = table.text("name");
    return name ? add(table.context(), table.find("name")->value.place, *name) : std::string();
}

const Place* NameRegistry::find(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? nullptr : &found->second;
}

std::vector<std::string> find_name_conflicts(const Diagnostics& diagnostics, const std::string& name,
                                             const std::vector<const NameRegistry*>& others) {
    std::vector<std::string> conflicts;
    if (name == "time" || name == "energy" || name == "ground")
        conflicts.push_back(fmt::format("the name \"{}\" is reserved", name));
    for (const NameRegistry* names : others)
        if (const Place* other = names->find(name))
            conflicts.push_back(fmt::format("the {} on {} has the same name; results of both would have one name",
                                            names->kind(), diagnostics.line_text(*other)));
    return conflicts;
}

void check_name(const TableReader& table, const std::string& name, const std::vector<const NameRegistry*>& others) {
    const Place place = table.find("name") ? table.find("name")->value.place : table.place();
    for (const std::string& conflict : find_name_conflicts(table.context().diagnostics, name, others))
        table.error(place, conflict);
}

std::string entry_label(const char* kind, const TomlValue& entry, std::size_t index) {
    const TomlMember* name = entry.find("name");
    if (!name || !name->value.is_text()) return fmt::format("{} number {}", kind, index + 1);
    return fmt::format("{} {}", kind, quote(name->value.string));
}

std::string entry_note(const char* kind, std::size_t index) { return fmt::format(" in [[{}]] number {}", kind, index + 1); }

const std::vector<TomlValue>& read_entries(const TableReader& file, const char* kind) {
    static const std::vector<TomlValue> none;
    const TomlMember* member = file.find(kind);
    if (!member) return none;
    if (member->value.is_array()) return member->value.items;
    file.error(member->place, fmt::format("{0} must be a list of tables; write [[{0}]]", kind));
    return none;
}

std::string read_free_name(const TableReader& table, const char* kind) {
    const std::string name = normalise_name(table.text("name").value_or(""));
    if (const auto fault = find_brace(name))
        table.context().diagnostics.error(table.find("name")->value.place,
                                          fmt::format("{} name {} {}", kind, quote(name), *fault));
    return name;
}

}  // namespace dttmm::host
