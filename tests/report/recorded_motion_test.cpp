// SPDX-License-Identifier: BSD-3-Clause
#include "report/recorded_motion.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;

const char* const kMotionModel = R"({"bodies": {"b": {}}, "nodes": {"n": {}}, "elements": {"beam-1": {}, "s": {}}})";

// Oracle: rows written here, columns in an order of their own; of a part whose columns are not all there nothing is known.
TEST(RecordedMotion, HasTheTracksWhoseColumnsAreAllThere) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv",
               "time,n.rotation.z,n.rotation.x,s.force.x,s.force.y,n.rotation.y,beam-1.force\ns,rad,rad,N,N,rad,N\n"
               "0,9,7,1,2,8,-5\n1,90,70,10,20,80,-50\n");
    const RecordedMotion motion(HistoryFile(folder / "history.csv"), Json::parse(kMotionModel), {100, 1000});
    EXPECT_THAT(motion.find(Track::Of::node, "n", "rotation")->values, ElementsAre(7, 8, 9, 70, 80, 90));
    EXPECT_EQ(motion.find(Track::Of::body, "n", "rotation"), nullptr);
    EXPECT_EQ(motion.find(Track::Of::element, "s", "force"), nullptr) << "z is missing";
    EXPECT_EQ(magnitude(*motion.find(Track::Of::element, "beam-1", "force"), 1), 50);
    EXPECT_TRUE(motion.moves());
}

TEST(RecordedMotion, KeepsBothBounds) {
    const TemporaryFolder folder;
    std::string text = "time,n.position.x,n.position.y,n.position.z\ns,m,m,m\n";
    for (int i = 0; i < 101; ++i) text += fmt::format("{},{},{},{}\n", 0.5 * i, i, -i, 2 * i);
    write_text(folder / "history.csv", text);
    const HistoryFile history(folder / "history.csv");
    const Json model = Json::parse(kMotionModel);
    const RecordedMotion by_rows(history, model, {40, 1000000}), by_numbers(history, model, {1000, 80}),
        two(history, model, {1, 1});
    EXPECT_EQ(by_rows.every(), 3u);
    EXPECT_EQ(by_rows.rows(), 34u);
    EXPECT_EQ(by_numbers.every(), 6u) << "20 rows of 4 numbers";
    EXPECT_EQ(by_numbers.times()[16], 48);
    EXPECT_EQ(by_numbers.tracks().front().values[3 * 16 + 1], -96);
    EXPECT_EQ(two.rows(), 2u);
}

TEST(RecordedMotion, OfEquilibriaEveryRowIsOne) {
    const TemporaryFolder folder;
    write_text(folder / "static.csv",
               "case,s.force,b.position.x,b.position.y,b.position.z\n,N,m,m,m\nsnow,-3,1,2,3\nwind,4,5,6,7\n");
    const RecordedMotion motion(CsvFile(folder / "static.csv"), Json::parse(kMotionModel));
    EXPECT_THAT(motion.times(), ElementsAre(0, 1));
    const Track* force = motion.find(Track::Of::element, "s", "force");
    ASSERT_NE(force, nullptr);
    EXPECT_EQ(magnitude(*force, 0), 3);
    EXPECT_THAT(motion.find(Track::Of::body, "b", "position")->values, ElementsAre(1, 2, 3, 5, 6, 7));
}

TEST(RecordedMotion, StationsOfABeamAreOneLine) {
    const TemporaryFolder folder;
    write_text(
        folder / "static.csv",
        "s.station0.position.x,s.station0.position.y,s.station0.position.z,s.station1.position.x,s.station1.position.y,"
        "s.station1.position.z,s.station3.position.x\nm,m,m,m,m,m,m\n1,2,3,4,5,6,7\n");
    const RecordedMotion motion(CsvFile(folder / "static.csv"), Json::parse(kMotionModel));
    const Track* line = motion.find(Track::Of::line, "s", "position");
    ASSERT_NE(line, nullptr);
    EXPECT_THAT(line->values, ElementsAre(1, 2, 3, 4, 5, 6)) << "from end to end, as far as none is missing";
    for (const char* name : {"s.station0.position.x", "a-b.station10.position.z"}) EXPECT_TRUE(is_station(name)) << name;
    for (const char* name :
         {"s.station.position.x", "s.stations1.position.x", "station1.position.x", "s.station1.force.x", "s.force.x"})
        EXPECT_FALSE(is_station(name)) << name;
}

}  // namespace
}  // namespace dttmm::host
