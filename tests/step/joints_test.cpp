// SPDX-License-Identifier: BSD-3-Clause
// Bodies on ODE joints, coupled with networks: machines whose motion is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <random>

#include "model/diagnostics.h"
#include "step/simulation.h"
#include "support/adaptive_ode.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

/// All machines stand askew in space: x, y in the plane of the motion, z the axis of the hinges.
const Eigen::Vector3d kZ = Eigen::Vector3d(1, 2, -2) / 3, kX = kZ.unitOrthogonal(), kY = kZ.cross(kX);
Eigen::Vector3d at(double x, double y, double z = 0) { return x * kX + y * kY + z * kZ; }

/// A rod in the plane from a to b; markers at its ends.
Body rod(const std::string& name, double mass, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double length = (b - a).norm();
    Body body = test::box(name, mass, {length, 0.03, 0.02}, 0.5 * (a + b));
    body.rotation.col(0) = (b - a) / length;
    body.rotation.col(2) = kZ;
    body.rotation.col(1) = kZ.cross(body.rotation.col(0));
    for (int end : {-1, 1}) {
        Marker marker;
        marker.name = end < 0 ? "a" : "b";
        marker.position.x() = 0.5 * end * length;
        body.markers.push_back(marker);
    }
    return body;
}

/// Sets the body turning at omega about the point p.
void turn(Body& body, const Eigen::Vector3d& p, double omega) {
    body.angular_velocity = omega * kZ;
    body.velocity = body.angular_velocity.cross(body.position - p);
}

/// All rows of a run as channel → values.
struct History {
    std::map<std::string, std::vector<double>> channels;
    double passes_per_step;
    const std::vector<double>& operator[](const std::string& name) const { return channels.at(name); }
    double largest(const std::string& name) const {
        double most = 0;
        for (double value : channels.at(name)) most = std::max(most, std::abs(value));
        return most;
    }
};

