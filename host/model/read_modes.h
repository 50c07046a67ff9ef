// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "model/model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// What the command line says instead of [modes]: texts as in the file.
struct ModesOverrides {
    std::optional<std::string> count, below, beams, about;
};

/// The names of the six directions, x y z rx ry rz.
extern const std::vector<std::string> kDirections;

/// A list of directions under `key`; none if it is not there. Faults are reported.
std::bitset<6> read_directions(const TableReader& table, const std::string& key);

/// [damping]. Faults are reported.
DampingSettings read_damping(const TableReader& file);

/// [modes] and dofs: how many frequencies or up to which, exact or lumped beams, in which directions the machine moves.
/// Faults are reported.
ModesSettings read_modes(const TableReader& file, const ModesOverrides& overrides);

}  // namespace dttmm::host
