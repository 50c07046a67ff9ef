// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_closure.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "support/bodies.h"
#include "support/shake.h"
#include "world/rotation_step.h"
#include "world/world.h"

namespace dttmm::host {
namespace {

constexpr double kGravity = 9.81;

/// Two rods hanging from each other and from the ground, thrown: centre of mass of each half way along it.
struct DoublePendulum {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3;
    const Eigen::Vector3d along = axis.unitOrthogonal();
    std::vector<Body> bodies = {test::box("upper", 2.3, {0.6, 0.05, 0.04}, 0.3 * along),
                                test::box("lower", 1.1, {0.8, 0.03, 0.05}, 1.0 * along)};
    std::vector<Joint> joints = {test::pin("pin", -1, 0, {0, 0, 0}, axis), test::pin("pin", 0, 1, 0.6 * along, axis)};
    DoublePendulum() {
        for (Body& body : bodies) {
            body.rotation.col(0) = along;
            body.rotation.col(1) = axis.cross(along);
            body.rotation.col(2) = axis;
        }
    }
    Eigen::Vector3d down() const { return axis.cross(along); }

    /// Of one step: gravity acts; kinetic energy over the step and mean potential energy at its ends.
    double step(World& world, std::vector<BodyState>& state, double h) const {
        std::vector<Eigen::Matrix<double, 6, 1>> weights(2);
        double energy = 0;
        for (size_t b = 0; b < 2; ++b) {
            weights[b] << bodies[b].mass * kGravity * down(), Eigen::Vector3d::Zero();
            energy -= 0.5 * bodies[b].mass * kGravity * down().dot(state[b].position);
        }
        world.apply(weights);
        const std::vector<BodyState> exact = test::shake(bodies, joints, state, weights, h);
        world.advance(h, exact);
        world.read_states(state);
        for (size_t b = 0; b < 2; ++b) {
            // ODE and the closure together make the motion of the scheme: ODE's joints carry, nothing else is changed
            EXPECT_LT((state[b].velocity - exact[b].velocity).norm(), 1e-10);
            EXPECT_LT((state[b].angular_velocity - exact[b].angular_velocity).norm(), 1e-10);
            const Eigen::Vector3d w = state[b].rotation.transpose() * state[b].angular_velocity;
            energy += 0.5 * bodies[b].mass * state[b].velocity.squaredNorm() + 0.5 * w.dot(bodies[b].inertia * w);
            energy -= 0.5 * bodies[b].mass * kGravity * down().dot(state[b].position);
        }
        return energy;
    }
};

// SHAKE keeps the energy of a conservative machine within the scheme's order for ever; ODE's joints alone let it drift and
// stand open by h² |C̈|/2. The energy turned over is m g l ~ 20 J; a chaotic motion over 30 s.
TEST(JointClosure, KeepsJointsClosedAndEnergyFromDrifting) {
    const DoublePendulum machine;
    double error[2] = {0, 0};
    for (int halving = 0; halving < 2; ++halving) {
        const double h = 2e-3 / (1 << halving);
        World world(machine.bodies, machine.joints);
        std::vector<BodyState> state(2);
        world.read_states(state);
        const double first = machine.step(world, state, h);
        const std::vector<JointEquations> equations = {{machine.joints[0], machine.bodies},
                                                       {machine.joints[1], machine.bodies}};
        double early = 0, late = 0;
        for (int n = 1; n * h < 30; ++n) {
            const double energy = machine.step(world, state, h) - first;
            error[halving] = std::max(error[halving], std::abs(energy));
            if (n * h < 5) early = std::max(early, std::abs(energy));
            if (n * h > 25) late = std::max(late, std::abs(energy));
            for (const JointEquations& joint : equations) {
                ASSERT_LT(joint.residual(state).cwiseAbs().maxCoeff(), 5e-15) << "step " << n;
            }
        }
        EXPECT_LT(late, 3 * early);
    }
    EXPECT_LT(error[0], 2e-2);
    EXPECT_LT(error[1], 0.4 * error[0]);  // second order, but the two motions part: chaos
}

// Oracle: the exact motion of a disc turning about a pin off its centre without forces: constant speed. ODE alone would hold
// the centre h² ω² r/2 too far out.
TEST(JointClosure, SteadyTurningIsExact) {
    const Eigen::Vector3d axis = Eigen::Vector3d(2, -1, 2) / 3;
    Body disc = test::box("disc", 5, {0.3, 0.3, 0.3}, {0, 0, 0});
    const Eigen::Vector3d anchor = 0.4 * axis.unitOrthogonal();
    const double omega = 40;
    disc.angular_velocity = omega * axis;
    disc.velocity = disc.angular_velocity.cross(-anchor);
    const Joint pin = test::pin("pin", -1, 0, anchor, axis);
    World world({disc}, {pin});
    std::vector<BodyState> state(1);
    world.read_states(state);
    const double h = 1e-3;
    // The leap-frog speed over a step is that of the chord
    const double chord = std::sin(omega * h / 2) / (omega * h / 2);
    state[0].velocity = RotationStep(-0.5 * h * disc.angular_velocity).apply(disc.velocity) * chord;
    world.set_states(state);
    for (int n = 1; n <= 2000; ++n) {
        const std::vector<Eigen::Matrix<double, 6, 1>> none(1, Eigen::Matrix<double, 6, 1>::Zero());
        world.apply(none);
        world.advance(h, test::shake({disc}, {pin}, state, none, h));
        world.read_states(state);
        ASSERT_NEAR((state[0].position - anchor).norm(), 0.4, 1e-15);
        ASSERT_NEAR(state[0].angular_velocity.norm(), omega, 1e-10);  // rounding of the position over h, 2000 times
    }
    const Eigen::Vector3d expected = anchor + Eigen::AngleAxisd(2000 * h * omega, axis) * Eigen::Vector3d(-anchor);
    EXPECT_LT((state[0].position - expected).norm(), 1e-10);
}

// Four hinges of a plane linkage hold three equations too many; they must close all the same, in any plane.
TEST(JointClosure, RedundantJointsClose) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3, x = axis.unitOrthogonal(), y = axis.cross(x);
    const auto link = [&](const char* name, double m, double length, const Eigen::Vector3d& from,
                          const Eigen::Vector3d& to) {
        Body body = test::box(name, m, {length, 0.02, 0.03}, 0.5 * (from + to));
        body.rotation.col(0) = (to - from).normalized();
        body.rotation.col(2) = axis;
        body.rotation.col(1) = axis.cross(body.rotation.col(0));
        return body;
    };
    const Eigen::Vector3d A(0, 0, 0), B = 0.3 * y, C = 0.9 * x + 0.5 * y, D = 0.8 * x;
    std::vector<Body> bodies = {link("crank", 0.7, 0.3, A, B), link("coupler", 1.9, (C - B).norm(), B, C),
                                link("rocker", 1.3, (D - C).norm(), C, D)};
    const std::vector<Joint> joints = {test::pin("pin", -1, 0, A, axis), test::pin("pin", 0, 1, B, axis),
                                       test::pin("pin", 1, 2, C, axis), test::pin("pin", 2, -1, D, axis)};
    World world(bodies, joints);
    std::vector<BodyState> state(3);
    world.read_states(state);
    std::vector<Eigen::Matrix<double, 6, 1>> pull(3, Eigen::Matrix<double, 6, 1>::Zero());
    for (int n = 0; n < 3000; ++n) {
        pull[1] << 20 * std::cos(7e-3 * n) * x + 30 * y, 0.3 * axis;
        world.apply(pull);
        world.advance(1e-3, test::shake(bodies, joints, state, pull, 1e-3));
        world.read_states(state);
        for (const Joint& joint : joints) {
            const JointEquations equations(joint, bodies);
            ASSERT_LT(equations.residual(state).cwiseAbs().maxCoeff(), 5e-15) << "step " << n;
        }
    }
    EXPECT_GT((state[0].position - bodies[0].position).norm(), 0.05);  // it has moved
}

}  // namespace
}  // namespace dttmm::host
