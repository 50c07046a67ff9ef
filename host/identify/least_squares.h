// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace dttmm::host {

/// Residuals, each divided by its standard deviation, at a point; always as many. May throw Error where the model has no
/// answer.
using ResidualFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;
/// Their derivatives, a column per unknown.
using JacobianFunction = std::function<Eigen::MatrixXd(const Eigen::VectorXd& x, const Eigen::VectorXd& residual)>;

/// A sum of squares to be made least between bounds.
struct LeastSquares {
    ResidualFunction residual;
    JacobianFunction jacobian;
    Eigen::VectorXd low, high;
    /// Whether the search is given up where residual and derivatives are these; none: it never is.
    std::function<bool(const Eigen::VectorXd& residual, const Eigen::MatrixXd& jacobian)> is_hopeless = {};
};

struct Minimum {
    Eigen::VectorXd x;
    Eigen::VectorXd residual;
    std::vector<bool> at_bound;  ///< the sum would fall beyond it
    bool is_converged = false;
    bool is_given_up = false;
    int evaluations = 0;
    size_t starts = 1;  ///< points that led here

    double chi2() const { return residual.squaredNorm(); }
};

inline constexpr int kMostEvaluations = 200;
/// When a search ends.
struct SearchEnd {
    int most_evaluations = kMostEvaluations;
    double enough = 1e-10;  ///< change of the sum, and of the distance gone, as a share
};

/// From `start` by the method of Levenberg and Marquardt (Eigen's, after MINPACK's lmder). An unknown that leaves its range
/// stays at the bound as long as the sum falls beyond it. Where the model has no answer the step is made shorter. Throws
/// what residual(start) throws.
Minimum minimise(const LeastSquares& problem, const Eigen::VectorXd& start, const SearchEnd& end = {});

}  // namespace dttmm::host
