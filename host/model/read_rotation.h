// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "model/table_reader.h"

namespace dttmm::host {

/// The keys by which a table says how its axes are turned: `rotation = { axis = [x, y, z], angle = "30 deg" }` about an axis
/// of any length, or `quaternion = [w, x, y, z]` of norm 1 to 1e-6, then normalised.
inline const std::vector<std::string> kRotationKeys = {"rotation", "quaternion"};

/// The rotation matrix R of the table: v_outer = R v_inner. Identity if it says nothing. Reports faults and then returns
/// nothing.
std::optional<Eigen::Matrix3d> read_rotation(const TableReader& table);

/// The rotation matrix of a table { axis, angle }, which messages call `what`. Reports faults and then returns nothing.
std::optional<Eigen::Matrix3d> read_axis_and_angle(const TableReader& outer, const TomlMember& member,
                                                   const std::string& what);

/// A vector that is not zero, scaled to length 1. Reports faults and then returns nothing.
std::optional<Eigen::Vector3d> read_direction(const TableReader& table, const char* key);

/// The unit vector across `axis`, a unit vector, from which angles about it count: the part of the vector `key` across it;
/// without that key, of the next of x, y, z behind that which `axis` is nearest to. `axis_name` names the axis in messages.
/// Reports faults and then returns nothing.
std::optional<Eigen::Vector3d> read_zero(const TableReader& table, const char* key, const Eigen::Vector3d& axis,
                                         const char* axis_name);

}  // namespace dttmm::host
