// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/diagnostics.h"

namespace dttmm::host {

struct TomlMember;

/// A TOML value and where it stands. Only the members that belong to `kind` are set.
struct TomlValue {
    enum class Kind { boolean, integer, real, text, date, array, table };

    Kind kind = Kind::table;
    Place place;
    double number = 0;                ///< integer and real, an infinity or NaN if the file says so; boolean: 1 or 0
    std::string string;               ///< text
    std::vector<TomlValue> items;     ///< array
    std::vector<TomlMember> members;  ///< table, in the order of the file

    bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
    bool is_text() const { return kind == Kind::text; }
    bool is_array() const { return kind == Kind::array; }
    bool is_table() const { return kind == Kind::table; }

    /// The member called `key`; null if there is none.
    const TomlMember* find(std::string_view key) const;
};

struct TomlMember {
    std::string key;
    Place place;  ///< of the key
    TomlValue value;
};

/// "a number", "a text", "a table", ...: what a message calls a value of this kind.
std::string_view kind_text(TomlValue::Kind kind);

/// The document as a table. A fault of syntax goes to `diagnostics` and gives nothing: the parser cannot look beyond it.
/// file: that of all places, as Diagnostics::add_file numbered it.
std::optional<TomlValue> parse_toml(std::string_view text, Diagnostics& diagnostics, int file = 0);

}  // namespace dttmm::host
