// SPDX-License-Identifier: BSD-3-Clause
#include "support/linear_algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <unsupported/Eigen/MatrixFunctions>

namespace dttmm::test {

Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.fullPivLu().solve(b); }
VectorL solve(const MatrixL& A, const VectorL& b) { return A.fullPivLu().solve(b); }

Eigen::MatrixXd stiffness_of(const Eigen::MatrixXd& G, const Eigen::VectorXd& k) {
    return G.transpose() * k.asDiagonal() * G;
}
MatrixL stiffness_of(const MatrixL& G, const VectorL& k) { return G.transpose() * k.asDiagonal() * G; }

Pencil solve_pencil(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, M);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}
Eigen::MatrixXd symmetric_eigenvectors(const Eigen::MatrixXd& A) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvectors();
}

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A) {
    return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& A) { return Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues(); }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& A) { return A.inverse(); }

Eigen::MatrixXd exponential(const Eigen::MatrixXd& A) { return A.exp(); }

}  // namespace dttmm::test
