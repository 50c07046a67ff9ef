// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace dttmm::test {

/// The exact motion of  M q'' + C q' + K q = p a (3 s² − 2 s³),  s = t/T clipped to 0…1,  from rest: the load is a
/// polynomial, so that the state, extended by 1, t, t², t³, moves by a matrix exponential. Nothing is discretised.
class ExactLinearSystem {
public:
    ExactLinearSystem(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C, const Eigen::MatrixXd& K, const Eigen::VectorXd& p,
                      double amplitude, double rise_time)
        : n_(M.rows()), rise_time_(rise_time), state_(Eigen::VectorXd::Zero(2 * n_ + 4)) {
        const Eigen::MatrixXd inverse = M.inverse();
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

    /// Motion after another dt.
    void advance(double dt) {
        const double rising = std::clamp(rise_time_ - time_, 0.0, dt);
        move(rate_, rising);
        move(after_, dt - rising);
        time_ += dt;
    }
    Eigen::VectorXd q() const { return state_.head(n_); }
    Eigen::VectorXd rate() const { return state_.segment(n_, n_); }

private:
    void move(const Eigen::MatrixXd& A, double dt) {
        if (dt <= 1e-15) return;
        if (!(dt == known_dt_ && &A == known_)) {
            exponential_ = Eigen::MatrixXd(A * dt).exp();
            known_dt_ = dt;
            known_ = &A;
        }
        state_ = exponential_ * state_;
    }
    Eigen::Index n_;
    double rise_time_, time_ = 0, known_dt_ = 0;
    const Eigen::MatrixXd* known_ = nullptr;
    Eigen::VectorXd state_;
    Eigen::MatrixXd rate_, after_, exponential_;
};

}  // namespace dttmm::test