History run(Model model, const Plugins& plugins, double step, double duration) {
    model.simulation.step = step;
    model.simulation.duration = duration;
    Simulation simulation(model, plugins);
    History history;
    simulation.record_to([&](std::span<const double> row) {
        for (size_t c = 0; c < row.size(); ++c) history.channels[simulation.channels()[c].name()].push_back(row[c]);
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    const auto steps = static_cast<double>(simulation.index());
    history.passes_per_step = static_cast<double>(simulation.end_of_step().passes()) / steps;
    return history;
}

constexpr double kRodLength = 0.8;

/// A rod on a hinge, its far end held by a spring-damper; it starts with speed.
Model pendulum(const Plugins& plugins, double k, double c, double omega, const Eigen::Vector3d& gravity = {0, 0, 0}) {
    Model model;
    model.simulation.gravity = gravity;
    model.bodies.push_back(rod("rod", 2.3, at(0, 0), at(kRodLength, 0)));
    turn(model.bodies[0], at(0, 0), omega);
    model.joints.push_back(test::pin("pin", -1, 0, at(0, 0), kZ));
    if (k > 0) model.elements.push_back(test::spring("bolt", plugins, {}, {0, 1}, k, c));
    return model;
}

double inertia_about_end(const Body& body) { return body.inertia(2, 2) + body.mass * kRodLength * kRodLength / 4; }

// Oracle: the closed solution of I θ'' + c l² θ' + k l² θ = 0 for small angles,
//     θ = ω₀/ω_d exp(−ζ ω t) sin ω_d t,
// at the stiffness of a real bolt. The angle stays below 1e-6, so that what is left out is below 1e-6 of it.
TEST(Joints, PendulumOnAStiffBoltFollowsTheClosedSolution) {
    const Plugins plugins;
    const double k = 4e8, c = 3e3, omega0 = 1e-3;
    const Model model = pendulum(plugins, k, c, omega0);
    const double I = inertia_about_end(model.bodies[0]), omega = std::sqrt(k * kRodLength * kRodLength / I);
    const double zeta = c * kRodLength * kRodLength / (2 * I * omega), damped = omega * std::sqrt(1 - zeta * zeta);
    double error[2];
    for (int halving = 0; halving < 2; ++halving) {
        const double h = 4e-6 / (1 << halving);  // omega h = 0.09
        const History history = run(model, plugins, h, 2e-3);
        error[halving] = 0;
        for (size_t n = 0; n < history["time"].size(); ++n) {
            const double t = history["time"][n];
            const double exact = omega0 / damped * std::exp(-zeta * omega * t) * std::sin(damped * t);
            error[halving] = std::max(error[halving], std::abs(history["pin.angle"][n] - exact) * damped / omega0);
        }
        EXPECT_LT(history.passes_per_step, 4);
    }
    EXPECT_LT(error[0], 2e-2);  // (omega h)²/24 of the phase, over seven periods
    EXPECT_NEAR(error[0] / error[1], 4, 0.1);
}

// Stable at any stiffness: omega h = 700. A force beside the joint's axis is carried by joint and bolt as statics has it:
// the bolt takes F a/l, the pin the rest.
TEST(Joints, StiffestBoltSharesAStaticLoad) {
    const Plugins plugins;
    Model model = pendulum(plugins, 4e11, 1e7, 0);
    Load load;
    load.on = {0, -1};  // half way along the rod
    load.direction = kY;
    load.signal = test::smooth_rise(700, 0.05);
    model.loads.push_back(load);
    const History history = run(model, plugins, 1e-3, 0.3);
    Eigen::Vector3d bolt, pin_force;
    for (int i = 0; i < 3; ++i) {
        bolt(i) = history[std::string("bolt.force.") + "xyz"[i]].back();
        pin_force(i) = history[std::string("pin.force.") + "xyz"[i]].back();
    }
    // Both are positive in tension, from the ground to the rod
    const double rounding = 4e11 * 1e-16 * 1000;      // of a position of 1 m, many times [N]
    bolt = (model.bodies[0].rotation * bolt).eval();  // its axes are those of the rod at the start
    EXPECT_LT((bolt - 350 * kY).norm(), rounding);
    EXPECT_LT((pin_force - 350 * kY).norm(), rounding);
}

// Oracle: error-controlled integration of I θ'' = −m g d sin θ − (spring's moment) to 1e-12; the spring, fixed where the end
// of the rod is at the start, pulls along the large arc. Second order.
TEST(Joints, PendulumAtLargeAnglesConvergesToTheSolutionInSecondOrder) {
    const Plugins plugins;
    const double k = 15, g = 9.81, omega0 = 3;
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        Model model = pendulum(plugins, k, 0, omega0, g * kX);
        model.simulation.coupling = coupling;
        const double I = inertia_about_end(model.bodies[0]), m = model.bodies[0].mass;
        const auto rate = [&](double, const Eigen::VectorXd& y) {
            // end of the rod at l (cos θ, sin θ), spring towards (l, 0): moment −k l² sin θ
            Eigen::VectorXd d(2);
            d << y(1), (-m * g * kRodLength / 2 * std::sin(y(0)) - k * kRodLength * kRodLength * std::sin(y(0))) / I;
            return d;
        };
        const Eigen::VectorXd exact = test::integrate(rate, Eigen::Vector2d(0, omega0), 5);
        double error[3];
        for (int halving = 0; halving < 3; ++halving) {
            const History history = run(model, plugins, 4e-3 / (1 << halving), 5);
            EXPECT_GT(history.largest("pin.angle"), 0.45);
            error[halving] = std::abs(history["pin.angle"].back() - exact(0));
        }
        EXPECT_LT(error[2], 1e-4);
        EXPECT_NEAR(error[0] / error[1], 4, 0.2);
        EXPECT_NEAR(error[1] / error[2], 4, 0.1);
    }
}

// Oracle: steady turning wants m ω² r from the pin, along the rod: tension. To the order of the scheme: (ω h)²/12.
TEST(Joints, PinCarriesTheCentripetalForce) {
    const Plugins plugins;
    const double omega = 21;
    const Model model = pendulum(plugins, 0, 0, omega);
    const History history = run(model, plugins, 1e-3, 0.5);
    const double expected = model.bodies[0].mass * omega * omega * kRodLength / 2;
    for (size_t n = 0; n < history["time"].size(); ++n) {
        Eigen::Vector3d force;
        for (int i = 0; i < 3; ++i) force(i) = history[std::string("pin.force.") + "xyz"[i]][n];
        const double angle = omega * history["time"][n];
        // on the ground: the pin is pulled outwards
        EXPECT_LT((force - expected * (std::cos(angle) * kX + std::sin(angle) * kY)).norm(), 1e-3 * expected) << n;
    }
}

enum class CouplerJoint { elastic, fixed };

/// Crank (hinge), a coupler of two halves joined elastically or by an ODE joint, and a piston (slider). It starts turning.
Model slider_crank(const Plugins& plugins, CouplerJoint joint, double stiffness) {
    const double r = 0.1, l = 0.35, omega = 30;
    const Eigen::Vector3d A = at(0, 0), B = at(0, r), C = at(std::sqrt(l * l - r * r), 0), M = 0.4 * B + 0.6 * C;
    Model model;
    model.bodies = {rod("crank", 1.7, A, B), rod("half1", 0.5, B, M), rod("half2", 0.8, M, C),
                    rod("piston", 1.1, C, C + at(0.07, 0))};
    // With the crank upright the coupler and the piston move along x without turning
    turn(model.bodies[0], A, omega);
    for (size_t b = 1; b < 4; ++b) model.bodies[b].velocity = at(-omega * r, 0);
    model.joints = {test::pin("main", -1, 0, A, kZ), test::pin("big_end", 0, 1, B, kZ), test::pin("small_end", 2, 3, C, kZ)};
    Joint guide = test::pin("guide", -1, 3, C, kX);
    guide.type = JointType::slider;
    model.joints.push_back(guide);
    if (joint == CouplerJoint::fixed) {
        Joint weld = test::pin("weld", 1, 2, M, kZ);
        weld.type = JointType::fixed;
        model.joints.push_back(weld);
    } else {
        Element element = test::spring("weld", plugins, {1, 1}, {2, 0}, stiffness, 0);
        for (int i = 6; i < 9; ++i) element.values.change()[static_cast<size_t>(i)] = stiffness * 1e-2;
        model.elements.push_back(element);
    }
    return model;
}

// Oracle: energy is conserved. A machine with redundant hinges, large turning and an elastic joint: over nine turns (2 s) it
// errs by no more than twice what it does over the first two, and halving the step leaves a quarter.
TEST(Joints, SliderCrankWithAnElasticCouplerKeepsItsEnergy) {
    const Plugins plugins;
    const Model model = slider_crank(plugins, CouplerJoint::elastic, 5e6);
    double largest[2];
    for (int halving = 0; halving < 2; ++halving) {
        const History history = run(model, plugins, 1e-4 / (1 << halving), 2);
        const std::vector<double>& residual = history["energy.residual"];
        double early = 0, late = 0;
        for (size_t n = 0; n < residual.size(); ++n) {
            if (n < residual.size() / 5) early = std::max(early, std::abs(residual[n]));
            late = std::max(late, std::abs(residual[n]));
        }
        EXPECT_LT(late, 2 * early);
        largest[halving] = late / history.largest("energy.kinetic");
    }
    EXPECT_LT(largest[0], 3e-3);
    EXPECT_NEAR(largest[0] / largest[1], 4, 0.8);
}

// The same machine with ODE's fixed joint and with a very stiff spring-damper in its place. The spring gives by F/k, some
// 7e-7 of the stroke; the rest of the difference falls with h².
TEST(Joints, FixedJointAndVeryStiffSpringAgree) {
    const Plugins plugins;
    const History fixed = run(slider_crank(plugins, CouplerJoint::fixed, 0), plugins, 1e-4, 1);
    const History stiff = run(slider_crank(plugins, CouplerJoint::elastic, 1e11), plugins, 1e-4, 1);
    const double turned = fixed.largest("guide.travel");
    EXPECT_GT(turned, 0.114);  // from upright to stretched: it turns round
    for (size_t n = 0; n < fixed["time"].size(); ++n)
        ASSERT_NEAR(fixed["guide.travel"][n], stiff["guide.travel"][n], 4e-6 * turned) << n;
}

// Oracle: Cardan's joint, tan(out) = tan(in)/cos(bend) from where the input's cross arm is at right angles to the plane of
// the bend.
TEST(Joints, UniversalJointTurnsAsCardansDoes) {
    const Plugins plugins;
    const double bend = 0.5;
    const Eigen::Vector3d out = std::cos(bend) * kZ + std::sin(bend) * kX;
    Model model;
    model.bodies = {test::box("in", 2, {0.2, 0.3, 0.4}, at(0, 0, -0.3)), test::box("out", 1.3, {0.3, 0.1, 0.2}, 0.4 * out)};
    Eigen::Matrix3d frame;
    frame << kX, kY, kZ;
    model.bodies[0].rotation = frame;
    frame << kY.cross(out), kY, out;
    model.bodies[1].rotation = frame;
    model.joints = {test::pin("in_bearing", -1, 0, at(0, 0, -0.3), kZ), test::pin("out_bearing", -1, 1, 0.4 * out, out)};
    Joint cross = test::pin("cross", 0, 1, at(0, 0), kY);
    cross.type = JointType::universal;
    cross.axis2 = kY.cross(out);
    model.joints.push_back(cross);
    // The arm on the input along y: the output turns at cos(bend) of the input
    model.bodies[0].angular_velocity = 12 * kZ;
    model.bodies[1].angular_velocity = 12 * std::cos(bend) * out;
    const History history = run(model, plugins, 1e-3, 2);
    for (size_t n = 0; n < history["time"].size(); ++n) {
        const double in = history["in_bearing.angle"][n], angle = history["out_bearing.angle"][n];
        ASSERT_NEAR(std::sin(angle) * std::cos(in), std::cos(bend) * std::sin(in) * std::cos(angle), 1e-13) << n;
    }
    EXPECT_LT(history.largest("energy.residual"), 1e-3 * history.largest("energy.kinetic"));
}

// Oracle: a mass on a slider, pulled by a constant force: x = F t²/2m until the stop, then rest; the stop carries F. What it
// took is in the ledger.
TEST(Joints, StopTakesTheSpeedAndThenCarriesTheForce) {
    const Plugins plugins;
    Model model;
    model.bodies = {test::box("mass", 4, {0.1, 0.2, 0.3}, at(0.3, 0.1))};
    Joint guide = test::pin("guide", -1, 0, at(0.3, 0.1), kX);
    guide.type = JointType::slider;
    guide.limits = {-0.2, 0.05};
    model.joints = {guide};
    Load load;
    load.on = {0, -1};
    load.direction = kX;
    load.signal = test::constant(30);
    model.loads = {load};
    const History history = run(model, plugins, 1e-3, 0.5);
    const double impact = std::sqrt(2 * 0.05 * 4 / 30.0);
    for (size_t n = 0; n < history["time"].size(); ++n) {
        const double t = history["time"][n];
        const double expected = t < impact ? 30 / 8.0 * t * t : 0.05;
        if (std::abs(t - impact) < 3e-3) continue;
        ASSERT_NEAR(history["guide.travel"][n], expected, 2e-12);  // the stop's play, 1e-12 m
    }
    Eigen::Vector3d force;
    for (int i = 0; i < 3; ++i) force(i) = history[std::string("guide.force.") + "xyz"[i]].back();
    EXPECT_LT((force - 30 * kX).norm(), 1e-9);
    // Where in the step the stop is reached is not resolved: F v h/2 = 30 N 0.87 m/s 0.5 ms
    EXPECT_NEAR(history["energy.dissipated"].back(), 30 * 0.05, 0.013);
    EXPECT_LT(std::abs(history["energy.residual"].back()), 1e-3);
    // In the row of the impact the centred velocity holds at least a quarter of the energy, and half the loss is booked
    EXPECT_LT(history.largest("energy.residual"), 0.26 * 30 * 0.05);
}

// Oracle: at rest on a stop the angle is the limit to the stop's play, and the ledger closes. A rod falls on its lower stop,
// leaves it when it is pulled off, and flies to the upper one.
TEST(Joints, StopLetsGo) {
    const Plugins plugins;
    Model model = pendulum(plugins, 0, 0, 0, -2 * kY);
    model.joints[0].limits = {-0.1, 0.2};
    Load load;
    load.on = {0, 1};
    load.direction = kY;
    load.signal = test::smooth_rise(8, 2);
    model.loads = {load};
    const History history = run(model, plugins, 1e-3, 2);
    const std::vector<double>& angle = history["pin.angle"];
    EXPECT_NEAR(*std::min_element(angle.begin(), angle.end()), -0.1, 1e-3);
    EXPECT_NEAR(angle[600], -0.1, 2e-12);
    EXPECT_NEAR(angle.back(), 0.2, 2e-12);
    EXPECT_LT(std::abs(history["energy.residual"].back()), 1e-2 * history.largest("energy.work"));
}

/// Blocks on sliders along x with stops, each block riding on the one before (−1: the ground).
struct Block {
    double mass, x, speed;
    int on;
    std::array<double, 2> limits;
};
Model train(const std::vector<Block>& blocks) {
    Model model;
    for (size_t b = 0; b < blocks.size(); ++b) {
        Body body = test::box(fmt::format("block{}", b), blocks[b].mass, {0.1, 0.2, 0.3}, at(blocks[b].x, 0));
        body.velocity = blocks[b].speed * kX;
        model.bodies.push_back(body);
        Joint guide = test::pin(fmt::format("guide{}", b), blocks[b].on, static_cast<int>(b), at(blocks[b].x, 0), kX);
        guide.type = JointType::slider;
        guide.limits = blocks[b].limits;
        model.joints.push_back(guide);
    }
    return model;
}

// Oracle: momentum. One step leads block 0 through its own stop and block 1 through that between the two. Which comes first,
// and in which order the joints stand in the model, must not matter: the stop of block 0 can only push, so they go on
// together at (−1 + 9)/2 m/s.
TEST(Joints, StopsWithinOneStepPushAndNeverPull) {
    const Plugins plugins;
    for (const auto& [own, between] : {std::pair{-0.0105, 0.1042}, std::pair{-0.0101, 0.105}})
        for (const bool swapped : {false, true}) {
            Model model = train({{1, 0, -1, -1, {own, 1}}, {1, 0.5, 9, 0, {-0.1, between}}});
            if (swapped) std::swap(model.joints[0], model.joints[1]);
            const History history = run(model, plugins, 1e-3, 0.02);
            EXPECT_NEAR(history["guide1.travel"].back(), between, 2e-12);
            double speed = 0;
            for (const char* axis : {"x", "y", "z"})
                speed += std::pow(history[std::string("block0.velocity.") + axis].back(), 2);
            EXPECT_NEAR(std::sqrt(speed), 4, 1e-8) << own << " " << swapped;
            EXPECT_LT(history.largest("guide0.force.x"), 1e-6);
        }
}

// Two stops of one motion, 5 mm apart: the nearer one holds, to rest, and nothing rebounds.
TEST(Joints, TheNearerOfTwoStopsHolds) {
    const Plugins plugins;
    Model model = train({{1, 0, 10, -1, {-0.1, 0.1}}});
    model.joints.push_back(model.joints[0]);
    model.joints[1].name = "guide1";
    model.joints[1].limits = {-0.1, 0.105};
    const History history = run(model, plugins, 1e-3, 0.05);
    EXPECT_LT(history.largest("guide0.travel"), 0.1 + 2e-12);
    EXPECT_NEAR(history["guide0.travel"].back(), 0.1, 2e-12);
    EXPECT_NEAR(history["energy.dissipated"].back(), 50, 1e-9);
}

// A slider-crank at its dead centre stands on a stop of its slider: the loop must draw back, and the stop lets it.
TEST(Joints, StopAtADeadCentreLetsTheMachineGo) {
    const Plugins plugins;
    const double r = 0.1, l = 0.5, omega = 30;
    Model model;
    model.bodies = {rod("crank", 1.2, at(0, 0), at(r, 0)), rod("rod", 0.9, at(r, 0), at(r + l, 0)),
                    rod("piston", 0.5, at(r + l, 0), at(r + l + 0.1, 0))};
    turn(model.bodies[0], at(0, 0), omega);
    turn(model.bodies[1], at(r + l, 0), -omega * r / l);
    model.joints = {test::pin("main", -1, 0, at(0, 0), kZ), test::pin("big_end", 0, 1, at(r, 0), kZ),
                    test::pin("small_end", 1, 2, at(r + l, 0), kZ)};
    Joint guide = test::pin("guide", -1, 2, at(r + l, 0), kX);
    guide.type = JointType::slider;
    guide.limits = {-0.05, 0};
    model.joints.push_back(guide);
    const History history = run(model, plugins, 1e-3, 0.02);
    // Oracle: centripetal and static forces at the start; the piston alone has m r ω² (1 + r/l) = 54 N
    EXPECT_LT(std::abs(history["small_end.force.x"][0]), 200);
    EXPECT_LT(history["guide.travel"][10], -1e-3);  // it has gone
}

// Row 0 tells the reaction at the start in the order of the rest: m ω² r of a rod that turns at once.
TEST(Joints, ReactionAtTheStartIsExact) {
    const Plugins plugins;
    const Model model = pendulum(plugins, 0, 0, 3);
    for (double h : {4e-3, 1e-3}) {
        const History history = run(model, plugins, h, 0.1);
        Eigen::Vector3d force;
        for (int i = 0; i < 3; ++i) force(i) = history[std::string("pin.force.") + "xyz"[i]][0];
        EXPECT_LT((force - model.bodies[0].mass * 9 * kRodLength / 2 * kX).norm(), 1e-9);
    }
}

// Fast turning wants more passes, not a failure: 0.6 rad per step. Oracle: energy, to the order of the scheme.
TEST(Joints, FastTurningIsFollowed) {
    const Plugins plugins;
    const double omega = 600;
    const Model model = pendulum(plugins, 0, 0, omega, 9.81 * kX);
    const History history = run(model, plugins, 1e-3, 1);
    EXPECT_LT(history.largest("energy.residual"), 0.01 * history.largest("energy.kinetic"));
    EXPECT_GT(history.passes_per_step, 5);
}

// A stop near half a turn, where the angle jumps: the lever, 0.1 rad per step, must not be taken for one beyond its other
// stop.
TEST(Joints, StopNearHalfATurnHolds) {
    const Plugins plugins;
    Model model = pendulum(plugins, 0, 0, 105);
    model.joints[0].limits = {0, 3.05};  // the step from 3.045 rad would end beyond half a turn
    const History history = run(model, plugins, 1e-3, 0.1);
    EXPECT_NEAR(history["pin.angle"].back(), 3.05, 2e-12);
    EXPECT_LT(history.largest("pin.angle"), 3.05 + 2e-12);
}

/// A block slides on an arm that turns at omega, on a spring without force at the start, where the block is r out.
struct BlockOnAnArm {
    static constexpr double kMass = 2, kReach = 0.3, kSpeed = 1.3, kStop = 0.021;
    double omega, stiffness, damping;

    /// The travel t after it was y and had the rate v: a damped vibration about where the spring bears its centripetal
    /// force.
    Eigen::Vector2d travel(double y, double v, double t) const {
        const double delta = 0.5 * damping / kMass, w2 = stiffness / kMass - omega * omega,
                     w = std::sqrt(w2 - delta * delta);
        const double rest = omega * omega * kReach / w2, a = y - rest, b = (v + delta * a) / w, decay = std::exp(-delta * t);
        const double c = std::cos(w * t), s = std::sin(w * t);
        return {rest + decay * (a * c + b * s), decay * (w * (b * c - a * s) - delta * (a * c + b * s))};
    }
    double reached() const {
        double t = 0;
        for (int i = 0; i < 50; ++i) {
            const Eigen::Vector2d y = travel(0, kSpeed, t);
            t -= (y(0) - kStop) / y(1);
        }
        return t;
    }
    /// The largest error of the travel up to `end`.
    double error(const Plugins& plugins, double h, double end) const {
        Model model;
        model.bodies = {test::box("arm", 1e7, {2, 2, 2}, at(0, 0)),
                        test::box("block", kMass, {0.1, 0.2, 0.3}, at(kReach, 0))};
        for (Body& body : model.bodies) turn(body, at(0, 0), omega);
        model.bodies[1].velocity += kSpeed * kX;
        Marker out;
        out.name = "out";
        out.position = at(kReach, 0);
        model.bodies[0].markers = {out};
        Joint guide = test::pin("guide", 0, 1, at(kReach, 0), kX);
        guide.type = JointType::slider;
        guide.limits = {-0.05, kStop};
        model.joints = {test::pin("main", -1, 0, at(0, 0), kZ), guide};
        model.elements = {test::spring("spring", plugins, {0, 0}, {1, -1}, stiffness, damping)};
        const History history = run(model, plugins, h, end);
        double worst = 0;
        for (size_t n = 0; n < history["time"].size(); ++n) {
            const double t = history["time"][n], late = t - reached();
            if (late > 0 && late < h) continue;  // the row behind the impact is on the stop
            const double expected = late < 0 ? travel(0, kSpeed, t)(0) : travel(kStop, 0, late)(0);
            worst = std::max(worst, std::abs(history["guide.travel"][n] - expected));
        }
        return worst;
    }
};

// A stop takes the speed, and the spring draws the block off at once. Oracle: closed form. The instant of the impact falls
// anywhere within a step: the error of any step is below one line of second order.
TEST(Joints, AStopThatIsLeftAtOnceIsOfSecondOrder) {
    const Plugins plugins;
    for (const auto& [omega, damping] :
         {std::pair{0.0, 0.0}, std::pair{0.0, 9.0}, std::pair{7.0, 0.0}, std::pair{7.0, 9.0}}) {
        const BlockOnAnArm machine{omega, 2900, damping};
        for (int n = 300; n < 9000; n = n * 7 / 5 + 1) {
            const double h = 0.12 / n;
            EXPECT_LT(machine.error(plugins, h, 0.12), (damping > 0 ? 16.5 : 9.8) * h * h)
                << omega << " " << damping << " " << n;
        }
    }
}

/// Two bodies on a slider fly and tumble; its lower stop is struck after 25 ms.
Model tumbling() {
    Model model;
    model.bodies = {test::box("a", 7.72, {0.1, 0.1, 0.1}, {-0.496, -0.296, 0.499}),
                    test::box("b", 0.977, {0.1, 0.1, 0.1}, {-0.369, -0.483, 0.55})};
    model.bodies[0].rotation = Eigen::Quaterniond(-0.407, 0.327, 0.296, 0.8).normalized().toRotationMatrix();
    model.bodies[1].rotation = Eigen::Quaterniond(0.683, 0.525, -0.422, 0.282).normalized().toRotationMatrix();
    model.bodies[0].inertia << 0.0459, -0.0186, -0.031, -0.0186, 0.0748, -0.0156, -0.031, -0.0156, 0.0478;
    model.bodies[1].inertia << 0.0261, -0.0283, 0.0029, -0.0283, 0.0819, 0.0023, 0.0029, 0.0023, 0.0879;
    for (Body& body : model.bodies) body.angular_velocity = Eigen::Vector3d(-1.33, -1.108, 0.007);
    const Eigen::Vector3d axis(0.642, 0.432, 0.634), arm = model.bodies[1].position - model.bodies[0].position;
    model.bodies[0].velocity = Eigen::Vector3d(-0.976, 1.371, 0.133);
    model.bodies[1].velocity = model.bodies[0].velocity + model.bodies[0].angular_velocity.cross(arm) - 2.03 * axis;
    Joint guide = test::pin("guide", 0, 1, {-0.228, 0.118, 0.298}, axis);
    guide.type = JointType::slider;
    guide.limits = {-0.05, 0.07};
    model.joints = {guide};
    return model;
}

// Two bodies on a slider fly and tumble, and rest on its stop until their turning draws them off: at that instant the force
// of the stop passes through zero. The slider turns within a step, so that a stop is hardly reached along one direction and
// not along the other. Oracle: momentum; the stop is passed by (omega h)^2 of the lengths at most.
TEST(Joints, AStopOfBodiesThatTurnLetsGoAtAnyStep) {
    const Plugins plugins;
    const Model model = tumbling();
    for (const double h : {1e-3, 5e-4, 2e-4, 1e-4, 5e-5}) {
        const History history = run(model, plugins, h, 0.12);
        EXPECT_NEAR(*std::ranges::min_element(history["guide.travel"]), -0.05, 3 * h * h) << h;
        EXPECT_GT(history["guide.travel"].back(), -0.04995) << h;  // off again
        for (const char* direction : {"x", "y", "z"}) {
            const auto momentum = [&](size_t row) {
                const std::string velocity = std::string(".velocity.") + direction;
                return 7.72 * history["a" + velocity][row] + 0.977 * history["b" + velocity][row];
            };
            EXPECT_NEAR(momentum(history["time"].size() - 1), momentum(0), 1e-12 * 8.7 * 3) << h << direction;
        }
    }
}

// Oracle: a rod that rests on its stop under a weight across it bears m g l/2 there, in the first row as in all others. The
// turning of the rod leaves its angle off the stop by rounding.
TEST(Joints, AStopHoldsFromTheFirstRowOn) {
    const Plugins plugins;
    for (int n = 0; n < 25; ++n) {
        const double angle = 0.03 + 0.11 * n;
        Model model;
        model.simulation.gravity = -10 * (std::cos(angle) * kY - std::sin(angle) * kX);
        model.bodies = {rod("rod", 2.3, at(0, 0), at(0.8 * std::cos(angle), 0.8 * std::sin(angle)))};
        model.joints = {test::pin("pin", -1, 0, at(0, 0), kZ)};
        model.joints[0].limits = {0, 1};
        const History history = run(model, plugins, 1e-3, 0.005);
        for (size_t row = 0; row < history["time"].size(); ++row) {
            double moment = 0;  // on the ground
            for (int i = 0; i < 3; ++i) moment += kZ(i) * history[std::string("pin.moment.") + "xyz"[i]][row];
            EXPECT_NEAR(moment, -2.3 * 10 * 0.4, 1e-8) << angle << " " << row;
            EXPECT_NEAR(history["rod.angular_velocity.z"][row], 0, 1e-8) << angle << " " << row;
        }
    }
}

// Oracle: momentum and energy. Three blocks that touch, the first of them moving, go on together from the start.
TEST(Joints, AnImpactAtTheStartIsBooked) {
    const Plugins plugins;
    const History history =
        run(train({{1, 0, 2, -1, {-1, 5}}, {1, 0.5, 0, 0, {0, 0.3}}, {1, 0.8, 0, 1, {0, 0.4}}}), plugins, 1e-3, 0.02);
    EXPECT_NEAR(history["energy.kinetic"].front(), 2, 1e-12);
    EXPECT_NEAR(history["energy.kinetic"].back(), 2 / 3.0, 1e-9);
    EXPECT_EQ(history["energy.dissipated"].front(), 0);
    EXPECT_NEAR(history["energy.dissipated"].back(), 4 / 3.0, 1e-9);
    EXPECT_NEAR(history["energy.residual"].back(), 0, 1e-9);
}

/// Two rods hang in the plane.
struct DoublePendulum {
    static constexpr double kGravity = 14;
    double m1 = 1.2, l1 = 0.5, m2 = 0.9, l2 = 0.4;
    double M11 = m1 * (l1 * l1 + 9e-4) / 12 + 0.25 * m1 * l1 * l1 + m2 * l1 * l1,
           M22 = m2 * (l2 * l2 + 9e-4) / 12 + 0.25 * m2 * l2 * l2, coupling = 0.5 * m2 * l1 * l2,
           g1 = (0.5 * m1 + m2) * l1 * kGravity, g2 = 0.5 * m2 * l2 * kGravity;
    /// Angles of the rods from the vertical, then their speeds.
    Eigen::Vector4d start;

    /// Accelerations of the angles while a moment acts on the second rod, and back on the first.
    Eigen::Vector2d accelerations(const Eigen::VectorXd& y, double moment) const {
        const double s = coupling * std::sin(y(0) - y(1)), c = coupling * std::cos(y(0) - y(1));
        const Eigen::Matrix2d M{{M11, c}, {c, M22}};
        return M.inverse() * Eigen::Vector2d(-s * y(3) * y(3) - g1 * std::sin(y(0)) - moment,
                                             s * y(2) * y(2) - g2 * std::sin(y(1)) + moment);
    }
    Model model() const {
        const auto along = [](double angle, double length) {
            return at(length * std::cos(angle), length * std::sin(angle));
        };
        const Eigen::Vector3d elbow = along(start(0), l1);
        Model model;
        model.simulation.gravity = kGravity * kX;
        model.bodies = {rod("upper", m1, at(0, 0), elbow), rod("lower", m2, elbow, elbow + along(start(1), l2))};
        turn(model.bodies[0], at(0, 0), start(2));
        turn(model.bodies[1], elbow, start(3));
        model.bodies[1].velocity += start(2) * kZ.cross(elbow);
        model.joints = {test::pin("shoulder", -1, 0, at(0, 0), kZ), test::pin("elbow", 0, 1, elbow, kZ)};
        return model;
    }
};

/// The elbow is on its upper stop: the rods swing as one body until the moment of the stop is zero.
struct ElbowOnAStop : DoublePendulum {
    static constexpr double kBend = 1.35;
    ElbowOnAStop() { start << 2.5643, 2.5643 + kBend, -2.779, -2.779; }
    /// The moment that holds the elbow.
    double holding(const Eigen::VectorXd& y) const {
        const auto bends = [&](double moment) { return accelerations(y, moment)(1) - accelerations(y, moment)(0); };
        return -bends(0) / (bends(1) - bends(0));
    }
    Eigen::VectorXd after(double t, const Eigen::VectorXd& y, bool is_held) const {
        const auto rates = [&](double, const Eigen::VectorXd& at) {
            Eigen::VectorXd rate(4);
            rate << at(2), at(3), accelerations(at, is_held ? holding(at) : 0);
            return rate;
        };
        return test::integrate(rates, y, t);
    }
    double let_go() const {
        double held = 0, free = 0.3;
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (held + free);
            (holding(after(middle, start, true)) < 0 ? held : free) = middle;
        }
        return free;
    }
};

