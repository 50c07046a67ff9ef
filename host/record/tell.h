// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace dttmm::host {

/// Writes a line to the standard error. What cannot be written is lost: a message must not end the run it is about.
void tell(const std::string& line) noexcept;

}  // namespace dttmm::host
