// SPDX-License-Identifier: BSD-3-Clause
#include "world/world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/error.h"
#include "support/bodies.h"

namespace dttmm::host {
namespace {

using Wrench = Eigen::Matrix<double, 6, 1>;

Body ugly_body() {
    Body body;
    body.name = "ugly";
    body.mass = 3.7;
    body.center_of_mass = {0.1, -0.2, 0.05};
    body.inertia << 0.3, 0.02, -0.01, 0.02, 0.5, 0.03, -0.01, 0.03, 0.6;
    body.position = {1, 2, 3};
    body.rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix();
    body.velocity = {0.3, 0.1, -0.2};
    body.angular_velocity = {1, -2, 0.5};
    return body;
}

// Oracle: rigid-body kinematics. ODE's reference point is the centre of mass.
TEST(World, PlacesTheCentreOfMass) {
    const Body body = ugly_body();
    const World world({body});
    std::vector<BodyState> state(1);
    world.read_states(state);
    const Eigen::Vector3d arm = body.rotation * body.center_of_mass;
    EXPECT_LT((state[0].position - body.position - arm).norm(), 1e-15);
    EXPECT_LT((state[0].velocity - body.velocity - body.angular_velocity.cross(arm)).norm(), 1e-15);
    EXPECT_LT((state[0].rotation - body.rotation).norm(), 1e-15);
}

// Oracle: the integrator by hand: v+ = v + h f/m, x+ = x + h v+, ω+ = ω + h I⁻¹ m, R+ = exp(h ω+) R. No gravity, no damping
// and no gyroscopic term of ODE's own may be in it.
TEST(World, AdvancesByTheLeapFrogFormula) {
    const Body body = ugly_body();
    World world({body});
    std::vector<BodyState> before(1), after(1);
    world.read_states(before);
    const double h = 1.7e-3;
    Wrench wrench;
    wrench << 50, -20, 70, 3, 8, -5;
    world.apply({wrench});
    world.advance(h);
    world.read_states(after);

    const Eigen::Matrix3d I = body.rotation * body.inertia * body.rotation.transpose();
    const Eigen::Vector3d v = before[0].velocity + h / body.mass * wrench.head<3>();
    const Eigen::Vector3d w = before[0].angular_velocity + h * I.inverse() * wrench.tail<3>();
    EXPECT_LT((after[0].velocity - v).norm(), 1e-15);
    EXPECT_LT((after[0].angular_velocity - w).norm(), 1e-14);
    EXPECT_LT((after[0].position - before[0].position - h * v).norm(), 1e-15);
    EXPECT_LT((after[0].rotation - Eigen::AngleAxisd(h * w.norm(), w.normalized()) * before[0].rotation).norm(), 1e-14);

    world.advance(h);  // what was applied acts over one step only
    std::vector<BodyState> later(1);
    world.read_states(later);
    EXPECT_EQ(later[0].velocity, after[0].velocity);
}

TEST(World, NothingBadReachesOde) {
    World world({ugly_body()});
    for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e16}) {
        for (int i = 0; i < 6; ++i) {
            Wrench wrench = Wrench::Zero();
            wrench(i) = bad;
            EXPECT_THROW(world.apply({wrench}), Error) << bad << " in component " << i;
        }
    }
    std::vector<BodyState> state(1);
    world.read_states(state);
    state[0].velocity.y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(world.set_states(state), Error);
    world.apply({Wrench::Zero()});
    world.advance(1e-3);
    world.read_states(state);
    EXPECT_TRUE(state[0].position.allFinite());
}

// ODE asserts on this mass and would abort the process: our handler turns it into an error.
TEST(World, AnAssertionOfOdeIsAnError) {
    Body body = ugly_body();
    body.mass = -1;
    try {
        const World world({body});
        FAIL() << "ODE accepted a negative mass";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::internal_error);
    }
}

TEST(World, WorldsComeAndGo) {
    for (int i = 0; i < 100; ++i) {
        World first({ugly_body()}), second({ugly_body(), ugly_body()});
        first.advance(1e-3);
        second.advance(1e-3);
    }
}

}  // namespace
}  // namespace dttmm::host
