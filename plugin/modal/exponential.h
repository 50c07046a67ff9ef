// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

namespace dttmm::plugin {

/// The largest sum of a column.
template <class Square>
double norm_of(const Square& X) {
    return X.cwiseAbs().colwise().sum().maxCoeff();
}

/// Halvings of X until its norm is at most 0.5.
template <class Square>
int squarings_of(const Square& X) {
    const double norm = norm_of(X);
    return norm > 0.5 ? static_cast<int>(std::ceil(std::log2(norm / 0.5))) : 0;
}

/// e^X and its derivative by Y, X' = Y: Taylor of a small fraction until a term changes nothing, then squared. At λ = 0 the
/// series ends by itself.
template <class Square>
void exponential_of(Square X, Square Y, Square& E, Square& D) {
    constexpr int kMostTerms = 16;  // of a norm of 0.5 the next is 1e-20
    const int squarings = squarings_of(X);
    const double part = std::ldexp(1.0, -squarings);
    X *= part;
    Y *= part;
    const auto n = X.rows();
    Square term = Square::Identity(n, n), change = Square::Zero(n, n);
    E = term;
    D = change;
    for (int k = 1; k <= kMostTerms; ++k) {
        const Square before = E, derivative = D;
        D += change = ((X * change + Y * term) / k).eval();
        E += term = (X * term / k).eval();
        if (E == before && D == derivative) break;
    }
    for (int k = 0; k < squarings; ++k) {
        D = (E * D + D * E).eval();
        E = (E * E).eval();
    }
}

/// e^X alone, by fewer products: Taylor's terms up to X¹⁵ as a polynomial in X⁴ (Paterson and Stockmeyer).
template <class Square>
Square exponential_alone(Square X) {
    const int squarings = squarings_of(X);  // at 0.5 the first term left out is 7e-19
    X *= std::ldexp(1.0, -squarings);
    const Square X2 = X * X, X3 = X2 * X, X4 = X2 * X2;
    constexpr std::array<double, 16> kPartOf = [] {
        std::array<double, 16> parts{1};
        for (std::size_t k = 1; k < parts.size(); ++k) parts[k] = parts[k - 1] / static_cast<double>(k);
        return parts;
    }();
    const auto four = [&](std::size_t k) {
        Square sum = kPartOf[k + 1] * X + kPartOf[k + 2] * X2 + kPartOf[k + 3] * X3;
        sum.diagonal().array() += kPartOf[k];
        return sum;
    };
    Square E = four(12);
    for (const std::size_t k : {std::size_t{8}, std::size_t{4}, std::size_t{0}}) E = (four(k) + X4 * E).eval();
    for (int k = 0; k < squarings; ++k) E = (E * E).eval();
    return E;
}

/// The one or the other, of fixed size.
template <class Square>
void exponential(const Square& X, const Square& Y, bool with_derivative, Square& E, Square& D) {
    if (with_derivative)
        exponential_of<Square>(X, Y, E, D);
    else
        E = exponential_alone<Square>(X);
}

/// The same of blocks of 6, 8, 10 or 12 rows, each worked out at its own size.
template <class Scalar>
using SquareUpTo12 = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
template <int size, class Scalar>
void exponential_of_size(const SquareUpTo12<Scalar>& X, const SquareUpTo12<Scalar>& Y, bool with_derivative,
                         SquareUpTo12<Scalar>& E, SquareUpTo12<Scalar>& D) {
    Eigen::Matrix<Scalar, size, size> own, derivative;
    exponential<Eigen::Matrix<Scalar, size, size>>(X, Y, with_derivative, own, derivative);
    E = own;
    if (with_derivative) D = derivative;
}
template <class Scalar>
void exponential(const SquareUpTo12<Scalar>& X, const SquareUpTo12<Scalar>& Y, bool with_derivative, SquareUpTo12<Scalar>& E,
                 SquareUpTo12<Scalar>& D) {
    switch (X.rows()) {
        case 6:
            return exponential_of_size<6>(X, Y, with_derivative, E, D);
        case 8:
            return exponential_of_size<8>(X, Y, with_derivative, E, D);
        case 10:
            return exponential_of_size<10>(X, Y, with_derivative, E, D);
        default:
            exponential_of_size<12>(X, Y, with_derivative, E, D);
    }
}

}  // namespace dttmm::plugin