// A stop that is pressed lets go when it would pull: centripetal forces count like others. Oracle: the equations of a double
// pendulum, held and free, by an error-controlled method.
TEST(Joints, APressedStopLetsGoWhereItWouldPull) {
    const Plugins plugins;
    const ElbowOnAStop machine;
    const double let_go = machine.let_go();
    ASSERT_NEAR(let_go, 0.14, 0.01);
    const Eigen::VectorXd then = machine.after(let_go, machine.start, true);
    Model model = machine.model();
    model.joints[1].limits = {-3, 0};
    for (const double h : {2e-3, 7e-4, 2e-4}) {
        const History history = run(model, plugins, h, 0.25);
        for (size_t n = 0; n < history["time"].size(); n += 7) {
            const double t = history["time"][n];
            EXPECT_GT(history["elbow.moment.z"][n], -1e-9) << t;
            const Eigen::VectorXd y =
                t < let_go ? machine.after(t, machine.start, true) : machine.after(t - let_go, then, false);
            EXPECT_NEAR(history["elbow.angle"][n], y(1) - y(0) - ElbowOnAStop::kBend, 40 * h * h) << t << " " << h;
        }
    }
}

/// The upper rod strikes a stop, and its weight holds it there; the lower one swings on.
struct ShoulderOnAStop : DoublePendulum {
    static constexpr double kStop = 0.2;
    double struck = 0;     ///< when [s]
    Eigen::VectorXd then;  ///< just after it
    ShoulderOnAStop() {
        start << -1.3, -0.9, 2.1, 3;
        for (int i = 0; i < 20; ++i) {
            then = free(struck);
            struck -= (then(0) - start(0) - kStop) / then(2);
        }
        then(3) += coupling * std::cos(then(0) - then(1)) / M22 * then(2);
        then(2) = 0;
    }
    Eigen::VectorXd free(double t) const {
        const auto rates = [&](double, const Eigen::VectorXd& at) {
            Eigen::VectorXd rate(4);
            rate << at(2), at(3), accelerations(at, 0);
            return rate;
        };
        return test::integrate(rates, start, t);
    }
    double elbow(double t) const {
        if (t < struck) return free(t)(1) - free(t)(0) - (start(1) - start(0));
        const auto rates = [&](double, const Eigen::VectorXd& at) {
            return Eigen::VectorXd(Eigen::Vector2d(at(1), -g2 * std::sin(at(0)) / M22));
        };
        return test::integrate(rates, then({1, 3}), t - struck)(0) - then(0) - (start(1) - start(0));
    }
};

