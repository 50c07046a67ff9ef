// SPDX-License-Identifier: BSD-3-Clause
#include "support/exact_pulses.h"

#include <cmath>
#include <numbers>

#include "support/linear_algebra.h"

namespace dttmm::test {

void LinearMachine::add_mass(const Eigen::MatrixXd& G, const Eigen::VectorXd& mass) {
    M += G.transpose() * mass.asDiagonal() * G;
}

void LinearMachine::add_spring(const Eigen::MatrixXd& G, const Eigen::VectorXd& k, const Eigen::VectorXd& c) {
    K += G.transpose() * k.asDiagonal() * G;
    C += G.transpose() * c.asDiagonal() * G;
}

ExactPulses::ExactPulses(const LinearMachine& machine, double step)
    : n_(machine.M.rows()), width_(std::lround(machine.width / step)), state_(Eigen::VectorXd::Zero(2 * n_ + 3)) {
    for (double start : machine.starts) starts_.push_back(std::lround(start / step));
    const Eigen::MatrixXd inverse = test::inverse(machine.M);
    const Eigen::VectorXd push = inverse * machine.pulse;
    Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(2 * n_ + 3, 2 * n_ + 3);
    rate.block(0, n_, n_, n_).setIdentity();
    rate.block(n_, 0, n_, n_) = -inverse * machine.K;
    rate.block(n_, n_, n_, n_) = -inverse * machine.C;
    rate.block(n_, 2 * n_, n_, 1) = inverse * machine.constant;
    quiet_ = exponential(rate * step);
    rate.block(n_, 2 * n_, n_, 1) += 0.5 * push;
    rate.block(n_, 2 * n_ + 1, n_, 1) -= 0.5 * push;
    const double turn = 2 * std::numbers::pi / machine.width;
    rate(2 * n_ + 1, 2 * n_ + 2) = -turn;  // cos' = −w sin, sin' = w cos
    rate(2 * n_ + 2, 2 * n_ + 1) = turn;
    pushing_ = exponential(rate * step);
    state_(2 * n_) = 1;
}

void ExactPulses::advance() {
    bool pushes = false;
    for (long start : starts_) {
        if (row_ == start) state_.tail<2>() = Eigen::Vector2d(1, 0);
        pushes = pushes || (row_ >= start && row_ < start + width_);
    }
    state_ = ((pushes ? pushing_ : quiet_) * state_).eval();
    ++row_;
}

}  // namespace dttmm::test
