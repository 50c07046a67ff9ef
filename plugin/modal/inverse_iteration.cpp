// SPDX-License-Identifier: BSD-3-Clause
#include "modal/inverse_iteration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/index.h"
#include "modal/search.h"
#include "modal/shape_basis.h"

namespace dttmm::plugin {

std::vector<FrameVector> InverseIteration::random_shapes(size_t count) {
    std::vector<FrameVector> shapes(count, FrameVector(as_size(stiffness_.frame_count())));
    for (FrameVector& shape : shapes)
        for (Vector6& u : shape)
            for (double& x : u) {
                seed_ = seed_ * 6364136223846793005u + 1442695040888963407u;
                x = static_cast<double>(seed_ >> 11) * 0x1p-53 - 0.5;
            }
    return shapes;
}

std::vector<double> InverseIteration::iterate(std::vector<FrameVector>& shapes, double lambda) {
    const auto n = as_row(shapes.size());
    if (!stiffness_.factor(lambda)) return {};
    Eigen::MatrixXd A(n, n), B(n, n);
    std::vector<double> lambdas(shapes.size());
    for (int round = 0; round < kRounds; ++round) {
        std::vector<FrameVector> loads, masses;
        for (FrameVector& shape : shapes) {
            loads.push_back(stiffness_.mass_times(shape));
            shape = loads.back();
            stiffness_.solve(shape);
            // Overflow and underflow have nothing to do with shapes
            double largest = 0;
            for (const Vector6& u : shape) largest = std::max(largest, u.cwiseAbs().maxCoeff());
            if (!(largest > 0) || !std::isfinite(largest)) return {};
            for (Vector6& u : shape) u /= largest;
            for (Vector6& r : loads.back()) r /= largest;
            masses.push_back(stiffness_.mass_times(shape));
        }
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j < n; ++j) {
                A(i, j) = dot(shapes[as_size(i)], loads[as_size(j)]);
                B(i, j) = dot(shapes[as_size(i)], masses[as_size(j)]);
            }
        // In units in which every shape has unit mass
        const Eigen::VectorXd unit = B.diagonal().cwiseSqrt().cwiseInverse();
        if (!unit.allFinite()) return {};
        const Eigen::MatrixXd scaled_a = unit.asDiagonal() * (0.5 * (A + A.transpose())) * unit.asDiagonal();
        const Eigen::MatrixXd scaled_b = unit.asDiagonal() * (0.5 * (B + B.transpose())) * unit.asDiagonal();
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(scaled_a, scaled_b);
        if (ritz.info() != Eigen::Success || !ritz.eigenvectors().allFinite()) return {};
        shapes = mixed(shapes, unit.asDiagonal() * ritz.eigenvectors());
        for (Eigen::Index i = 0; i < n; ++i) lambdas[as_size(i)] = lambda + ritz.eigenvalues()(i);
    }
    return lambdas;
}

}  // namespace dttmm::plugin
