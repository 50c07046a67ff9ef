// SPDX-License-Identifier: BSD-3-Clause
#include "core/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace dttmm::plugin {
namespace {

const Vector3 kAxis = Vector3(1, -2, 0.5).normalized();

// Oracle: Eigen's angle-axis rotation; angles from rounding to beyond half a turn. Both round the angle itself (5 rad to
// 4e-16), so entries of size one agree to a few units in the last place.
TEST(Rotation, VectorToMatrixIsTheAngleAxisRotation) {
    for (double angle : {0.0, 1e-12, 1e-6, 0.01, 0.5, 2.0, 3.14, M_PI, 5.0})
        EXPECT_LT(
            (rotation_from_vector(angle * kAxis) - Eigen::AngleAxisd(angle, kAxis).toRotationMatrix()).cwiseAbs().maxCoeff(),
            1.5e-15)
            << angle;
}

// Oracle: the vector the matrix was made from; small angles keep all their digits relative to the angle.
TEST(Rotation, MatrixToVectorIsTheInverse) {
    for (double angle : {0.0, 1e-12, 1e-6, 9e-4, 1.1e-3, 0.01, 0.5, 2.0, 3.0, 3.14159, M_PI - 1e-9}) {
        const Vector3 theta = angle * kAxis;
        EXPECT_LT((rotation_vector(rotation_from_vector(theta)) - theta).norm(), 1e-15 + 4e-16 * angle) << angle;
    }
}

// Oracle: central differences, which neglect the step squared times third derivatives of the order of v; angles on both
// sides of 0.1, where the series end.
TEST(Rotation, RateOfAMomentOfAGradient) {
    const Vector3 v(1, -2, 3);
    for (double angle : {0.0, 1e-3, 0.09, 0.11, 2.0, 4.0}) {
        const Vector3 theta = angle * kAxis;
        const Matrix3 rate = moment_of_gradient_rate(theta, v);
        for (int i = 0; i < 3; ++i) {
            constexpr double kStep = 1e-5;
            const Vector3 by = kStep * Vector3::Unit(i);
            const Vector3 slope = (moment_of_gradient(theta + by, v) - moment_of_gradient(theta - by, v)) / (2 * kStep);
            EXPECT_LT((rate.col(i) - slope).norm(), 2e-9) << angle;
        }
    }
}

// Oracle: the matrices themselves; angles on both sides of 0.1, where the series end.
TEST(Rotation, VectorsGoAsByTheMatrices) {
    const Vector3 v(1, -2, 3);
    for (double angle : {0.0, 1e-3, 0.09, 0.11, 2.0}) {
        const Vector3 theta = angle * kAxis;
        EXPECT_LT((turned(theta, v) - rotation_from_vector(theta) * v).norm(), 4e-15) << angle;
        EXPECT_LT((moment_of_gradient(theta, v) - rotation_vector_rate(theta).transpose() * v).norm(), 4e-15) << angle;
    }
}

TEST(Rotation, HalfATurnGivesOneOfItsTwoVectors) {
    const Vector3 theta = rotation_vector(Eigen::AngleAxisd(M_PI, kAxis).toRotationMatrix());
    EXPECT_NEAR(theta.norm(), M_PI, 1e-14);
    EXPECT_NEAR(std::abs(theta.normalized().dot(kAxis)), 1, 1e-14);
}

// Oracle: central difference of log(exp(ε~) exp(θ~)); its error is O(1e-10).
// Oracle: J⁻¹ of the same vector, by another formula.
TEST(Rotation, AngularVelocityIsTheInverseOfTheRateOfTheVector) {
    const Vector3 axis = Vector3(2, -3, 6) / 7, rate(0.3, 1.1, -0.7);
    for (const double angle : {0.0, 1e-9, 0.02, 0.0999, 0.1001, 1.0, 3.0, 5.9}) {
        const Vector3 theta = angle * axis;
        EXPECT_LT((rotation_vector_rate(theta) * angular_velocity(theta, rate) - rate).norm(), 1e-13) << angle;
    }
}

TEST(Rotation, RateIsTheDerivativeOfTheVector) {
    for (double angle : {1e-4, 9e-3, 1.1e-2, 0.7, 2.9}) {
        const Vector3 theta = angle * kAxis;
        const Matrix3 R = rotation_from_vector(theta), rate = rotation_vector_rate(theta);
        for (int i = 0; i < 3; ++i) {
            const Vector3 e = 1e-5 * Vector3::Unit(i);
            const Vector3 difference =
                (rotation_vector(rotation_from_vector(e) * R) - rotation_vector(rotation_from_vector(-e) * R)) / 2e-5;
            EXPECT_LT((rate.col(i) - difference).norm(), 1e-9) << angle << ", axis " << i;
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
