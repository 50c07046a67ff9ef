// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/summary.h"

#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

using Of = Channel::Of;

// What the summary, the table and the warnings of a run ask a recorder for, whatever it belongs to: a plugin may give a node
// a force.
TEST(Summary, CountsWhatARunTells) {
    for (const Of of : {Of::element, Of::joint, Of::node, Of::body, Of::marker}) {
        for (const char* quantity : {"force", "moment", "angle", "travel", "length", "position", "acceleration"})
            EXPECT_EQ(counts_in_summary(Channel(of, "part", quantity, "x", "N")), Recorder::Counts::peak) << quantity;
        for (const char* quantity : {"deflection", "rotation", "velocity", "quaternion", "section3.force"})
            EXPECT_EQ(counts_in_summary(Channel(of, "part", quantity, "x", "N")), Recorder::Counts::nothing) << quantity;
    }
    for (const char* quantity : {"kinetic", "residual"})
        EXPECT_EQ(counts_in_summary(Channel(Of::energy, "energy", quantity, "", "J")), Recorder::Counts::extremes)
            << quantity;
}

}  // namespace
}  // namespace dttmm::host
