// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// The parameters of an element as its type declares them. "section.tube" is the key `tube` of the table `section = { ... }`
/// in the element; a text is a word that the type knows, a quantity or an expression.

/// The keys of the element's table that its parameters stand under, each once.
std::vector<std::string> parameter_keys(const dttmm_element_type& type);

/// The numbers of all parameters, in the order declared, those the model leaves out by their defaults. Reports faults and
/// then returns nothing.
std::optional<std::vector<double>> read_values(const TableReader& table, const dttmm_element_type& type);

}  // namespace dttmm::host
