// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/networks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/models.h"
#include "support/states.h"

namespace dttmm::host {
namespace {

/// Two turned bodies with centres of mass off their origins; a spring to the ground, and one between turned markers.
Model two_bodies(const Plugins& plugins) {
    Model model;
    model.simulation.step = 1e-3;
    Body first = test::box("first", 2, {0.1, 0.2, 0.3}, {0.4, -0.1, 0.7});
    first.center_of_mass = {0.05, -0.02, 0.01};
    first.rotation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    first.markers.push_back({"foot", {0.1, 0.2, -0.3}, nullptr});
    first.markers.push_back(
        {"hand", {0.3, 0.1, 0.2}, std::make_shared<Eigen::Matrix3d>(Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitX()))});
    Body second = test::box("second", 3, {0.3, 0.1, 0.1}, {0.9, 0.2, 0.5});
    second.center_of_mass = {-0.02, 0.03, 0.04};
    second.rotation = Eigen::AngleAxisd(-1.4, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix();
    model.bodies = {first, second};
    model.elements.push_back(test::spring("leg", plugins, {}, {0, 0}, 700, 3));
    model.elements.push_back(test::spring("arm", plugins, {0, 1}, {1, -1}, 400, 2));
    return model;
}

Eigen::Vector3d marker_position(const Model& model, const std::vector<BodyState>& at, size_t body,
                                const Eigen::Vector3d& marker) {
    return at[body].position + at[body].rotation * (marker - model.bodies[body].center_of_mass);
}

// Oracle: isotropic springs by hand: force −k (displacement of the marker from where it was assembled, seen from the other
// end), moment about the centre of mass by its lever arm.
TEST(Networks, BodyWrenchesAreThoseOfTheirSprings) {
    const Plugins plugins;
    const Model model = two_bodies(plugins);
    Networks networks(model, plugins);
    const std::vector<BodyState> rest = test::start_states(model);
    std::vector<BodyState> moved = rest;
    moved[0].position += Eigen::Vector3d(0.01, -0.02, 0.03);
    moved[1].position += Eigen::Vector3d(-0.05, 0.01, 0.02);
    for (BodyState& state : moved) state.velocity = state.angular_velocity = Eigen::Vector3d::Zero();
    moved[0].rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()) * rest[0].rotation;

    std::vector<double> wrenches(12, 0.0);
    networks.linearise(moved, wrenches.data(), nullptr);

    const Eigen::Vector3d foot = model.bodies[0].markers[0].position, hand = model.bodies[0].markers[1].position;
    const Eigen::Vector3d leg = -700 * (marker_position(model, moved, 0, foot) - marker_position(model, rest, 0, foot));
    const Eigen::Matrix3d turned = moved[0].rotation * rest[0].rotation.transpose();
    const Eigen::Vector3d p_rest = marker_position(model, rest, 1, {0, 0, 0}) - marker_position(model, rest, 0, hand);
    const Eigen::Vector3d p = marker_position(model, moved, 1, {0, 0, 0}) - marker_position(model, moved, 0, hand);
    const Eigen::Vector3d arm = 400 * (p - turned * p_rest);  // pulls the first body along, the second back

