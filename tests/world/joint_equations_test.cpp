// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <random>

#include "support/bodies.h"
#include "support/linear_algebra.h"
#include "world/rotation_step.h"

namespace dttmm::host {
namespace {

const JointType kTypes[] = {JointType::ball, JointType::hinge, JointType::slider, JointType::universal, JointType::fixed};

Body ugly_body(const std::string& name, const Eigen::Vector3d& position, const Eigen::Vector3d& turned) {
    Body body = test::box(name, 3.7, {0.3, 0.2, 0.1}, position);
    body.center_of_mass = {0.03, -0.02, 0.05};
    body.rotation = RotationStep(turned).apply(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
    return body;
}

Joint joint_of(JointType type, int first, int second) {
    Joint joint;
    joint.name = "joint";
    joint.type = type;
    joint.first = first;
    joint.second = second;
    joint.anchor = {0.4, -0.7, 0.2};
    joint.axis = Eigen::Vector3d(1, 2, -2) / 3;
    joint.axis2 = Eigen::Vector3d(2, 1, 2) / 3;
    if (type == JointType::hinge || type == JointType::slider) joint.limits = {-0.5, 0.9};
    return joint;
}

class AllJoints : public testing::TestWithParam<std::tuple<JointType, int, int>> {
protected:
    std::vector<Body> bodies = {ugly_body("one", {0.3, 0.1, -0.2}, {0.4, -1.1, 0.7}),
                                ugly_body("two", {-0.5, 0.2, 0.9}, {-1.3, 0.2, 0.5})};
    JointType type = std::get<0>(GetParam());
    JointEquations joint{joint_of(type, std::get<1>(GetParam()), std::get<2>(GetParam())), bodies};

    std::vector<BodyState> start() const {
        std::vector<BodyState> at;
        for (const Body& b : bodies)
            at.push_back(
                {b.position + b.rotation * b.center_of_mass, b.rotation, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
        return at;
    }
    static std::vector<BodyState> moved(std::vector<BodyState> at, double t) {
        for (BodyState& b : at) {
            b.position += t * b.velocity;
            b.rotation = RotationStep(t * b.angular_velocity).apply(b.rotation);
        }
        return at;
    }
    /// Somewhere off the joint, with velocities: the derivatives must hold there too.
    std::vector<BodyState> off() const {
        std::vector<BodyState> at = start();
        std::mt19937 generator(5);
        std::uniform_real_distribution<double> number(-1, 1);
        const auto any = [&] { return Eigen::Vector3d::NullaryExpr([&] { return number(generator); }).eval(); };
        for (BodyState& b : at) {
            b.velocity = any();
            b.angular_velocity = any();
        }
        at = moved(at, 0.1);
        for (BodyState& b : at) {
            b.velocity = any();
            b.angular_velocity = any();
        }
        return at;
    }
    Eigen::VectorXd residual(const std::vector<BodyState>& at) const { return joint.residual(at); }
};

INSTANTIATE_TEST_SUITE_P(JointEquations, AllJoints,
                         testing::Combine(testing::ValuesIn(kTypes), testing::Values(0), testing::Values(1, -1)));
INSTANTIATE_TEST_SUITE_P(JointEquationsFromGround, AllJoints,
                         testing::Combine(testing::ValuesIn(kTypes), testing::Values(-1), testing::Values(1)));

TEST_P(AllJoints, IsClosedAtTheStart) { EXPECT_LT(residual(start()).norm(), 1e-15); }

// Oracle: central differences of C along the motion of constant velocities; error of order t² and rounding/t.
TEST_P(AllJoints, JacobianIsTheRateOfTheEquations) {
    const std::vector<BodyState> at = off();
    const JointEquations::Jacobian J = joint.jacobian(at);
    Eigen::VectorXd rate = Eigen::VectorXd::Zero(joint.count());
    for (const size_t side : {0u, 1u}) {
        const int body = joint.bodies()[side];
        if (body < 0) continue;
        Eigen::Matrix<double, 6, 1> u;
        u << at[static_cast<size_t>(body)].velocity, at[static_cast<size_t>(body)].angular_velocity;
        rate += J[side] * u;
    }
    const double t = 1e-5;
    const Eigen::VectorXd expected = (residual(moved(at, t)) - residual(moved(at, -t))) / (2 * t);
    EXPECT_LT((rate.head(joint.lasting()) - expected).norm(), 1e-9);
}

// Oracle: second differences of C.
TEST_P(AllJoints, CurvatureIsTheSecondRateAtConstantVelocities) {
    const std::vector<BodyState> at = off();
    const Eigen::VectorXd curvature = joint.curvature(at);
    const double t = 1e-3;
    const Eigen::VectorXd expected = (residual(moved(at, t)) - 2 * residual(at) + residual(moved(at, -t))) / (t * t);
    EXPECT_LT((curvature.head(joint.lasting()) - expected).norm(), 1e-5);
}

// The same of a coordinate, whose row is that of a closed joint: the second body moves against the first at a rate of 0.7.
TEST_P(AllJoints, CurvatureOfACoordinateIsItsSecondRate) {
    const bool on_ground = joint.bodies()[0] < 0 || joint.bodies()[1] < 0;
    if (!joint.has_coordinate()) return;
    const Joint described = joint_of(type, 0, 1);
    std::vector<BodyState> at = off();
    for (size_t b = 0; b < 2; ++b) {  // about the anchor
        const BodyState place = start()[b];
        at[b].position = place.position;
        at[b].rotation = place.rotation;
        at[b].angular_velocity = (on_ground ? 0.0 : 1.0) * Eigen::Vector3d(1.1, -0.4, 0.8);
    }
    if (joint.turns()) at[1].angular_velocity += 0.7 * described.axis;
    for (BodyState& body : at) body.velocity = body.angular_velocity.cross(body.position - described.anchor);
    if (!joint.turns()) at[1].velocity += 0.7 * described.axis;
    const double t = 1e-3, q = joint.coordinate(at);
    const double expected = (joint.coordinate(moved(at, t)) - 2 * q + joint.coordinate(moved(at, -t))) / (t * t);
    EXPECT_NEAR(joint.curvature(at)(joint.coordinate_row()), expected, 1e-5);
}

// A joint leaves as many freedoms as it should: the rank of its equations at the start.
TEST_P(AllJoints, EquationsAreIndependent) {
    const JointEquations::Jacobian J = joint.jacobian(start());
    Eigen::MatrixXd both(joint.count(), 12);
    both << J[0], J[1];
    const Eigen::VectorXd singular = test::singular_values(both);
    EXPECT_GT(singular(joint.lasting() - 1) / singular(0), 0.05);
    const std::map<JointType, int> expected = {{JointType::ball, 3},
                                               {JointType::hinge, 5},
                                               {JointType::slider, 5},
                                               {JointType::universal, 4},
                                               {JointType::fixed, 6}};
    EXPECT_EQ(joint.lasting(), expected.at(type));
}

// What a joint leaves free: the second body turns about the axis, or slides along it, and nothing opens; the coordinate
// tells how far, positive about and along the axis, and its row in J how fast.
TEST_P(AllJoints, CoordinateFollowsTheFreeMotion) {
    ASSERT_EQ(joint.has_coordinate(), type == JointType::hinge || type == JointType::slider);
    if (!joint.has_coordinate()) return;
    std::vector<BodyState> at = start();
    const Joint description = joint_of(type, 0, 1);
    const double amount = 0.6;
    const bool second_moves = joint.bodies()[1] >= 0;
    BodyState& body = at[static_cast<size_t>(joint.bodies()[second_moves ? 1 : 0])];
    const Eigen::Vector3d step = (second_moves ? amount : -amount) * description.axis;
    if (type == JointType::hinge) {
        body.position = description.anchor + RotationStep(step).apply(Eigen::Vector3d(body.position - description.anchor));
        body.rotation = RotationStep(step).apply(body.rotation);
        body.angular_velocity = step;
        body.velocity = step.cross(body.position - description.anchor);
    } else {
        body.position += step;
        body.velocity = step;
    }
    EXPECT_LT(residual(at).norm(), 1e-15);
    EXPECT_NEAR(joint.coordinate(at), amount, 1e-15);
    const JointEquations::Jacobian J = joint.jacobian(at);
    Eigen::Matrix<double, 6, 1> u;
    u << body.velocity, body.angular_velocity;
    const auto& rows = J[second_moves ? 1 : 0];
    const Eigen::VectorXd opening = rows.topRows(joint.lasting()) * u;
    EXPECT_LT(opening.norm(), 1e-15);
    EXPECT_NEAR(rows.row(joint.lasting()).dot(u), amount, 1e-15);
}

}  // namespace
}  // namespace dttmm::host
