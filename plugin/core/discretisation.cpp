// SPDX-License-Identifier: BSD-3-Clause
#include "core/discretisation.h"

namespace dttmm::plugin {

AffineMotion fox_euler(const History& past, double h) { return newmark(past, h, 0.5, 1.0); }

AffineMotion newmark(const History& past, double h, double beta, double gamma) {
    // x = x₁ + h v₁ + h² ((1/2 − β) a₁ + β a)  =>  a = A x + B
    // v = v₁ + h ((1 − γ) a₁ + γ a)            =>  v = C x + D
    AffineMotion step;
    step.A = 1 / (beta * h * h);
    step.B = -step.A * (past.x[0] + h * past.v[0] + (0.5 - beta) * h * h * past.a[0]);
    step.C = gamma * h * step.A;
    step.D = past.v[0] + h * ((1 - gamma) * past.a[0] + gamma * step.B);
    return step;
}

AffineMotion wilson_theta(const History& past, double h, double theta) { return newmark(past, theta * h, 1.0 / 6, 0.5); }

Motion wilson_end_of_step(const History& past, double h, double theta, const Vector6& x_theta) {
    // The acceleration is linear over θh: read it at h, integrate once for v and twice for x.
    const Vector6 a_theta = wilson_theta(past, h, theta).acceleration(x_theta);
    Motion end;
    end.a = past.a[0] + (a_theta - past.a[0]) / theta;
    end.v = past.v[0] + 0.5 * h * (end.a + past.a[0]);
    end.x = past.x[0] + h * past.v[0] + h * h / 6 * (2 * past.a[0] + end.a);
    return end;
}

AffineMotion houbolt(const History& past, double h) {
    AffineMotion step;
    step.A = 2 / (h * h);
    step.B = -(5 * past.x[0] - 4 * past.x[1] + past.x[2]) / (h * h);
    step.C = 11 / (6 * h);
    step.D = -(18 * past.x[0] - 9 * past.x[1] + 2 * past.x[2]) / (6 * h);
    return step;
}

AffineMotion houbolt_second_step(const History& past, double h) {
    AffineMotion step;
    step.A = 2 / (h * h);
    step.B = -(4 * past.x[0] - 2 * past.x[1] + h * h * past.a[1]) / (h * h);
    step.C = 11 / (6 * h);
    step.D = -(16 * past.x[0] - 5 * past.x[1] + 2 * h * h * past.a[1]) / (6 * h);
    return step;
}

AffineMotion park(const History& past, double h) {
    // v = C x + D and a = C v + (history of v)  =>  a = C² x + C D + (history of v)
    AffineMotion step;
    step.C = 5 / (3 * h);
    step.D = (-15 * past.x[0] + 6 * past.x[1] - past.x[2]) / (6 * h);
    step.A = step.C * step.C;
    step.B = step.C * step.D + (-15 * past.v[0] + 6 * past.v[1] - past.v[2]) / (6 * h);
    return step;
}

AffineMotion bdf1(const History& past, double h) {
    AffineMotion step;
    step.C = 1 / h;
    step.D = -past.x[0] / h;
    step.A = step.C * step.C;
    step.B = step.C * step.D - past.v[0] / h;
    return step;
}

AffineMotion bdf2(const History& past, double h) {
    AffineMotion step;
    step.C = 3 / (2 * h);
    step.D = (-4 * past.x[0] + past.x[1]) / (2 * h);
    step.A = step.C * step.C;
    step.B = step.C * step.D + (-4 * past.v[0] + past.v[1]) / (2 * h);
    return step;
}

GeneralisedAlpha::GeneralisedAlpha(double rho)
    : alpha_m((2 * rho - 1) / (rho + 1)),
      alpha_f(rho / (rho + 1)),
      beta(0.25 * (1 - alpha_m + alpha_f) * (1 - alpha_m + alpha_f)),
      gamma(0.5 - alpha_m + alpha_f) {}

AffineMotion Centred::motion(const Vector6& x_now, const Vector6& x_before, double h) const {
    AffineMotion step;
    step.A = 1 / (h * h);
    step.B = (x_before - 2 * x_now) / (h * h);
    step.C = gamma / h;
    step.D = ((1 - 2 * gamma) * x_now + (gamma - 1) * x_before) / h;
    return step;
}

}  // namespace dttmm::plugin
