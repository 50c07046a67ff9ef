// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// [[case]]: which loads and motions of supports act, with which factors. `model` has its nodes and loads. A load or a
/// motion in none of the cases is warned about. Faults are reported.
std::vector<LoadCase> read_cases(const TableReader& file, const Model& model);

/// The case of a name. Throws Error(usage) with the nearest name where there is none.
const LoadCase& find_case(const Model& model, const std::string& name);

/// Makes gravity, loads and motions of supports those of a case of the model.
void apply_case(Model& model, const LoadCase& load_case);

}  // namespace dttmm::host
