// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/diagnostics.h"
#include "model/index.h"
#include "model/keys.h"
#include "model/parameters.h"
#include "model/toml_document.h"

namespace dttmm::host {

/// The files that a model is made of.
struct InputFiles {
    std::vector<std::filesystem::path> folders = {{}};  ///< by Place::file: where the files that it names are looked for
    std::vector<std::filesystem::path> read = {};       ///< beside the model file, in turn
};

/// What every part of the reader works with.
struct ReadContext {
    const Parameters& parameters;
    Diagnostics& diagnostics;
    InputFiles& inputs;
    double instant = 0;  ///< the first at which loads and motions count [s]

    /// Where a file that is named at this place is looked for.
    const std::filesystem::path& folder_of(Place place) const { return inputs.folders.at(as_size(place.file)); }
};

/// The bound that `number` breaks, "more than 0 N/m"; empty if it breaks none.
std::string broken_bound(double number, const Bounds& bounds, std::string_view unit);

/// The functions below report a fault and return nothing. `what` names the value in messages: `element "bolt3": stiffness`.

/// A number (SI), a quantity or an expression over the parameters, in the SI unit `unit`.
std::optional<double> read_number(const ReadContext& context, const TomlValue& value, const std::string& what,
                                  std::string_view unit, const Bounds& bounds = {});

/// A list of `count` such numbers; one number alone stands for all of them if it `spreads`.
std::optional<std::vector<double>> read_numbers(const ReadContext& context, const TomlValue& value, const std::string& what,
                                                std::string_view unit, std::size_t count, bool spreads = false,
                                                const Bounds& bounds = {});

std::optional<Eigen::Vector3d> read_vector(const ReadContext& context, const TomlValue& value, const std::string& what,
                                           std::string_view unit, const Bounds& bounds = {});

/// A table with the keys it may have; reports every other key when it is made, with the nearest of them.
class TableReader {
public:
    /// `label` names the table in messages, e.g. `body "plate"`; empty for the file itself. `note` follows it where a key
    /// is unknown. A `value` that is no table is reported and read as an empty one. unit: what "" in the table of keys
    /// stands for.
    TableReader(const ReadContext& context, const TomlValue& value, std::string label, const KeyTable& table,
                std::string note = {}, std::string_view unit = {});
    /// Of keys that a plugin declares, besides some of `table`.
    TableReader(const ReadContext& context, const TomlValue& value, std::string label, std::vector<std::string> keys,
                const KeyTable* table = nullptr, std::string note = {});

    bool is_valid() const { return value_.is_table(); }
    Place place() const { return value_.place; }
    const ReadContext& context() const { return context_; }

    /// What "" in the table of keys stands for.
    std::string_view unit() const { return unit_; }

    const TomlMember* find(std::string_view key) const { return value_.find(key); }

    /// Reports the key if it is missing, unless an unknown key that was reported is likely to mean it.
    const TomlMember* require(std::string_view key) const;

    /// Reports all but the first of the given keys that are there, and the lack of any; returns the first.
    const TomlMember* require_one(const std::vector<std::string>& keys) const;

    /// In the unit and within the bounds that the table of keys gives. A missing key is reported, or gives the fallback.
    std::optional<double> number(std::string_view key) const;
    std::optional<double> number(std::string_view key, double fallback) const;
    std::optional<Eigen::Vector3d> vector(std::string_view key) const;
    std::optional<Eigen::Vector3d> vector(std::string_view key, const Eigen::Vector3d& fallback) const;
    /// As many numbers as the table of keys says.
    std::optional<std::vector<double>> numbers(std::string_view key) const;
    std::optional<std::string> text(std::string_view key) const;
    std::optional<std::string> text(std::string_view key, const std::string& fallback) const;

    /// One of the words of the table of keys; its index. A missing key gives the fallback.
    std::optional<int> choice(std::string_view key, int fallback) const;

    /// Of the table of keys. Throws Error(internal_error) for a key it has not.
    const Key& key(std::string_view name) const;
    std::string_view unit_of(const Key& key) const { return *key.unit ? std::string_view(key.unit) : unit_; }

    /// `label: key`, as messages name the value.
    std::string what(std::string_view key) const;

    void error(Place place, const std::string& text) const;
    void warning(Place place, const std::string& code, const std::string& text) const;

private:
    std::string labelled(const std::string& text) const;
    void check_keys(const std::vector<std::string>& keys, const std::string& note);

    const ReadContext& context_;
    const TomlValue& value_;
    std::string label_;
    std::vector<std::string> meant_;  ///< keys that unknown ones are likely to mean
    const KeyTable* table_;
    std::string_view unit_;
};

}  // namespace dttmm::host
