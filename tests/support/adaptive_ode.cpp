// SPDX-License-Identifier: BSD-3-Clause
#include "support/adaptive_ode.h"

#include <algorithm>
#include <cmath>

namespace dttmm::test {

Eigen::VectorXd integrate(const std::function<Eigen::VectorXd(double, const Eigen::VectorXd&)>& f, Eigen::VectorXd y,
                          double t_end, double tolerance) {
    double t = 0, h = 1e-4;
    while (t < t_end) {
        h = std::min(h, t_end - t);
        const Eigen::VectorXd k1 = f(t, y), k2 = f(t + h / 5, y + h * k1 / 5),
                              k3 = f(t + 3 * h / 10, y + h * (3 * k1 / 40 + 9 * k2 / 40)),
                              k4 = f(t + 4 * h / 5, y + h * (44 * k1 / 45 - 56 * k2 / 15 + 32 * k3 / 9)),
                              k5 = f(t + 8 * h / 9,
                                     y + h * (19372 * k1 / 6561 - 25360 * k2 / 2187 + 64448 * k3 / 6561 - 212 * k4 / 729)),
                              k6 = f(t + h, y + h * (9017 * k1 / 3168 - 355 * k2 / 33 + 46732 * k3 / 5247 + 49 * k4 / 176 -
                                                     5103 * k5 / 18656));
        const Eigen::VectorXd next =
            y + h * (35 * k1 / 384 + 500 * k3 / 1113 + 125 * k4 / 192 - 2187 * k5 / 6784 + 11 * k6 / 84);
        const Eigen::VectorXd k7 = f(t + h, next);
        const double error =
            h * (71 * k1 / 57600 - 71 * k3 / 16695 + 71 * k4 / 1920 - 17253 * k5 / 339200 + 22 * k6 / 525 - k7 / 40)
                    .cwiseAbs()
                    .maxCoeff();
        const double allowed = tolerance * std::max(1.0, y.cwiseAbs().maxCoeff());
        if (error <= allowed) {
            t += h;
            y = next;
        }
        h *= std::clamp(0.9 * std::pow(allowed / std::max(error, 1e-300), 0.2), 0.2, 5.0);
    }
    return y;
}

}  // namespace dttmm::test
