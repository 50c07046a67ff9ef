// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace dttmm::test {

/// M q'' + C q' + K q = constant + pulse F(t) from rest at q = 0, F a train of haversine pulses ½ (1 − cos 2πs/width).
struct LinearMachine {
    Eigen::MatrixXd M, C, K;
    Eigen::VectorXd constant, pulse;
    double width;                ///< of a pulse [s]
    std::vector<double> starts;  ///< of the pulses [s]

    explicit LinearMachine(Eigen::Index n)
        : M(Eigen::MatrixXd::Zero(n, n)), C(M), K(M), constant(Eigen::VectorXd::Zero(n)), pulse(constant), width(1) {}

    /// `G`: the motion of a point or a body by q. Masses and inertias along its rows.
    void add_mass(const Eigen::MatrixXd& G, const Eigen::VectorXd& mass) { M += G.transpose() * mass.asDiagonal() * G; }
    /// `G`: what a spring-damper is deformed by q.
    void add_spring(const Eigen::MatrixXd& G, const Eigen::VectorXd& k, const Eigen::VectorXd& c) {
        K += G.transpose() * k.asDiagonal() * G;
        C += G.transpose() * c.asDiagonal() * G;
    }
};

/// Its exact motion, row by row: the state extended by 1, cos and sin moves by a matrix exponential, so that nothing is
/// discretised in time. Pulses begin and end on a row.
class ExactPulses {
public:
    ExactPulses(const LinearMachine& machine, double step)
        : n_(machine.M.rows()), width_(std::lround(machine.width / step)), state_(Eigen::VectorXd::Zero(2 * n_ + 3)) {
        for (double start : machine.starts) starts_.push_back(std::lround(start / step));
        const Eigen::MatrixXd inverse = machine.M.inverse();
        const Eigen::VectorXd push = inverse * machine.pulse;
        Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(2 * n_ + 3, 2 * n_ + 3);
        rate.block(0, n_, n_, n_).setIdentity();
        rate.block(n_, 0, n_, n_) = -inverse * machine.K;
        rate.block(n_, n_, n_, n_) = -inverse * machine.C;
        rate.block(n_, 2 * n_, n_, 1) = inverse * machine.constant;
        quiet_ = Eigen::MatrixXd(rate * step).exp();
        rate.block(n_, 2 * n_, n_, 1) += 0.5 * push;
        rate.block(n_, 2 * n_ + 1, n_, 1) -= 0.5 * push;
        const double turn = 2 * std::numbers::pi / machine.width;
        rate(2 * n_ + 1, 2 * n_ + 2) = -turn;  // cos' = −w sin, sin' = w cos
        rate(2 * n_ + 2, 2 * n_ + 1) = turn;
        pushing_ = Eigen::MatrixXd(rate * step).exp();
        state_(2 * n_) = 1;
    }

    /// The next row.
    void advance() {
        bool pushes = false;
        for (long start : starts_) {
            if (row_ == start) state_.tail<2>() = Eigen::Vector2d(1, 0);
            pushes = pushes || (row_ >= start && row_ < start + width_);
        }
        state_ = ((pushes ? pushing_ : quiet_) * state_).eval();
        ++row_;
    }
    auto q() const { return state_.head(n_); }
    auto rate() const { return state_.segment(n_, n_); }

private:
    Eigen::Index n_;
    long width_, row_ = 0;
    std::vector<long> starts_;
    Eigen::VectorXd state_;
    Eigen::MatrixXd quiet_, pushing_;
};

}  // namespace dttmm::test
