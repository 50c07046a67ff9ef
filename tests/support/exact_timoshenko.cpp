// SPDX-License-Identifier: BSD-3-Clause
#include "support/exact_timoshenko.h"

#include <cmath>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>

namespace dttmm::test {

ExactTimoshenko::Matrix ExactTimoshenko::transfer(double omega, double x) const {
    const Real square = static_cast<Real>(omega) * omega;
    Matrix S = Matrix::Zero();
    S(0, 1) = 1;
    S(0, 3) = -1 / static_cast<Real>(shear);
    S(1, 2) = 1 / static_cast<Real>(EI);
    S(2, 3) = 1;
    S(2, 1) = -rotary * square;
    S(3, 0) = mass * square;
    // In units in which the entries are of one size
    const Vector unit(1, 1, EI, EI);
    const Matrix scaled = unit.cwiseInverse().asDiagonal() * S * unit.asDiagonal();
    return unit.asDiagonal() * Matrix((scaled * static_cast<Real>(x)).exp()) * unit.cwiseInverse().asDiagonal();
}

ExactTimoshenko::Real ExactTimoshenko::free_free(double omega) const {
    const Matrix U = transfer(omega, length);
    return U(2, 0) * U(3, 1) - U(2, 1) * U(3, 0);
}

std::vector<double> ExactTimoshenko::free_frequencies(int count, double step) const {
    std::vector<double> found;
    for (int i = 1; static_cast<int>(found.size()) < count; ++i) {
        if (i > 1000000) throw std::runtime_error("the frequencies were not found");
        double low = i * step, high = low + step;
        const bool sign = free_free(low) > 0;
        if ((free_free(high) > 0) == sign) continue;
        for (int halving = 0; halving < 60; ++halving) {
            const double middle = 0.5 * (low + high);
            ((free_free(middle) > 0) == sign ? low : high) = middle;
        }
        found.push_back(0.5 * (low + high));
    }
    return found;
}

double ExactTimoshenko::free_shape(double omega, double x) const {
    const Matrix U = transfer(omega, length);
    const Vector start(U(2, 1), -U(2, 0), 0, 0);  // makes m = 0 at the far end
    return static_cast<double>((transfer(omega, x) * start)(0));
}

ExactTipMass::ExactTipMass(const ExactTimoshenko& beam, double tip_mass, double tip_inertia, int modes)
    : beam_(beam), mass_(tip_mass), inertia_(tip_inertia) {
    for (double low = 1; static_cast<int>(omegas_.size()) < modes; low *= 1.01) {
        double a = low, b = 1.01 * low;
        const bool sign = receptance(a).second > 0;
        if ((receptance(b).second > 0) == sign) continue;
        for (int halving = 0; halving < 60; ++halving) {
            const double middle = 0.5 * (a + b);
            ((receptance(middle).second > 0) == sign ? a : b) = middle;
        }
        const double w = 0.5 * (a + b), step = 1e-5 * w;
        const ExactTimoshenko::Real slope = (receptance(w + step).second - receptance(w - step).second) / (2 * step);
        omegas_.push_back(w);
        // y/F = N/D and = Σ ω_i² r_i/(ω_i² − ω²) near ω_i:  r_i = −2 N/(D' ω_i)
        shares_.push_back(static_cast<double>(-2 * receptance(w).first / (slope * w)));
    }
}

double ExactTipMass::tip(double force, double t) const {
    double y = 0;
    for (size_t i = 0; i < omegas_.size(); ++i) y += shares_[i] * (1 - std::cos(omegas_[i] * t));
    return force * y;
}

double ExactTipMass::compliance() const {
    double sum = 0;
    for (double share : shares_) sum += share;
    return sum;
}

std::pair<ExactTimoshenko::Real, ExactTimoshenko::Real> ExactTipMass::receptance(double omega) const {
    using Real = ExactTimoshenko::Real;
    const Real square = static_cast<Real>(omega) * omega;
    const ExactTimoshenko::Matrix U = beam_.transfer(omega, beam_.length);
    // From z_0 = [0 0 m q]: −ω² M y = q + F and −ω² J θ = −m of the body behind the output end
    Real moment[2], force[2];
    for (int c : {0, 1}) {
        moment[c] = U(2, 2 + c) - square * inertia_ * U(1, 2 + c);
        force[c] = U(3, 2 + c) + square * mass_ * U(0, 2 + c);
    }
    // moment = 0 and force = −F for (m, q) ~ (−moment[1], moment[0])
    const Real y = U(0, 3) * moment[0] - U(0, 2) * moment[1];
    const Real D = force[1] * moment[0] - force[0] * moment[1];
    return {-y, D};
}

}  // namespace dttmm::test
