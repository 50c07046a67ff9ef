// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

std::string without_blanks_around(std::string_view text);

/// The parts between commas, without the blanks around them; an empty part is kept.
std::vector<std::string> split_list(std::string_view text);

}  // namespace dttmm::host
