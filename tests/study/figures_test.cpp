// SPDX-License-Identifier: BSD-3-Clause
#include "study/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/error.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;

const std::vector<Channel> kChannels = {{"time", "s"},
                                        {Channel::Of::element, "bolt1", "force", "z", "N"},
                                        {Channel::Of::element, "bolt2", "force", "z", "N"},
                                        {Channel::Of::body, "plate", "position", "z", "m"}};

std::vector<std::string> names_of(const HistoryFigures& figures) {
    std::vector<std::string> names;
    for (const Column& column : figures.columns()) names.push_back(column.name + " " + column.unit);
    return names;
}

// Oracle: by hand; the mean of 2, −6, 4 with half ends is (1 − 6 + 2)/2, that of the squares (2 + 36 + 8)/2.
TEST(FiguresOfAHistory, ByHand) {
    HistoryFigures figures({"bolt1.force.z:peak,time,minimum,maximum,final,mean,rms"}, kChannels, std::nullopt);
    figures.take_row(std::vector<double>{0, 2, 0, 0});
    figures.take_row(std::vector<double>{0.5, -6, 0, 0});
    figures.take_row(std::vector<double>{1, 4, 0, 0});
    EXPECT_THAT(figures.values(), ElementsAre(6, 0.5, -6, 4, 4, -1.5, std::sqrt(23.0)));
    EXPECT_EQ(names_of(figures)[1], "bolt1.force.z.time s");
}

TEST(FiguresOfAHistory, PatternsAndWhatIsThereWithoutThem) {
    EXPECT_THAT(
        names_of(HistoryFigures({"bolt*:rms", "plate.position.z"}, kChannels, std::nullopt)),
        ElementsAre("bolt1.force.z.rms N", "bolt2.force.z.rms N", "plate.position.z.peak m", "plate.position.z.final m"));
    EXPECT_THAT(
        names_of(HistoryFigures({}, kChannels, std::nullopt)),
        ElementsAre("bolt1.force.z.peak N", "bolt1.force.z.final N", "bolt2.force.z.peak N", "bolt2.force.z.final N"));
    EXPECT_THROW(HistoryFigures({"bolt1.force.z:peek"}, kChannels, std::nullopt), Error);
    EXPECT_THROW(HistoryFigures({"screw*"}, kChannels, std::nullopt), Error);
}

// Oracle: by hand.
TEST(FiguresOfAHistory, FormulasOverChannels) {
    HistoryFigures figures({"lift = bolt1.force.z + bolt2.force.z: peak, final", "work = bolt1.force.z*plate.position.z",
                            "worst = bolt1.force.z > bolt2.force.z ? bolt1.force.z : bolt2.force.z"},
                           kChannels, std::nullopt);
    EXPECT_THAT(names_of(figures), ElementsAre("lift.peak N", "lift.final N", "work.peak SI", "work.final SI",
                                               "worst.peak SI", "worst.final SI"));
    figures.take_row(std::vector<double>{0, 2, 3, 0.5});
    figures.take_row(std::vector<double>{1, -4, 1, 2});
    EXPECT_THAT(figures.values(), ElementsAre(5, -3, 8, -8, 3, 1));
    for (const char* wrong :
         {"lift = 3", "lift = bolt1.force.z + bolt9.force.z", "bolt1.force.z = 3", "lift = bolt1.force.z +"})
        EXPECT_THROW(HistoryFigures({wrong}, kChannels, std::nullopt), Error) << wrong;
    EXPECT_THROW(HistoryFigures({"a = bolt1.force.z", "a = bolt2.force.z"}, kChannels, std::nullopt), Error);
}

TEST(FiguresOfAHistory, RowsOfAFewChannels) {
    HistoryFigures figures({"plate:final"}, kChannels, std::vector<int>{0, 3});
    figures.take_row(std::vector<double>{0, 8});
    EXPECT_THAT(figures.values(), ElementsAre(8));
    EXPECT_THROW(HistoryFigures({"bolt1"}, kChannels, std::vector<int>{0, 3}), Error);
}

}  // namespace
}  // namespace dttmm::host
