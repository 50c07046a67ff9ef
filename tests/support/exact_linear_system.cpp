// SPDX-License-Identifier: BSD-3-Clause
#include "support/exact_linear_system.h"

#include <algorithm>
#include <cmath>

#include "support/linear_algebra.h"

namespace dttmm::test {

ExactLinearSystem::ExactLinearSystem(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C, const Eigen::MatrixXd& K,
                                     const Eigen::VectorXd& p, double amplitude, double rise_time)
    : n_(M.rows()), rise_time_(rise_time), state_(Eigen::VectorXd::Zero(2 * n_ + 4)) {
    // Of one size each, velocities over a frequency and s for t: otherwise rounding grows with the norm of the matrix
    const Eigen::MatrixXd inverse = test::inverse(M), stiffness = inverse * K;
    frequency_ = std::sqrt(stiffness.cwiseAbs().maxCoeff());
    rate_ = Eigen::MatrixXd::Zero(2 * n_ + 4, 2 * n_ + 4);
    rate_.block(0, n_, n_, n_).diagonal().setConstant(frequency_);
    rate_.block(n_, 0, n_, n_) = -stiffness / frequency_;
    rate_.block(n_, n_, n_, n_) = -inverse * C;
    const Eigen::VectorXd push = inverse * p * amplitude / frequency_;
    rate_.block(n_, 2 * n_ + 2, n_, 1) = 3 * push;
    rate_.block(n_, 2 * n_ + 3, n_, 1) = -2 * push;
    for (int power = 1; power <= 3; ++power)
        rate_(2 * n_ + power, 2 * n_ + power - 1) = rise_time > 0 ? power / rise_time : 0;
    after_ = rate_;  // from T on the load is constant: a times the state's 1
    after_.block(n_, 2 * n_ + 2, n_, 2).setZero();
    after_.block(n_, 2 * n_, n_, 1) = push;
    state_(2 * n_) = 1;
}

void ExactLinearSystem::advance(double dt) {
    const double rising = std::clamp(rise_time_ - time_, 0.0, dt);
    move(rate_, rising);
    move(after_, dt - rising);
    time_ += dt;
}

void ExactLinearSystem::move(const Eigen::MatrixXd& A, double dt) {
    if (dt <= 1e-15) return;
    if (!(dt == known_dt_ && &A == known_)) {
        exponential_ = exponential(A * dt);
        known_dt_ = dt;
        known_ = &A;
    }
    state_ = exponential_ * state_;
}

}  // namespace dttmm::test
