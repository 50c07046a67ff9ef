// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_table.h"

#include <fmt/compile.h>

#include <cassert>
#include <cmath>
#include <iterator>

#include "record/csv_writer.h"

namespace dttmm::host {

CsvTable::CsvTable(const std::vector<Column>& columns) : text_(csv_header(columns)), columns_(columns.size()) {}

CsvTable::CsvTable(const std::vector<Column>& first, std::span<const Channel> channels)
    : columns_(first.size() + channels.size()) {
    for (const Column& column : first) add(column.name);
    for (const Channel& channel : channels) add(channel.name());
    end_row();
    for (const Column& column : first) add(column.unit);
    for (const Channel& channel : channels) add(channel.unit());
    end_row();
}

void CsvTable::separate() {
    assert(filled_ < columns_);
    if (filled_++ > 0) text_ += ',';
}

CsvTable& CsvTable::add(double value) {
    separate();
    if (!std::isnan(value)) fmt::format_to(std::back_inserter(text_), FMT_COMPILE("{}"), value);
    return *this;
}

CsvTable& CsvTable::add(std::string_view text) {
    separate();
    add_csv_field(text, text_);
    return *this;
}

void CsvTable::end_row() {
    while (filled_ < columns_) separate();
    text_ += '\n';
    filled_ = 0;
}

}  // namespace dttmm::host
