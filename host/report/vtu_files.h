// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "report/scene.h"

namespace dttmm::host {

/// Writes a scene for ParaView: an unstructured grid per instant of a run, per mode, or per equilibrium, in the folder
/// <name>.frames beside the collection <name>.pvd. Its times are seconds of a run, and numbers of modes or equilibria: two
/// modes may have one frequency, and ParaView takes what has one time for parts of one grid. World axes, SI.
///     points    runs and equilibria: where they are; modes: at the start
///     cells     bodies as hexahedra of their inertia, nodes as vertices, elements as polylines (vertices where they have no
///               length)
///     points:   displacement, from the start [m]; of a mode its shape, to first order in the rotations, in its own unit
///     cells:    part (its place in part_names), kind (0 body, 1 node, 2 element), force [N], NaN where it is not known
///     fields:   TimeValue, frequency [Hz] of a mode, part_names, left_out
/// Older frames of the folder are removed. Returns what was written. Throws Error(input_output), also for a folder with
/// other files.
/// Source: VTK File Formats, XML, version 1.0: base64 with a length of eight bytes, little-endian.
std::string write_vtu(const Scene& scene, const std::filesystem::path& path);

}  // namespace dttmm::host
