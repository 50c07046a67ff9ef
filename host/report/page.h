// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "analysis/json.h"

namespace dttmm::host {

/// First line of every report, by which one is known.
inline constexpr const char* kReportBeginning = "<!doctype html><!-- dttmm report -->";

/// The whole page: one file that needs nothing else. Its content policy allows its own scripts and styles by their hashes,
/// and nothing from elsewhere. title: plain text. data: what the scripts show. has_machine: whether three.js is needed.
std::string make_page(const std::string& title, const Json& data, bool has_machine);

}  // namespace dttmm::host
