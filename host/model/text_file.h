// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace dttmm::host {

/// The text of a regular file of at most kLargestFile bytes (one more where it is longer), or of the standard input, which
/// is called "-" and is read once. Throws Error(input_output) if it cannot be read.
std::string read_text_file(const std::filesystem::path& file);

}  // namespace dttmm::host
