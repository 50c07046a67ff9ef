// SPDX-License-Identifier: BSD-3-Clause
//
// A joint along a line between two ports.
#include <gtest/gtest.h>

#include "core/rotation.h"
#include "support/dense_network.h"
#include "support/network_model.h"
#include "time/network.h"

namespace dttmm::plugin {
namespace {

using test::DenseNetwork;

using test::NetworkModel;

struct Place {
    Vector3 position;
    Matrix3 rotation;
    dttmm_motion motion() const {
        dttmm_motion motion{};
        Eigen::Map<Vector3>{motion.position} = position;
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{motion.rotation} = rotation;
        return motion;
    }
    Place displaced(const Vector6& d) const {
        return {position + d.head<3>(), rotation_from_vector(Vector3(d.tail<3>())) * rotation};
    }
};

// Oracle: central differences of the wrench. Its symmetric part is the second derivative of the energy, as of any force that
// turns with what it acts on.
TEST(AxialJoint, StiffnessOfTheStepHasThatOfItsForce) {
    for (const NetworkModel::Values& law :
         {NetworkModel::Values{{"stiffness", {4e3}}, {"damping", {7}}, {"preload", {900}}},
          NetworkModel::Values{{"law", {1}}, {"stiffness", {3e3}}, {"cubic", {2e5}}, {"natural_length", {0.35}}}}) {
        const Place start[2] = {{Vector3(0.3, -0.1, 0.2), rotation_from_vector(Vector3(0.4, -0.8, 1.3))},
                                {Vector3(0.6, 0.25, -0.1), rotation_from_vector(Vector3(-1.1, 0.2, 0.6))}};
        NetworkModel model;
        const Vector3 arms[2] = {{0.07, -0.11, 0.05}, {-0.13, 0.04, 0.09}};
        Place centres[2];
        for (int p : {0, 1}) {
            model.node(p == 0 ? "a" : "b", DTTMM_NODE_ON_BODY, start[p].position, start[p].rotation, arms[p]);
            centres[p] = {start[p].position - start[p].rotation * arms[p], start[p].rotation};
        }
        model.element("s", "axial_spring", {"a", "b"}, law);
        DenseNetwork network(model.description());
        const double accelerations[12] = {};
        const dttmm_motion motions[] = {centres[0].motion(), centres[1].motion()};
        network.start({0, 0, 0.01}, motions, accelerations, nullptr);
        network.begin_step({0, 0, 0.01}, nullptr);
        using Vector = Eigen::Matrix<double, 12, 1>;
        const auto wrench_at = [&](const Place& a, const Place& b) {
            const dttmm_motion trial[] = {a.motion(), b.motion()};
            Vector wrench;
            network.evaluate(trial, wrench.data(), nullptr);
            return wrench;
        };
        Vector wrench;
        Eigen::Matrix<double, 12, 12, Eigen::RowMajor> S;
        network.evaluate(motions, wrench.data(), S.data());
        Eigen::Matrix<double, 12, 12> difference;
        for (int i = 0; i < 12; ++i) {
            const double e = 1e-6;
            const auto moved = [&](double way) {
                Place at[2] = {centres[0], centres[1]};
                at[i / 6] = centres[i / 6].displaced(way * Vector6::Unit(i % 6));
                return wrench_at(at[0], at[1]);
            };
            difference.col(i) = -(moved(e) - moved(-e)) / (2 * e);
        }
        const Eigen::Matrix<double, 12, 12> expected = 0.5 * (difference + difference.transpose());
        const Eigen::Matrix<double, 12, 12> found = 0.5 * (S + S.transpose());
        EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
    }
}

// Oracle: differences of its length along motions with constant accelerations.
TEST(AxialJoint, RatesAreThoseOfItsLength) {
    const Place start[2] = {{Vector3(0.3, -0.1, 0.2), rotation_from_vector(Vector3(0.4, -0.8, 1.3))},
                            {Vector3(0.6, 0.25, -0.1), rotation_from_vector(Vector3(-1.1, 0.2, 0.6))}};
    const Twist velocity[2] = {{Vector3(0.7, -1.2, 0.4), Vector3(0.9, 1.4, -0.6)},
                               {Vector3(-0.3, 0.8, 1.1), Vector3(-1.3, 0.5, 0.7)}},
                acceleration[2] = {{Vector3(2, 1, -3), Vector3(-1, 2, 4)}, {Vector3(-1, 3, 2), Vector3(5, -2, 1)}};
    NetworkModel model;
    const Vector3 arms[2] = {{0.07, -0.11, 0.05}, {-0.13, 0.04, 0.09}};
    for (int p : {0, 1}) {
        model.node(p == 0 ? "a" : "b", DTTMM_NODE_ON_BODY, start[p].position, start[p].rotation, arms[p]);
    }
    model.element("s", "axial_spring", {"a", "b"}, {{"stiffness", {1}}, {"natural_length", {0.2}}});
    const Assembly assembly = assemble(model.description());
    const Joint joint(assembly.joints[0], assembly, std::make_shared<JointKind>(assembly.joints[0].law));
    // The frames lie at the centres of mass. θ' = ω to second order as ω + ½ α t turns about the start
    const auto frame_at = [&](int p, double t) {
        const Vector3 centre = start[p].position - start[p].rotation * arms[p];
        const Vector3 turn = t * velocity[p].angular + 0.5 * t * t * acceleration[p].angular;
        return make_frame({centre + t * velocity[p].linear + 0.5 * t * t * acceleration[p].linear,
                           rotation_from_vector(turn) * start[p].rotation});
    };
    const auto elongation = [&](double t) {
        const Frame from = frame_at(0, t), to = frame_at(1, t);
        return joint.deformation(joint.pose(from, to), from, to)(0);
    };
    const Frame from = frame_at(0, 0), to = frame_at(1, 0);
    EXPECT_NEAR(elongation(0), (start[1].position - start[0].position).norm() - 0.2, 1e-15);
    constexpr double e = 1e-4;
    const Vector6 rate = joint.rate(from, velocity[0], to, velocity[1]);
    EXPECT_NEAR(rate(0), (elongation(e) - elongation(-e)) / (2 * e), 1e-7);
    EXPECT_EQ(rate.tail<5>().norm(), 0);
    const Vector6 second = joint.acceleration(from, velocity[0], acceleration[0], to, velocity[1], acceleration[1]);
    EXPECT_NEAR(second(0), (elongation(e) - 2 * elongation(0) + elongation(-e)) / (e * e), 1e-5);
    // Its axes turn as the line does
    const auto axis = [&](double t) { return Vector3(joint.pose(frame_at(0, t), frame_at(1, t)).axes.col(0)); };
    const Vector3 turning = joint.pose(from, to).axes * joint.turning(from, velocity[0], to, velocity[1]);
    EXPECT_LT((turning.cross(axis(0)) - (axis(e) - axis(-e)) / (2 * e)).norm(), 1e-6);
}

}  // namespace
}  // namespace dttmm::plugin
