// SPDX-License-Identifier: BSD-3-Clause
#include "model/bolt_circle.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "model/names.h"
#include "model/pattern_index.h"
#include "model/read_rotation.h"
#include "model/tree_places.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr std::array<const char*, 2> kPorts = {"from", "to"};

/// Whether the element can be a bolt; faults are reported.
bool check_element(const TableReader& table, const TomlValue* element, const dttmm_element_type* type) {
    if (!element) return table.require("element") != nullptr;
    const auto fail = [&](Place place, const std::string& text) {
        table.error(place, "element: " + text);
        return false;
    };
    if (!element->is_table())
        return fail(element->place, fmt::format("expected a table such as {{ type = \"spring_damper\", ... }}, got {}",
                                                kind_text(element->kind)));
    if (type && type->ends == DTTMM_ENDS_AT)
        return fail(element->find("type")->value.place, fmt::format("a {} has no two ends and is no bolt", type->name));
    for (const char* key : {"name", "from", "to", "at"})
        if (const TomlMember* member = element->find(key))
            return fail(member->place, fmt::format("{} comes from the bolt circle; leave the key out", key));
    return true;
}

const dttmm_element_type* type_of(const TomlValue* element, const ElementCatalogue& catalogue) {
    const TomlMember* type = element ? element->find("type") : nullptr;
    const int index = type && type->value.is_text() ? catalogue.find(type->value.string) : -1;
    return index < 0 ? nullptr : catalogue.types[as_size(index)];
}

struct Port {
    TomlValue* body = nullptr;
    TreePose pose = {};  ///< in the body's axes
};

/// Nothing, which is reported, where the name is that of no body or marker.
std::optional<Port> find_port(TomlValue& document, const TableReader& table, const char* key, const std::string& name) {
    const std::size_t dot = name.find('.');
    const std::string body_name = normalise_name(name.substr(0, dot));
    const Place place = table.find(key)->value.place;
    const auto fail = [&](const std::string& text) {
        table.error(place, fmt::format("{}: {}", key, text));
        return std::nullopt;
    };
    std::vector<std::string> known = {"ground"};
    for (TomlMember& member : document.members) {
        if (member.key != "body") continue;
        for (TomlValue& body : member.value.items) {
            const TomlMember* given = body.find("name");
            if (!given || !given->value.is_text()) continue;
            known.push_back(normalise_name(given->value.string));
            if (known.back() != body_name) continue;
            Port port{&body, {}};
            if (dot == name.npos) return port;
            const TomlMember* markers = body.find("markers");
            std::vector<std::string> names;
            for (const TomlMember& marker : markers ? markers->value.members : std::vector<TomlMember>()) {
                names.push_back(normalise_name(marker.key));
                if (names.back() != normalise_name(name.substr(dot + 1))) continue;
                port.pose = read_tree_pose(table.context(), marker.value, "marker");
                return port;
            }
            return fail(fmt::format("body {} has no marker {}{}", quote(body_name), quote(name.substr(dot + 1)),
                                    suggestion(name.substr(dot + 1), names)));
        }
    }
    const TomlMember* nodes = document.find("nodes");
    if (nodes && nodes->value.find(name))
        return fail(
            fmt::format("{} is a node, which is a point; for bolts between nodes of your own use [[repeat]]", quote(name)));
    return fail(fmt::format("there is no body {}{}", quote(body_name), suggestion(body_name, known)));
}

TomlValue make_marker(const BoltCircle& circle, int k, const Port& port, bool turns) {
    const double angle = circle.start_angle + 2 * M_PI * (k - 1) / circle.count;
    const Eigen::Vector3d radial = std::cos(angle) * circle.zero + std::sin(angle) * circle.axis.cross(circle.zero);
    const Eigen::Vector3d p = port.pose.position + port.pose.rotation * (circle.radius * radial);
    TomlValue position = list_value({p.x(), p.y(), p.z()}, circle.place);
    if (!turns) return position;
    Eigen::Matrix3d axes;
    axes << radial, circle.axis.cross(radial), circle.axis;
    const Eigen::Quaterniond q = Eigen::Quaterniond(port.pose.rotation * axes).normalized();
    TomlValue marker;
    marker.place = circle.place;
    marker.members.push_back({"position", circle.place, std::move(position)});
    marker.members.push_back({"quaternion", circle.place, list_value({q.w(), q.x(), q.y(), q.z()}, circle.place)});
    return marker;
}

}  // namespace

std::optional<BoltCircle> read_bolt_circle(const TableReader& table, const TomlValue* element,
                                           const ElementCatalogue& catalogue) {
    const dttmm_element_type* type = type_of(element, catalogue);
    BoltCircle circle;
    circle.place = table.place();
    circle.turns = type && !is_line(*type) && !element->find("axes");
    const auto name = table.text("name"), from = table.text("from"), to = table.text("to");
    const auto count = read_count(table);
    const auto radius = table.number("radius"), start_angle = table.number("start_angle", 0);
    const auto axis = table.find("axis") ? read_direction(table, "axis") : std::optional(circle.axis);
    const auto zero = axis ? read_zero(table, "zero", *axis, "axis") : std::nullopt;
    const bool is_bolt = check_element(table, element, type);
    if (!name || !from || !to || !count || !radius || !start_angle || !zero || !is_bolt) return std::nullopt;
    circle.name = *name;
    circle.ports = {*from, *to};
    circle.count = *count;
    circle.radius = *radius;
    circle.start_angle = *start_angle;
    circle.axis = *axis;
    circle.zero = *zero;
    return circle;
}

bool add_bolt_markers(TomlValue& document, const BoltCircle& circle, const TableReader& table) {
    bool is_whole = true;
    for (std::size_t end = 0; end < 2; ++end) {
        if (circle.ports[end] == "ground") continue;
        const auto port = find_port(document, table, kPorts[end], circle.ports[end]);
        is_whole &= port.has_value();
        if (!port) continue;
        TomlValue& markers = member_of(*port->body, "markers", TomlValue::Kind::table);
        const bool turns = circle.turns && (end == 0 || circle.ports[0] == "ground");
        for (int k = 1; k <= circle.count; ++k)
            markers.members.push_back(
                {fmt::format("{}{}", circle.name, k), circle.place, make_marker(circle, k, *port, turns)});
    }
    return is_whole;
}

TomlValue make_bolt(const BoltCircle& circle, int k, TomlValue element) {
    const Place place = element.place;
    const std::string name = fmt::format("{}{}", circle.name, k);
    std::vector<TomlMember> members = {{"name", place, text_value(name, place)}};
    for (std::size_t end = 0; end < 2; ++end) {
        const std::string& port = circle.ports[end];
        const std::string at = port == "ground" ? port : port.substr(0, port.find('.')) + "." + name;
        members.push_back({kPorts[end], place, text_value(at, place)});
    }
    std::ranges::move(element.members, std::back_inserter(members));
    element.members = std::move(members);
    return element;
}

}  // namespace dttmm::host
