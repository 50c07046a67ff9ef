// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model/diagnostics.h"

namespace dttmm::host {

/// Limits within which the TOML parser, which recurses, is safe and quick.
inline constexpr std::size_t kLargestFile = 64u << 20;  // [byte]
inline constexpr std::size_t kLongestLine = 1u << 20;   // [byte]
inline constexpr int kDeepestKey = 64;                  // parts of a dotted key or header
inline constexpr int kDeepestNesting = 32;              // arrays and inline tables within each other

struct TextFault {
    Place place;
    std::string text;
};

/// The first reason why `text` must not reach the TOML parser: too large, UTF-16 or UTF-32, a NUL byte, bytes that are not
/// UTF-8, a line, key or nesting beyond the limits above, a string that is not closed (at its opening quote), a character
/// beyond ASCII outside strings and comments. Linear in the size of the text and without recursion.
std::optional<TextFault> find_text_fault(std::string_view text);

/// Line and column of the byte at `offset`.
Place place_of_byte(std::string_view text, std::size_t offset);

}  // namespace dttmm::host
