// SPDX-License-Identifier: BSD-3-Clause
#include "world/rotation_step.h"

#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

// Oracle: Eigen's angle-axis rotation, on both sides of the switch from the series (|θ|² < 1e-3) to the functions.
TEST(RotationStep, IsTheAngleAxisRotation) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized(), v(0.3, 4, -1);
    for (double angle : {0.0, 1e-9, 1e-3, 0.0316, 0.0317, 0.5, 3.0, 7.0}) {
        const RotationStep step(angle * axis);
        const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
        EXPECT_LT((step.apply(v) - R * v).norm(), 4e-15) << angle;
        EXPECT_LT((step.apply(Eigen::Matrix3d(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitY()))) -
                   R * Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitY()).toRotationMatrix())
                      .norm(),
                  4e-15)
            << angle;
    }
}

}  // namespace
}  // namespace dttmm::host
