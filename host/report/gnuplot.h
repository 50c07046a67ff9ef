// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "report/svg_chart.h"

namespace dttmm::host {

/// Charts over each other by gnuplot as a PNG picture at `path`. Throws Error(input_output) where gnuplot is not installed,
/// with the command that installs it, or where it fails.
void draw_png(const std::string& title, const std::vector<Chart>& charts, const std::filesystem::path& path);

/// Charts over each other as text by gnuplot, each `columns` wide and `rows` high. Throws as draw_png does.
std::string draw_text(const std::vector<Chart>& charts, int columns, int rows);

}  // namespace dttmm::host
