// SPDX-License-Identifier: BSD-3-Clause
#include "statics/loads_without_potential.h"

#include <algorithm>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Steps of GMRES. A force per length that turns with a bar of 5 to 160 segments takes 8, 11, 15 at the most where the force
/// is 10, 50, 200 EI/L².
constexpr Eigen::Index kMostSteps = 60;
/// Of the right-hand side. 1e-6 to 1e-15 take the same iterations but for chance.
constexpr double kResidual = 1e-9;

}  // namespace

/// A u, 6 per part.
Eigen::VectorXd LoadsWithoutPotential::loads_of(std::span<const Vector6> u) const {
    Eigen::VectorXd loads(6 * as_row(parts_.size()));
    for (size_t k = 0; k < parts_.size(); ++k)
        loads.segment<6>(6 * as_row(k)) = parts_[k].block * u[as_size(parts_[k].frame)];
    return loads;
}

void LoadsWithoutPotential::take_off(const Eigen::VectorXd& loads, std::span<Vector6> r) const {
    for (size_t k = 0; k < parts_.size(); ++k) r[as_size(parts_[k].frame)] -= loads.segment<6>(6 * as_row(k));
}

/// y of (I + A K⁻¹) y = `without`.
Eigen::VectorXd LoadsWithoutPotential::loads_that_balance(const Elimination& matrix, const Eigen::VectorXd& without,
                                                          size_t frames) const {
    const double size = without.norm();
    if (size == 0) return without;
    const Eigen::Index most = std::min(kMostSteps, without.size());
    Eigen::MatrixXd basis(without.size(), most + 1), H = Eigen::MatrixXd::Zero(most + 1, most);
    basis.col(0) = without / size;
    Eigen::VectorXd shares;
    for (Eigen::Index k = 0; k < most; ++k) {
        std::vector<Vector6> u(frames, Vector6::Zero());
        std::vector<double> q(as_size(matrix.rigid_count()), 0.0);
        take_off(-basis.col(k), u);
        matrix.solve(u, q);
        Eigen::VectorXd next = basis.col(k) + loads_of(u);
        for (Eigen::Index i = 0; i <= k; ++i) {
            H(i, k) = basis.col(i).dot(next);
            next -= H(i, k) * basis.col(i);
        }
        H(k + 1, k) = next.norm();
        const auto equations = H.topLeftCorner(k + 2, k + 1);
        const Eigen::VectorXd right = size * Eigen::VectorXd::Unit(k + 2, 0);
        shares = equations.householderQr().solve(right);
        if ((equations * shares - right).norm() <= kResidual * size || H(k + 1, k) == 0) break;
        basis.col(k + 1) = next / H(k + 1, k);
    }
    return basis.leftCols(shares.size()) * shares;
}

void LoadsWithoutPotential::solve(const Elimination& matrix, std::span<Vector6> r, std::span<double> g) const {
    if (!parts_.empty()) {
        std::vector<Vector6> u(r.begin(), r.end());
        std::vector<double> q(g.begin(), g.end());
        matrix.solve(u, q);
        take_off(loads_that_balance(matrix, loads_of(u), u.size()), r);
    }
    matrix.solve(r, g);
}

}  // namespace dttmm::plugin
