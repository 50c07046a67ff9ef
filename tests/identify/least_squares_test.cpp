// SPDX-License-Identifier: BSD-3-Clause
#include "identify/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "model/error.h"

namespace dttmm::host {
namespace {

/// b − A x.
LeastSquares linear_problem(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double low, double high) {
    return {[=](const Eigen::VectorXd& x) { return Eigen::VectorXd(A * x - b); },
            [=](const Eigen::VectorXd&, const Eigen::VectorXd&) { return A; }, Eigen::VectorXd::Constant(A.cols(), low),
            Eigen::VectorXd::Constant(A.cols(), high)};
}

Eigen::MatrixXd ugly_matrix() {
    Eigen::MatrixXd A(5, 3);
    A << 1.2, -0.7, 3.1, 0.4, 2.2, -1.9, -2.5, 0.3, 0.8, 1.1, 1.7, 0.2, 0.6, -1.4, 2.3;
    return A;
}
const Eigen::VectorXd kRight = (Eigen::VectorXd(5) << 1.3, -0.2, 2.9, 0.7, -1.1).finished();

// Oracle: the normal equations.
TEST(LeastSquaresFit, ALinearProblemIsSolvedByItsNormalEquations) {
    const Eigen::MatrixXd A = ugly_matrix();
    const Minimum found = minimise(linear_problem(A, kRight, -100, 100), Eigen::Vector3d(5, -7, 9));
    const Eigen::VectorXd x = (A.transpose() * A).ldlt().solve(A.transpose() * kRight);
    EXPECT_LT((found.x - x).norm(), 1e-9);
    EXPECT_TRUE(found.is_converged);
    EXPECT_NEAR(found.chi2(), (A * x - kRight).squaredNorm(), 1e-12);
}

// Oracle: the conditions of Karush, Kuhn and Tucker, and the smaller problem without the unknowns that are at a bound.
TEST(LeastSquaresFit, AtABoundTheOthersAreBest) {
    const Eigen::MatrixXd A = ugly_matrix();
    const double low = -0.3, high = 0.5;
    const Minimum found = minimise(linear_problem(A, kRight, low, high), Eigen::Vector3d(0.1, 0.2, 0.3));
    const Eigen::VectorXd slope = A.transpose() * (A * found.x - kRight);
    bool has_bound = false;
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (found.at_bound[static_cast<size_t>(i)]) {
            has_bound = true;
            EXPECT_TRUE((found.x(i) == low && slope(i) > 0) || (found.x(i) == high && slope(i) < 0)) << i;
        } else {
            EXPECT_NEAR(slope(i), 0, 1e-8) << i;
        }
    }
    EXPECT_TRUE(has_bound) << "the problem was made to have one";
}

// A search that is given up ends where it was then, and says so.
TEST(LeastSquaresFit, IsGivenUpWhereItIsHopeless) {
    LeastSquares problem = linear_problem(ugly_matrix(), kRight, -100, 100);
    const Eigen::Vector3d start(5, -7, 9);
    int asked = 0;
    problem.is_hopeless = [&](const Eigen::VectorXd& residual, const Eigen::MatrixXd& jacobian) {
        EXPECT_EQ(jacobian, ugly_matrix());
        EXPECT_TRUE(asked > 0 || residual == ugly_matrix() * start - kRight);
        return ++asked == 2;
    };
    const Minimum once = minimise(problem, start);
    EXPECT_TRUE(once.is_given_up);
    EXPECT_FALSE(once.is_converged);
    EXPECT_LT(once.chi2(), (ugly_matrix() * start - kRight).squaredNorm());
    problem.is_hopeless = [](const Eigen::VectorXd&, const Eigen::MatrixXd&) { return true; };
    EXPECT_EQ(minimise(problem, start).x, start);
    problem.is_hopeless = [](const Eigen::VectorXd&, const Eigen::MatrixXd&) { return false; };
    EXPECT_FALSE(minimise(problem, start).is_given_up);
}

// Rosenbrock's valley, from the usual start; its minimum is (1, 1) exactly.
TEST(LeastSquaresFit, FollowsACurvedValley) {
    const LeastSquares valley{
        [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(10 * (x(1) - x(0) * x(0)), 1 - x(0))); },
        [](const Eigen::VectorXd& x, const Eigen::VectorXd&) {
            Eigen::MatrixXd J(2, 2);
            J << -20 * x(0), 10, -1, 0;
            return J;
        },
        Eigen::Vector2d(-5, -5), Eigen::Vector2d(5, 5)};
    const Minimum found = minimise(valley, Eigen::Vector2d(-1.2, 1));
    EXPECT_LT((found.x - Eigen::Vector2d(1, 1)).norm(), 1e-8);
}

// ln x has no value below 0: steps to there are made shorter. The minimum of (ln x)² is at 1.
TEST(LeastSquaresFit, AStepToWhereThereIsNoAnswerIsMadeShorter) {
    const LeastSquares problem{[](const Eigen::VectorXd& x) {
                                   if (!(x(0) > 0)) throw Error(ExitCode::numerical_failure, "no logarithm");
                                   return Eigen::VectorXd(Eigen::Vector2d(std::log(x(0)), 0.1 * std::log(x(0))));
                               },
                               [](const Eigen::VectorXd& x, const Eigen::VectorXd&) {
                                   return Eigen::MatrixXd(Eigen::Vector2d(1 / x(0), 0.1 / x(0)));
                               },
                               Eigen::VectorXd::Constant(1, -100), Eigen::VectorXd::Constant(1, 100)};
    const Minimum found = minimise(problem, Eigen::VectorXd::Constant(1, 8));  // Newton's step from 8 goes to −8.6
    EXPECT_NEAR(found.x(0), 1, 1e-8);
    EXPECT_THROW(minimise(problem, Eigen::VectorXd::Constant(1, -3)), Error) << "the start itself has none";
}

}  // namespace
}  // namespace dttmm::host
