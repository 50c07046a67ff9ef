// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "model/model.h"
#include "world/block_matrix.h"
#include "world/rotation_step.h"

namespace dttmm::host {

/// Positions are known to a few units in the last place of their size.
inline constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();

/// Mass and inertia of a body about its centre of mass; R turns its axes into world axes.
struct Inertia {
    double mass;                ///< [kg]
    Eigen::Matrix3d J;          ///< body axes [kg m²]
    Eigen::Matrix3d inverse_J;  ///< [1/(kg m²)]

    explicit Inertia(const Body& body) : mass(body.mass), J(body.inertia), inverse_J(body.inertia.inverse()) {}

    /// diag(m, R J Rᵀ), world axes
    BlockMatrix::Block block(const Eigen::Matrix3d& R) const {
        BlockMatrix::Block M = BlockMatrix::Block::Zero();
        M.diagonal().head<3>().setConstant(mass);
        M.bottomRightCorner<3, 3>() = R * J * R.transpose();
        return M;
    }
    /// R J Rᵀ w: of an angular velocity the angular momentum, of an angular acceleration the moment
    Eigen::Vector3d turned(const Eigen::Matrix3d& R, const Eigen::Vector3d& w) const {
        return R * (J * (R.transpose() * w));
    }
    /// Kinetic energy of a momentum [p; L], world axes [J]
    double energy_of(const Eigen::Matrix3d& R, const Eigen::Matrix<double, 6, 1>& momentum) const {
        const Eigen::Vector3d own = R.transpose() * momentum.tail<3>();
        return 0.5 * (momentum.head<3>().squaredNorm() / mass + own.dot(inverse_J * own));
    }
    /// Angular momentum half way through a step of size h that starts at R with the angular velocity w over it:
    ///     L = R_{½} J R_{½}ᵀ w = exp(h w~/2) R J Rᵀ w,   for the exponential leaves w alone
    Eigen::Vector3d momentum_over_step(const Eigen::Matrix3d& R, const Eigen::Vector3d& w, double h) const {
        return RotationStep(0.5 * h * w).apply(turned(R, w));
    }
    /// An upper bound of the largest radius of gyration [m]
    double gyration_bound() const { return std::sqrt(J.trace() / (2 * mass)); }
};

}  // namespace dttmm::host
