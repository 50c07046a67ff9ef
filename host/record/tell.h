// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace dttmm::host {

/// Writes a line to the standard error; on a terminal in as many as its width needs. What cannot be written is lost: a
/// message must not end the run it is about.
void tell(const std::string& line) noexcept;

/// `text` in lines of `width` characters at most, where its blanks allow it; those after the first are indented by four.
std::string wrap(std::string_view text, std::size_t width);

}  // namespace dttmm::host
