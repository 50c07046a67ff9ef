// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::host {

/// Of ASCII, whatever the locale says.
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace dttmm::host
