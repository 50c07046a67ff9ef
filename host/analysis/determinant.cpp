// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/determinant.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/places.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_table.h"

namespace dttmm::host {

std::string determinant_table(ModalMachine& machine, const std::string& range) {
    const size_t dots = range.find(".."), colon = range.rfind(':');
    const std::string count = colon == std::string::npos ? "" : range.substr(colon + 1);
    const bool is_count =
        !count.empty() && count.size() < 8 && std::ranges::all_of(count, [](char c) { return c >= '0' && c <= '9'; });
    if (dots == std::string::npos || !is_count || colon < dots + 2 || std::stoi(count) < 2)
        throw Error(ExitCode::usage,
                    fmt::format("--determinant {}: write from..to:count with two frequencies or more, as 1Hz..200Hz:400",
                                quote(range)));
    const double from = frequency_of("--determinant", range.substr(0, dots)),
                 to = frequency_of("--determinant", range.substr(dots + 2, colon - dots - 2));
    if (!(to > from))
        throw Error(ExitCode::usage,
                    fmt::format("--determinant {}: the second frequency must be more than the first", quote(range)));
    const int points = std::stoi(count);
    CsvTable table({{"frequency", "Hz"}, {"sign", "1"}, {"log10_determinant", "1"}, {"smallest_singular_value", "1"}});
    for (int i = 0; i < points; ++i) {
        const double f = from + (to - from) * i / (points - 1);
        const dttmm_overall overall = machine.overall(f);
        table.add(f).add(overall.sign).add(overall.log10_determinant).add(overall.smallest).end_row();
    }
    return table.text();
}

std::string overall_matrix_table(ModalMachine& machine, const std::string& frequency) {
    const ModalInstance::OverallMatrix matrix = machine.overall_matrix(frequency_of("--matrix", frequency));
    std::vector<Column> columns = {{"equation", ""}, {"unit", ""}};
    for (const auto& [name, unit] : matrix.columns) columns.push_back({name, unit});
    CsvTable table(columns);
    for (size_t i = 0; i < matrix.rows.size(); ++i) {
        table.add(matrix.rows[i].first).add(matrix.rows[i].second);
        for (const double entry : matrix.U.row(as_row(i))) table.add(entry);
        table.end_row();
    }
    return table.text();
}

}  // namespace dttmm::host
