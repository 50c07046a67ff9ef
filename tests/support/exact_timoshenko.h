// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace dttmm::test {

/// A uniform Timoshenko beam, bending in one plane, exact: its transfer matrix is exp(S x) with, in the signs of the state
/// vector z = [y θ m q],
///     y' = θ − q/κGA,   θ' = m/EI,   m' = q − ρI ω² θ,   q' = ρA ω² y
/// Nothing is discretised. Extended precision: a free-free determinant loses digits like cosh βL.
struct ExactTimoshenko {
    using Real = long double;
    using Matrix = Eigen::Matrix<Real, 4, 4>;
    using Vector = Eigen::Matrix<Real, 4, 1>;

    double EI, shear, mass, rotary, length;  ///< [N m²], κGA [N], [kg/m], ρI [kg m], [m]

    Matrix transfer(double omega, double x) const {
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

    /// Neither force nor moment at both ends.
    Real free_free(double omega) const {
        const Matrix U = transfer(omega, length);
        return U(2, 0) * U(3, 1) - U(2, 1) * U(3, 0);
    }

    /// Angular frequencies of the first `count` bending modes of the free beam [rad/s], by steps of `step` and bisection.
    std::vector<double> free_frequencies(int count, double step) const {
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

    /// Deflection at x of the free mode at omega; its size is of no meaning.
    double free_shape(double omega, double x) const {
        const Matrix U = transfer(omega, length);
        const Vector start(U(2, 1), -U(2, 0), 0, 0);  // makes m = 0 at the far end
        return static_cast<double>((transfer(omega, x) * start)(0));
    }
};

}  // namespace dttmm::test
