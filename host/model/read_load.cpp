// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "model/index.h"
#include "model/name_registry.h"
#include "model/names.h"
#include "model/read_rotation.h"
#include "model/read_signal.h"
#include "model/signal_shapes.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr int kOfElement = 1, kOfBody = 2;  ///< words of `axes`

/// Only `[1, 1, 0]` and the like need another length than one. Along one axis a length looks like a part of the force.
void warn_length(const TableReader& table) {
    const auto direction = table.vector("direction");
    const bool is_along_axis = direction && (direction->array() != 0).count() == 1;
    if (is_along_axis && direction->cwiseAbs().maxCoeff() != 1)
        table.warning(table.find("direction")->value.place, "direction-length",
                      fmt::format("the length of direction, {:g}, does not count: force, moment or force_per_length alone "
                                  "gives the magnitude; write 1 or -1",
                                  direction->cwiseAbs().maxCoeff()));
}

/// One signal, or two: at the `from` end and at the `to` end.
struct AlongLine {
    Signal at_from;
    std::optional<Signal> at_to;
};

std::optional<AlongLine> read_along_line(const TableReader& table, const TomlMember& member) {
    const auto read = [&](const TomlValue& value, const std::string& what) {
        return read_signal(table.context(), value, what, table.key(member.key).unit);
    };
    const std::string what = table.what(member.key);
    if (!member.value.is_array()) {
        const auto one = read(member.value, what);
        return one ? std::optional(AlongLine{*one, std::nullopt}) : std::nullopt;
    }
    const std::vector<TomlValue>& items = member.value.items;
    if (items.size() != 2) {
        table.error(member.value.place,
                    fmt::format("force_per_length has one value, or two, [at from, at to], got {}{}", items.size(),
                                items.size() == 3 ? "; its direction stands in `direction`" : ""));
        return std::nullopt;
    }
    const auto at_from = read(items[0], what + " at from"), at_to = read(items[1], what + " at to");
    return at_from && at_to ? std::optional(AlongLine{*at_from, *at_to}) : std::nullopt;
}

/// Index of the element that `element` names, a line. Faults are reported.
std::optional<int> read_line(const TableReader& table, const TomlMember& member, const LoadPlaces& places) {
    const auto fail = [&](const std::string& text) {
        table.error(member.value.place, "element" + text);
        return std::nullopt;
    };
    if (!member.value.is_text()) return fail(fmt::format(" must be a text, got {}", kind_text(member.value.kind)));
    const std::string name = normalise_name(member.value.string);
    const auto found = std::ranges::find(places.elements, name, &Element::name);
    if (found == places.elements.end()) {
        if (places.element_names.find(name)) return std::nullopt;  // its own fault is reported
        std::vector<std::string> names;
        for (const Element& element : places.elements) names.push_back(element.name);
        if (places.attachments.has(name))
            return fail(fmt::format(": {} is no element; a force or moment on it has the key `on`", quote(name)));
        return fail(fmt::format(": there is no element {}{}", quote(name), suggestion(name, names)));
    }
    const dttmm_element_type& type = *places.catalogue.types[as_size(found->type)];
    if (takes_line_loads(type)) return as_int(found - places.elements.begin());
    std::vector<std::string> lines;
    for (const dttmm_element_type* one : places.catalogue.types)
        if (takes_line_loads(*one)) lines.emplace_back(one->name);
    return fail(fmt::format(
        ": line load on a {}: {} is no line with segments; a force_per_length acts on {}", type.name, quote(name),
        lines.empty() ? "none of the element types loaded" : "a " + fmt::format("{}", fmt::join(lines, " or "))));
}

