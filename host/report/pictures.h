// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "analysis/json.h"
#include "record/history_file.h"

namespace dttmm::host {

/// A recorded motion as the page reads it. At most 2000 rows, fewer of large machines. model: member "model" of
/// summary.json. Null where nothing moves.
///     {times [s], every (rows from one to the next), bodies: {name: {position: 3 per row [m], quaternion: 4 per row}},
///      nodes: {name: {position, rotation [rad]}}, forces: {element: magnitude per row [N]}}
Json describe_motion(const HistoryFile& history, const Json& model);

/// shapes.csv of dttmm modes, by mode and element: {element: x y z ux uy uz of every station}. Null where there is none.
Json describe_lines(const std::filesystem::path& shapes);

}  // namespace dttmm::host
