// SPDX-License-Identifier: BSD-3-Clause
#include "record/history_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_file.h"

namespace dttmm::host {

HistoryFile::HistoryFile(std::filesystem::path path) : path_(std::move(path)), text_(read_whole_file(path_)) {
    const std::vector<std::string> names = csv_record(text_, rows_begin_);
    const std::size_t units_begin = rows_begin_;
    if (names.front() != "time" || units_begin >= text_.size())
        fail(1, "this is no history of a run: its first line are the names of channels, of which \"time\" is the first");
    const std::vector<std::string> units = csv_record(text_, rows_begin_);
    if (units.size() != names.size() || units.front() != "s")
        fail(2, fmt::format("the second line are the units, one for each of the {} names, \"s\" first", names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) columns_.push_back({names[c], units[c]});
    rows_begin_ = std::min(rows_begin_, text_.size());
}

std::vector<std::vector<double>> HistoryFile::read(const std::vector<int>& wanted) const {
    std::vector<std::vector<double>> values(wanted.size());
    std::size_t line = 2;
    for (std::size_t begin = rows_begin_; begin < text_.size();) {
        const std::size_t end = text_.find('\n', begin);
        if (end == text_.npos) break;  // torn
        ++line;
        std::string_view row(text_.data() + begin, end - begin);
        begin = end + 1;
        if (row.ends_with('\r')) row.remove_suffix(1);
        std::size_t next = 0, column = 0;
        for (bool is_last = false; !is_last; ++column) {
            const std::size_t comma = row.find(',');
            is_last = comma == row.npos;
            const std::string_view field = row.substr(0, comma);
            if (!is_last) row.remove_prefix(comma + 1);
            if (next == wanted.size() || column != as_size(wanted[next])) continue;
            double value = 0;
            const auto [stop, fault] = std::from_chars(field.data(), field.data() + field.size(), value);
            if (fault != std::errc() || stop != field.data() + field.size() || !std::isfinite(value))
                fail(line, fmt::format("{} of the channel \"{}\" is no finite number", quote(field), columns_[column].name));
            values[next++].push_back(value);
        }
        if (column != columns_.size()) fail(line, fmt::format("{} fields, but {} names", column, columns_.size()));
    }
    return values;
}

void HistoryFile::fail(std::size_t line, const std::string& fault) const {
    throw Error(ExitCode::input_output, fmt::format("{}:{}: {}", path_.string(), line, fault));
}

}  // namespace dttmm::host
