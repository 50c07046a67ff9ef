// SPDX-License-Identifier: BSD-3-Clause
#include "statics/hanging_frames.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

/// Two branches at a node that a spring holds, one described from the tip inwards; a loop with a pendulum of its own; and
/// what only a line to it holds.
class Tree : public testing::Test {
protected:
    Tree() {
        const Values spring = {{"stiffness", {4e3, 2e3, 3e3}}, {"rotational_stiffness", {70, 40, 90}}},
                     ball = {{"stiffness", {5e3}}, {"rotational_stiffness", {0}}};
        model_.node("root", DTTMM_NODE_GROUND, {0.1, -0.2, 0.3});
        const std::pair<const char*, Eigen::Vector3d> inner[] = {
            {"fork", {0.7, 0.1, 0.2}}, {"left", {1.1, 0.5, 0.4}}, {"tip", {1.3, 0.9, 0.1}},  {"right", {1.0, -0.4, 0.3}},
            {"p", {-0.5, 0.2, 0.6}},   {"q", {-0.4, -0.5, 0}},    {"bob", {-0.9, -0.6, -1}}, {"lone", {0.2, 0.3, -1.4}}};
        for (const auto& [name, position] : inner) model_.node(name, DTTMM_NODE_INNER, position);
        model_.element("trunk", "spring_damper", {"root", "fork"}, spring);
        model_.element("limb", "spring_damper", {"fork", "left"}, spring);
        model_.element("twig", "spring_damper", {"tip", "left"}, spring);
        model_.element("bough", "spring_damper", {"right", "fork"}, ball);
        model_.element("one", "spring_damper", {"root", "p"}, spring);
        model_.element("two", "spring_damper", {"p", "q"}, spring);
        model_.element("three", "spring_damper", {"q", "root"}, spring);
        model_.element("thread", "spring_damper", {"q", "bob"}, ball);
        model_.element("line", "axial_spring", {"p", "lone"}, {{"stiffness", {900}}});
    }
    using Values = test::NetworkModel::Values;
    test::NetworkModel model_;
};

int frame_of(const Mechanism& mechanism, const dttmm_network& description, const std::string& name) {
    for (uint32_t n = 0; n < description.node_count; ++n)
        if (description.nodes[n].name == name) return mechanism.assembly.nodes[n].frame;
    return -1;
}

TEST_F(Tree, FramesHangByOneJoint) {
    const dttmm_network description = model_.description();
    const Mechanism mechanism(description);
    const HangingFrames hanging(mechanism);
    for (const char* const name : {"fork", "left", "tip", "right", "bob"})
        EXPECT_TRUE(hanging.hangs(frame_of(mechanism, description, name))) << name;
    for (const char* const name : {"p", "q", "lone"})
        EXPECT_FALSE(hanging.hangs(frame_of(mechanism, description, name))) << name;
}

// Oracle: the deformations measured in the new places are those that the small motions add up to, however large they are.
TEST_F(Tree, GoWhereTheirDeformationsLead) {
    const dttmm_network description = model_.description();
    const Mechanism mechanism(description);
    HangingFrames hanging(mechanism);
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> draw(-0.6, 0.6);
    std::vector<Frame> frames = described_frames(mechanism);
    for (int round = 0; round < 3; ++round) {
        std::vector<PlacedJoint> placed;
        const std::vector<Frame> before = frames;
        for (const Joint& joint : mechanism.joints)
            placed.emplace_back(joint, Ends{before[as_size(joint.from())], before[as_size(joint.to())]});
        std::vector<Vector6> motion(frames.size(), Vector6::Zero());
        for (size_t f = as_size(mechanism.assembly.driven_count); f < motion.size(); ++f)
            for (double& number : motion[f]) number = draw(engine);
        const auto motion_of = [&](int frame) { return motion[as_size(frame)]; };
        hanging.deform([&](size_t j) -> const PlacedJoint& { return placed[j]; }, motion_of);
        for (const char* const name : {"p", "q"}) {  // as the network moves what is in a loop
            Frame& frame = frames[as_size(frame_of(mechanism, description, name))];
            frame.position[0] += 0.3;
        }
        hanging.place(mechanism, frames);
        int checked = 0;
        hanging.for_each_joint([&](size_t j) {
            const Joint& joint = mechanism.joints[j];
            const PlacedJoint now(joint, {frames[as_size(joint.from())], frames[as_size(joint.to())]});
            const Vector6 change = change_of_motion(placed[j], motion_of(joint.from()), motion_of(joint.to()));
            EXPECT_LT((now.x.head<3>() - placed[j].x.head<3>() - change.head<3>()).norm(), 1e-13);
            if (joint.turns()) {
                EXPECT_LT((now.x.tail<3>() - placed[j].x.tail<3>() - change.tail<3>()).norm(), 1e-12);
            }
            ++checked;
        });
        EXPECT_EQ(checked, 5);
        frames = before;
        for (Frame& frame : frames) frame.position[1] += 0.1;
    }
}

}  // namespace
}  // namespace dttmm::plugin
