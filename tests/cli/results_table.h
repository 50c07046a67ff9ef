// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "cli/process.h"

namespace dttmm::host {

/// A CSV file of results by the names of its columns.
struct ResultsTable {
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;

    size_t column(const std::string& name) const {
        const auto found = std::ranges::find(names, name);
        EXPECT_NE(found, names.end()) << name;
        return static_cast<size_t>(found - names.begin());
    }
    double value(size_t row, const std::string& name) const { return rows[row][column(name)]; }
    std::complex<double> amplitude(size_t row, const std::string& channel) const {
        return {value(row, channel + ".re"), value(row, channel + ".im")};
    }
};

inline ResultsTable read_table(const std::filesystem::path& file) {
    ResultsTable table;
    const std::string text = read_text(file);
    std::istringstream names(text.substr(0, text.find('\n')));
    for (std::string name; std::getline(names, name, ',');) table.names.push_back(name);
    table.rows = read_history(file);
    return table;
}

}  // namespace dttmm::host
