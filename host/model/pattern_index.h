// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/expression.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// The index of a pattern and its value in one copy.
struct PatternIndex {
    std::string name;
    std::optional<double> number;  ///< none: it stands for `text`
    std::string text;              ///< as braces write it, "3" or "front"
};

using PatternIndices = std::vector<PatternIndex>;

PatternIndex numbered_index(const std::string& name, double number);

/// Why `name` is no name for an index, ready to follow `index "x" `; nothing if it is one. Refused are names that mean
/// something else in an expression: `constants`, those of `outer` patterns, functions, pi and t.
std::optional<std::string> find_index_fault(const std::string& name, const PatternIndices& outer,
                                            const Constants& constants);

/// A text of a pattern in one copy: "{i+1}" is replaced by its value, and in an expression ("=...") the name of an index by
/// its number. Braces may hold an expression over indices and `constants`. In an expression their value ends a name, or is
/// an operand. Throws Error(model_invalid) for a brace that is not closed or not opened, for an unknown name, for an index
/// of texts in an expression, and for braces that would make another number or no name there.
std::string with_indices(std::string_view text, const PatternIndices& indices, const Constants& constants);

/// The functions below report a fault and return nothing. `outer`: indices of the patterns around this one.

/// The name in the key `index`.
std::optional<std::string> read_index_name(const TableReader& table, const PatternIndices& outer);

/// The key `count`, a whole number.
std::optional<int> read_count(const TableReader& table);

/// The index with each of its values in turn, of `count` from 1 or as `values` has them.
std::optional<PatternIndices> read_indices(const TableReader& table, const PatternIndices& outer);

}  // namespace dttmm::host
