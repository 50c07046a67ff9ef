// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::host {

/// Of ASCII, in every locale.
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace dttmm::host
