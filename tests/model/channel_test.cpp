// SPDX-License-Identifier: BSD-3-Clause
#include "model/channel.h"

#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

using Of = Channel::Of;

TEST(Channel, IsNamedByWhatItIs) {
    const Channel whole = Channel(Of::marker, "plate.tip", "velocity", "x", "m/s");
    EXPECT_EQ(whole.name(), "plate.tip.velocity.x");
    EXPECT_EQ(whole.owner(), "plate.tip");
    EXPECT_EQ(whole.quantity(), "velocity");
    EXPECT_EQ(whole.axis(), "x");
    EXPECT_EQ(whole.without_axis(), "plate.tip.velocity");
    EXPECT_EQ(whole.name_in_owner(), "velocity.x");
    const Channel scalar = Channel(Of::energy, "energy", "residual", "", "J");
    EXPECT_EQ(scalar.name(), "energy.residual");
    EXPECT_EQ(scalar.quantity(), "residual");
    EXPECT_EQ(scalar.name_in_owner(), "residual");
    EXPECT_EQ(scalar.axis(), "");
    const Channel nobody{"time", "s"};
    EXPECT_EQ(nobody.name(), "time");
    EXPECT_EQ(nobody.owner(), "");
    EXPECT_EQ(nobody.axis(), "");
}

}  // namespace
}  // namespace dttmm::host
