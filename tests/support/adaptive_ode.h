// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

#include "support/oracle.h"

namespace dttmm::test {

/// y(t_end) of y' = f(t, y) from y at 0, by an error-controlled Runge-Kutta method of order 5(4); error about `tolerance`
/// times the number of steps. Source: Dormand and Prince (1980), J. Comput. Appl. Math. 6, 19–26.
DTTMM_ORACLE Eigen::VectorXd integrate(const std::function<Eigen::VectorXd(double, const Eigen::VectorXd&)>& f,
                                       Eigen::VectorXd y, double t_end, double tolerance = 1e-13);

}  // namespace dttmm::test
