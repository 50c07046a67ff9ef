// SPDX-License-Identifier: BSD-3-Clause
#include "world/world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/error.h"
#include "support/bodies.h"
#include "support/shake.h"

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

// Both futures of a saved world agree to the bit: that of the world that was saved, and the one it is restored to. Chain of
// a hinge, a ball and a slider on stops, with forces; also a free body. Setting poses that were merely read would not do:
// ODE normalises every quaternion that is set.
TEST(World, RestoredWorldRepeatsItsFutureToTheBit) {
    std::vector<Body> bodies;
    for (int i = 0; i < 4; ++i) {
        bodies.push_back(ugly_body());
        bodies.back().position = Eigen::Vector3d(1, 2, 3) + 0.4 * i * Eigen::Vector3d(1, -1, 0.5);
        bodies.back().velocity.setZero();
        bodies.back().angular_velocity.setZero();
    }
    std::vector<Joint> joints(3);
    joints[0] = test::pin("hinge", -1, 0, {0.9, 2, 3}, {0, 0.6, 0.8});
    joints[0].limits = {-0.2, 0.3};
    joints[1] = test::pin("ball", 0, 1, {1.2, 1.8, 3.1}, {1, 0, 0});
    joints[1].type = JointType::ball;
    joints[2] = test::pin("slider", 1, 2, {1.6, 1.4, 3.3}, {0.6, 0, 0.8});
    joints[2].type = JointType::slider;
    joints[2].limits = {-0.01, 0.02};
    World world(bodies, joints);
    std::vector<BodyState> state(4);
    std::vector<Wrench> wrenches(4);
    bool stop_acted = false;
    const auto run = [&](int from, int steps) {
        std::vector<std::vector<BodyState>> path;
        for (int n = from; n < from + steps; ++n) {
            for (size_t b = 0; b < 4; ++b)
                wrenches[b] << 9.0 * std::sin(0.01 * n), -4, -20.0 + 3.0 * static_cast<double>(b), 0.1, 0.2, -0.3;
            world.apply(wrenches);
            world.read_states(state);
            std::vector<Stop> stops(3);
            world.find_stops(2e-3, stops);
            world.advance(2e-3, test::shake(bodies, joints, state, stops, wrenches, 2e-3));
            world.read_states(state);
            path.push_back(state);
            for (const Stop& stop : world.stops()) stop_acted = stop_acted || stop.acts;
        }
        return path;
    };
    run(0, 700);
    World::Saved saved;
    world.save(saved);
    const auto first = run(700, 1500);
    world.restore(saved);
    const auto second = run(700, 1500);
    EXPECT_TRUE(stop_acted);
    for (size_t n = 0; n < first.size(); ++n)
        for (size_t b = 0; b < 4; ++b) {
            ASSERT_EQ(first[n][b].position, second[n][b].position) << "step " << n << ", body " << b;
            ASSERT_EQ(first[n][b].rotation, second[n][b].rotation) << "step " << n << ", body " << b;
            ASSERT_EQ(first[n][b].velocity, second[n][b].velocity) << "step " << n << ", body " << b;
            ASSERT_EQ(first[n][b].angular_velocity, second[n][b].angular_velocity) << "step " << n << ", body " << b;
        }
}

}  // namespace
}  // namespace dttmm::host