/// A force per length; `magnitude` is its value.
std::optional<Load> read_line_load(const TableReader& table, const TomlMember& member, const TomlMember* magnitude,
                                   const LoadPlaces& places) {
    const auto element = read_line(table, member, places);
    const auto direction = read_direction(table, "direction");
    if (direction) warn_length(table);
    const auto axes = table.choice("axes", 0);
    if (axes == kOfBody) table.error(table.find("axes")->place, "axes = \"body\" is for a force or moment on a body");
    if (!magnitude) return std::nullopt;
    if (magnitude->key != "force_per_length") {
        table.error(magnitude->place, fmt::format("a {} acts at a point: name a body, a marker or a node with `on`; along "
                                                  "an element acts a force_per_length, as \"2 kN/m\"",
                                                  magnitude->key));
        return std::nullopt;
    }
    const auto along = read_along_line(table, *magnitude);
    if (!element || !direction || !axes || !along) return std::nullopt;
    Load load{{}, *direction, false, along->at_from, table.context().diagnostics.place_text(magnitude->place)};
    load.element = *element;
    load.signal_at_to = along->at_to;
    load.turns = *axes == kOfElement;
    return load;
}

bool is_vibration(const TomlMember& magnitude) { return magnitude.key == "harmonic" || magnitude.key == "psd"; }

/// A moment, or a `harmonic` or `psd` whose unit is that of one.
bool is_moment_by(const TomlMember& magnitude) {
    if (!is_vibration(magnitude)) return magnitude.key == "moment";
    const TomlMember* size = magnitude.value.find(magnitude.key == "psd" ? "values" : "amplitude");
    const TomlValue* first = size && size->value.is_array() && !size->value.items.empty() ? &size->value.items.front()
                             : size                                                       ? &size->value
                                                                                          : nullptr;
    if (!first || !first->is_text() || first->string.starts_with("=")) return false;
    try {
        parse_quantity(first->string);
    } catch (const Error&) {
        return false;  // the reader of the number reports it
    }
    const std::string unit = unit_text(first->string);
    return !unit.empty() && measures(unit, magnitude.key == "psd" ? "(N*m)^2/Hz" : "N*m");
}

std::optional<Signal> read_magnitude(const TableReader& table, const TomlMember& magnitude, bool is_moment) {
    const std::string what = table.what(magnitude.key);
    if (is_vibration(magnitude))
        return read_vibration(
            TableReader(table.context(), magnitude.value, what, key_table(magnitude.key), {}, is_moment ? "N*m" : "N"),
            magnitude.key == "psd");
    return read_signal(table.context(), magnitude.value, what, table.key(magnitude.key).unit);
}

/// A force or moment at a point; `magnitude` is its value.
std::optional<Load> read_point_load(const TableReader& table, const TomlMember& member, const TomlMember* magnitude,
                                    const Attachments& attachments) {
    const auto on = attachments.read(table, "on");
    const auto direction = read_direction(table, "direction");
    if (direction) warn_length(table);
    const auto axes = table.choice("axes", 0);
    if (axes == kOfElement)
        table.error(table.find("axes")->place,
                    "axes = \"element\" is for a force_per_length; those of a force or moment on a body are \"world\" or "
                    "\"body\"");
    if (axes == kOfBody && on && on->body < 0)
        table.error(table.find("axes")->place, "axes = \"body\" is for a load on a body or its marker");
    if (on && on->is_ground()) table.error(member.value.place, "a load on the ground moves nothing");
    if (!magnitude) return std::nullopt;
    if (magnitude->key == "force_per_length") {
        table.error(magnitude->place,
                    "a force_per_length acts along an element: name a line with `element` in place of `on`");
        return std::nullopt;
    }
    const bool is_moment = is_moment_by(*magnitude);
    if (on && attachments.is_clamped(*on))
        table.error(
            member.value.place,
            fmt::format("node {} is fixed in all directions: a load there moves nothing, and no reaction has it; leave "
                        "it out, or a direction of `fixed`",
                        quote(member.value.string)));
    else if (on && direction && attachments.is_held(*on, *direction, is_moment))
        table.warning(member.value.place, "load-on-support",
                      fmt::format("node {} is fixed in the direction of the {}, which moves nothing: its reaction alone has "
                                  "it",
                                  quote(member.value.string), magnitude->key));
    if (on && !is_moment && attachments.is_off_centre(*on))
        table.error(
            member.value.place,
            fmt::format("{} is a body whose center_of_mass is not its origin: say where the force acts; give the body "
                        "a marker there, as markers.centre at its center_of_mass, and name that",
                        quote(member.value.string)));
    const auto signal =
        magnitude->key == "unbalance" ? std::optional(Signal()) : read_magnitude(table, *magnitude, is_moment);
    if (!on || !direction || !axes || !signal) return std::nullopt;
    Load load{*on, *direction, is_moment, *signal, table.context().diagnostics.place_text(magnitude->place)};
    load.turns = *axes == kOfBody;
    return load;
}

