// SPDX-License-Identifier: BSD-3-Clause
//
// Random machines in time: what holds for all of them.
#include <gtest/gtest.h>

#include "model/error.h"
#include "support/random_machine.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using test::Placement;
using test::RandomMachine;
using test::RecordedRun;

constexpr uint64_t kMachines = 60;
constexpr int kShort = 25;  // steps

// Oracle: objectivity. A machine that stands elsewhere, turned as a whole, moves in the same way, turned. What is left of
// the difference is what the solver leaves over: a millionth of what a step changes.
TEST(RandomMachines, MoveInTheSameWayWhereverTheyStand) {
    const Placement elsewhere{Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix(),
                              Eigen::Vector3d(2, -1.5, 1)};
    size_t compared = 0;
    for (uint64_t seed = 1; seed <= kMachines; ++seed) {
        try {
            const RecordedRun here(RandomMachine(seed, kShort).text()), there(RandomMachine(seed, kShort, elsewhere).text());
            double largest = 0, apart = 0;
            for (size_t n = 0; n < here.count(); ++n)
                for (int b = 0; here.has(fmt::format("b{}.position.x", b)); ++b) {
                    const std::string channel = fmt::format("b{}.position", b);
                    const Eigen::Vector3d way = here.vector(n, channel) - here.vector(0, channel),
                                          other = there.vector(n, channel) - there.vector(0, channel);
                    largest = std::max(largest, way.norm());
                    apart = std::max(apart, (elsewhere.turn * way - other).norm());
                }
            EXPECT_LT(apart, 1e-6 * largest + 1e-14) << seed << ": of " << largest << " m";
            ++compared;
        } catch (const Error&) {  // a rigid direction that both its ends hold
        }
    }
    EXPECT_GT(compared, kMachines * 9 / 10);
}

}  // namespace
}  // namespace dttmm::host
