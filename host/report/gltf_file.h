// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "report/scene.h"

namespace dttmm::host {

/// Writes a scene as binary glTF 2.0: one file of a JSON and a BIN chunk, little-endian, in metres and seconds. A root turns
/// the world so that z is up, where glTF has y. Below it is a node per part with its name: bodies with their position and
/// rotation and the box of their inertia, nodes as cubes, elements as prisms between their points, one per piece of a bent
/// beam. An animation per film:
///     run          as recorded, linear between the rows
///     mode         one period, which lasts 1 s; the largest displacement is 10 % of the machine's size, and no rotation is
///                  larger than 0.5 rad
///     equilibrium  from the start to the whole of it in 1 s
/// A run or equilibrium that could not be seen has a second animation, enlarged; its name says how much. The extras of the
/// file have the title, what is left out, and the factor of every animation. Returns what was written. Throws
/// Error(input_output); Error(resource) for more than 4 GB, which the format cannot have.
/// Source: Khronos Group, glTF 2.0 Specification (2021).
std::string write_gltf(const Scene& scene, const std::filesystem::path& path);

/// By how much a motion is enlarged to be seen: of a mode to the amplitude above; else 1, 2 or 5 times a power of ten if its
/// largest displacement is less than 2 % of the size and nothing turns far, or 1.
double enlargement(const Scene& scene, const Film& film);

}  // namespace dttmm::host
