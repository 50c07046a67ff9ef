// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace dttmm::host {

/// Names of bodies, markers, elements and parameters: letters of any script, combining marks, digits, `_` and `-`, at most
/// 100 characters, `-` not the first, compared in Unicode normal form C. The dot is kept for `body.marker`.

/// `name` in normal form C; as it is if it is not UTF-8.
std::string normalise_name(std::string_view name);

/// What is wrong with a normalised name: the rule it breaks, ready to follow `body name "x" `; nothing if it is a name.
std::optional<std::string> find_name_fault(std::string_view name);

/// The same of a name that may hold anything but braces: outside of a [[repeat]] they stand for nothing.
std::optional<std::string> find_brace(std::string_view name);

}  // namespace dttmm::host
