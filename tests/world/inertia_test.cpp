// SPDX-License-Identifier: BSD-3-Clause
#include "world/inertia.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace dttmm::host {
namespace {

// Oracle: the inverse of the whole matrix.
TEST(Inertia, EnergyOfAMomentum) {
    Body body;
    body.mass = 3.7;
    body.inertia << 0.31, -0.04, 0.02, -0.04, 0.52, 0.07, 0.02, 0.07, 0.43;
    const Inertia inertia(body);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    Eigen::Matrix<double, 6, 1> momentum;
    momentum << 0.3, -1.1, 2.0, 0.7, 0.2, -0.4;
    const double expected = 0.5 * momentum.dot(inertia.block(R).inverse() * momentum);
    EXPECT_NEAR(inertia.energy_of(R, momentum), expected, 1e-14 * expected);
}

}  // namespace
}  // namespace dttmm::host