// Oracle: the equations of a double pendulum, and momentum about the elbow at the impact, wherever in a step it falls. Over
// that step the bodies go straight on: without what is made up for, the speed of the elbow is off by the first order.
TEST(Joints, AnImpactIsOfSecondOrderInAllJoints) {
    const Plugins plugins;
    const ShoulderOnAStop machine;
    ASSERT_NEAR(machine.struck, 0.06, 0.003);
    Model model = machine.model();
    model.joints[0].limits = {-1, ShoulderOnAStop::kStop};
    const double end = 0.2, exact = machine.elbow(end);
    for (int n = 150; n < 4000; n = n * 6 / 5 + 1) {
        const double h = end / n;
        const History history = run(model, plugins, h, end);
        EXPECT_NEAR(history["shoulder.angle"].back(), ShoulderOnAStop::kStop, 2e-12);
        EXPECT_NEAR(history["elbow.angle"].back(), exact, 60 * h * h) << n;
    }
}

// One carriage strikes its stop and a force draws it off at once. Within the steps in which it leaves, the second carriage
// strikes a stop of the first. Oracle: momentum. What is being left must not hold the speed that the second impact gives.
TEST(Joints, AnImpactElsewhereEndsTheLeavingOfAStop) {
    const Plugins plugins;
    const double pull = 20, h = 1e-3, end = 0.02, first = 0.0104;
    for (const double later : {1.7e-3, 1.9e-3, 2.1e-3, 2.5e-3, 3e-3}) {
        const double second = first + later, stop = first - 0.5 * pull * first * first,
                     reach = 3 * second + stop - 0.5 * pull * later * later;
        Model model = train({{1, 0, -1, -1, {-stop, 0.5}}, {1, 0.5, 3, 0, {-0.3, reach}}});
        Load load;
        load.on = {0, -1};
        load.direction = kX;
        load.signal = test::constant(pull);
        model.loads = {load};
        const History history = run(model, plugins, h, end);
        double speed = 0;
        for (int i = 0; i < 3; ++i) speed += kX(i) * history[std::string("block0.velocity.") + "xyz"[i]].back();
        EXPECT_NEAR(speed, 0.5 * (pull * later + 3) + pull * (end - second), pull * h) << later;
    }
}

