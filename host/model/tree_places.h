// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "model/table_reader.h"

namespace dttmm::host {

/// Where things are at the start, read from the tree of the file before the readers of its tables. What is faulty there
/// counts as left out: its reader reports it.

struct TreePose {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// Of a node in the world, a body in the world, or a marker in the axes of its body: a table, or [x, y, z] alone. `table` is
/// the name of its table of keys.
TreePose read_tree_pose(const ReadContext& context, const TomlValue& value, const char* table);

/// Where "node", "body" or "body.marker" is in the world [m]; nothing where there is none of that name.
std::optional<Eigen::Vector3d> find_tree_place(const ReadContext& context, const TomlValue& document,
                                               const std::string& name);

/// The value for an inserted text, or [x, y, ...].
TomlValue text_value(const std::string& text, Place place);
TomlValue list_value(std::initializer_list<double> numbers, Place place);

/// The member `key` of a table; one of the kind is made, empty, where there is none.
TomlValue& member_of(TomlValue& table, const std::string& key, TomlValue::Kind kind);

/// Puts a value in the place of that of the key, or behind all members.
void set_member(TomlValue& table, const std::string& key, TomlValue value);

}  // namespace dttmm::host
