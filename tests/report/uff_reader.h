// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace dttmm::host {

/// A dataset of a universal file: its number and its lines. Read by columns; shares nothing with the writer.
struct UffSet {
    int number = 0;
    std::vector<std::string> lines;

    /// Columns first..last of a line, from 1, as the specification counts them.
    std::string text(std::size_t line, std::size_t first, std::size_t last) const {
        const std::string& whole = lines.at(line);
        return whole.size() < first ? "" : whole.substr(first - 1, last - first + 1);
    }
    std::string trimmed(std::size_t line, std::size_t first, std::size_t last) const {
        std::string cut = text(line, first, last);
        cut.erase(cut.find_last_not_of(' ') + 1);
        return cut;
    }
    /// A field is a number and blanks, and nothing else; or the test has failed.
    double number_at(std::size_t line, std::size_t first, std::size_t last) const {
        const std::string field = text(line, first, last);
        char* end = nullptr;
        const double value = std::strtod(field.c_str(), &end);
        EXPECT_TRUE(end != field.c_str() && std::string(end).find_first_not_of(' ') == std::string::npos)
            << number << ", line " << line << ": \"" << field << "\"";
        return value;
    }
    int whole(std::size_t line, std::size_t first, std::size_t last) const {
        return static_cast<int>(number_at(line, first, last));
    }
};

/// All datasets. A line with -1 in columns 5 and 6 begins and ends each; no line has more than 80 bytes.
inline std::vector<UffSet> read_uff(const std::string& file) {
    std::vector<UffSet> sets;
    std::istringstream in(file);
    bool is_open = false, is_first = false;
    for (std::string line; std::getline(in, line);) {
        EXPECT_LE(line.size(), 80u) << line;
        if (line.substr(0, 6) == "    -1" && line.find_first_not_of(' ', 6) == std::string::npos) {
            is_open = !is_open;
            is_first = is_open;
        } else if (is_first) {
            sets.push_back({std::atoi(line.substr(0, 6).c_str()), {}});
            is_first = false;
        } else {
            EXPECT_TRUE(is_open) << line;
            sets.back().lines.push_back(line);
        }
    }
    EXPECT_FALSE(is_open);
    return sets;
}

inline std::vector<UffSet> uff_sets_of(const std::vector<UffSet>& all, int number) {
    std::vector<UffSet> found;
    for (const UffSet& set : all)
        if (set.number == number) found.push_back(set);
    return found;
}

/// Values of a dataset 58 in double precision: x, y, and the imaginary part or zero.
inline std::vector<std::array<double, 3>> read_uff_values(const UffSet& set) {
    const int type = set.whole(6, 1, 10), count = set.whole(6, 11, 20), is_even = set.whole(6, 21, 30);
    const double first = set.number_at(6, 31, 43), step = set.number_at(6, 44, 56);
    EXPECT_TRUE(type == 4 || type == 6) << type;
    const std::size_t width = 20u * (type == 6 ? 2 : 1) + (is_even ? 0 : 13), per_line = 80 / width;
    std::vector<std::array<double, 3>> values;
    for (int i = 0; i < count; ++i) {
        const std::size_t line = 11 + static_cast<std::size_t>(i) / per_line;
        std::size_t at = 1 + static_cast<std::size_t>(i) % per_line * width;
        std::array<double, 3> value = {first + i * step, 0, 0};
        if (!is_even) {
            value[0] = set.number_at(line, at, at + 12);
            at += 13;
        }
        value[1] = set.number_at(line, at, at + 19);
        if (type == 6) value[2] = set.number_at(line, at + 20, at + 39);
        values.push_back(value);
    }
    EXPECT_EQ(set.lines.size(), 11 + (static_cast<std::size_t>(count) + per_line - 1) / per_line);
    return values;
}

}  // namespace dttmm::host
