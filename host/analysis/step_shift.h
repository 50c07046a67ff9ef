// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "analysis/json.h"

namespace dttmm::host {

/// What the time step makes of a damped vibration. Per step it is multiplied by z = exp(s_h h). The true one, s, solves
///     s^2 + 2 zeta omega s + omega^2 = 0,   while   A(z) + 2 zeta omega V(z) + omega^2 P(z) = 0
/// with the acceleration A = (z - 2 + 1/z)/h^2, velocity V and position P of the scheme. Real and imaginary part of the
/// second give zeta and omega. The trapezoidal rule makes of it s = (2/h) tanh(s_h h/2); undamped omega h/2 = tan(omega_h
/// h/2), that is omega_h = omega (1 - (omega h)^2/12 + ..). Central differences: omega h/2 = sin(omega_h h/2).
class StepShift {
public:
    /// Of the step of a run, by its summary; nothing if there is none. A history that is extrapolated is the sum of two, 4/3
    /// of that of the shortest step and -1/3 of that of twice this step: both, the shortest first.
    static std::vector<StepShift> of_run(const Json& summary);
    /// scheme: "centred" or that of an explicit coupling; radius: of the centred one at infinite frequency.
    StepShift(double step, std::string scheme, double radius);

    /// The s of the machine behind the s_h of the history, both with positive imaginary part.
    std::complex<double> true_rate(std::complex<double> recorded) const;
    /// "implicit coupling, step 0.001 s: frequencies are too low by (omega h)^2/12".
    std::string describe() const;
    double step() const { return step_; }

private:
    double step_;
    std::string scheme_;
    double beta_, gamma_;
};

}  // namespace dttmm::host
