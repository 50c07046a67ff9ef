// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <type_traits>

#include "core/lanes.h"
#include "core/types.h"

namespace dttmm::plugin {

// Real: double, or Lanes for four at once; of one to the same bits. It is not deduced, so that expressions convert.

/// R = exp(θ~): turns by the angle |θ| [rad] about θ. Any size of θ.
template <class Real = double>
Matrix3Of<Real> rotation_from_vector(const std::type_identity_t<Vector3Of<Real>>& theta);

/// θ = log R with |θ| ≤ π [rad], the inverse of rotation_from_vector; exact to rounding for every angle, π included
/// (there one of the two opposite vectors is returned). R must be orthonormal to rounding.
template <class Real = double>
Vector3Of<Real> rotation_vector(const std::type_identity_t<Matrix3Of<Real>>& R);

/// The rotation vector of the same rotation as θ, a full turn away or not, that is nearest to another.
inline Vector3 nearest_turn(const Vector3& theta, const Vector3& other) {
    const double angle = theta.norm();
    const Vector3 round = angle > 1 ? Vector3((1 - 2 * M_PI / angle) * theta) : theta;
    return (round - other).squaredNorm() < (theta - other).squaredNorm() ? round : theta;
}

/// J⁻¹(θ) with d(log R) = J⁻¹(θ) ε when R = exp(θ~) changes to exp(ε~) exp(θ~). |θ| < 2π.
///     J⁻¹ = I − θ~/2 + (1 − (|θ|/2) cot(|θ|/2)) θ~²/|θ|²
/// Source: Bullo and Murray (1995), Proc. 3rd European Control Conf., 1091–1097.
Matrix3 rotation_vector_rate(const Vector3& theta);

/// J(θ) θ': the angular velocity of exp(θ~) while θ changes at the rate θ'. Any size of θ.
///     J = I + (1 − cos φ)/φ² θ~ + (φ − sin φ)/φ³ θ~²,     φ = |θ|
Vector3 angular_velocity(const Vector3& theta, const Vector3& rate);

/// J⁻ᵀ(θ) v: makes of the gradient v by θ the moment that does its work. |θ| < 2π.
template <class Real = double>
Vector3Of<Real> moment_of_gradient(const std::type_identity_t<Vector3Of<Real>>& theta,
                                   const std::type_identity_t<Vector3Of<Real>>& v);

/// ∂(J⁻ᵀ(θ) v)/∂θ, column by column. |θ| < 2π.
Matrix3 moment_of_gradient_rate(const Vector3& theta, const Vector3& v);

/// v turned by θ, exactly exp(θ~) v but for rounding, without making the matrix where θ is small.
template <class Real = double>
Vector3Of<Real> turned(const std::type_identity_t<Vector3Of<Real>>& theta, const std::type_identity_t<Vector3Of<Real>>& v);

/// a × b and |a|², written out, so that one thing and four give the same bits.
template <class Real>
[[gnu::always_inline]] inline Vector3Of<Real> cross(const Vector3Of<Real>& a, const Vector3Of<Real>& b) {
    return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
template <class Real>
[[gnu::always_inline]] inline Real squared_norm(const Vector3Of<Real>& a) {
    return a.x() * a.x() + a.y() * a.y() + a.z() * a.z();
}

// ---- The small angles of every step -------------------------------------------------------------------------------------

namespace detail {

/// Series of sin φ/φ, (1 − cos φ)/φ² and (1 − (φ/2) cot(φ/2))/φ² in φ² < kSmall; the first terms left out are below 1e-18.
/// Without divisions, which the compiler may not turn into multiplications.
inline constexpr double kSmall = 1e-2;
template <class Real>
[[gnu::always_inline]] inline Real sinc(const Real& x) {
    return 1 + x * (-1. / 6 + x * (1. / 120 + x * (-1. / 5040 + x * (1. / 362880 - x * (1. / 39916800)))));
}
template <class Real>
[[gnu::always_inline]] inline Real versine(const Real& x) {
    return 0.5 + x * (-1. / 24 + x * (1. / 720 + x * (-1. / 40320 + x * (1. / 3628800 - x * (1. / 479001600)))));
}
template <class Real>
[[gnu::always_inline]] inline Real half_cotangent(const Real& x) {
    return 1. / 12 + x * (1. / 720 + x * (1. / 30240 + x * (1. / 1209600 + x * (1. / 47900160))));
}

/// Where one angle is not small; of four: one after the other.
Matrix3 large_rotation_from_vector(const Vector3& theta);
Matrix3Of<Lanes> large_rotation_from_vector(const Vector3Of<Lanes>& theta);
Vector3 large_turned(const Vector3& theta, const Vector3& v);
Vector3Of<Lanes> large_turned(const Vector3Of<Lanes>& theta, const Vector3Of<Lanes>& v);
Vector3 large_rotation_vector(const Matrix3& R);
Vector3Of<Lanes> large_rotation_vector(const Matrix3Of<Lanes>& R);
Vector3 large_moment_of_gradient(const Vector3& theta, const Vector3& v);
Vector3Of<Lanes> large_moment_of_gradient(const Vector3Of<Lanes>& theta, const Vector3Of<Lanes>& v);
Matrix3 large_rotation_vector_rate(const Vector3& theta);

}  // namespace detail

template <class Real>
[[gnu::always_inline]] inline Matrix3Of<Real> rotation_from_vector(const std::type_identity_t<Vector3Of<Real>>& theta) {
    const Real squared = squared_norm<Real>(theta);
    if (!all_below(squared, detail::kSmall)) [[unlikely]]
        return detail::large_rotation_from_vector(theta);
    // I + s θ~ + c (θ θᵀ − θ² I)
    const Real s = detail::sinc(squared), c = detail::versine(squared);
    const Real x = theta.x(), y = theta.y(), z = theta.z();
    const Real sx = s * x, sy = s * y, sz = s * z, cxy = c * x * y, cxz = c * x * z, cyz = c * y * z;
    Matrix3Of<Real> R;
    R << 1 - c * (y * y + z * z), cxy - sz, cxz + sy, cxy + sz, 1 - c * (x * x + z * z), cyz - sx, cxz - sy, cyz + sx,
        1 - c * (x * x + y * y);
    return R;
}

template <class Real>
[[gnu::always_inline]] inline Vector3Of<Real> turned(const std::type_identity_t<Vector3Of<Real>>& theta,
                                                     const std::type_identity_t<Vector3Of<Real>>& v) {
    const Real squared = squared_norm<Real>(theta);
    if (!all_below(squared, detail::kSmall)) [[unlikely]]
        return detail::large_turned(theta, v);
    const Vector3Of<Real> once = cross<Real>(theta, v);
    return v + detail::sinc(squared) * once + detail::versine(squared) * cross<Real>(theta, once);
}

template <class Real>
[[gnu::always_inline]] inline Vector3Of<Real> rotation_vector(const std::type_identity_t<Matrix3Of<Real>>& R) {
    // 2 sin φ n = vee(R − Rᵀ). Small angles: φ/sin φ = 1 + s²/6 + 3 s⁴/40 + 15 s⁶/336 + …, s = sin φ
    const Vector3Of<Real> twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const Real t = 0.25 * squared_norm<Real>(twice_sine);
    if (!(all_below(t, detail::kSmall) && all_below(-(R(0, 0) + R(1, 1) + R(2, 2)), -1))) [[unlikely]]
        return detail::large_rotation_vector(R);
    const Real series =
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

template <class Real>
[[gnu::always_inline]] inline Vector3Of<Real> moment_of_gradient(const std::type_identity_t<Vector3Of<Real>>& theta,
                                                                 const std::type_identity_t<Vector3Of<Real>>& v) {
    const Real squared = squared_norm<Real>(theta);
    if (!all_below(squared, detail::kSmall)) [[unlikely]]
        return detail::large_moment_of_gradient(theta, v);
    const Vector3Of<Real> once = cross<Real>(theta, v);
    return v + Real(0.5) * once + detail::half_cotangent(squared) * cross<Real>(theta, once);
}

}  // namespace dttmm::plugin
