// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace dttmm::host {

/// exp(θ~), the rotation by the vector θ [rad], ready to be applied:  exp(θ~) v = v + a θ × v + b θ × (θ × v)
/// with a = sin φ/φ and b = (1 − cos φ)/φ², φ = |θ|. Exact to rounding for every angle; the series spares the usual small
/// step the trigonometric functions.
class RotationStep {
public:
    explicit RotationStep(const Eigen::Vector3d& theta) : theta_(theta) {
        const double s = theta.squaredNorm();
        if (s < 1e-3) {
            // both series at once, a packet of two: the divisions are what they cost
            using Pair = Eigen::Array2d;
            const Pair ab =
                Pair(1, 0.5) - s / Pair(6, 24) * (1 - s / Pair(20, 30) * (1 - s / Pair(42, 56) * (1 - s / Pair(72, 90))));
            a_ = ab(0);
            b_ = ab(1);
        } else {
            const double angle = std::sqrt(s), half = std::sin(0.5 * angle);
            a_ = std::sin(angle) / angle;
            b_ = 2 * half * half / s;
        }
    }

    Eigen::Vector3d apply(const Eigen::Vector3d& v) const {
        const Eigen::Vector3d c = theta_.cross(v);
        return v + a_ * c + b_ * theta_.cross(c);
    }

    Eigen::Matrix3d apply(const Eigen::Matrix3d& R) const {
        Eigen::Matrix3d turned;
        for (int column = 0; column < 3; ++column) turned.col(column) = apply(Eigen::Vector3d(R.col(column)));
        return turned;
    }

private:
    Eigen::Vector3d theta_;
    double a_, b_;
};

}  // namespace dttmm::host
