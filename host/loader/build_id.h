// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace dttmm::host {

/// The build ID of the program or library that holds this address, in hexadecimal: the hash of its contents that the linker
/// wrote into it (`--build-id`, NT_GNU_BUILD_ID). Throws std::logic_error where the linker wrote none.
std::string build_id_at(const void* address);

}  // namespace dttmm::host
