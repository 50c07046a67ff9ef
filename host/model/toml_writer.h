// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "model/toml_document.h"

namespace dttmm::host {

/// A document as TOML text that reads back with the same values: keys of the file first, then its tables, each value on one
/// line. Whole numbers below 1e16 are integers.
std::string write_toml(const TomlValue& document);

}  // namespace dttmm::host
