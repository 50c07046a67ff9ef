// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "model/error.h"
#include "model/index.h"
#include "model/names.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& fault) {
    throw Error(ExitCode::model_invalid, fmt::format("--sweep {}: {}", quote(text), fault));
}

Quantity quantity_in(const std::string& text, const std::string& part) {
    try {
        return parse_quantity(part);
    } catch (const Error& error) {
        refuse(text, error.what());
    }
}

long count_in(const std::string& text, const std::string& part) {
    long count = 0;
    const auto [end, fault] = std::from_chars(part.data(), part.data() + part.size(), count);
    if (fault != std::errc{} || end != part.data() + part.size() || count < 1 || count > kMostCases)
        refuse(text,
               fmt::format("the count after \":\" must be a whole number from 1 to {}, got {}", kMostCases, quote(part)));
    return count;
}

std::vector<std::string> range_values(const std::string& text, const std::string& range) {
    const size_t dots = range.find(".."), colon = range.rfind(':');
    if (colon == std::string::npos || colon < dots) refuse(text, "a range wants a count: name=from..to:count");
    const Quantity from = quantity_in(text, range.substr(0, dots));
    const Quantity to = quantity_in(text, range.substr(dots + 2, colon - dots - 2));
    const long count = count_in(text, range.substr(colon + 1));
    if (from.unit != to.unit) refuse(text, fmt::format("its ends have different units, {} and {}", from.unit, to.unit));
    if (count == 1 && from.value != to.value)
        refuse(text, "one value cannot be both ends: write a count of 2 or more, or name=value");
    std::vector<std::string> values;
    for (long i = 0; i < count; ++i) {
        const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
        const double value = from.value + share * (to.value - from.value);
        values.push_back(from.unit == "1" ? number_text(value) : fmt::format("{} {}", number_text(value), from.unit));
    }
    return values;
}

std::vector<std::string> list_values(const std::string& text, const std::string& list) {
    std::vector<std::string> values;
    for (size_t begin = 0; begin <= list.size();) {
        const size_t comma = std::min(list.find(',', begin), list.size());
        const std::string item = list.substr(begin, comma - begin);
        quantity_in(text, item);
        values.push_back(item);
        begin = comma + 1;
    }
    return values;
}

void check_value(const std::string& name, const std::string& value, const Parameter& in_file) {
    std::optional<std::string> unit;
    try {
        unit = find_missing_unit(in_file, value);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("--sweep {}: {}", quote(name), error.what()));
    }
    if (unit)
        throw Error(ExitCode::usage, fmt::format("--sweep {}: of which unit? the file gives {}; write it with every value, "
                                                 "e.g. \"{} {}\"",
                                                 quote(name), *unit, value, *unit));
}

}  // namespace

SweepAxis parse_sweep_axis(const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
        throw Error(ExitCode::usage, fmt::format("--sweep {}: write name=from..to:count or name=value,value", quote(text)));
    const std::string name = text.substr(0, equals), rest = text.substr(equals + 1);
    return {normalise_name(name), rest.find("..") != std::string::npos ? range_values(text, rest) : list_values(text, rest)};
}

void refuse_set_beside(const std::string& option, const std::string& name, const Parameters::Overrides& set) {
    for (const auto& [given, value] : set)
        if (normalise_name(given) == name)
            throw Error(ExitCode::usage, fmt::format("{} {}: --set gives this parameter a value too; leave one of them out",
                                                     option, quote(name)));
}

void check_axes(const std::vector<SweepAxis>& axes, const std::vector<Parameter>& parameters,
                const Parameters::Overrides& set) {
    std::vector<std::string> known;
    for (const Parameter& parameter : parameters) known.push_back(parameter.name);
    for (const SweepAxis& axis : axes) {
        const auto found = std::ranges::find(parameters, axis.name, &Parameter::name);
        if (found == parameters.end())
            throw Error(ExitCode::usage,
                        fmt::format("--sweep {}: no such parameter{}", quote(axis.name), suggestion(axis.name, known)));
        refuse_set_beside("--sweep", axis.name, set);
        for (const std::string& value : axis.values) check_value(axis.name, value, *found);
    }
}

std::vector<SweepCase> make_grid(const std::vector<SweepAxis>& axes) {
    std::vector<SweepCase> grid = {{}};
    for (size_t a = 0; a < axes.size(); ++a) {
        for (size_t other = 0; other < a; ++other)
            if (axes[a].name == axes[other].name)
                throw Error(ExitCode::usage, fmt::format("--sweep names the parameter {} twice", quote(axes[a].name)));
        if (grid.size() * axes[a].values.size() > as_size(kMostCases))
            throw Error(ExitCode::model_invalid, fmt::format("the sweep has more than {} cases", kMostCases));
        std::vector<SweepCase> wider;
        for (const SweepCase& known : grid)
            for (const std::string& value : axes[a].values) {
                wider.push_back(known);
                wider.back().emplace_back(axes[a].name, value);
            }
        grid = std::move(wider);
    }
    return grid;
}

}  // namespace dttmm::host
