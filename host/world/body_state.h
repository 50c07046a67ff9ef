// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dttmm::host {

/// A rigid body as ODE keeps it: pose of the centre of mass at t_n, velocities over the step that ended there (half a step
/// back). World axes; R turns body axes into world axes. Before the first step, in the arguments named `at`, the velocities
/// are those of the instant.
struct BodyState {
    Eigen::Vector3d position;  ///< [m]
    Eigen::Matrix3d rotation;
    Eigen::Vector3d velocity;          ///< [m/s]
    Eigen::Vector3d angular_velocity;  ///< [rad/s]
};

/// Six numbers per body, world axes: [of the centre of mass; angular], or [force; moment about the centre of mass].
using BodyVectors = std::vector<Eigen::Matrix<double, 6, 1>>;

}  // namespace dttmm::host
