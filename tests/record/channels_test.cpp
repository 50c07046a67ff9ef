// SPDX-License-Identifier: BSD-3-Clause
#include "record/channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/error_matcher.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Of = Channel::Of;

const std::vector<Channel> kChannels{
    {"time", "s"},                                              // 0
    Channel(Of::element, "bolt1", "force", "x", "N"),           // 1
    Channel(Of::element, "bolt1", "force", "y", "N"),           // 2
    Channel(Of::element, "bolt1", "moment", "x", "N m"),        // 3
    Channel(Of::element, "bolt2", "force", "x", "N"),           // 4
    Channel(Of::body, "plate", "position", "x", "m"),           // 5
    Channel(Of::marker, "plate.tip", "velocity", "x", "m/s"),   // 6
    Channel(Of::body, "plate2", "position", "x", "m"),          // 7
    Channel(Of::energy, "energy", "residual", "", "J", false),  // 8
};

// Oracle for all selections: the rule of the header, applied by hand to the nine channels above.
TEST(SelectChannels, WithoutPatternsTakesTheDefaults) {
    EXPECT_THAT(select_channels(kChannels, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

TEST(SelectChannels, APatternMayStopAtADot) {
    EXPECT_THAT(select_channels(kChannels, {"bolt*.force"}), ElementsAre(0, 1, 2, 4));
    EXPECT_THAT(select_channels(kChannels, {"plate"}), ElementsAre(0, 5, 6));
    EXPECT_THAT(select_channels(kChannels, {"plate.tip"}), ElementsAre(0, 6));
}

TEST(SelectChannels, GlobsMatchWholeNames) {
    EXPECT_THAT(select_channels(kChannels, {"bolt?.force.x"}), ElementsAre(0, 1, 4));
    EXPECT_THAT(select_channels(kChannels, {"bolt[2-9].*"}), ElementsAre(0, 4));
    EXPECT_THAT(select_channels(kChannels, {"*"}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
    EXPECT_THAT(select_channels(kChannels, {"time"}), ElementsAre(0));
}

TEST(SelectChannels, KeepsTheOrderOfTheChannelsAndRepeatsNone) {
    EXPECT_THAT(select_channels(kChannels, {"energy", "bolt1.force.y", "bolt1"}), ElementsAre(0, 1, 2, 3, 8));
}

TEST(SelectChannels, APatternForNothingIsAnErrorThatHelps) {
    expect_error(
        [] {
            select_channels(kChannels, {"plate", "bolt*.forces"});
        },
        ExitCode::model_invalid,
        AllOf(HasSubstr("\"bolt*.forces\""), HasSubstr("nearest is \"bolt1.force\""),
              HasSubstr("Available: time, bolt1.force, bolt1.moment, bolt2.force, plate.position")));
    expect_error([] { select_channels(kChannels, {"plte.position"}); }, ExitCode::model_invalid,
                 HasSubstr("nearest is \"plate.position\""));
    for (const char* pattern : {"", "bolt", "force", ".", "bolt1.", "[", "TIME"})
        expect_error([&] { select_channels(kChannels, {pattern}); }, ExitCode::model_invalid,
                     HasSubstr("matches no channel"));
}

TEST(SelectChannels, ALongListIsShortened) {
    std::vector<Channel> many{{"time", "s"}};
    for (int i = 0; i < 500; ++i) many.push_back(Channel(Of::node, "node" + std::to_string(i), "position", "x", "m"));
    expect_error([&] { select_channels(many, {"beam"}); }, ExitCode::model_invalid,
                 AllOf(HasSubstr("node10.position and 489 more"), Not(HasSubstr("node11.position"))));
}

}  // namespace
}  // namespace dttmm::host
