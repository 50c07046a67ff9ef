// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_element.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <tuple>

#include "model/wording.h"

namespace dttmm {
namespace {

constexpr double kFarApart = 1000;  // [m]

std::span<const dttmm_parameter> parameters_of(const dttmm_element_type& type) {
    return {type.parameters, type.parameter_count};
}

std::vector<std::string> keys_of(const dttmm_element_type& type) {
    std::vector<std::string> keys = {"name", "type", "from", "to"};
    for (const dttmm_parameter& parameter : parameters_of(type)) keys.emplace_back(parameter.name);
    return keys;
}

/// The catalogue index of the entry's type; -1 where there is none, which is reported.
int read_type(const ReadContext& context, const TomlValue& entry, const std::string& label,
              const ElementCatalogue& catalogue) {
    const auto fail = [&](Place place, const std::string& text) {
        context.diagnostics.error(place, label + ": " + text);
        return -1;
    };
    const TomlMember* type = entry.find("type");
    if (!type) return fail(entry.place, "missing key \"type\"");
    if (!type->value.is_text())
        return fail(type->value.place, fmt::format("type must be a text, got {}", kind_text(type->value.kind)));
    const int index = catalogue.find(type->value.string);
    if (index >= 0) return index;
    std::vector<std::string> names, declared;
    for (std::size_t i = 0; i < catalogue.types.size(); ++i) {
        names.emplace_back(catalogue.types[i]->name);
        declared.push_back(fmt::format("{} (plugin {})", names.back(), quote(catalogue.plugins[i])));
    }
    const auto nearest = find_nearest(type->value.string, names);
    return fail(type->value.place,
                fmt::format("no loaded plugin declares element type {}; declared: {}{}", quote(type->value.string),
                            declared.empty() ? "none, as no plugin is loaded" : listed(declared),
                            nearest ? fmt::format("; did you mean {}?", quote(*nearest)) : ""));
}

std::optional<std::vector<double>> read_parameter(const TableReader& table, const dttmm_parameter& parameter) {
    const std::vector<double> defaults(parameter.count, parameter.default_value);
    const bool is_required = parameter.flags & DTTMM_PARAMETER_REQUIRED;
    if (!is_required && !table.find(parameter.name)) return defaults;
    const TomlMember* member = table.require(parameter.name);
    if (!member) return std::nullopt;
    return read_numbers(table.context(), member->value, table.what(parameter.name), parameter.unit, parameter.count,
                        parameter.flags & DTTMM_PARAMETER_SPREADS, {parameter.minimum, parameter.maximum});
}

std::optional<std::vector<double>> read_values(const TableReader& table, const dttmm_element_type& type) {
    std::vector<double> values;
    bool is_complete = true;
    for (const dttmm_parameter& parameter : parameters_of(type)) {
        const auto numbers = read_parameter(table, parameter);
        if (numbers) values.insert(values.end(), numbers->begin(), numbers->end());
        is_complete &= numbers.has_value();
    }
    return is_complete ? std::optional(values) : std::nullopt;
}

/// An element between one body and itself, or the ground and itself, cannot deform.
bool check_ends(const TableReader& table, const Element& element, const Attachments& attachments) {
    const Place place = table.find("to")->value.place;
    if (element.from.body == element.to.body) {
        table.error(place, element.to.body < 0 ? "both ends are on the ground" : "both ends are on the same body");
        return false;
    }
    if (element.from.body < 0 || element.to.body < 0) return true;  // the ground end coincides with the other
    const double distance = (attachments.position(element.to) - attachments.position(element.from)).norm();
    if (distance > kFarApart)
        table.warning(place, fmt::format("the ends are {} m apart at the start", number_text(distance)));
    return true;
}

class ElementsReader {
public:
    ElementsReader(const ElementCatalogue& catalogue, const Attachments& attachments, const NameRegistry& body_names,
                   NameRegistry& names)
        : catalogue_(catalogue), attachments_(attachments), body_names_(body_names), names_(names) {}

    void read(const ReadContext& context, const TomlValue& entry, std::size_t index) {
        const std::string label = entry_label("element", entry, index);
        const int type = entry.is_table() ? read_type(context, entry, label, catalogue_) : -1;
        const std::vector<std::string> keys =
            type < 0 ? all_keys(entry) : keys_of(*catalogue_.types[static_cast<std::size_t>(type)]);
        const TableReader table(context, entry, label, keys, entry_note("element", index));
        if (table.is_valid()) read(table, type);
    }

    std::vector<Element> take() { return std::move(elements_); }

private:
    /// Of an element of unknown type no key is known to be wrong.
    static std::vector<std::string> all_keys(const TomlValue& entry) {
        std::vector<std::string> keys;
        for (const TomlMember& member : entry.members) keys.push_back(member.key);
        return keys;
    }

    void read(const TableReader& table, int type) {
        Element element;
        element.name = names_.add_from(table);
        element.type = type;
        element.place = table.context().diagnostics.place_text(table.place());
        check_name(table, element.name, {&body_names_});
        const auto from = attachments_.read(table, "from");
        const auto to = attachments_.read(table, "to");
        element.from = from.value_or(Attachment{});
        element.to = to.value_or(Attachment{});
        const bool has_ends = from && to && check_ends(table, element, attachments_);
        if (type < 0) return;
        const auto values = read_values(table, *catalogue_.types[static_cast<std::size_t>(type)]);
        if (!has_ends || !values) return;
        element.values = *values;
        warn(table, element);
        elements_.push_back(std::move(element));
    }

    void warn(const TableReader& table, const Element& element) {
        const auto is_zero = [](double value) { return value == 0; };
        if (!element.values.empty() && std::all_of(element.values.begin(), element.values.end(), is_zero))
            table.warning(table.place(), "free: every parameter is zero, it carries nothing");
        const auto [twin, is_new] = seen_.emplace(std::tuple(element.type, element.from.body, element.from.marker,
                                                             element.to.body, element.to.marker, element.values),
                                                  element.name);
        if (!is_new)
            table.warning(table.place(),
                          fmt::format("identical to element {}: same ends, type and values", quote(twin->second)));
    }

    const ElementCatalogue& catalogue_;
    const Attachments& attachments_;
    const NameRegistry& body_names_;
    NameRegistry& names_;
    std::map<std::tuple<int, int, int, int, int, std::vector<double>>, std::string> seen_;
    std::vector<Element> elements_;
};

}  // namespace

std::vector<Element> read_elements(const TableReader& file, const ElementCatalogue& catalogue,
                                   const Attachments& attachments, const NameRegistry& body_names, NameRegistry& names) {
    ElementsReader reader(catalogue, attachments, body_names, names);
    std::size_t index = 0;
    for (const TomlValue& entry : read_entries(file, "element")) reader.read(file.context(), entry, index++);
    return reader.take();
}

}  // namespace dttmm
