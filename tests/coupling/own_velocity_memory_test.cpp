// SPDX-License-Identifier: BSD-3-Clause
//
// Why a scheme must not run on its own velocity memory under ODE (theory 1.4), shown with ODE itself: the paper keeps the
// previous position and velocity in static variables, and its Fox-Euler velocity is then a recursion of its own.
#include <gtest/gtest.h>

#include <cmath>

#include "core/discretisation.h"
#include "support/models.h"
#include "world/world.h"

namespace dttmm::host {
namespace {

using plugin::fox_euler, plugin::History, plugin::Vector6;

constexpr double kMass = 50, kStiffness = 5e5 * 4, kDamping = 100 * 4, kStep = 1e-3;  // the seed's bolts under 50 kg

/// Largest |x| of a body on four bolts in ODE in the later half of `steps`, ended early where it exceeds 1 m; the bolts'
/// velocity by Fox-Euler, its previous velocity either its own last result or the host's: the mean of ODE's velocities over
/// the two steps around t_{n−1}.
double amplitude_after(int steps, bool own_memory) {
    World world({test::box("plate", kMass, {0.3, 0.2, 0.1}, {1e-6, 0, 0})});
    std::vector<BodyState> now(1), before(1), two_before(1);
    world.read_states(now);
    before = two_before = now;
    double own_velocity = 0, largest_late = 0;
    for (int n = 0; n < steps && std::abs(now[0].position.x()) < 1; ++n) {
        History past;
        for (auto* list : {&past.x, &past.v, &past.a}) list->fill(Vector6::Zero());
        past.x[0](0) = before[0].position.x();
        past.v[0](0) = own_memory ? own_velocity : (now[0].position.x() - two_before[0].position.x()) / (2 * kStep);
        Vector6 x = Vector6::Zero();
        x(0) = now[0].position.x();
        const double v = fox_euler(past, kStep).velocity(x)(0);
        own_velocity = v;

        Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
        wrench(0) = -kStiffness * now[0].position.x() - kDamping * v;
        world.apply({wrench});
        world.advance(kStep);
        two_before = before;
        before = now;
        world.read_states(now);
        if (n > steps / 2) largest_late = std::max(largest_late, std::abs(now[0].position.x()));
    }
    return std::max(largest_late, std::abs(now[0].position.x()));
}

// Oracle: the sign-alternating error grows by about c h/m = 0.8 % a step, a factor of about 3000 in a second; 6 s are far
// beyond any doubt, while the true motion has decayed as exp(−c t/2m) to nothing.
TEST(OwnVelocityMemory, GrowsWithoutBoundUnderOde) {
    EXPECT_GT(amplitude_after(6000, true), 1e-3);
    EXPECT_LT(amplitude_after(6000, false), 1e-9);
}

}  // namespace
}  // namespace dttmm::host
