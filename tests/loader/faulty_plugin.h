// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "support/paths.h"

namespace dttmm::host {

/// The plugin with this fault, one of those in tests/loader/faulty/faulty.c; "none" is in order.
inline std::filesystem::path faulty_plugin(const std::string& fault) {
    return std::filesystem::path(test::paths::faulty_plugins()) / (fault + ".so");
}

}  // namespace dttmm::host
