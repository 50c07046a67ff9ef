// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "support/oracle.h"

namespace dttmm::test {

/// M q'' + C q' + K q = constant + pulse F(t) from rest at q = 0, F a train of haversine pulses ½ (1 − cos 2πs/width).
struct DTTMM_ORACLE LinearMachine {
    Eigen::MatrixXd M, C, K;
    Eigen::VectorXd constant, pulse;
    double width;                ///< of a pulse [s]
    std::vector<double> starts;  ///< of the pulses [s]

    explicit LinearMachine(Eigen::Index n)
        : M(Eigen::MatrixXd::Zero(n, n)), C(M), K(M), constant(Eigen::VectorXd::Zero(n)), pulse(constant), width(1) {}

    /// `G`: the motion of a point or a body by q. Masses and inertias along its rows.
    void add_mass(const Eigen::MatrixXd& G, const Eigen::VectorXd& mass);
    /// `G`: what a spring-damper is deformed by q.
    void add_spring(const Eigen::MatrixXd& G, const Eigen::VectorXd& k, const Eigen::VectorXd& c);
};

/// Its exact motion, row by row: the state extended by 1, cos and sin moves by a matrix exponential, so that nothing is
/// discretised in time. Pulses begin and end on a row.
class DTTMM_ORACLE ExactPulses {
public:
    ExactPulses(const LinearMachine& machine, double step);

    /// The next row.
    void advance();
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
