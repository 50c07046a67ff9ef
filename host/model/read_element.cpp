// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_element.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>

#include "model/index.h"
#include "model/read_node.h"
#include "model/read_rotation.h"
#include "model/read_values.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr double kFarApart = 100;  // [m] a bolt of a part whose millimetres were read as metres

std::vector<std::string> keys_of(const dttmm_element_type& type) {
    std::vector<std::string> keys = names_of(key_table(type.ends == DTTMM_ENDS_AT ? "element.at" : "element"));
    std::erase(keys, "sections");  // divided by now, where the type has them
    for (std::string& key : parameter_keys(type)) keys.push_back(std::move(key));
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

using Ends = std::vector<Attachment>;

/// The ends `from` and `to`, between which an element can deform.
std::optional<Ends> read_from_to(const TableReader& table, const Attachments& attachments) {
    const auto from = attachments.read(table, "from");
    const auto to = attachments.read(table, "to");
    if (!from || !to) return std::nullopt;
    const Place place = table.find("to")->value.place;
    if (from->body == to->body && from->node == to->node) {
        table.error(place, from->is_ground() ? "both ends are on the ground"
                           : from->node >= 0
                               ? "both ends are on the same node"
                               : "both ends are on the same body: nothing can deform; one end must be on another, "
                                 "on a node or on the ground");
        return std::nullopt;
    }
    if (from->is_ground() || to->is_ground()) return Ends{*from, *to};  // the ground end coincides with the other
    const double distance = (attachments.position(*to) - attachments.position(*from)).norm();
    if (distance > kFarApart)
        table.warning(place, "ends-apart", fmt::format("the ends are {} m apart at the start", number_text(distance)));
    return Ends{*from, *to};
}

/// What the key `axes` says: "from", "to" or { axis, angle }, the turn from the world's axes at the start. None: those of
/// the `from` end. Faults are reported.
std::optional<Eigen::Matrix3d> read_axes(const TableReader& table, const dttmm_element_type& type, const Ends& ends,
                                         const Attachments& attachments) {
    const TomlMember* member = table.find("axes");
    if (!member) return std::nullopt;
    const TomlValue& value = member->value;
    const auto fail = [&](const std::string& text) {
        table.error(value.place, text);
        return std::nullopt;
    };
    if (is_line(type))
        return fail(fmt::format("axes: a {} has axes of its own, x from end to end; leave the key out", type.name));
    std::optional<Eigen::Matrix3d> axes;
    if (value.is_table()) {
        axes = read_axis_and_angle(table, *member, table.what("axes"));
        if (!axes) return std::nullopt;
    } else if (value.is_text() && (value.string == "from" || value.string == "to")) {
        const Attachment& end = ends[value.string == "from" ? 0 : 1];
        axes = attachments.axes(end.is_ground() ? ends[value.string == "from" ? 1 : 0] : end);
    } else {
        return fail("axes must be \"from\", \"to\" or { axis = [x, y, z], angle = \"30 deg\" }");
    }
    if (ends[0].node < 0) return axes;
    if ((*axes - attachments.axes(ends[0])).norm() > 1e-12)
        return fail("axes: its `from` end is a node, whose axes it has; give that node this `rotation`, or begin at a body");
    return std::nullopt;
}

/// The nodes of `at`: one, or a list.
std::optional<Ends> read_at(const TableReader& table, const Attachments& attachments) {
    const TomlMember* member = table.require("at");
    if (!member) return std::nullopt;
    const TomlValue& value = member->value;
    Ends ends;
    const auto add = [&](const TomlValue& item) {
        const auto at = attachments.read(table, item, "at");
        if (!at) return false;
        const auto fail = [&](const std::string& text) {
            table.error(item.place, "at: " + text);
            return false;
        };
        if (at->is_ground()) return fail("the ground does not move; name a node");
        if (at->body >= 0) return fail(fmt::format("{} is a body; give the mass to the body", quote(item.string)));
        if (std::find(ends.begin(), ends.end(), *at) != ends.end())
            return fail(fmt::format("{} is named twice", quote(item.string)));
        ends.push_back(*at);
        return true;
    };
    if (!value.is_array()) return add(value) ? std::optional(ends) : std::nullopt;
    bool is_whole = true;
    for (const TomlValue& item : value.items) is_whole &= add(item);
    if (value.items.empty()) table.error(value.place, "at is empty; name a node");
    return is_whole && !ends.empty() ? std::optional(ends) : std::nullopt;
}

class ElementsReader {
public:
    ElementsReader(const ElementCatalogue& catalogue, const Attachments& attachments,
                   const std::vector<const NameRegistry*>& others, NameRegistry& names, std::vector<Node>& nodes)
        : catalogue_(catalogue), attachments_(attachments), others_(others), names_(names), nodes_(nodes) {}

    void read(const ReadContext& context, const TomlValue& entry, std::size_t index) {
        const std::string label = entry_label("element", entry, index);
        const int type = entry.is_table() ? read_type(context, entry, label, catalogue_) : -1;
        const std::vector<std::string> keys = type < 0 ? all_keys(entry) : keys_of(*catalogue_.types[as_size(type)]);
        const TableReader table(context, entry, label, keys, &key_table("element"), entry_note("element", index));
        if (table.is_valid()) read(table, type);
    }

    void reserve(std::size_t count) { elements_.reserve(count); }
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
        check_name(table, element.name, others_);
        const auto ends = reads_at(table, type) ? read_at(table, attachments_) : read_from_to(table, attachments_);
        if (type < 0) return;
        const auto values = read_values(table, *catalogue_.types[as_size(type)]);
        if (!ends || !values) return;
        element.ends = *ends;
        if (!reads_at(table, type))
            if (const auto axes = read_axes(table, *catalogue_.types[as_size(type)], *ends, attachments_))
                element.axes = std::make_shared<Eigen::Matrix3d>(*axes);
        element.values = share(*values);
        warn(table, element);
        move_ground_end(table, element);
        elements_.push_back(std::move(element));
    }

    /// `motion = { .. }`: the ground end becomes a fixed node with the same axes, which a support moves.
    void move_ground_end(const TableReader& table, Element& element) {
        const TomlMember* motion = table.find("motion");
        if (!motion) return;
        const auto ground = std::ranges::find_if(element.ends, &Attachment::is_ground);
        if (ground == element.ends.end()) {
            table.error(motion->place,
                        "motion moves an end on the ground, and no end is \"ground\"; give a fixed node this motion");
            return;
        }
        const bool is_from = ground == element.ends.begin();
        const Attachment& other = element.ends[is_from ? 1 : 0];
        Node node;
        node.name = element.name + ".ground";
        node.position = attachments_.position(other);
        node.rotation = is_from && element.axes ? *element.axes : attachments_.axes(other);
        node.fixed.set();
        read_motion(table.context(), *motion, table.what("ground end"), node);
        if (is_from) element.axes.reset();  // they are those of the node
        *ground = {-1, -1, as_int(nodes_.size())};
        nodes_.push_back(std::move(node));
    }

    /// An element of unknown type is judged by what it has.
    bool reads_at(const TableReader& table, int type) const {
        return type < 0 ? table.find("at") != nullptr : catalogue_.types[as_size(type)]->ends == DTTMM_ENDS_AT;
    }

    void warn(const TableReader& table, const Element& element) {
        const auto is_zero = [](double value) { return value == 0 || std::isnan(value); };  // not given
        if (!element.values.empty() && std::all_of(element.values.begin(), element.values.end(), is_zero))
            table.warning(table.place(), "free-element", "free: every parameter is zero, it carries nothing");
        std::vector<std::uint64_t> axes;
        if (element.axes) axes = bits_of({element.axes->data(), element.axes->data() + 9});
        const auto [twin, is_new] =
            seen_.emplace(std::tuple(element.type, element.ends, element.values.data(), axes), element.name);
        if (!is_new)
            table.warning(table.place(), "duplicate-element",
                          fmt::format("identical to element {}: same ends, type and values", quote(twin->second)));
    }

    /// Equal numbers once, for all elements that have them.
    SharedNumbers share(const std::vector<double>& values) {
        SharedNumbers& shared = shared_[bits_of(values)];
        if (shared.empty()) shared = values;
        return shared;
    }

    /// Numbers that can be put in order: not a number stands for what the model does not give.
    static std::vector<std::uint64_t> bits_of(const std::vector<double>& values) {
        std::vector<std::uint64_t> bits;
        for (double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
        return bits;
    }

    const ElementCatalogue& catalogue_;
    const Attachments& attachments_;
    const std::vector<const NameRegistry*>& others_;
    NameRegistry& names_;
    std::vector<Node>& nodes_;
    std::map<std::vector<std::uint64_t>, SharedNumbers> shared_;
    /// By type, ends, where the numbers stand, which are shared, and axes.
    std::map<std::tuple<int, Ends, const double*, std::vector<std::uint64_t>>, std::string> seen_;
    std::vector<Element> elements_;
};

}  // namespace

std::vector<Element> read_elements(const TableReader& file, const ElementCatalogue& catalogue,
                                   const Attachments& attachments, const std::vector<const NameRegistry*>& others,
                                   NameRegistry& names, std::vector<Node>& nodes) {
    ElementsReader reader(catalogue, attachments, others, names, nodes);
    const std::vector<TomlValue>& entries = read_entries(file, "element");
    reader.reserve(entries.size());
    std::size_t index = 0;
    for (const TomlValue& entry : entries) reader.read(file.context(), entry, index++);
    return reader.take();
}

}  // namespace dttmm::host