// Oracle: a block that a stop holds on a turning arm presses it with m r w², at the start too.
TEST(Joints, AStopOnATurningArmBearsTheCentripetalForce) {
    const Plugins plugins;
    for (const double h : {1e-3, 1e-4}) {
        Model model;
        model.bodies = {test::box("arm", 5, {0.2, 0.2, 0.2}, at(0, 0)), test::box("block", 2, {0.1, 0.2, 0.3}, at(0.3, 0))};
        for (Body& body : model.bodies) turn(body, at(0, 0), 10);
        Joint guide = test::pin("guide", 0, 1, at(0.3, 0), kX);
        guide.type = JointType::slider;
        guide.limits = {-0.1, 0};
        model.joints = {test::pin("main", -1, 0, at(0, 0), kZ), guide};
        const History history = run(model, plugins, h, 0.1);
        for (size_t n = 0; n < history["time"].size(); ++n) {
            Eigen::Vector3d force;
            for (int i = 0; i < 3; ++i) force(i) = history[std::string("guide.force.") + "xyz"[i]][n];
            EXPECT_LT((force - 2 * 0.3 * 100 * kX).norm(), n == 0 ? 1e-6 : 1e3 * h * h) << n << " " << h;
        }
    }
}

// Oracle: the same machine at a step 40 times finer, which itself errs by 1/1600 of the bound. In space the turning jumps
// about all axes at once.
TEST(Joints, AnImpactOfBodiesThatTumbleIsOfSecondOrder) {
    const Plugins plugins;
    const double end = 0.07;
    const History fine = run(tumbling(), plugins, end / 40000, end);
    for (int n = 70; n < 1000; n = n * 6 / 5 + 1) {
        const History history = run(tumbling(), plugins, end / n, end);
        for (const char* channel : {"a.position.x", "a.position.y", "a.position.z", "b.position.x", "b.position.y",
                                    "b.position.z", "guide.travel"})
            EXPECT_NEAR(history[channel].back(), fine[channel].back(), 0.12 * std::pow(end / n, 2)) << channel << " " << n;
    }
}

