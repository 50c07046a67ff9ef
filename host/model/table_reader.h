// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/diagnostics.h"
#include "model/parameters.h"
#include "model/toml_document.h"

namespace dttmm {

/// What every part of the reader works with.
struct ReadContext {
    const Parameters& parameters;
    Diagnostics& diagnostics;
    std::filesystem::path folder;               ///< of the model file
    std::vector<std::filesystem::path>& files;  ///< that the model names and that were read, in turn
};

/// Where a number may lie [SI].
struct Bounds {
    double minimum = -std::numeric_limits<double>::infinity();
    double maximum = std::numeric_limits<double>::infinity();
    bool excludes_minimum = false;
};

inline constexpr Bounds kPositive = {0, std::numeric_limits<double>::infinity(), true};
inline constexpr Bounds kNotNegative = {0, std::numeric_limits<double>::infinity(), false};

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
    /// is unknown. A `value` that is no table is reported and read as an empty one.
    TableReader(const ReadContext& context, const TomlValue& value, std::string label, std::vector<std::string> keys,
                std::string note = {});

    bool is_valid() const { return value_.is_table(); }
    Place place() const { return value_.place; }
    const ReadContext& context() const { return context_; }

    const TomlMember* find(std::string_view key) const { return value_.find(key); }

    /// Reports the key if it is missing.
    const TomlMember* require(std::string_view key) const;

    /// Reports all but the first of the given keys that are there, and the lack of any; returns the first.
    const TomlMember* require_one(const std::vector<std::string>& keys) const;

    /// A missing key is reported, or gives the fallback.
    std::optional<double> number(std::string_view key, std::string_view unit, const Bounds& bounds = {}) const;
    std::optional<double> number(std::string_view key, std::string_view unit, const Bounds& bounds, double fallback) const;
    std::optional<Eigen::Vector3d> vector(std::string_view key, std::string_view unit, const Bounds& bounds = {}) const;
    std::optional<Eigen::Vector3d> vector(std::string_view key, std::string_view unit, const Eigen::Vector3d& fallback,
                                          const Bounds& bounds = {}) const;
    std::optional<std::string> text(std::string_view key) const;
    std::optional<std::string> text(std::string_view key, const std::string& fallback) const;

    /// One of the given words; its index. A missing key gives the fallback.
    std::optional<int> choice(std::string_view key, const std::vector<std::string>& words, int fallback) const;

    /// `label: key`, as messages name the value.
    std::string what(std::string_view key) const;

    void error(Place place, const std::string& text) const;
    void warning(Place place, const std::string& code, const std::string& text) const;

private:
    std::string labelled(const std::string& text) const;

    const ReadContext& context_;
    const TomlValue& value_;
    std::string label_;
};

}  // namespace dttmm
