// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// Where a number may lie [SI].
struct Bounds {
    double minimum = -std::numeric_limits<double>::infinity();
    double maximum = std::numeric_limits<double>::infinity();
    bool excludes_minimum = false;
};

inline constexpr Bounds kPositive = {0, std::numeric_limits<double>::infinity(), true};
inline constexpr Bounds kNotNegative = {0, std::numeric_limits<double>::infinity(), false};
/// Beyond it a small motion is lost in rounding [m].
inline constexpr double kFarthest = 1e6;
inline constexpr double kShortestStep = 1e-9, kLongestStep = 1;        // [s]
inline constexpr double kLeastTolerance = 1e-9, kMostTolerance = 0.5;  // beyond 50 % nothing is known of a history
inline constexpr int kMostModes = 10000;
inline constexpr int kMostCopies = 100000;  // of a pattern: as many beams take a minute to read, measured on two cores

/// A key of the model file: what its value may be, and what it says. The reader, `dttmm help`, `dttmm schema` and the
/// completion of words all come from the tables of keys below.
struct Key {
    enum class Kind : unsigned char {
        number,      ///< with a unit, or an expression
        numbers,     ///< a list of `count` numbers; of any length where that is 0
        point,       ///< such a list, or the name of a place
        word,        ///< one of `words`
        text,        ///< any
        texts,       ///< a list of texts
        directions,  ///< a list out of x y z rx ry rz
        place,       ///< a body, a marker, a node or "ground"
        places,      ///< a list of them
        signal,      ///< a number, an expression of t, or a table with a type
        signals,     ///< one, or a list of `count` of them
        table,       ///< with the keys of `table`
        tables,      ///< several such, each under [[name]]
        named,       ///< a table whose keys are names and whose values are such tables, or what else `kind` of them says
    };
    const char* name;
    Kind kind;
    const char* help;
    const char* fallback = "";  ///< what it is where the file leaves it out; kRequired: it must be there
    const char* unit = "1";     ///< of numbers; "": that of the signal
    int count = 3;              ///< of numbers
    Bounds bounds = {};
    const char* words = "";  ///< "implicit|explicit"
    const char* table = "";  ///< name of the table of keys; for a list of numbers another way to write it
};

inline constexpr const char* kRequired = "required";

struct KeyTable {
    const char* name;  ///< "simulation", as `dttmm help` has it
    const char* head;  ///< how the file opens it: "[simulation]"
    const char* help;
    const char* example;  ///< the model of `dttmm help` that shows it, host/help/<example>.toml
    std::span<const Key> keys;
};

/// All tables of the model file but those of elements' parameters, which plugins declare.
std::span<const KeyTable> key_tables();
/// By its name. Throws Error(internal_error) where there is none.
const KeyTable& key_table(std::string_view name);
/// Nothing where the table has no such key.
const Key* find_key(const KeyTable& table, std::string_view name);
std::vector<std::string> names_of(const KeyTable& table);
/// "implicit|explicit" as a list.
std::vector<std::string> words_of(const Key& key);

}  // namespace dttmm::host
