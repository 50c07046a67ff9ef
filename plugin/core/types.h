// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace dttmm::plugin {

template <class Real>
using Vector3Of = Eigen::Matrix<Real, 3, 1>;
template <class Real>
using Matrix3Of = Eigen::Matrix<Real, 3, 3>;
using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using RowVector3 = Eigen::RowVector3d;
using Matrix3 = Eigen::Matrix3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Matrix13 = Eigen::Matrix<double, 13, 13>;

/// The matrix a~ of the cross product: a~ b = a × b.
inline Matrix3 skew(const Vector3& a) {
    Matrix3 m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

}  // namespace dttmm::plugin
