// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/stability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/models.h"

namespace dttmm {
namespace {

FastestMode fastest_of(const Model& model, const Plugins& plugins) {
    const World world(model.bodies);
    std::vector<BodyState> at(model.bodies.size());
    world.read_states(at);
    Networks networks(model, plugins);
    return find_fastest_mode(model, networks, at);
}

// Oracle: closed form of the symmetric plate: ω² = 4k/m in translation, 4k y²/Jx about x, 4k x²/Jy, 4k (x² + y²)/Jz.
TEST(Stability, FastestModeOfThePlateIsItsClosedForm) {
    const Plugins plugins;
    const double k = 5e5, m = test::kPlateMass;
    const Model model = test::plate_stack(plugins, 1, k, 100, 1e-3, Coupling::implicit);
    const double about_x = 4 * k * 0.08 * 0.08 / (m / 12 * (0.04 + 4e-4)),
                 about_y = 4 * k * 0.13 * 0.13 / (m / 12 * (0.09 + 4e-4)),
                 about_z = 4 * k * (0.13 * 0.13 + 0.08 * 0.08) / (m / 12 * 0.13);
    const FastestMode fastest = fastest_of(model, plugins);
    EXPECT_NEAR(fastest.omega, std::sqrt(std::max({4 * k / m, about_x, about_y, about_z})), 1e-4 * fastest.omega);
    EXPECT_EQ(fastest.body, "plate1");
}

// Oracle: the same plate turned and moved as a whole has the same frequencies.
TEST(Stability, FastestModeDoesNotDependOnTheFrame) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 3, 5e5, 100, 1e-3, Coupling::implicit);
    const double upright = fastest_of(model, plugins).omega;
    const Eigen::Matrix3d R = Eigen::AngleAxisd(1.3, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
    for (Body& body : model.bodies) {
        body.position = Eigen::Vector3d(3, -1, 2) + R * body.position;
        body.rotation = R;
    }
    EXPECT_NEAR(fastest_of(model, plugins).omega, upright, 1e-4 * upright);
}

TEST(Stability, NothingElasticHasNoFastestMode) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 2, 5e5, 100, 1e-3, Coupling::implicit);
    model.elements.clear();
    EXPECT_EQ(fastest_of(model, plugins).omega, 0);
}

}  // namespace
}  // namespace dttmm
