// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_table.h"

#include <cassert>
#include <cmath>

#include "model/wording.h"
#include "record/csv_writer.h"

namespace dttmm::host {

CsvTable::CsvTable(const std::vector<Column>& columns) : text_(csv_header(columns)), columns_(columns.size()) {}

void CsvTable::separate() {
    assert(filled_ < columns_);
    if (filled_++ > 0) text_ += ',';
}

CsvTable& CsvTable::add(double value) {
    separate();
    if (!std::isnan(value)) text_ += number_text(value);
    return *this;
}

CsvTable& CsvTable::add(std::string_view text) {
    separate();
    text_ += csv_field(text);
    return *this;
}

void CsvTable::end_row() {
    while (filled_ < columns_) separate();
    text_ += '\n';
    filled_ = 0;
}

}  // namespace dttmm::host
