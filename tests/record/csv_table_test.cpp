// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_table.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace dttmm::host {
namespace {

// Oracle: the text by hand. What is no number and what is missing are empty fields.
TEST(CsvTable, HasNamesUnitsAndRows) {
    CsvTable table({{"case", ""}, {"k,1", "N/m"}, {"a", "1"}, {"b", "m"}});
    table.add("one").add(0.1).add_all(std::array{1e300, -3.0}).end_row();
    table.add("a \"b\"").add(std::nan("")).end_row();
    table.add("open");
    EXPECT_EQ(table.text().substr(0, table.text().find("open")),
              "case,\"k,1\",a,b\n,N/m,1,m\none,0.1,1e+300,-3\n\"a \"\"b\"\"\",,,\n");
}

}  // namespace
}  // namespace dttmm::host