    const Eigen::Map<const Eigen::Vector3d> f0(&wrenches[0]), m0(&wrenches[3]), f1(&wrenches[6]), m1(&wrenches[9]);
    EXPECT_LT((f0 - leg - arm).norm(), 1e-11);
    EXPECT_LT((f1 + arm).norm(), 1e-11);
    const Eigen::Vector3d foot_arm = marker_position(model, moved, 0, foot) - moved[0].position;
    const Eigen::Vector3d end = marker_position(model, moved, 1, {0, 0, 0});
    EXPECT_LT((m0 - foot_arm.cross(leg) - (end - moved[0].position).cross(arm)).norm(), 1e-11);
    EXPECT_LT((m1 + (end - moved[1].position).cross(arm)).norm(), 1e-11);
}

// Oracle: central differences of the body wrenches by the bodies' poses, at rest.
TEST(Networks, BodyStiffnessIsTheDerivativeOfTheBodyWrenches) {
    const Plugins plugins;
    const Model model = two_bodies(plugins);
    Networks networks(model, plugins);
    const std::vector<BodyState> rest = test::start_states(model);
    Eigen::Matrix<double, 12, 12> S = Eigen::Matrix<double, 12, 12>::Zero();
    const Networks::LinearSink add = [&](int row, int column, const Networks::Block& block, const Networks::Block&) {
        S.block<6, 6>(6 * row, 6 * column) += block;
    };
    Eigen::Matrix<double, 12, 1> wrench = Eigen::Matrix<double, 12, 1>::Zero();
    networks.linearise(rest, wrench.data(), &add);
    EXPECT_LT(wrench.norm(), 1e-11);
    for (size_t body = 0; body < 2; ++body)
        for (int i = 0; i < 6; ++i) {
            const auto wrench_at = [&](double e) {
                std::vector<BodyState> moved = rest;
                if (i < 3)
                    moved[body].position(i) += e;
                else
                    moved[body].rotation = Eigen::AngleAxisd(e, Eigen::Vector3d::Unit(i - 3)) * moved[body].rotation;
                Eigen::Matrix<double, 12, 1> w = Eigen::Matrix<double, 12, 1>::Zero();
                networks.linearise(moved, w.data(), nullptr);
                return w;
            };
            const Eigen::Matrix<double, 12, 1> difference = -(wrench_at(1e-6) - wrench_at(-1e-6)) / 2e-6;
            EXPECT_LT((S.col(static_cast<int>(6 * body) + i) - difference).norm(), 1e-6 * S.norm())
                << "body " << body << ", " << i;
        }
}

// Oracle: the matrices of each element alone. Springs and dampers side by side act along the same lines, so that what an
// element dissipates is what it stores by c/k.
TEST(Networks, ElementsAreToldApart) {
    const Plugins plugins;
    const Model model = two_bodies(plugins);
    const std::vector<BodyState> rest = test::start_states(model);
    Eigen::Matrix<double, 12, 1> u;
    u << 0.3, -0.2, 0.7, 1.1, -0.4, 0.6, -0.9, 0.5, 0.1, 0.8, -1.3, 0.2;
    Networks networks(model, plugins);
    const std::vector<Networks::TakenUp> taken = networks.take_up(rest, u.data());
    ASSERT_EQ(taken.size(), 2u);
    for (size_t e = 0; e < 2; ++e) {
        Model alone = model;
        alone.elements = {model.elements[e]};
        Networks own(alone, plugins);
        double elastic = 0, damped = 0;
        const Networks::LinearSink add = [&](int row, int column, const Networks::Block& K, const Networks::Block& C) {
            elastic += u.segment<6>(6 * row).dot(K * u.segment<6>(6 * column));
            damped += u.segment<6>(6 * row).dot(C * u.segment<6>(6 * column));
        };
        std::vector<double> wrenches(12);
        own.linearise(rest, wrenches.data(), &add);
        EXPECT_EQ(taken[e].element, model.elements[e].name);
        EXPECT_NEAR(taken[e].elastic, elastic, 1e-12 * elastic);
        EXPECT_NEAR(taken[e].damped, damped, 1e-12 * damped);
        EXPECT_NEAR(damped, (e == 0 ? 3.0 / 700 : 2.0 / 400) * elastic, 1e-12 * damped);
    }
}

TEST(Networks, NeighboursAreTheBodiesThatShareAnElement) {
    const Plugins plugins;
    const Networks networks(two_bodies(plugins), plugins);
    ASSERT_EQ(networks.neighbours().size(), 1u);
    EXPECT_EQ(networks.neighbours()[0], (std::pair<int, int>{1, 0}));
    EXPECT_EQ(networks.instances().size(), 1u);
    EXPECT_TRUE(networks.is_implicit());
    EXPECT_EQ(networks.load_weights()[0] + networks.load_weights()[1] + networks.load_weights()[2], 1.0);
}

// What the plugin refuses is told with the place of the element in the model file.
TEST(Networks, ARefusalNamesTheElementsPlace) {
    const Plugins plugins;
    Model model = two_bodies(plugins);
    model.elements[1].values.change()[4] = -1;
    model.elements[1].place = "machine.toml:31:1";
    try {
        const Networks networks(model, plugins);
        FAIL() << "a negative damping was accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("machine.toml:31:1"), std::string::npos) << text;
        EXPECT_NE(text.find("\"arm\""), std::string::npos) << text;
        EXPECT_NE(text.find("damping"), std::string::npos) << text;
    }
}

}  // namespace
}  // namespace dttmm::host
