// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "support/exact_linear_system.h"
#include "support/models.h"

namespace dttmm::test {

/// Exact lifts of the plates of plate_stack() at the time `end`: a chain of `count` masses m, springs 4k and dampers 4c to
/// the one below, the first to the ground, pulled at the top. Its modes are known in closed form,
///     v_j(i) = sin(i θ_j),  λ_j = 2 − 2 cos θ_j,  θ_j = (2j − 1) π/(2N + 1),  |v_j|² = (2N + 1)/4,
/// the damping is proportional to the stiffness, so each mode is one equation, solved by a matrix exponential.
inline Eigen::VectorXd exact_chain(int count, double k, double c, double end) {
    const auto one = [](double value) { return Eigen::MatrixXd(Eigen::MatrixXd::Constant(1, 1, value)); };
    Eigen::VectorXd lift = Eigen::VectorXd::Zero(count);
    for (int j = 1; j <= count; ++j) {
        const double theta = (2 * j - 1) * M_PI / (2 * count + 1), lambda = 2 - 2 * std::cos(theta);
        Eigen::VectorXd shape(count);
        for (int i = 0; i < count; ++i) shape(i) = std::sin((i + 1) * theta) / std::sqrt(0.25 * (2 * count + 1));
        ExactLinearSystem mode(one(kPlateMass), one(4 * c * lambda), one(4 * k * lambda), one(shape(count - 1)).col(0), 1000,
                               18.4e-3);
        mode.advance(end);
        lift += mode.q()(0) * shape;
    }
    return lift;
}

}  // namespace dttmm::test
