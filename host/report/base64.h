// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace dttmm::host {

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);
/// Of little-endian numbers of four bytes: 7 digits. What is larger than such a number can be is infinite.
std::string base64_of_floats(std::span<const double> values);
/// Of little-endian numbers of eight bytes.
std::string base64_of_doubles(std::span<const double> values);

}  // namespace dttmm::host
