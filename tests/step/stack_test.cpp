// SPDX-License-Identifier: BSD-3-Clause
//
// A stack of plates, each bolted to the one below by four bolts, pulled at the top: several coupled bodies against the exact
// modal solution of the axial chain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "step/simulation.h"
#include "support/exact_chain.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

/// Largest error of a plate's position at `end`, as a share of the static stretch of the stack.
double stack_error(int count, double step, Coupling coupling) {
    const Plugins plugins;
    const double k = 5e5, c = 100, end = 0.1;
    const Model model = test::plate_stack(plugins, count, k, c, step, coupling);
    Simulation simulation(model, plugins);
    while (simulation.time() < end - 0.5 * step) simulation.step();
    const Eigen::VectorXd exact = test::exact_chain(count, k, c, end);
    double worst = 0;
    for (int p = 0; p < count; ++p) {
        const auto i = static_cast<size_t>(p);
        worst = std::max(worst, std::abs(simulation.bodies()[i].position.z() - model.bodies[i].position.z() - exact(p)));
    }
    return worst / (1000 * count / (4 * k));
}

TEST(Stack, FollowsTheExactChainToSecondOrder) {
    for (int count : {1, 3, 10}) {
        for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
            const double coarse = stack_error(count, 2e-4, coupling), fine = stack_error(count, 1e-4, coupling);
            EXPECT_LT(coarse, 1e-3) << count;
            EXPECT_NEAR(coarse / fine, 4, 0.6) << count;
        }
    }
}

TEST(Stack, AHundredPlatesHoldTheirTolerance) { EXPECT_LT(stack_error(100, 5e-4, Coupling::implicit), 2e-4); }

// Oracle: bits. The order in which the elements stand in the file does not decide which bodies they hold: the same stack
// with its elements reversed gives the same motion to rounding.
TEST(Stack, OrderOfTheElementsDoesNotMatter) {
    const Plugins plugins;
    const Model model = test::plate_stack(plugins, 4, 5e5, 100, 1e-3, Coupling::implicit);
    Model reversed = model;
    std::reverse(reversed.elements.begin(), reversed.elements.end());
    Simulation a(model, plugins), b(reversed, plugins);
    for (int n = 0; n < 50; ++n) {
        a.step();
        b.step();
    }
    for (size_t p = 0; p < 4; ++p) EXPECT_LT((a.bodies()[p].position - b.bodies()[p].position).norm(), 1e-14);
}

}  // namespace
}  // namespace dttmm::host
