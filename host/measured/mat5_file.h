// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "measured/mat_arrays.h"

namespace dttmm::host {

/// The variables of a MAT file of level 5, from its bytes, the head of 128 included. Variables may be compressed (level 7).
/// file: for messages. Throws Error(input_output) with the variable and its byte for a file that is cut off or damaged.
/// Source: MathWorks, MAT-File Format, level 5.
std::vector<MatArray> read_mat5(const std::filesystem::path& file, std::string_view bytes, bool is_big_endian);

}  // namespace dttmm::host
