// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/channel.h"
#include "record/column.h"

namespace dttmm::host {

/// A CSV file that is made whole in memory, of numbers and texts: names, units, rows, in the form of history.csv.
class CsvTable {
public:
    explicit CsvTable(const std::vector<Column>& columns);
    /// The columns of channels behind `first`.
    CsvTable(const std::vector<Column>& first, std::span<const Channel> channels);

    /// Fields of the row that is open. A number that is not there, NaN, is an empty field.
    CsvTable& add(double value);
    CsvTable& add(std::string_view text);
    CsvTable& add_all(const auto& values) {
        for (const double value : values) add(value);
        return *this;
    }
    /// Closes the row; what is missing of it are empty fields.
    void end_row();

    /// Of all closed rows.
    const std::string& text() const { return text_; }

private:
    void separate();

    std::string text_;
    std::size_t columns_, filled_ = 0;
};

}  // namespace dttmm::host
