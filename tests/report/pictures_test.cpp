// SPDX-License-Identifier: BSD-3-Clause
#include "report/pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "report/base64.h"

namespace dttmm::host {
namespace {

const char* const kModel = R"({"bodies": {"b": {}, "unseen": {}}, "nodes": {"n": {}}, "elements": {"e": {}, "s": {}}})";

// Oracle: rows written here; the force of e is 5 N by 3-4-5.
TEST(Pictures, MotionIsThatOfTheRows) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv",
               "time,s.force,e.force.x,e.force.y,e.force.z,n.position.x,n.position.y,n.position.z,b.position.x,b.position.y,"
               "b.position.z,b.quaternion.w,b.quaternion.x,b.quaternion.y,b.quaternion.z,unseen.position.x\n"
               "s,N,N,N,N,m,m,m,m,m,m,1,1,1,1,m\n0,-2,3,0,4,1,2,3,4,5,6,1,0,0,0,8\n0.5,1,0,0,0,7,8,9,10,11,12,0,1,0,0,8\n");
    const Json motion = describe_motion(HistoryFile(folder / "history.csv"), Json::parse(kModel));
    EXPECT_EQ(motion["every"], 1);
    EXPECT_EQ(motion["times"], base64_of_doubles(std::vector<double>{0, 0.5}));
    EXPECT_EQ(motion["bodies"]["b"]["position"], base64_of_floats(std::vector<double>{4, 5, 6, 10, 11, 12}));
    EXPECT_EQ(motion["bodies"]["b"]["quaternion"], base64_of_floats(std::vector<double>{1, 0, 0, 0, 0, 1, 0, 0}));
    EXPECT_EQ(motion["nodes"]["n"]["position"], base64_of_floats(std::vector<double>{1, 2, 3, 7, 8, 9}));
    EXPECT_EQ(motion["forces"]["e"], base64_of_floats(std::vector<double>{5, 0}));
    EXPECT_EQ(motion["forces"]["s"], base64_of_floats(std::vector<double>{2, 1}));
    EXPECT_FALSE(motion["bodies"].contains("unseen"));
}

TEST(Pictures, ManyRowsAreShownAtEqualDistances) {
    const TemporaryFolder folder;
    std::string text = "time,b.position.x,b.position.y,b.position.z\ns,m,m,m\n";
    for (int i = 0; i < 4500; ++i) text += fmt::format("{},{},0,0\n", i, 2 * i);
    write_text(folder / "history.csv", text);
    const Json motion = describe_motion(HistoryFile(folder / "history.csv"), Json::parse(kModel));
    std::vector<double> times;
    for (int i = 0; i < 4500; i += 3) times.push_back(i);
    EXPECT_EQ(motion["every"], 3);
    EXPECT_EQ(motion["times"], base64_of_doubles(times));
}

TEST(Pictures, WithoutPositionsThereIsNoMotion) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv", "time,s.force\ns,N\n0,1\n1,2\n");
    EXPECT_TRUE(describe_motion(HistoryFile(folder / "history.csv"), Json::parse(kModel)).is_null());
}

TEST(Pictures, LinesGoByModeAndElement) {
    const TemporaryFolder folder;
    EXPECT_TRUE(describe_lines(folder / "shapes.csv").is_null());
    write_text(folder / "shapes.csv",
               "mode,frequency,element,s,x,y,z,ux,uy,uz\n1,Hz,,m,m,m,m,1,1,1\n1,5,a,0,1,2,3,4,5,6\n2,9,a,0,1,2,3,-4,-5,-6\n"
               "2,9,a,1,2,3,4,5,6,7\n");
    const Json lines = describe_lines(folder / "shapes.csv");
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(lines[1]["a"], base64_of_floats(std::vector<double>{1, 2, 3, -4, -5, -6, 2, 3, 4, 5, 6, 7}));
}

}  // namespace
}  // namespace dttmm::host
