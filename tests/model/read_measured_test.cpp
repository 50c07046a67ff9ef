// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_measured.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

TEST(ReadMeasured, ChannelsWithSignUnitGainAndDelay) {
    const MeasuredSettings measured = parse(model_with(R"([measured]
file = "blow.csv"
input = "plate.a.z"
noise = "1 %"
averages = 8
clock = 1.019
channel = [
  { column = "ch1", is = " -plate.a.acceleration.z ", unit = "g", gain = 1.02, delay = "0.1 ms", noise = "0.2 m/s^2" },
  { column = "ch 2", is = "plate.velocity.x" },
]
)"))
                                          .measured;
    EXPECT_EQ(measured.file.filename(), "blow.csv");
    EXPECT_EQ(measured.input, "plate.a.z");
    EXPECT_EQ(measured.noise, "1 %");
    EXPECT_EQ(measured.averages, 8);
    EXPECT_EQ(measured.clock, 1.019);
    ASSERT_EQ(measured.channels.size(), 2u);
    const MeasuredChannel& first = measured.channels[0];
    EXPECT_EQ(first.column, "ch1");
    EXPECT_EQ(first.channel, "plate.a.acceleration.z");
    EXPECT_TRUE(first.is_reversed);
    EXPECT_EQ(first.unit, "g");
    EXPECT_EQ(first.gain, 1.02);
    EXPECT_EQ(first.delay, 1e-4);
    EXPECT_EQ(first.noise, "0.2 m/s^2");
    EXPECT_EQ(measured.channels[1].column, "ch 2");
    EXPECT_FALSE(measured.channels[1].is_reversed);
    EXPECT_EQ(measured.channels[1].gain, 1);
}

TEST(ReadMeasured, FaultsNameTheirPlace) {
    const auto fault = [](const std::string& rest) { return errors_of(model_with("[measured]\n" + rest)); };
    EXPECT_THAT(fault("channel = [{ column = \"a\", is = \"b\" }, { column = \"a\", is = \"c\" }]\n"),
                AllOf(HasSubstr("m.toml:13:"), HasSubstr("has a channel already")));
    EXPECT_THAT(fault("channel = [{ is = \"b\" }]\n"), HasSubstr("column"));
    EXPECT_THAT(fault("averages = 2.5\n"), AllOf(HasSubstr("m.toml:13:"), HasSubstr("whole")));
    EXPECT_THAT(fault("channel = [{ column = \"a\", is = \"b\", unit = \"furl\" }]\n"), HasSubstr("furl"));
    EXPECT_THAT(fault("clock = 7\n"), HasSubstr("clock"));
    EXPECT_THAT(fault("files = \"a\"\n"), HasSubstr("did you mean \"file\""));
}

}  // namespace
}  // namespace dttmm::host
