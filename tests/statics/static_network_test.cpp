// SPDX-License-Identifier: BSD-3-Clause
#include "statics/static_network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

/// A bar that springs hold, clamped to the ground at its root, between that and a body.
test::NetworkModel bent_bar() {
    test::NetworkModel model;
    model.node("root", DTTMM_NODE_GROUND, {0.1, -0.2, 0.3});
    model.node("middle", DTTMM_NODE_INNER, {0.7, 0.1, 0.2});
    model.node("body", DTTMM_NODE_ON_BODY, {1.4, 0.2, 0.1});
    const test::NetworkModel::Values springs = {
        {"stiffness", {4e3, 2e3, 3e3}}, {"rotational_stiffness", {70, 40, 90}}, {"damping", {0}}};
    model.element("lower", "spring_damper", {"root", "middle"}, springs);
    model.element("upper", "spring_damper", {"middle", "body"}, springs);
    return model;
}

/// The condensed equations of a network whose inside took shares of its first correction, one after the other.
std::vector<double> formed_after(const std::vector<double>& shares) {
    const test::NetworkModel model = bent_bar();
    const dttmm_network description = model.description();
    const Mechanism mechanism(description);
    StaticNetwork network(mechanism, Loading(mechanism.assembly, description));
    dttmm_motion body{};
    body.position[0] = 1.4;
    body.position[1] = 0.2;
    body.position[2] = 0.1;
    for (const int i : {0, 4, 8}) body.rotation[i] = 1;
    const uint32_t index = 0;
    const double loads[6] = {300, -500, 200, 0, 0, 0};
    network.set_loads(Vector3::Zero(), loads);
    network.form({&body, &index}, 0);
    network.correct(std::vector<Vector6>(1, Vector6::Zero()));
    for (const double share : shares) network.move({&body, &index}, share);
    network.form({&body, &index}, 0);
    std::vector<double> all(42, 0.0);
    std::vector<Vector6> wrench(1, Vector6::Zero());
    network.condense(wrench, all.data());
    std::copy_n(wrench[0].data(), 6, all.data() + 36);
    return all;
}

// Oracle: the share that counts, taken alone: dttmm_static.h says that the first may be too large.
TEST(StaticNetwork, ASmallerShareTakesThePlaceOfTheFirst) {
    const std::vector<double> once = formed_after({0.3}), twice = formed_after({1, 0.3}), other = formed_after({1});
    for (size_t i = 0; i < once.size(); ++i) EXPECT_DOUBLE_EQ(twice[i], once[i]) << i;
    EXPECT_NE(other[0], once[0]) << "the share counts";
}

}  // namespace
}  // namespace dttmm::plugin
