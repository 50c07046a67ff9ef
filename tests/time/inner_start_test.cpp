// SPDX-License-Identifier: BSD-3-Clause
#include "time/inner_start.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/rotation.h"
#include "support/dense_network.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

constexpr uint32_t kMoved = DTTMM_NODE_ON_BODY, kFree = DTTMM_NODE_INNER;
const Matrix3 kSkew = rotation_from_vector(Vector3(0.4, -0.8, 1.3)), kAskew = rotation_from_vector(Vector3(-1.1, 0.2, 0.6));

/// Velocity and angular velocity of a node at the start, where the ports move so; `model` has these first.
Vector6 velocity_at_start(const test::NetworkModel& model, uint32_t node, const std::vector<Vector6>& of_ports) {
    constexpr double h = 1e-6;
    const dttmm_network description = model.description();
    test::DenseNetwork network(description);
    std::vector<dttmm_motion> now, then;
    for (size_t p = 0; p < of_ports.size(); ++p)
        for (double t : {0.0, h}) {
            dttmm_motion motion{};
            Eigen::Map<Vector3>{motion.position} =
                Eigen::Map<const Vector3>(description.nodes[p].position) + t * of_ports[p].head<3>();
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{motion.rotation} =
                rotation_from_vector(Vector3(t * of_ports[p].tail<3>())) *
                Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(description.nodes[p].rotation);
            Eigen::Map<Vector3>{motion.velocity} = of_ports[p].head<3>();
            Eigen::Map<Vector3>{motion.angular_velocity} = of_ports[p].tail<3>();
            (t == 0 ? now : then).push_back(motion);
        }
    const std::vector<double> accelerations(6 * of_ports.size(), 0.0);
    network.start({0, 0, h}, now.data(), accelerations.data(), nullptr);
    network.begin_step({0, 0, h}, nullptr);
    network.commit_settled(then.data());
    std::vector<double> values(network.channels().size());
    network.outputs(values.data());
    Vector6 velocity = Vector6::Constant(std::nan(""));
    for (size_t c = 0; c < values.size(); ++c) {
        const dttmm_channel& channel = network.channels()[c];
        if (channel.of != DTTMM_OF_NODE || channel.index != node) continue;
        const std::string name = channel.name;
        for (const auto& [vector, first] : {std::pair(std::string("velocity"), 0), {"angular_velocity", 3}})
            for (int i = 0; i < 3; ++i)
                if (name == vector + "." + "xyz"[i]) velocity(first + i) = values[c];
    }
    return velocity;
}

Vector6 along(const Vector3& linear, const Vector3& angular = Vector3::Zero()) {
    Vector6 v;
    v << linear, angular;
    return v;
}

/// A heavy body between two ports that move.
test::NetworkModel mass_between(const test::NetworkModel::Values& left, const test::NetworkModel::Values& right) {
    test::NetworkModel model;
    model.node("left", kMoved, Vector3(0.1, -0.2, 0.3), kSkew);
    model.node("right", kMoved, Vector3(0.1, -0.2, 0.3), kAskew);
    model.node("mass", kFree, Vector3(0.1, -0.2, 0.3));
    model.element("left", "spring_damper", {"left", "mass"}, left);
    model.element("right", "spring_damper", {"right", "mass"}, right);
    model.element("mass", "rigid_body", {"mass"},
                  {{"mass", {900}}, {"inertia.xx", {20}}, {"inertia.yy", {30}}, {"inertia.zz", {25}}});
    return model;
}

const std::vector<Vector6> kApart = {along(Vector3(3, -1, 0.2)), along(Vector3(-0.7, 0.4, 2))};

// Oracle: springs alone say where it goes, in proportion to their stiffness. It swings in 67 s, its dampers hold for 59 s,
// then for 10 min: they take no part.
TEST(InnerStart, SpringsMoveASlowMassNotItsDampers) {
    for (const double more : {1.0, 10.0}) {
        const Vector6 v = velocity_at_start(
            mass_between({{"stiffness", {3}}, {"damping", {400 * more}}}, {{"stiffness", {5}}, {"damping", {70 * more}}}), 2,
            kApart);
        const Vector3 expected = (3 * kApart[0] + 5 * kApart[1]).head<3>() / 8;
        EXPECT_LT((v.head<3>() - expected).norm(), 1e-12 * expected.norm()) << v.transpose();
    }
}