// Bodies that no joint and no element holds, light and heavy, beside a pendulum: they must not keep its step from being
// found.
TEST(Joints, FreeBodiesBesideAPendulumDoNotMatter) {
    const Plugins plugins;
    for (double mass : {1e-9, 1e-3, 10.0}) {
        Model model = pendulum(plugins, 0, 0, 0, 9.81 * kX + 3 * kY);
        model.bodies.push_back(test::box("free", mass, {0.1, 0.1, 0.1}, at(5, 0)));
        EXPECT_NO_THROW(run(model, plugins, 1e-3, 1)) << mass;
    }
}

// Tiny parts on redundant joints: what once made ODE fail within its step.
TEST(Joints, TinyPartsOnRedundantJointsRun) {
    const Plugins plugins;
    Model model;
    model.bodies = {test::box("part", 1e-8, {1e-1, 1e-1, 1e-1}, at(0.1, 0))};
    model.bodies[0].inertia = 1e-10 * Eigen::Matrix3d::Identity();
    model.joints = {test::pin("weld", -1, 0, at(0.1, 0), kZ), test::pin("hinge", -1, 0, at(0, 0), kY)};
    model.joints[0].type = JointType::fixed;
    Load load;
    load.on = {0, -1};
    load.direction = kX;
    load.signal = test::constant(1e-9);
    model.loads = {load};
    const History history = run(model, plugins, 1e-3, 0.1);
    for (const char* axis : {"x", "y", "z"}) {
        const std::vector<double>& position = history[std::string("part.position.") + axis];
        EXPECT_NEAR(position.back(), position.front(), 1e-12);
    }
}

