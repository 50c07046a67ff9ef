// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCholesky>
#include <vector>

#include "world/block_matrix.h"

namespace dttmm::host {

/// LDLᵀ of a BlockMatrix, its pattern analysed once. Where no body is coupled to another, each has the inverse of its own
/// block instead, in a third of the time.
class BlockFactor {
public:
    explicit BlockFactor(const BlockMatrix& matrix);

    /// False when the matrix is singular; the factor is then unusable.
    bool factor(const BlockMatrix& matrix);
    /// x ← matrix⁻¹ b; x has its size already.
    void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;
    /// The entry of D of an unknown; only with joints.
    double pivot(int index) const { return solver_.pivot(index); }

private:
    using Sparse = Eigen::SparseMatrix<double>;
    using Ldlt = Eigen::SimplicialLDLT<Sparse, Eigen::Upper, Eigen::NaturalOrdering<int>>;
    /// Eigen's factorize() makes an empty matrix each time; what it calls then does without.
    class Solver : public Ldlt {
    public:
        void refactor(const Sparse& matrix) { this->template factorize_preordered<true>(matrix); }
        double pivot(int index) const { return this->m_diag(index); }
    };
    Solver solver_;
    std::vector<int> starts_;  ///< first unknown of every body, if none is coupled to another; else empty
    std::vector<BlockMatrix::Block> inverses_;
};

}  // namespace dttmm::host