/// A force m e Omega² that turns about `direction`: two vibrations across it, a quarter of a turn apart.
std::vector<Load> read_unbalance(const TableReader& table, const TomlMember& magnitude, const Load& about) {
    const auto size = table.number("unbalance");
    const auto phase = table.number("phase", 0);
    const Eigen::Vector3d axis = about.direction;
    const auto zero = read_zero(table, "zero", axis, "direction, about which the unbalance turns");
    if (!zero || !size || !phase) return {};
    const Constants& constants = table.context().parameters.constants();
    HarmonicSignal::Numbers numbers;
    numbers.formula = std::make_shared<const Expression>(fmt::format("({:.17g})*{}^2", *size, kSpeed), constants, kSpeed);
    numbers.order = 1;
    if (!read_speed(table, magnitude.place, numbers)) return {};
    std::vector<Load> loads;
    for (const int part : {0, 1}) {
        Load load = about;
        load.place = table.context().diagnostics.place_text(magnitude.place);
        load.direction = part == 0 ? *zero : Eigen::Vector3d(axis.cross(*zero));
        numbers.phase = *phase - part * std::numbers::pi / 2;
        load.signal = Signal(std::make_shared<const HarmonicSignal>(numbers));
        loads.push_back(load);
    }
    return loads;
}

std::vector<Load> read_load(const ReadContext& context, const TomlValue& entry, std::size_t index,
                            const LoadPlaces& places) {
    const TableReader table(context, entry, entry_label("load", entry, index), key_table("load"), entry_note("load", index));
    if (!table.is_valid()) return {};
    const bool is_along = table.find("element") || (table.find("force_per_length") && !table.find("on"));
    const TomlMember* place =
        table.find("on") && is_along ? table.require_one({"element", "on"}) : table.require(is_along ? "element" : "on");
    const TomlMember* magnitude = table.require_one({"force", "moment", "force_per_length", "harmonic", "psd", "unbalance"});
    const bool is_unbalance = magnitude && magnitude->key == "unbalance";
    for (const char* key : {"phase", "zero"})
        if (const TomlMember* member = table.find(key); member && !is_unbalance)
            table.error(member->place, fmt::format("{} is for an unbalance", key));
    if (!place) {
        read_direction(table, "direction");
        return {};
    }
    std::optional<Load> load = is_along ? read_line_load(table, *place, magnitude, places)
                                        : read_point_load(table, *place, magnitude, places.attachments);
    if (!load) return {};
    if (table.find("name")) load->name = read_free_name(table, "load");
    return is_unbalance ? read_unbalance(table, *magnitude, *load) : std::vector{*load};
}

}  // namespace

std::vector<Load> read_loads(const TableReader& file, const LoadPlaces& places) {
    std::vector<Load> loads;
    std::size_t index = 0;
    for (const TomlValue& entry : read_entries(file, "load"))
        for (Load& load : read_load(file.context(), entry, index++, places)) loads.push_back(std::move(load));
    return loads;
}

}  // namespace dttmm::host
