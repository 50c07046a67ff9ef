// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace dttmm::host {

/// A text as HTML and SVG show it: nothing in it is markup. Control characters, which XML forbids, become blanks.
std::string html_text(std::string_view text);

}  // namespace dttmm::host
