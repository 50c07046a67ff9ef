// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace dttmm::test {

/// Cells of a line of a CSV file without quotes; a comma at the end has an empty one behind it.
inline std::vector<std::string> split_csv_line(const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line)
        if (c == ',')
            cells.emplace_back();
        else
            cells.back() += c;
    return cells;
}

}  // namespace dttmm::test
