// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "model/table_reader.h"

namespace dttmm::host {

/// Puts the tables of the files that the key `include` names in front of those of the document, which is that of `file`;
/// their names are relative to the file that includes them, and these may include others. A file that is included a second
/// time, a circle among them, a key that two files give, and a file that cannot be read are faults; they go to
/// `diagnostics`. `inputs` gets every file that was read.
void include_files(TomlValue& document, const std::filesystem::path& file, Diagnostics& diagnostics, InputFiles& inputs);

}  // namespace dttmm::host
