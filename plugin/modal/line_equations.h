// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

#include "modal/exponential.h"

namespace dttmm::plugin {

/// Of states y along a piece, from x = 0 to 1: y' = (S[0] + S[1] x + S[2] x²) y; by_lambda is what λ adds to S.
template <class Square>
struct LineEquations {
    std::array<Square, 3> S;
    Square by_lambda;

    /// Of all but by_lambda.
    double norm() const { return norm_of(S[0]) + norm_of(S[1]) + norm_of(S[2]); }
    bool is_uniform() const { return S[1].isZero(0) && S[2].isZero(0); }
    LineEquations half(double from) const {
        return {{(S[0] + from * S[1] + from * from * S[2]) / 2, (S[1] + 2 * from * S[2]) / 4, S[2] / 8}, by_lambda / 2};
    }
};

/// Their entries: most are zero.
template <class Square>
class LineEntries {
public:
    /// power: of x, by which an entry goes.
    LineEntries(const LineEquations<Square>& equations, bool with_lambda) {
        for (const unsigned power : {0u, 1u, 2u}) list(equations.S[power], power);
        own_ = count_;
        if (with_lambda) list(equations.by_lambda, 0);
    }
    /// Adds the products of S and of by_lambda with y_k-1, y_k-2, y_k-3, which stand at k modulo 4.
    template <class Rows>
    void add_product(unsigned k, const std::array<Rows, 4>& y, Rows& sum) const {
        add(0, own_, k, y, sum);
    }
    template <class Rows>
    void add_by_lambda(unsigned k, const std::array<Rows, 4>& y, Rows& sum) const {
        add(own_, count_, k, y, sum);
    }

private:
    struct Entry {
        unsigned power;
        Eigen::Index row, column;
        typename Square::Scalar value;
    };
    void list(const Square& block, unsigned power) {
        for (Eigen::Index i = 0; i < block.rows(); ++i)
            for (Eigen::Index j = 0; j < block.cols(); ++j)
                if (block(i, j) != typename Square::Scalar(0)) entries_[count_++] = {power, i, j, block(i, j)};
    }
    template <class Rows>
    void add(std::size_t from, std::size_t to, unsigned k, const std::array<Rows, 4>& y, Rows& sum) const {
        for (std::size_t e = from; e < to; ++e) {
            const auto& [power, row, column, value] = entries_[e];
            sum.row(row) += value * y[(k - 1 - power) % 4].row(column);
        }
    }

    std::array<Entry, 4 * std::size_t{Square::MaxSizeAtCompileTime}> entries_;
    std::size_t count_ = 0, own_ = 0;
};

/// Carries states Σ y[j] λʲ from x = 0 to 1, λ counted from that of the equations, by the power series y = Σ yₖ xᵏ,
///     k yₖ[j] = S₀ yₖ₋₁[j] + S₁ yₖ₋₂[j] + S₂ yₖ₋₃[j] + S_λ yₖ₋₁[j−1].
/// norm: of all S together; over halves where it is so large that terms cancel.
template <class Square, class States, std::size_t powers>
void carry_over(const LineEquations<Square>& equations, double norm, std::array<States, powers>& y) {
    constexpr double kMostNorm = 4;      // sums are then at most e⁴ times smaller than their terms
    constexpr unsigned kMostTerms = 40;  // the next is 4^41/41! = 1e-25
    if (norm > kMostNorm) {
        for (const double from : {0., 0.5}) carry_over(equations.half(from), norm / 2, y);
        return;
    }
    constexpr int kOrder = States::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
    using Rows = Eigen::Matrix<typename States::Scalar, States::RowsAtCompileTime, States::ColsAtCompileTime, kOrder,
                               States::MaxRowsAtCompileTime, States::MaxColsAtCompileTime>;
    const LineEntries<Square> entries(equations, powers > 1);
    struct Power {
        std::array<Rows, 4> terms;  ///< yₖ at k modulo 4
        Rows sum;
    };
    std::array<Power, powers> all;
    const Rows zero = Rows::Zero(y[0].rows(), y[0].cols());
    std::size_t reached = 0;
    for (std::size_t j = 0; j < powers; ++j) {
        all[j] = {{y[j], zero, zero, zero}, y[j]};
        if (!y[j].isZero(0)) reached = j;
    }
    for (unsigned k = 1, idle = 0; k <= kMostTerms && idle < 3; ++k) {
        bool changes = false;
        if constexpr (powers > 1)
            if (reached + 1 < powers) {  // higher powers are not felt where the last is not
                Rows most = zero;
                for (std::size_t j = 0; j < powers && j < reached; ++j) most += all[j].sum.cwiseAbs();
                changes = most + all[reached].sum.cwiseAbs() != most;
                if (changes) ++reached;
            }
        for (std::size_t j = 0; j < powers && j <= reached; ++j) {
            auto& [terms, sum] = all[j];
            Rows& next = terms[k % 4] = zero;
            entries.add_product(k, terms, next);
            if (j > 0) entries.add_by_lambda(k, all[j - 1].terms, next);
            next *= 1.0 / k;
            const Rows before = sum;
            sum += next;
            changes = changes || sum != before;
        }
        idle = changes ? 0 : idle + 1;
    }
    for (std::size_t j = 0; j < powers; ++j) y[j] = all[j].sum;
}

}  // namespace dttmm::plugin
