// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <complex>

namespace dttmm::plugin {

/// LU factors of a sparse matrix with a symmetric pattern, in units that balance it: stiffnesses of 1e9 N/m stand beside
/// rows of rigid directions, whose entries are near one, and partial pivoting compares them. Units are powers of two, which
/// change no digit.
/// Source of the idea: Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices (2001).
class BalancedLu {
public:
    using Sparse = Eigen::SparseMatrix<std::complex<double>>;

    /// False: the matrix is singular. The order of elimination is kept as long as the pattern stays.
    bool factor(const Sparse& matrix);
    Eigen::Index size() const { return balanced_.rows(); }
    Eigen::VectorXcd solve(const Eigen::VectorXcd& right_hand_side) const;

private:
    void find_units(const Sparse& matrix);

    Sparse balanced_;
    Eigen::VectorXd units_;  ///< of the unknowns
    Eigen::SparseLU<Sparse> lu_;
};

}  // namespace dttmm::plugin
