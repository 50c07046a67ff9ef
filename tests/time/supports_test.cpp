// SPDX-License-Identifier: BSD-3-Clause
#include "time/supports.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace dttmm::plugin {
namespace {

dttmm_node support_node(const char* name, uint32_t kind, uint32_t fixed, double x) {
    return {name, kind, 0, {x, 0.2, -0.3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, fixed, 0, {}, {}};
}

/// Two bodies and four nodes, of which the second and the last move.
struct Described {
    std::vector<dttmm_body> bodies = std::vector<dttmm_body>(2);
    std::vector<dttmm_node> nodes = {
        support_node("free", DTTMM_NODE_INNER, 0, 1), support_node("clamp", DTTMM_NODE_INNER, 0x3f, 2),
        support_node("still", DTTMM_NODE_INNER, 0x3f, 3), support_node("roller", DTTMM_NODE_INNER, 0x24, 4)};
    std::vector<uint32_t> supports = {1, 3};
    dttmm_network network() const {
        dttmm_network network{};
        network.body_count = 2;
        network.bodies = bodies.data();
        network.node_count = 4;
        network.nodes = nodes.data();
        network.support_count = static_cast<uint32_t>(supports.size());
        network.supports = supports.data();
        return network;
    }
};

TEST(Supports, AreBodiesBehindThoseOfTheHost) {
    const Described described;
    const Supports supports(described.network());
    const dttmm_network& whole = supports.description();
    ASSERT_EQ(whole.body_count, 4u);
    EXPECT_EQ(whole.bodies[2].position[0], 2);
    EXPECT_EQ(whole.bodies[3].position[0], 4);
    EXPECT_EQ(supports.body_of(0), -1);
    EXPECT_EQ(supports.body_of(1), 2);
    EXPECT_EQ(supports.body_of(2), -1);
    EXPECT_EQ(supports.body_of(3), 3);
    EXPECT_EQ(whole.nodes[1].kind, static_cast<uint32_t>(DTTMM_NODE_ON_BODY)) << "all directions: a point of it";
    EXPECT_EQ(whole.nodes[1].body, 2u);
    EXPECT_EQ(whole.nodes[2].kind, static_cast<uint32_t>(DTTMM_NODE_INNER));
    EXPECT_EQ(whole.nodes[3].kind, static_cast<uint32_t>(DTTMM_NODE_INNER)) << "some: it hangs on it";
    EXPECT_TRUE(Supports(dttmm_network{}).empty());
    for (const std::vector<uint32_t>& wrong : {std::vector<uint32_t>{0}, {9}, {3, 1}, {1, 1}}) {
        Described bad;
        bad.supports = wrong;
        EXPECT_THROW(Supports{bad.network()}, Error);
    }
}

// Oracle: a support that turns at a constant rate about one axis and falls freely, over unequal numbers of steps: the mean
// of the velocities over two steps is that of the instant, exactly for both.
TEST(Supports, VelocitiesStandAtTheInstant) {
    const Described described;
    Supports supports(described.network());
    const Vector3 spin = Vector3(3, -1, 2);
    constexpr double h = 0.01, a = -9;
    const auto at = [&](double t) {
        std::vector<dttmm_support_motion> motions(2);
        for (int i = 0; i < 3; ++i) motions[1].rotation[i] = t * spin(i);
        for (int i = 0; i < 3; ++i) motions[1].angular_velocity[i] = spin(i);
        motions[0].displacement[1] = 0.5 * a * t * t + 0.7 * t;
        motions[0].velocity[1] = a * t + 0.7;
        motions[0].acceleration[1] = a;
        return motions;
    };
    supports.move_to(at(0).data());
    supports.start();
    std::vector<dttmm_motion> out(2);
    for (int n = 0; n < 5; ++n) {
        supports.move_to(at((n + 1) * h).data());
        supports.begin_step(h);
        supports.write_end(out);
        EXPECT_NEAR(out[0].velocity[1], a * (n + 0.5) * h + 0.7, 1e-13) << "over the step";
        supports.commit_step();
        supports.write_instant(out);
        EXPECT_NEAR(out[0].velocity[1], a * n * h + 0.7, 1e-13) << n;
        EXPECT_NEAR(out[0].position[1], 0.2 + at(n * h)[0].displacement[1], 1e-15);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(out[1].angular_velocity[i], spin(i), 1e-12) << n;
    }
    double accelerations[12];
    supports.write_accelerations(accelerations);
    EXPECT_EQ(accelerations[1], a);
    // A force of 2 N on the support over a step: it has done minus its work
    double wrenches[12] = {0, 2};
    const double none[12] = {}, rigid[12] = {0, 0.5};
    supports.add_work(wrenches, none);
    EXPECT_EQ(supports.work(), 0) << "up to the start of that step";
    const double way = at(5 * h)[0].displacement[1] - at(4 * h)[0].displacement[1],
                 way_before = at(4 * h)[0].displacement[1] - at(3 * h)[0].displacement[1];
    // Of the next 2 N a rigid direction has 0.5 N at the start of the step, and had none before: 0.25 N over the step before
    supports.add_work(wrenches, rigid);
    EXPECT_NEAR(supports.work(), -2 * way - 0.25 * way_before, 1e-14);
    dttmm_support_motion nowhere[2] = {};
    nowhere[1].rotation[2] = NAN;
    EXPECT_THROW(supports.move_to(nowhere), Error);
}

// Oracle: a share of a turn about one axis is a turn about it.
TEST(Supports, StaticsLeadThemThere) {
    const Described described;
    Supports supports(described.network());
    std::vector<dttmm_support_motion> motions(2);
    const Vector3 turn = 1.9 * Vector3(1, 2, -2) / 3;
    for (int i = 0; i < 3; ++i) motions[0].rotation[i] = turn(i);
    motions[1].displacement[2] = 0.05;
    supports.begin_statics();
    supports.move_to(motions.data());
    supports.form_statics();
    double change[12];
    EXPECT_NEAR(supports.write_change(change).value(), 1.9, 1e-14);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(change[3 + i], turn(i), 1e-14);
    std::vector<dttmm_motion> out(2);
    supports.move_statics(0.4);
    supports.write_at_rest(out);
    const Matrix3 expected = Eigen::AngleAxisd(0.4 * 1.9, turn.normalized()).toRotationMatrix();
    EXPECT_LT((Eigen::Map<const RowMajor3>(out[0].rotation) - expected).norm(), 1e-14);
    EXPECT_NEAR(out[1].position[2], -0.3 + 0.4 * 0.05, 1e-15);
    supports.keep_statics();
    supports.move_statics(1);
    supports.form_statics();
    EXPECT_FALSE(supports.write_change(change)) << "it is there";
    supports.recall_statics();
    supports.form_statics();
    EXPECT_TRUE(supports.write_change(change));
}

// Oracle: about one axis the rotation vector is the angle, and a share of it the same share of the angle, beyond full turns
// too. Where the axis changes, the first change is the derivative of the frame: differences of exp(θ~) over 1e-6 of it.
TEST(Supports, StaticsCountFullTurns) {
    const Described described;
    Supports supports(described.network());
    std::vector<dttmm_support_motion> motions(2);
    const Vector3 axis = Vector3(2, -1, 2) / 3;
    const auto lead_to = [&](const Vector3& turn) {
        for (int i = 0; i < 3; ++i) motions[0].rotation[i] = turn(i);
        supports.move_to(motions.data());
        supports.form_statics();
    };
    const auto rotation = [&] {
        std::vector<dttmm_motion> out(2);
        supports.write_at_rest(out);
        return Matrix3(Eigen::Map<const RowMajor3>(out[0].rotation));
    };
    supports.begin_statics();
    double change[12];
    lead_to(4 * M_PI * axis);
    EXPECT_NEAR(supports.write_change(change).value(), 4 * M_PI, 1e-13);
    supports.move_statics(0.3);
    EXPECT_LT((rotation() - Eigen::AngleAxisd(1.2 * M_PI, axis).toRotationMatrix()).norm(), 1e-14);
    supports.form_statics();
    EXPECT_NEAR(supports.write_change(change).value(), 2.8 * M_PI, 1e-13) << "what is left of it";
    lead_to(Vector3(3.2, 1.4, -2.9));
    ASSERT_TRUE(supports.write_change(change));
    const Matrix3 before = rotation();
    constexpr double kShare = 1e-6;
    supports.move_statics(kShare);
    const Matrix3 by_change = (rotation() - before) * before.transpose() / kShare;
    const Vector3 turn(by_change(2, 1), by_change(0, 2), by_change(1, 0));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(change[3 + i], turn(i), 1e-4) << i;
}

}  // namespace
}  // namespace dttmm::plugin
