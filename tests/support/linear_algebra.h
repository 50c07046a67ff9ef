// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "support/oracle.h"

/// Eigen's solvers for matrices of any size, compiled once for all tests.
namespace dttmm::test {

using MatrixL = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using VectorL = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// x of A x = b, by elimination with full pivoting.
DTTMM_ORACLE Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
DTTMM_ORACLE VectorL solve(const MatrixL& A, const VectorL& b);

/// Gᵀ diag(k) G: stiffness by the unknowns of springs k that their rows of G deform.
DTTMM_ORACLE Eigen::MatrixXd stiffness_of(const Eigen::MatrixXd& G, const Eigen::VectorXd& k);
DTTMM_ORACLE MatrixL stiffness_of(const MatrixL& G, const VectorL& k);

struct Pencil {
    Eigen::VectorXd values;   ///< ascending
    Eigen::MatrixXd vectors;  ///< columns u with uᵀ M u = 1
};

/// K u = λ M u with symmetric K and positive definite M.
DTTMM_ORACLE Pencil solve_pencil(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);

/// Of a symmetric matrix, ascending.
DTTMM_ORACLE Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);
DTTMM_ORACLE Eigen::MatrixXd symmetric_eigenvectors(const Eigen::MatrixXd& A);

DTTMM_ORACLE Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

/// Descending.
DTTMM_ORACLE Eigen::VectorXd singular_values(const Eigen::MatrixXd& A);

DTTMM_ORACLE Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

DTTMM_ORACLE Eigen::MatrixXd exponential(const Eigen::MatrixXd& A);

}  // namespace dttmm::test
