// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "record/csv_table.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Oracle: what CsvTable wrote, to the bit.
TEST(CsvFile, IsWhatTheTableWrote) {
    const TemporaryFolder folder;
    CsvTable table({{"mode", "1"}, {"place", ""}, {"u", "m"}});
    table.add(1).add("a \"b\", c\nd").add(0.1).end_row();
    table.add(2).add("").add(NAN).end_row();
    write_text(folder / "modes.csv", table.text());
    const CsvFile file(folder / "modes.csv");
    ASSERT_EQ(file.rows(), 2u);
    EXPECT_EQ(file.find("u"), 2);
    EXPECT_EQ(file.find("v"), -1);
    EXPECT_TRUE(file.is_text(1));
    EXPECT_THAT(file.numbers(0), ElementsAre(1, 2));
    EXPECT_THAT(file.texts(1), ElementsAre("a \"b\", c\nd", ""));
    EXPECT_EQ(file.numbers(2)[0], 0.1);
    EXPECT_TRUE(std::isnan(file.numbers(2)[1]));
}

TEST(CsvFile, AnUnfinishedRowIsLeftOut) {
    const TemporaryFolder folder;
    write_text(folder / "frf.csv", "a,b\nm,N\n1,2\n3,");
    const CsvFile file(folder / "frf.csv");
    EXPECT_TRUE(file.is_torn());
    EXPECT_EQ(file.rows(), 1u);
}

TEST(CsvFile, ADamagedFileIsRefusedAtItsPlace) {
    const TemporaryFolder folder;
    const auto expect = [&](const char* text, const auto& message) {
        write_text(folder / "frf.csv", text);
        expect_error([&] { CsvFile(folder / "frf.csv"); }, ExitCode::input_output, message);
    };
    expect("a,b\nm,N\n1,2\n3\n", HasSubstr("frf.csv:4: 1 fields, but 2 names"));
    expect("a,b\nm,N\n1,2x\n", AllOf(HasSubstr("frf.csv:3: "), HasSubstr("\"2x\" of the column \"b\" is no number")));
    expect("a,b\nm\n", HasSubstr("frf.csv:2: 1 units, but 2 names"));
    expect("", HasSubstr("frf.csv:1: this is no table of results"));
}

}  // namespace
}  // namespace dttmm::host
