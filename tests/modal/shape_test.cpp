// SPDX-License-Identifier: BSD-3-Clause
#include "modal/shape.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <memory>

#include "modal/inverse_iteration.h"
#include "modal/shape_basis.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

// A beam, and two bodies on springs, one to the ground. Their force turns, one body has a lever. Oracle: the strain of a mix
// of three shapes, element by element.
TEST(StrainBetween, IsTheStrainOfEveryMix) {
    test::NetworkModel network;
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    network.node("a", DTTMM_NODE_INNER, {0.3, 0, 0});
    network.node("b", DTTMM_NODE_INNER, {0.9, 1.1, -0.4});
    network.node("c", DTTMM_NODE_INNER, {1.7, 0.2, 0.8});
    network.element("beam", "beam", {"a", "b"},
                    {{"theory", {0}},
                     {"section.EA", {4e6}},
                     {"section.EIy", {3e5}},
                     {"section.EIz", {7e5}},
                     {"section.GJ", {2e5}},
                     {"section.mass", {16}},
                     {"section.inertia", {0.05}}});
    network.element("spring", "spring_damper", {"b", "c"},
                    {{"stiffness", {3e5, 7e5, 2e6}}, {"rotational_stiffness", {9e4, 3e5, 2e5}}});
    network.element("foot", "spring_damper", {"ground", "c"}, {{"stiffness", {8e5}}});
    network.element("mass", "point_mass", {"c"}, {{"mass", {3.1}}});
    const dttmm_network description = network.description();
    FrequencyModel model({&description, 0, nullptr, 0b111111, 0, nullptr});
    ASSERT_EQ(model.bonds.size(), 2u);
    Eigen::MatrixXd turning = Eigen::MatrixXd::Random(12, 12) * 1e5;
    turning = (turning + turning.transpose()).eval();
    EndBlocks blocks;
    for (const int i : {0, 1})
        for (const int k : {0, 1}) blocks.at[i][k] = turning.block<6, 6>(6 * i, 6 * k);
    model.bonds[0].turning = std::make_shared<const EndBlocks>(blocks);
    const Matrix6 lever = 4e5 * Matrix6::Random();
    model.levers.push_back({0, 1, lever + lever.transpose()});

    DynamicStiffness D(model);
    D.cut(300);
    D.set(2e4);
    const std::vector<FrameVector> shapes = InverseIteration(D).random_shapes(3);
    const Eigen::MatrixXd energy = strain_between(D, shapes);
    EXPECT_EQ(energy, energy.transpose());
    for (const Eigen::Vector3d& mix :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.4, -1.3, 0), Eigen::Vector3d(-2, 0.7, 0.9)}) {
        const double whole = sum(strain_energies(D, mixed(shapes, mix).front())).energy;
        EXPECT_NEAR(mix.dot(energy * mix), whole, 1e-12 * energy.cwiseAbs().sum());
    }
}

}  // namespace
}  // namespace dttmm::plugin
