// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace dttmm::host {

/// A line of a chart; where y is NaN it is interrupted.
struct ChartLine {
    std::string label;
    std::vector<double> x, y;
};

struct Chart {
    std::string x_label, y_label;
    std::vector<ChartLine> lines;
    bool is_logarithmic = false;  ///< y; what is not positive is left out
};

/// Charts over each other as one SVG picture, for light and dark pages. title: for those who do not see it. Texts are plain.
std::string draw_svg(const std::string& title, const std::vector<Chart>& charts);

/// At most about `count` round numbers (1, 2, 5 times a power of ten) from `low` to `high`, ascending.
std::vector<double> round_ticks(double low, double high, int count);

}  // namespace dttmm::host
