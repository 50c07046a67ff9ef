// SPDX-License-Identifier: BSD-3-Clause
#include "core/rotation.h"

#include <Eigen/Geometry>
#include <cmath>

namespace dttmm {

Matrix3 rotation_from_vector(const Vector3& theta) {
    // Rodrigues: exp(θ~) = I + (sin φ/φ) θ~ + ((1 − cos φ)/φ²) θ~², the second factor written as ½ (sin(φ/2)/(φ/2))²
    const double angle = theta.norm();
    const double half_sinc = angle > 1e-8 ? std::sin(0.5 * angle) / (0.5 * angle) : 1.0;
    const double sinc = angle > 1e-8 ? std::sin(angle) / angle : 1.0;
    const Matrix3 cross = skew(theta);
    return Matrix3::Identity() + sinc * cross + 0.5 * half_sinc * half_sinc * cross * cross;
}

Vector3 rotation_vector(const Matrix3& R) {
    // 2 sin φ n = vee(R − Rᵀ). Small angles: φ/sin φ is harmless. Large ones: the quaternion keeps its digits up to π.
    const Vector3 twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double sine_squared = 0.25 * twice_sine.squaredNorm();
    if (sine_squared < 1e-6 && R.trace() > 1) {
        // φ/sin φ = 1 + s²/6 + 3 s⁴/40 + 15 s⁶/336 + …, s = sin φ; the first term left out is below 1e-25
        return 0.5 * (1 + sine_squared * (1.0 / 6 + sine_squared * (3.0 / 40 + sine_squared * (15.0 / 336)))) * twice_sine;
    }
    const Eigen::Quaterniond q(R);
    const double sine_half = q.vec().norm();
    if (sine_half == 0) return Vector3::Zero();
    const double angle = 2 * std::atan2(q.w() < 0 ? -sine_half : sine_half, std::abs(q.w()));
    return angle / sine_half * q.vec();
}

Matrix3 rotation_vector_rate(const Vector3& theta) {
    const double angle = theta.norm();
    // (1 − (φ/2) cot(φ/2))/φ² = 1/12 + φ²/720 + φ⁴/30240 + …
    const double squared = angle * angle;
    const double factor = angle < 1e-2 ? 1.0 / 12 + squared * (1.0 / 720 + squared / 30240)
                                       : (1 - 0.5 * angle / std::tan(0.5 * angle)) / squared;
    const Matrix3 cross = skew(theta);
    return Matrix3::Identity() - 0.5 * cross + factor * cross * cross;
}

}  // namespace dttmm
