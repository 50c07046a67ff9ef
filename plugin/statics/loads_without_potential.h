// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "solve/elimination.h"

namespace dttmm::plugin {

/// The parts of the stiffness of loads that are not symmetric, beside a symmetric matrix that is factored: solutions of
/// (K + A) u = r, A a block per loaded frame. The equation of the loads y = A u,
///     (I + A K⁻¹) y = A K⁻¹ r,
/// is solved by GMRES, each step of which takes one solution with K; then K u = r − y. A moment takes two steps.
/// Source: Saad and Schultz (1986), GMRES, SIAM J. Sci. Stat. Comput. 7, 856-869.
class LoadsWithoutPotential {
public:
    /// Forgets them all.
    void clear() { parts_.clear(); }
    /// A block of A; zero: none. frame: of the matrix.
    void add(int frame, const Matrix6& part) {
        if (!part.isZero(0)) parts_.push_back({frame, part});
    }
    /// Solves as Elimination::solve, A added to its matrix.
    void solve(const Elimination& matrix, std::span<Vector6> r, std::span<double> g) const;

private:
    struct Part {
        int frame;
        Matrix6 block;
    };
    Eigen::VectorXd loads_of(std::span<const Vector6> u) const;
    void take_off(const Eigen::VectorXd& loads, std::span<Vector6> r) const;
    Eigen::VectorXd loads_that_balance(const Elimination& matrix, const Eigen::VectorXd& without, size_t frames) const;

    std::vector<Part> parts_;
};

}  // namespace dttmm::plugin
