// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/diagnostics.h"
#include "model/expression.h"
#include "model/model.h"
#include "model/toml_document.h"

namespace dttmm::host {

/// The unit of `in_file` as the file gives it, "N/mm", where `text` is a plain number that is to replace it. Nothing where
/// the file gives no unit, or where `text` has a unit, is an expression or is zero, which is the same in every unit. Throws
/// Error(model_invalid) where `text` is no quantity, or one of another dimension than the file's.
std::optional<std::string> find_missing_unit(const Parameter& in_file, const std::string& text);

/// The [parameters] of a model file after --set: each a number, a quantity or an expression over others, resolved in the
/// order of their dependence. The three coordinates [m] of a place in [stations] are parameters too: "front.x", "front.y",
/// "front.z".
class Parameters {
public:
    using Overrides = std::vector<std::pair<std::string, std::string>>;

    /// `table` and `stations` may be null. Faults of the file go to `diagnostics`; an override without value, without the
    /// unit that the file gives, or of an unknown name throws Error(usage).
    Parameters(const TomlValue* table, const TomlValue* stations, const Overrides& overrides, Diagnostics& diagnostics);

    /// The SI value of an expression (without its "=") that must measure what the SI unit `wanted` measures. The name of a
    /// parameter alone keeps that parameter's unit; anything more is a plain SI number. Nothing if it rests on a parameter
    /// whose fault has been told; throws Error(model_invalid) for a fault of its own.
    std::optional<double> evaluate(std::string_view expression, std::string_view wanted) const;

    /// Throws Error(model_invalid) for an expression that is the name of a parameter alone, of a unit that `wanted` does not
    /// measure.
    void check_unit(std::string_view expression, std::string_view wanted) const;

    /// Whether the value of an expression changes with the parameter `name`, or with a name of that kind that is none.
    bool rests_on(std::string_view expression, const std::string& name) const;

    /// The expression with every parameter in it that rests on `name` replaced by what it is. Throws Error(model_invalid)
    /// where that becomes longer than an expression may be.
    std::string written_out(std::string_view expression, const std::string& name, int depth = 0) const;

    /// Whether an expression that was evaluated rests on the parameter `name`.
    bool has_used(const std::string& name) const;

    /// Whether an expression rests on a parameter whose fault has been told.
    bool rests_on_fault(std::string_view expression) const;

    /// Whether an expression is the name of a place in [stations] and nothing else.
    bool is_station(std::string_view expression) const;

    /// The names of all places in [stations].
    std::vector<std::string> stations() const;

    /// The values of all that resolved.
    const Constants& constants() const { return constants_; }

    /// In the order of the file.
    std::vector<Parameter> all() const;

private:
    struct Entry {
        Parameter parameter;
        Place place;
        bool is_coordinate = false;      ///< of a station: a length
        std::string expression;          ///< without "="; empty for a number or quantity
        std::vector<std::size_t> needs;  ///< indices of the parameters in the expression
        bool is_resolved = false;
        bool is_faulty = false;
    };

    void read_entry(const TomlMember& member);
    void read_station(const TomlMember& member);
    void override_entry(const std::string& name, const std::string& text);
    void read_text(Entry& entry, const std::string& text);
    void read_value(Entry& entry, const TomlValue& value);
    void find_needs(Entry& entry, const Constants& known);
    Constants stand_ins() const;  ///< every name with some value
    void resolve_all();
    void resolve(Entry& entry);
    void report_circles();
    void fail(Entry& entry, const std::string& text);
    const Entry& named_by(const Entry& entry) const;  ///< the entry whose value it takes over: itself, or of "=name"
    const Entry* find(std::string_view name) const;
    std::vector<std::string> names() const;

    Diagnostics& diagnostics_;
    std::vector<Entry> entries_;
    std::map<std::string, std::size_t, std::less<>> index_;
    Constants constants_;
    /// Names in the expressions that were evaluated. Evaluation changes no parameter, so mutable.
    mutable std::set<std::string> used_;
};

}  // namespace dttmm::host
