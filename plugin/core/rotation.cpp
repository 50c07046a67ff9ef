// SPDX-License-Identifier: BSD-3-Clause
#include "core/rotation.h"

#include <Eigen/Geometry>
#include <cmath>

namespace dttmm::detail {

Matrix3 large_rotation_from_vector(const Vector3& theta) {
    // Rodrigues: exp(θ~) = I + (sin φ/φ) θ~ + ((1 − cos φ)/φ²) θ~², the second factor written as ½ (sin(φ/2)/(φ/2))²
    const double angle = theta.norm();
    const double half_sinc = std::sin(0.5 * angle) / (0.5 * angle);
    const Matrix3 cross = skew(theta);
    return Matrix3::Identity() + std::sin(angle) / angle * cross + 0.5 * half_sinc * half_sinc * cross * cross;
}

Vector3 large_rotation_vector(const Matrix3& R) {
    // The quaternion keeps its digits up to π
    const Eigen::Quaterniond q(R);
    const double sine_half = q.vec().norm();
    if (sine_half == 0) return Vector3::Zero();
    const double angle = 2 * std::atan2(q.w() < 0 ? -sine_half : sine_half, std::abs(q.w()));
    return angle / sine_half * q.vec();
}

Matrix3 large_rotation_vector_rate(const Vector3& theta) {
    const double angle = theta.norm();
    const Matrix3 cross = skew(theta);
    return Matrix3::Identity() - 0.5 * cross + (1 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle) * cross * cross;
}

}  // namespace dttmm::detail
