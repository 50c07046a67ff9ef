// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "support/exact_linear_system.h"
#include "support/models.h"

namespace dttmm::test {

using PlateForces = std::vector<std::array<double, 4>>;  ///< of the bolts along z, on the 1 ms grid, from t = 0 on

/// The four bolts of the plate, the same k [N/m] and c [N s/m] in every direction, and its load.
struct PlateOnBolts {
    std::array<double, 4> k;
    double c, rise_time;
};

inline const PlateOnBolts kSoftBolts{
    {4e5, 5e5, 5e5, 5e5}, 100, 18.4e-3};  // examples/four_bolt_plate, bolt 1 softer by a fifth
inline const PlateOnBolts kStiffBolts{{4e8, 5e8, 5e8, 5e8}, 1000, 20e-3};  // examples/stiff_bolts

/// Motion of a point of a body by that of the body: p' = G [v; w], `arm` from the centre of mass.
inline Eigen::Matrix<double, 3, 6> marker_motion(const Eigen::Vector3d& arm) {
    Eigen::Matrix<double, 3, 6> G;
    G << 1, 0, 0, 0, arm.z(), -arm.y(), 0, 1, 0, -arm.z(), 0, arm.x(), 0, 0, 1, arm.y(), -arm.x(), 0;
    return G;
}

/// Bolt forces k z + c z' from the exact motion of the plate's six linear equations.
inline PlateForces exact_plate_forces(const PlateOnBolts& bolts, int milliseconds) {
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(6, 6), C = M, K = M;
    M.diagonal() << 9.42, 9.42, 9.42, 9.42 / 12 * (0.04 + 4e-4), 9.42 / 12 * (0.09 + 4e-4), 9.42 / 12 * 0.13;
    for (size_t i = 0; i < 4; ++i) {
        const auto G = marker_motion(kCorners[i]);
        K += bolts.k[i] * G.transpose() * G;
        C += bolts.c * G.transpose() * G;
    }
    ExactLinearSystem plate(M, C, K, Eigen::VectorXd::Unit(6, 2), 1000, bolts.rise_time);
    PlateForces forces;
    for (int ms = 0; ms <= milliseconds; ++ms) {
        if (ms > 0) plate.advance(1e-3);
        std::array<double, 4> row;
        for (size_t i = 0; i < 4; ++i) {
            const auto G = marker_motion(kCorners[i]);
            row[i] = bolts.k[i] * (G * plate.q()).z() + bolts.c * (G * plate.rate()).z();
        }
        forces.push_back(row);
    }
    return forces;
}

/// Largest difference over bolts and the 1 ms grid, as a share of the static force of a bolt, 250 N; not a number if one
/// of them is not.
inline double plate_error(const PlateForces& forces, const PlateForces& exact) {
    double largest = 0;
    for (size_t n = 0; n < exact.size(); ++n)
        for (size_t i = 0; i < 4; ++i) {
            const double error = std::abs(forces[n][i] - exact[n][i]) / 250;
            if (std::isnan(error)) return error;
            largest = std::max(largest, error);
        }
    return largest;
}

}  // namespace dttmm::test
