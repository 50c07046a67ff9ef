// SPDX-License-Identifier: BSD-3-Clause
#include "record/history_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/error.h"
#include "record/csv_writer.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;

// Oracle: what CsvWriter wrote, to the bit, a name with a comma and quotes among it.
TEST(HistoryFile, IsWhatTheWriterWrote) {
    const TemporaryFolder folder;
    const double tiny = std::numeric_limits<double>::denorm_min(), large = -1.7976931348623157e308;
    {
        CsvWriter writer(folder / "history.csv", {{"time", "s"}, {"a,\"b\"", "N"}, {"c", "m"}});
        writer.write_row(std::vector<double>{0, 0.1, tiny});
        writer.write_row(std::vector<double>{0.001, 1.0 / 3, large});
        writer.finish();
    }
    const HistoryFile file(folder / "history.csv");
    ASSERT_EQ(file.columns().size(), 3u);
    EXPECT_EQ(file.columns()[1].name, "a,\"b\"");
    EXPECT_EQ(file.columns()[2].unit, "m");
    EXPECT_FALSE(file.is_torn());
    EXPECT_THAT(file.read({0, 2}), ElementsAre(ElementsAre(0, 0.001), ElementsAre(tiny, large)));
    EXPECT_THAT(file.read({1}), ElementsAre(ElementsAre(0.1, 1.0 / 3)));
}

TEST(HistoryFile, ATornRowIsLeftOut) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv", "time,a\r\ns,m\r\n0,1\r\n1,2\r\n2,");
    const HistoryFile file(folder / "history.csv");
    EXPECT_TRUE(file.is_torn());
    EXPECT_THAT(file.read({0, 1}), ElementsAre(ElementsAre(0, 1), ElementsAre(1, 2)));
}

TEST(HistoryFile, WhatIsNoHistoryIsRefused) {
    const TemporaryFolder folder;
    EXPECT_THROW(HistoryFile(folder / "history.csv"), Error);
    EXPECT_THROW(HistoryFile(folder.path()), Error);
    for (const char* text : {"", "\n", "time", "time\n", "x,y\ns,m\n", "time,a\ns\n", "time,\"a\ns,m\n0,1\n"}) {
        write_text(folder / "history.csv", text);
        EXPECT_THROW(HistoryFile(folder / "history.csv"), Error) << text;
    }
}

}  // namespace
}  // namespace dttmm::host
