// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "identify/column_maps.h"
#include "identify/model_names.h"
#include "identify/observations.h"
#include "measured/measurement.h"
#include "record/warnings.h"

namespace dttmm::host {

/// The place and direction that a name tells: "floor1.x", "plate.corner1.acceleration.z"; where all moves in one direction
/// "floor1" is enough. Nothing: it tells none.
std::optional<ObservedFreedom> find_freedom(ModelNames& names, const std::string& name);

/// Adds the modes of a file to observations, with their shapes at the places and directions that the model knows. noise: of
/// the frequencies, as the user gives it. Throws Error(usage) for a map to no place and direction. Columns that are none
/// are left out, with a note.
void add_modes(const Measurement& measurement, const NoiseLevel& noise, ModelNames& names, ColumnMaps& maps,
               Observations& observations, Warnings& warnings);

/// Gives all shapes a row for every freedom, when all files are read.
void complete_shapes(Observations& observations);

}  // namespace dttmm::host
