// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <vector>

#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

/// Complex amplitudes [m, rad] of all frames, 6 per frame.
using Response = std::vector<Eigen::Matrix<std::complex<double>, 6, 1>>;

/// Motion under a harmonic wrench [N, N m] at a point [m, world] of a frame (−1: the ground, nothing moves), damped; the
/// lines in the pieces in which D has them. Throws Error(DTTMM_ERROR_SINGULAR) at a natural frequency without damping.
Response respond(const DynamicStiffness& D, double omega, int frame, const Vector3& point, const Vector6& wrench);

}  // namespace dttmm::plugin