// A heavy load on a light link, masses 1e7 and 1e11 apart: ODE alone lets such a load fall almost freely. Oracle: beside the
// load the link weighs nothing, so that both loads move alike to 1e-7 of the motion.
TEST(Joints, HeavyLoadHangsOnALightLink) {
    const Plugins plugins;
    std::vector<Eigen::Vector3d> ends;
    for (double mass : {1e5, 1e9}) {
        Model model;
        model.simulation.gravity = 9.81 * kX;
        model.bodies = {rod("link", 0.01, at(0, 0), at(0.2, 0)), rod("load", mass, at(0.2, 0), at(0.3, 0.3))};
        model.joints = {test::pin("top", -1, 0, at(0, 0), kZ), test::pin("bottom", 0, 1, at(0.2, 0), kZ)};
        for (Joint& joint : model.joints) joint.type = JointType::ball;
        const History history = run(model, plugins, 1e-3, 1);
        EXPECT_LT(history.largest("energy.residual"), 1e-3 * history.largest("energy.kinetic"));
        ends.emplace_back(history["load.position.x"].back(), history["load.position.y"].back(),
                          history["load.position.z"].back());
    }
    EXPECT_GT((ends[0] - at(0.25, 0.15)).norm(), 0.01);
    EXPECT_LT((ends[0] - ends[1]).norm(), 1e-6);
}

// ---- Singular positions --------------------------------------------------------------------------------------------------

/// Bars in a row on parallel cranks of length kCrank, at an angle θ from kY about −kZ. When all lie in one line, each window
/// could go on in two ways.
constexpr double kCrank = 0.31;
Model windows(int count, double theta, double omega) {
    Model model;
    model.simulation.gravity = -9.81 * kY;
    const Eigen::Vector3d along = kCrank * (std::sin(theta) * kX + std::cos(theta) * kY);
    Eigen::Vector3d foot = at(0, 0);
    for (int i = 0; i <= count; ++i) {
        if (i > 0) {
            const Eigen::Vector3d next = foot + at(0.4 + 0.13 * i, 0);
            model.bodies.push_back(rod(fmt::format("bar{}", i), 1.7 - 0.4 * i, foot + along, next + along));
            model.bodies.back().velocity = -omega * kZ.cross(along);
            foot = next;
        }
        model.bodies.push_back(rod(fmt::format("crank{}", i), 0.8 + 0.3 * i, foot, foot + along));
        turn(model.bodies.back(), foot, -omega);
        const int crank = static_cast<int>(model.bodies.size()) - 1;
        model.joints.push_back(test::pin(fmt::format("foot{}", i), -1, crank, foot, kZ));
        if (i > 0) {
            model.joints.push_back(
                test::pin(fmt::format("left{}", i), crank - 2, crank - 1, foot - at(0.4 + 0.13 * i, 0) + along, kZ));
            model.joints.push_back(test::pin(fmt::format("right{}", i), crank - 1, crank, foot + along, kZ));
        }
    }
    return model;
}

