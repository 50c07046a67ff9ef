// SPDX-License-Identifier: BSD-3-Clause
#include "model/tree_places.h"

#include <algorithm>

#include "model/names.h"
#include "model/read_rotation.h"

namespace dttmm::host {

TreePose read_tree_pose(const ReadContext& context, const TomlValue& value, const char* table) {
    Diagnostics unheard("");
    const ReadContext silent{context.parameters, unheard, context.inputs};
    TreePose pose;
    if (!value.is_table()) {
        pose.position = read_vector(silent, value, "position", "m").value_or(pose.position);
        return pose;
    }
    const TableReader reader(silent, value, "", key_table(table));
    pose.position = reader.vector("position", pose.position).value_or(pose.position);
    pose.rotation = read_rotation(reader).value_or(pose.rotation);
    return pose;
}

std::optional<Eigen::Vector3d> find_tree_place(const ReadContext& context, const TomlValue& document,
                                               const std::string& name) {
    const std::size_t dot = name.find('.');
    const std::string first = normalise_name(name.substr(0, dot));
    if (const TomlMember* nodes = document.find("nodes"); nodes && dot == name.npos)
        for (const TomlMember& node : nodes->value.members)
            if (normalise_name(node.key) == first) return read_tree_pose(context, node.value, "node").position;
    const TomlMember* bodies = document.find("body");
    for (const TomlValue& body : bodies ? bodies->value.items : std::vector<TomlValue>()) {
        const TomlMember* given = body.find("name");
        if (!given || normalise_name(given->value.string) != first) continue;
        const TreePose pose = read_tree_pose(context, body, "body");
        if (dot == name.npos) return pose.position;
        const TomlMember* markers = body.find("markers");
        for (const TomlMember& marker : markers ? markers->value.members : std::vector<TomlMember>())
            if (normalise_name(marker.key) == normalise_name(name.substr(dot + 1)))
                return pose.position + pose.rotation * read_tree_pose(context, marker.value, "marker").position;
    }
    return std::nullopt;
}

TomlValue text_value(const std::string& text, Place place) {
    TomlValue value;
    value.kind = TomlValue::Kind::text;
    value.place = place;
    value.string = text;
    return value;
}

TomlValue list_value(std::initializer_list<double> numbers, Place place) {
    TomlValue list;
    list.kind = TomlValue::Kind::array;
    list.place = place;
    for (const double number : numbers) {
        TomlValue& item = list.items.emplace_back();
        item.kind = TomlValue::Kind::real;
        item.place = place;
        item.number = number + 0.0;  // no negative zero
    }
    return list;
}

TomlValue& member_of(TomlValue& table, const std::string& key, TomlValue::Kind kind) {
    const auto found = std::ranges::find(table.members, key, &TomlMember::key);
    if (found != table.members.end()) return found->value;
    TomlMember member{key, table.place, {}};
    member.value.kind = kind;
    member.value.place = table.place;
    table.members.push_back(std::move(member));
    return table.members.back().value;
}

void set_member(TomlValue& table, const std::string& key, TomlValue value) {
    const auto found = std::ranges::find(table.members, key, &TomlMember::key);
    if (found != table.members.end())
        found->value = std::move(value);
    else
        table.members.push_back({key, value.place, std::move(value)});
}

}  // namespace dttmm::host
