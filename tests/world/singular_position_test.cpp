// SPDX-License-Identifier: BSD-3-Clause
#include "world/singular_position.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/bodies.h"

namespace dttmm::host {
namespace {

// Oracle: the drawings. A chain from the ground and a tree have no loop, also in any order of the joints; four bars, two
// hinges between the same bodies, and a chain that ends on the ground again have one.
TEST(SingularPosition, LoopsOfJoints) {
    const auto loop = [](const std::vector<std::pair<int, int>>& between) {
        std::vector<Joint> joints;
        for (const auto& [first, second] : between)
            joints.push_back(test::pin("j", first, second, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
        return form_loop(joints);
    };
    EXPECT_FALSE(loop({}));
    EXPECT_FALSE(loop({{-1, 0}}));
    EXPECT_FALSE(loop({{2, 1}, {-1, 0}, {1, 0}}));
    EXPECT_FALSE(loop({{3, 4}, {0, 3}, {-1, 1}, {0, 2}, {1, 0}}));
    EXPECT_TRUE(loop({{-1, 0}, {0, -1}}));
    EXPECT_TRUE(loop({{-1, 0}, {1, 2}, {0, 1}, {2, -1}}));
    EXPECT_TRUE(loop({{3, 4}, {-1, 0}, {5, 3}, {4, 5}}));
}

// A parallelogram that lies flat half way through a step, beside bodies that are fixed to the ground. Oracle: it is seen
// among 800 equations, and not looked for among 1250.
TEST(SingularPosition, IsNotLookedForAmongMoreThanAThousandEquations) {
    for (const int fixed : {0, 130, 205}) {
        std::vector<Body> bodies = {test::box("crank", 1, {1, 0.1, 0.1}, {0.5, 0, 0}),
                                    test::box("rocker", 1.3, {1, 0.1, 0.1}, {2.5, 0, 0}),
                                    test::box("coupler", 2, {2, 0.1, 0.1}, {2, 0, 0})};
        const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
        std::vector<Joint> joints = {test::pin("a", -1, 0, {0, 0, 0}, z), test::pin("b", -1, 1, {2, 0, 0}, z),
                                     test::pin("c", 0, 2, {1, 0, 0}, z), test::pin("d", 1, 2, {3, 0, 0}, z)};
        for (int i = 0; i < fixed; ++i) {
            bodies.push_back(test::box("b", 1, {0.1, 0.1, 0.1}, {0, 0, 1.0 + i}));
            joints.push_back(test::pin("f", -1, 3 + i, {0, 0, 1.0 + i}, z));
            joints.back().type = JointType::fixed;
        }
        const auto at = [&](double angle) {
            std::vector<BodyState> states;
            for (const Body& body : bodies) {
                BodyState state;
                state.position = body.position;
                state.rotation.setIdentity();
                state.velocity.setZero();
                state.angular_velocity.setZero();
                states.push_back(state);
            }
            const Eigen::Vector3d along(std::cos(angle), std::sin(angle), 0);
            states[0].position = 0.5 * along;
            states[1].position = Eigen::Vector3d(2, 0, 0) + 0.5 * along;
            states[2].position = Eigen::Vector3d(1, 0, 0) + along;
            for (int i : {0, 1}) states[static_cast<size_t>(i)].rotation = Eigen::AngleAxisd(angle, z).toRotationMatrix();
            return states;
        };
        const JointSystem system(bodies, joints);
        SingularPosition position(system, true);
        position.open();
        position.find(system, at(-0.01), at(0), at(0.01));
        EXPECT_EQ(position.is_near(), 20 + 6 * fixed <= 1000) << fixed;
    }
}

}  // namespace
}  // namespace dttmm::host
