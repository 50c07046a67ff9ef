// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"

namespace dttmm::host {
namespace {

// What follows holds a number between 0.8 and 1.25 times itself: at half and at twice of it a line fails.
constexpr double kBelow = 0.8, kAbove = 1.25;

BodyState at_rest(const Body& body) { return {body.position, body.rotation, {0, 0, 0}, {0, 0, 0}}; }

// Oracle: a ball joint at the centre of mass holds 1/m, whatever the moments of inertia are. E is 1e-7 of that, 1e-10 and
// 1e-13 where passes gain too little, and a step later a thousand times as much.
TEST(JointSystem, EIsAShareOfTheMobility) {
    const std::vector<Body> bodies = {test::box("block", 3.7, {0.3, 0.2, 0.1}, {0.4, -0.7, 0.2})};
    Joint ball;
    ball.second = 0;
    ball.anchor = bodies[0].position;
    JointSystem system(bodies, {ball});
    BlockMatrix matrix(1, {}, system.nodes());
    const std::vector<BodyState> now = {at_rest(bodies[0])};
    const auto share = [&] {
        matrix.set_zero();
        BlockMatrix::Block K = BlockMatrix::Block::Zero();
        K.diagonal().head<3>().setConstant(bodies[0].mass);
        K.bottomRightCorner<3, 3>() = bodies[0].inertia;
        matrix.add(0, 0, K);
        system.write_to(matrix);
        return std::abs(matrix.upper().diagonal()(matrix.joint_index(0) + 1)) * bodies[0].mass;
    };
    const auto expect = [&](double E) {
        EXPECT_GT(share(), kBelow * E);
        EXPECT_LT(share(), kAbove * E);
    };
    system.linearise(now, now, std::vector<Stop>(1));
    expect(1e-7);
    for (const double E : {1e-10, 1e-13, 1e-13}) {
        system.tighten();
        expect(E);
    }
    for (const double E : {1e-10, 1e-7, 1e-7}) {
        system.linearise(now, now, std::vector<Stop>(1));
        expect(E);
    }
}

// Oracle: 1e-12 m from where the stop is; the slider is 0.5 m long to one side and 0.9 m to the other.
TEST(JointSystem, AStopIsReachedWithinATrillionth) {
    const std::vector<Body> bodies = {test::box("block", 3.7, {0.3, 0.2, 0.1}, {0, 0, 0})};
    Joint slider;
    slider.type = JointType::slider;
    slider.second = 0;
    slider.limits = {-0.5, 0.9};
    const JointSystem system(bodies, {slider});
    const auto side = [&](double travel) {
        BodyState now = at_rest(bodies[0]);
        now.position.x() += travel;
        std::vector<Stop> stops(1);
        system.find_stops({now}, stops, stops);
        return stops[0].side;
    };
    EXPECT_EQ(side(-0.5 + kBelow * 1e-12), 1);
    EXPECT_EQ(side(-0.5 + kAbove * 1e-12), 0);
    EXPECT_EQ(side(0.9 - kBelow * 1e-12), -1);
    EXPECT_EQ(side(0.9 - kAbove * 1e-12), 0);
}

}  // namespace
}  // namespace dttmm::host
