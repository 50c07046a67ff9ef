// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "model/table_reader.h"

namespace dttmm::host {

/// The names of one kind of thing in a model, each once, with the place where it was given.
class NameRegistry {
public:
    /// `kind`: "body", "element", ...
    explicit NameRegistry(std::string kind) : kind_(std::move(kind)) {}

    /// Keeps a name: normalised, checked and not given before. Faults are reported; the normalised name is returned anyway.
    std::string add(const ReadContext& context, Place place, const std::string& name);

    /// The `name` of a table, kept. Empty if there is none to keep, which is reported.
    std::string add_from(const TableReader& table);

    const std::string& kind() const { return kind_; }

    /// Null if the name was not given.
    const Place* find(const std::string& name) const;

private:
    std::string kind_;
    std::map<std::string, Place> places_;
};

/// What speaks against a name: it is reserved, or a thing of another kind has it, so that results could not be told apart.
std::vector<std::string> find_name_conflicts(const Diagnostics& diagnostics, const std::string& name,
                                             const std::vector<const NameRegistry*>& others);

/// Reports the same of the `name` of a table.
void check_name(const TableReader& table, const std::string& name, const std::vector<const NameRegistry*>& others = {});

/// How messages call entry `index` of a [[kind]]: by its name if it has one, else by its number, counted from 1.
std::string entry_label(const char* kind, const TomlValue& entry, std::size_t index);

/// The end of a message about an unknown key of that entry: ` in [[element]] number 3`.
std::string entry_note(const char* kind, std::size_t index);

/// The entries of [[kind]]; none if the key is missing. Anything but a list of tables is reported.
const std::vector<TomlValue>& read_entries(const TableReader& file, const char* kind);

/// The required key `name` of what is no channel: it may hold anything but braces. Empty with a fault, which is reported.
std::string read_free_name(const TableReader& table, const char* kind);

}  // namespace dttmm::host
