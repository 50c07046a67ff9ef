// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "support/oracle.h"

namespace dttmm::test {

/// The exact motion of  M q'' + C q' + K q = p a (3 s² − 2 s³),  s = t/T clipped to 0…1,  from rest: the load is a
/// polynomial, so that the state, extended by 1, s, s², s³, moves by a matrix exponential. Nothing is discretised.
class DTTMM_ORACLE ExactLinearSystem {
public:
    ExactLinearSystem(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C, const Eigen::MatrixXd& K, const Eigen::VectorXd& p,
                      double amplitude, double rise_time);

    /// Motion after another dt.
    void advance(double dt);
    Eigen::VectorXd q() const { return state_.head(n_); }
    Eigen::VectorXd rate() const { return frequency_ * state_.segment(n_, n_); }

private:
    void move(const Eigen::MatrixXd& A, double dt);
    Eigen::Index n_;
    double rise_time_, frequency_ = 0, time_ = 0, known_dt_ = 0;
    const Eigen::MatrixXd* known_ = nullptr;
    Eigen::VectorXd state_;
    Eigen::MatrixXd rate_, after_, exponential_;
};

}  // namespace dttmm::test
