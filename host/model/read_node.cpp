// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_node.h"

#include <fmt/format.h>

#include "model/index.h"
#include "model/read_modes.h"
#include "model/read_position.h"
#include "model/read_rotation.h"
#include "model/read_signal.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

/// A velocity and a direction held where it is exclude each other.
void check_motion(const TableReader& table, const Node& node) {
    const auto check = [&](const char* key, const Eigen::Vector3d& velocity, std::size_t first) {
        for (std::size_t d = 0; d < 3; ++d)
            if (node.fixed[first + d] && velocity(as_row(d)) != 0)
                table.error(table.find(key)->value.place,
                            fmt::format("{} moves the node in {}, which is fixed", key, kDirections[first + d]));
    };
    check("velocity", node.velocity, 0);
    check("angular_velocity", node.angular_velocity, 3);
}

Node read_node(const ReadContext& context, const TomlMember& member, NameRegistry& names) {
    Node node;
    node.name = names.add(context, member.place, member.key);
    const std::string label = "node " + quote(member.key);
    if (!member.value.is_table()) {
        node.position = read_vector(context, member.value, label, "m").value_or(node.position);
        check_position(context, member.value.place, label, node.position);
        return node;
    }
    const TableReader table(context, member.value, label, key_table("node"));
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    node.position = table.vector("position").value_or(zero);
    if (const TomlMember* position = table.find("position"))
        check_position(context, position->value.place, label, node.position);
    node.fixed = read_directions(table, "fixed");
    node.rotation = read_rotation(table).value_or(node.rotation);
    node.moves = table.find("velocity") || table.find("angular_velocity");
    node.velocity = table.vector("velocity", zero).value_or(zero);
    node.angular_velocity = table.vector("angular_velocity", zero).value_or(zero);
    check_motion(table, node);
    if (const TomlMember* motion = table.find("motion")) read_motion(context, *motion, label, node);
    return node;
}

}  // namespace

void read_motion(const ReadContext& context, const TomlMember& member, const std::string& label, Node& node) {
    const TableReader table(context, member.value, label + ": motion", key_table("node.motion"));
    if (!table.is_valid()) return;
    node.motion_place = context.diagnostics.place_text(member.value.place);
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
        const TomlMember* signal = table.find(kDirections[d]);
        if (!signal) continue;
        if (!node.fixed[d])
            table.error(signal->place, fmt::format("{} is not fixed: a support moves a node in fixed directions only; add "
                                                   "\"{}\" to fixed, or leave its motion out",
                                                   kDirections[d], kDirections[d]));
        node.motion[d] =
            read_signal(table.context(), signal->value, table.what(kDirections[d]), table.key(signal->key).unit);
    }
    if (member.value.members.empty())
        table.error(member.value.place, "it moves no direction; write motion = { z = \"-5 mm\" }, or leave it out");
}

std::vector<Node> read_nodes(const TableReader& file, const std::vector<const NameRegistry*>& others, NameRegistry& names) {
    std::vector<Node> nodes;
    const TomlMember* member = file.find("nodes");
    if (!member) return nodes;
    if (!member->value.is_table()) {
        file.error(member->place, fmt::format("nodes must be a table of name = [x, y, z], got {}; write [nodes]",
                                              kind_text(member->value.kind)));
        return nodes;
    }
    for (const TomlMember& entry : member->value.members) {
        nodes.push_back(read_node(file.context(), entry, names));
        for (const std::string& conflict : find_name_conflicts(file.context().diagnostics, nodes.back().name, others))
            file.context().diagnostics.error(entry.place, fmt::format("node {}: {}", quote(entry.key), conflict));
    }
    return nodes;
}

}  // namespace dttmm::host
