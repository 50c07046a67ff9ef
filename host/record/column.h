// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace dttmm::host {

/// Head of a column of a table, or of a dataset.
struct Column {
    std::string name;
    std::string unit;  ///< "1" for a pure number, empty for a text
};

/// What every writer of histories relies on: column 0 is "time", names differ and are not empty, no control character in a
/// name or unit, no slash in a name (HDF5 would make a group of it). Throws Error(internal_error) otherwise.
void check_columns(const std::vector<Column>& columns);

}  // namespace dttmm::host
