// SPDX-License-Identifier: BSD-3-Clause
#include "core/rotation.h"

#include <Eigen/Geometry>
#include <cmath>

namespace dttmm::plugin {

namespace {

/// Of c(φ) = (1 − (φ/2) cot(φ/2))/φ² and its derivative by φ².
struct HalfCotangent {
    double value, slope;
};

HalfCotangent half_cotangent_at(double squared) {
    if (squared < detail::kSmall)
        return {detail::half_cotangent(squared),
                1. / 720 + squared * (1. / 15120 + squared * (1. / 403200 + squared * (1. / 11975040)))};
    const double angle = std::sqrt(squared), sine = std::sin(0.5 * angle), tangent = std::tan(0.5 * angle);
    const double value = (1 - 0.5 * angle / tangent) / squared;
    return {value, ((0.25 * angle / (sine * sine) - 0.5 / tangent) / angle - 2 * value) / (2 * squared)};
}

}  // namespace

Vector3 angular_velocity(const Vector3& theta, const Vector3& rate) {
    const double squared = theta.squaredNorm(), angle = std::sqrt(squared), half = std::sin(0.5 * angle);
    const bool is_small = squared < detail::kSmall;
    const double versine = is_small ? detail::versine(squared) : 2 * half * half / squared;
    // (φ − sin φ)/φ³: the next term of the series is below 1e-13
    const double third = is_small ? 1. / 6 - squared * (1. / 120 - squared * (1. / 5040 - squared * (1. / 362880)))
                                  : (angle - std::sin(angle)) / (squared * angle);
    const Vector3 once = theta.cross(rate);
    return rate + versine * once + third * theta.cross(once);
}

Matrix3 moment_of_gradient_rate(const Vector3& theta, const Vector3& v) {
    // J⁻ᵀ v = v + θ × v/2 + c θ × (θ × v)
    const auto [c, slope] = half_cotangent_at(theta.squaredNorm());
    const Vector3 once = theta.cross(v), twice = theta.cross(once);
    return -0.5 * skew(v) - c * (skew(once) + skew(theta) * skew(v)) + 2 * slope * twice * theta.transpose();
}

}  // namespace dttmm::plugin

namespace dttmm::plugin::detail {

namespace {

/// What `function` makes of every lane of its arguments.
template <class Result, class Function, class... Arguments>
Result lane_by_lane(const Function& function, const Arguments&... arguments) {
    Result result;
    for (int i = 0; i < Lanes::kCount; ++i) set_lane(result, i, function(lane(arguments, i)...));
    return result;
}

}  // namespace

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

Vector3 large_moment_of_gradient(const Vector3& theta, const Vector3& v) {
    return large_rotation_vector_rate(theta).transpose() * v;
}

Matrix3 large_rotation_vector_rate(const Vector3& theta) {
    const Matrix3 cross = skew(theta);
    return Matrix3::Identity() - 0.5 * cross + half_cotangent_at(theta.squaredNorm()).value * cross * cross;
}

Matrix3Of<Lanes> large_rotation_from_vector(const Vector3Of<Lanes>& theta) {
    return lane_by_lane<Matrix3Of<Lanes>>([](const Vector3& one) { return rotation_from_vector(one); }, theta);
}

Vector3 large_turned(const Vector3& theta, const Vector3& v) { return large_rotation_from_vector(theta) * v; }

Vector3Of<Lanes> large_turned(const Vector3Of<Lanes>& theta, const Vector3Of<Lanes>& v) {
    return lane_by_lane<Vector3Of<Lanes>>([](const Vector3& one, const Vector3& of) { return turned(one, of); }, theta, v);
}

Vector3Of<Lanes> large_rotation_vector(const Matrix3Of<Lanes>& R) {
    return lane_by_lane<Vector3Of<Lanes>>([](const Matrix3& one) { return rotation_vector(one); }, R);
}

Vector3Of<Lanes> large_moment_of_gradient(const Vector3Of<Lanes>& theta, const Vector3Of<Lanes>& v) {
    return lane_by_lane<Vector3Of<Lanes>>([](const Vector3& one, const Vector3& of) { return moment_of_gradient(one, of); },
                                          theta, v);
}

}  // namespace dttmm::plugin::detail
