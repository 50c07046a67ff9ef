// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "measured/mat_arrays.h"

namespace dttmm::host {

/// The variables of a MAT file of level 7.3, which is an HDF5 file, in the order of their names. Throws Error(input_output)
/// with the variable for a file that is cut off or damaged. Not while another thread uses HDF5.
/// HDF5 1.10.8 itself crashes on a few files whose attributes are damaged: 3 of 10000 in which some bytes were changed.
std::vector<MatArray> read_mat73(const std::filesystem::path& file);

}  // namespace dttmm::host
