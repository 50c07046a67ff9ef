// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace dttmm::host {

/// A file that is part of the page.
struct Asset {
    std::string_view name;    ///< "page.js"
    std::string_view text;    ///< in UTF-8
    std::string_view sha256;  ///< of the text, 64 hexadecimal digits
};

/// Built in by CMake: page.html, page.css, the scripts of this folder and those of assets/.
const Asset& report_asset(std::string_view name);

}  // namespace dttmm::host