/// Oracle: the branch that momentum chooses has one degree of freedom,
///     (Σ I_crank + Σ m_bar a²) θ'' = g a (Σ m_crank/2 + Σ m_bar) sin θ.
double exact_angle(const Model& model, double theta, double omega, double t) {
    double inertia = 0, weight = 0;
    for (const Body& body : model.bodies) {
        const bool is_crank = body.name.starts_with("crank");
        inertia += body.mass * kCrank * kCrank * (is_crank ? 0.25 : 1) + (is_crank ? body.inertia(2, 2) : 0);
        weight += body.mass * 9.81 * kCrank * (is_crank ? 0.5 : 1);
    }
    const auto f = [&](double, const Eigen::VectorXd& y) {
        return Eigen::VectorXd(Eigen::Vector2d(y(1), weight / inertia * std::sin(y(0))));
    };
    return test::integrate(f, Eigen::Vector2d(theta, omega), t)(0);
}

/// How far the first crank is from the exact motion at the end [m].
double error_at_end(const Model& model, const History& history, double theta, double omega) {
    const double exact = exact_angle(model, theta, omega, history["time"].back());
    Eigen::Vector3d centre;
    for (int i = 0; i < 3; ++i) centre(i) = history[std::string("crank0.position.") + "xyz"[i]].back();
    return (centre - 0.5 * kCrank * (std::sin(exact) * kX + std::cos(exact) * kY)).norm();
}

// Two turns, four singular positions, one to three windows, each of other size, that lie flat at once: IFToMM A02 among
// them. Second order: the energy falls fourfold with the step.
TEST(Joints, LinkagesPassSingularPositionsOnTheBranchOfTheirMomentum) {
    const Plugins plugins;
    const double theta = 0.2, omega = 3.1;
    for (const int count : {1, 2, 3}) {
        const Model model = windows(count, theta, omega);
        double energy[2];
        for (const int halving : {0, 1}) {
            const History history = run(model, plugins, 2.5e-3 / (1 << halving), 2);
            EXPECT_LT(error_at_end(model, history, theta, omega), 1e-3 / (1 << 2 * halving)) << count;
            energy[halving] = history.largest("energy.residual") / history.largest("energy.kinetic");
        }
        EXPECT_LT(energy[0], 3e-4) << count;
        EXPECT_LT(energy[1], 0.3 * energy[0]) << count;
        const History coarse = run(model, plugins, 10e-3, 2);
        EXPECT_LT(error_at_end(model, coarse, theta, omega), 0.05) << count;
        const History fine = run(model, plugins, 0.1e-3, 2);
        EXPECT_LT(error_at_end(model, fine, theta, omega), 2e-6) << count;
    }
}

// Oracle: the same in other axes. Which equation says next to nothing in a singular position depends on them.
TEST(Joints, LinkagesPassSingularPositionsInAnyAxes) {
    const Plugins plugins;
    const double theta = 0.2, omega = 3.1;
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int frame = 0; frame < 12; ++frame) {
        const Eigen::Vector3d axis = frame < 4 ? kZ : Eigen::Vector3d(number(engine), number(engine), number(engine));
        const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7 + 0.5 * frame, axis.normalized()).toRotationMatrix();
        for (const int count : {1, 2}) {
            const Model model = windows(count, theta, omega);
            Model turned = model;
            turned.simulation.gravity = R * model.simulation.gravity;
            for (Body& body : turned.bodies) {
                body.position = (R * body.position).eval();
                body.rotation = (R * body.rotation).eval();
                body.velocity = (R * body.velocity).eval();
                body.angular_velocity = (R * body.angular_velocity).eval();
            }
            for (Joint& joint : turned.joints) {
                joint.anchor = (R * joint.anchor).eval();
                joint.axis = (R * joint.axis).eval();
            }
            History history = run(turned, plugins, 2.5e-3, 1);
            const double exact = exact_angle(model, theta, omega, history["time"].back());
            Eigen::Vector3d centre;
            for (int i = 0; i < 3; ++i) centre(i) = history[std::string("crank0.position.") + "xyz"[i]].back();
            EXPECT_LT((centre - R * (0.5 * kCrank * (std::sin(exact) * kX + std::cos(exact) * kY))).norm(), 1e-3)
                << count << ", frame " << frame;
        }
    }
}

// Rounding of the poses moves what is nearly free all the more; the bars are in one line after 10 ms.
TEST(Joints, LinkagesPassSingularPositionsAtTheShortestSteps) {
    const Plugins plugins;
    const double theta = M_PI / 2 - 0.05, omega = 5.3;
    for (const int count : {1, 2})
        for (const double h : {50e-6, 5e-6, 2e-6}) {
            const Model model = windows(count, theta, omega);
            const History history = run(model, plugins, h, 0.02);
            EXPECT_LT(error_at_end(model, history, theta, omega), 1e-7) << count << ", " << h;
            EXPECT_LT(history.largest("energy.residual"), 1e-3) << count << ", " << h;
        }
}

// From rest and in motion; the equations of the joints have one rank at the start and another ever after.
TEST(Joints, LinkagesStartInSingularPositions) {
    const Plugins plugins;
    for (const double omega : {0.0, 2.7}) {
        const double theta = M_PI / 2;
        const Model model = windows(2, theta, omega);
        for (const double h : {10e-3, 2.5e-3})
            EXPECT_LT(error_at_end(model, run(model, plugins, h, 0.5), theta, omega), 20 * h * h) << omega << ", " << h;
    }
}

TEST(Joints, VelocitiesThatOpenAJointAreRefused) {
    const Plugins plugins;
    Model model = pendulum(plugins, 0, 0, 3);
    model.joints[0].place = "pendulum.toml:17:1";
    model.bodies[0].velocity += at(0, 0, 0.01);
    try {
        run(model, plugins, 1e-3, 1);
        FAIL();
    } catch (const ModelError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("pendulum.toml:17:1: joint \"pin\""));
        EXPECT_THAT(error.what(), testing::HasSubstr("0.00667 m/s") /* the largest part of 0.01 z */);
    }
}

}  // namespace
}  // namespace dttmm::host