// Oracle: where no spring holds, dampers share it alike; its inertia takes no part.
TEST(InnerStart, DampersMoveAMassThatNoSpringHolds) {
    const Vector6 v = velocity_at_start(mass_between({{"damping", {400}}}, {{"damping", {70}}}), 2, kApart);
    const Vector3 expected = (400 * kApart[0] + 70 * kApart[1]).head<3>() / 470;
    EXPECT_LT((v.head<3>() - expected).norm(), 1e-12 * expected.norm()) << v.transpose();
}

// Oracle: of all motions that a frictionless hinge leaves a pendulum the one with the least kinetic energy, ω = −m L v/(I +
// m L²).
TEST(InnerStart, APendulumTurnsAgainstItsMovingHinge) {
    constexpr double kMass = 1.7, kInertia = 0.03, kLength = 0.45;
    test::NetworkModel model;
    model.node("hinge", kMoved, Vector3(0.1, -0.2, 0.3), kSkew);
    model.node("top", kFree, Vector3(0.1, -0.2, 0.3), kSkew);
    model.node("centre", kFree, Vector3(0.1, -0.2, 0.3) - kLength * kSkew.col(2), kSkew);
    model.element("hinge", "elastic_hinge", {"hinge", "top"}, {{"stiffness.ry", {0}}});
    model.element("bob", "rigid_body", {"centre", "top"},
                  {{"mass", {kMass}}, {"inertia.xx", {0.02}}, {"inertia.yy", {kInertia}}, {"inertia.zz", {0.01}}});
    const double speed = 2.3, spin = kMass * kLength * speed / (kInertia + kMass * kLength * kLength);
    const Vector6 v = velocity_at_start(model, 2, {along(speed * kSkew.col(0))});
    EXPECT_LT((v.tail<3>() - spin * kSkew.col(1)).norm(), 1e-12 * spin) << v.transpose() << "\n" << spin * kSkew.col(1);
}

// Oracle: the velocity given, between springs of which one is 1e6 times stiffer than the other. It is a row of the
// equations: nothing of what the springs pull is left in it.
TEST(InnerStart, AGivenVelocityIsARowNotASpring) {
    test::NetworkModel model = mass_between({{"stiffness", {4e9}}}, {{"stiffness", {4e3}}});
    const Vector6 given = along(Vector3(-2, 5, 0.3), Vector3(0.1, 0.7, -3));
    dttmm_node& node = model.node("held", kFree, Vector3(0.4, -0.2, 0.9), kAskew);
    node.moves = 1;
    Eigen::Map<Vector3>{node.velocity} = given.head<3>();
    Eigen::Map<Vector3>{node.angular_velocity} = given.tail<3>();
    model.node("foot", kFree, Vector3(0.1, -0.2, 0.3), kSkew);
    model.element("body", "rigid_body", {"foot", "held"},
                  {{"mass", {30}}, {"inertia.xx", {2}}, {"inertia.yy", {3}}, {"inertia.zz", {2.5}}});
    model.element("soft", "spring_damper", {"mass", "foot"}, {{"stiffness", {70}}});
    model.element("stiff", "spring_damper", {"right", "foot"}, {{"stiffness", {1e8}}, {"rotational_stiffness", {1e5}}});
    const Vector6 v = velocity_at_start(model, 3, kApart);
    EXPECT_LT((v - given).norm(), 1e-13 * given.norm()) << v.transpose();
    // The body between follows all three
    const Vector3 foot = given.head<3>() + given.tail<3>().cross(Vector3(-0.3, 0, -0.6)),
                  expected = (4e9 * kApart[0] + 4e3 * kApart[1]).head<3>() / (4e9 + 4e3 + 70) + 70 / (4e9 + 4e3 + 70) * foot,
                  mass = velocity_at_start(model, 2, kApart).head<3>();
    EXPECT_LT((mass - expected).norm(), 1e-12 * expected.norm()) << mass.transpose();
}

}  // namespace
}  // namespace dttmm::plugin
