// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_slope.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.h"
#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Forces of the rigid directions of a mode at λ. They are those of D(μ) x + Jᵀ q = (D(μ) − D(λ)) φ at any other μ, where x
/// is φ again.
std::vector<double> rigid_forces(DynamicStiffness& D, const Mode& mode, double lambda) {
    constexpr double kShifts[] = {0.7, 1.3, 0.5, 1.7};  // μ over λ: one of them is no other frequency's
    constexpr double kSame = 1e-6;                      // share of the shape
    if (D.rigid_rows().empty()) return {};
    D.set(lambda);
    const FrameVector here = D.stiffness_times(mode.shape);
    for (const double shift : kShifts) {
        if (!D.factor(shift * lambda)) continue;
        FrameVector x = D.stiffness_times(mode.shape);
        for (size_t f = 0; f < x.size(); ++f) x[f] -= here[f];
        const std::vector<double> q = D.solve(x);
        double difference = 0, size = 0;
        for (size_t f = 0; f < x.size(); ++f) {
            difference += (x[f] - mode.shape[f]).squaredNorm();
            size += mode.shape[f].squaredNorm();
        }
        if (difference <= kSame * kSame * size) return q;
    }
    throw Error(DTTMM_ERROR_NUMERIC, "the forces of the rigid directions of a mode were not found");
}

/// L over shapes and forces, symmetric.
Eigen::MatrixXd lagrangian(DynamicStiffness& D, double lambda, std::span<const Mode> modes,
                           const std::vector<std::vector<double>>& forces) {
    D.set(lambda);
    const auto count = as_row(modes.size());
    Eigen::MatrixXd L(count, count), work(count, count);
    for (Eigen::Index j = 0; j < count; ++j) {
        const FrameVector& shape = modes[as_size(j)].shape;
        const FrameVector load = D.stiffness_times(shape);
        const std::vector<double> openings = D.openings(shape);
        for (Eigen::Index i = 0; i < count; ++i) {
            L(i, j) = dot(modes[as_size(i)].shape, load);
            work(i, j) = 0;
            for (size_t r = 0; r < openings.size(); ++r) work(i, j) += forces[as_size(i)][r] * openings[r];
        }
    }
    return 0.5 * (L + L.transpose()) + work + work.transpose();
}

}  // namespace

std::vector<double> frequency_changes(DynamicStiffness& at, std::span<const Mode> modes, DynamicStiffness& above,
                                      DynamicStiffness& below) {
    const double omega = modes.front().omega, lambda = omega * std::abs(omega);
    at.cut(modes.front().cut);
    std::vector<std::vector<double>> forces;
    for (const Mode& mode : modes) forces.push_back(rigid_forces(at, mode, lambda));
    at.set(lambda);
    const auto count = as_row(modes.size());
    Eigen::MatrixXd mass(count, count);
    for (Eigen::Index j = 0; j < count; ++j) {
        const FrameVector momentum = at.mass_times(modes[as_size(j)].shape);
        for (Eigen::Index i = 0; i < count; ++i) mass(i, j) = dot(modes[as_size(i)].shape, momentum);
    }
    for (DynamicStiffness* other : {&above, &below}) {
        other->cut_like(at);
        if (other->frame_count() != at.frame_count() || other->rigid_rows() != at.rigid_rows())
            throw Error(DTTMM_ERROR_ARGUMENT, "the machines differ in more than numbers");
    }
    const Eigen::MatrixXd change =
        0.5 * (lagrangian(above, lambda, modes, forces) - lagrangian(below, lambda, modes, forces));
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> branches(change, 0.5 * (mass + mass.transpose()));
    if (branches.info() != Eigen::Success)
        throw Error(DTTMM_ERROR_NUMERIC, "the branches of a multiple frequency were not found");
    std::vector<double> changes;
    for (const double of_lambda : branches.eigenvalues()) changes.push_back(of_lambda / (2 * std::abs(omega)));
    return changes;
}

}  // namespace dttmm::plugin
