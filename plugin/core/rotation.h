// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types.h"

namespace dttmm {

/// R = exp(θ~): turns by the angle |θ| [rad] about θ. Any size of θ.
Matrix3 rotation_from_vector(const Vector3& theta);

/// θ = log R with |θ| ≤ π [rad], the inverse of rotation_from_vector; exact to rounding for every angle, π included
/// (there one of the two opposite vectors is returned). R must be orthonormal to rounding.
Vector3 rotation_vector(const Matrix3& R);

/// J⁻¹(θ) with d(log R) = J⁻¹(θ) ε when R = exp(θ~) changes to exp(ε~) exp(θ~). |θ| < 2π.
///     J⁻¹ = I − θ~/2 + (1 − (|θ|/2) cot(|θ|/2)) θ~²/|θ|²
/// Source: Bullo and Murray (1995), Proc. 3rd European Control Conf., 1091–1097.
Matrix3 rotation_vector_rate(const Vector3& theta);

/// J⁻ᵀ(θ) v: makes of the gradient v by θ the moment that does its work. |θ| < 2π.
Vector3 moment_of_gradient(const Vector3& theta, const Vector3& v);

/// v turned by θ, exactly exp(θ~) v but for rounding, without making the matrix where θ is small.
Vector3 turned(const Vector3& theta, const Vector3& v);

// ---- The small angles of every step -------------------------------------------------------------------------------------

namespace detail {

/// Series of sin φ/φ and (1 − cos φ)/φ² in φ² < kSmall; the first terms left out are below 1e-18.
inline constexpr double kSmall = 1e-2;
inline double sinc(double squared) {
    return 1 - squared / 6 * (1 - squared / 20 * (1 - squared / 42 * (1 - squared / 72 * (1 - squared / 110))));
}
inline double versine(double squared) {
    return 0.5 * (1 - squared / 12 * (1 - squared / 30 * (1 - squared / 56 * (1 - squared / 90 * (1 - squared / 132)))));
}

/// (1 − (φ/2) cot(φ/2))/φ² = 1/12 + φ²/720 + φ⁴/30240 + φ⁶/1209600 + φ⁸/47900160 + …
inline double half_cotangent(double squared) {
    return 1. / 12 + squared * (1. / 720 + squared * (1. / 30240 + squared * (1. / 1209600 + squared / 47900160)));
}

inline Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

Matrix3 large_rotation_from_vector(const Vector3& theta);
Vector3 large_rotation_vector(const Matrix3& R);
Matrix3 large_rotation_vector_rate(const Vector3& theta);

}  // namespace detail

inline Matrix3 rotation_from_vector(const Vector3& theta) {
    const double squared = theta.squaredNorm();
    if (!(squared < detail::kSmall)) return detail::large_rotation_from_vector(theta);
    // I + s θ~ + c (θ θᵀ − θ² I)
    const double s = detail::sinc(squared), c = detail::versine(squared);
    const double x = theta.x(), y = theta.y(), z = theta.z();
    const double sx = s * x, sy = s * y, sz = s * z, cxy = c * x * y, cxz = c * x * z, cyz = c * y * z;
    Matrix3 R;
    R << 1 - c * (y * y + z * z), cxy - sz, cxz + sy, cxy + sz, 1 - c * (x * x + z * z), cyz - sx, cxz - sy, cyz + sx,
        1 - c * (x * x + y * y);
    return R;
}

inline Vector3 turned(const Vector3& theta, const Vector3& v) {
    const double squared = theta.squaredNorm();
    if (!(squared < detail::kSmall)) return detail::large_rotation_from_vector(theta) * v;
    const Vector3 once = detail::cross(theta, v);
    return v + detail::sinc(squared) * once + detail::versine(squared) * detail::cross(theta, once);
}

inline Vector3 rotation_vector(const Matrix3& R) {
    // 2 sin φ n = vee(R − Rᵀ). Small angles: φ/sin φ = 1 + s²/6 + 3 s⁴/40 + 15 s⁶/336 + …, s = sin φ
    const Vector3 twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double t = 0.25 * twice_sine.squaredNorm();
    if (!(t < detail::kSmall && R.trace() > 1)) return detail::large_rotation_vector(R);
    const double series =
        1 +
        t * (1. / 6 +
             t * (3. / 40 + t * (5. / 112 + t * (35. / 1152 + t * (63. / 2816 + t * (231. / 13312 + t * (143. / 10240)))))));
    return 0.5 * series * twice_sine;
}

inline Matrix3 rotation_vector_rate(const Vector3& theta) {
    const double squared = theta.squaredNorm();
    if (!(squared < detail::kSmall)) return detail::large_rotation_vector_rate(theta);
    const double c = detail::half_cotangent(squared);
    const double x = theta.x(), y = theta.y(), z = theta.z();
    const double cxy = c * x * y, cxz = c * x * z, cyz = c * y * z;
    Matrix3 J;
    J << 1 - c * (y * y + z * z), cxy + 0.5 * z, cxz - 0.5 * y, cxy - 0.5 * z, 1 - c * (x * x + z * z), cyz + 0.5 * x,
        cxz + 0.5 * y, cyz - 0.5 * x, 1 - c * (x * x + y * y);
    return J;
}

inline Vector3 moment_of_gradient(const Vector3& theta, const Vector3& v) {
    const double squared = theta.squaredNorm();
    if (!(squared < detail::kSmall)) return detail::large_rotation_vector_rate(theta).transpose() * v;
    const Vector3 once = detail::cross(theta, v);
    return v + 0.5 * once + detail::half_cotangent(squared) * detail::cross(theta, once);
}

}  // namespace dttmm
