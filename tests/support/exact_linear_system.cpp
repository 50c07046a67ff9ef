// SPDX-License-Identifier: BSD-3-Clause
#include "support/exact_linear_system.h"

#include <algorithm>

#include "support/linear_algebra.h"

namespace dttmm::test {

ExactLinearSystem::ExactLinearSystem(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C, const Eigen::MatrixXd& K,
                                     const Eigen::VectorXd& p, double amplitude, double rise_time)
    : n_(M.rows()), rise_time_(rise_time), state_(Eigen::VectorXd::Zero(2 * n_ + 4)) {
    const Eigen::MatrixXd inverse = test::inverse(M);
    rate_ = Eigen::MatrixXd::Zero(2 * n_ + 4, 2 * n_ + 4);
    rate_.block(0, n_, n_, n_).setIdentity();
    rate_.block(n_, 0, n_, n_) = -inverse * K;
    rate_.block(n_, n_, n_, n_) = -inverse * C;
    const Eigen::VectorXd push = inverse * p * amplitude;
    rate_.block(n_, 2 * n_ + 2, n_, 1) = 3 / (rise_time * rise_time) * push;
    rate_.block(n_, 2 * n_ + 3, n_, 1) = -2 / (rise_time * rise_time * rise_time) * push;
    for (int power = 1; power <= 3; ++power) rate_(2 * n_ + power, 2 * n_ + power - 1) = power;
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
