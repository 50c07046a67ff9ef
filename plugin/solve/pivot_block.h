// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <optional>

#include "core/index.h"
#include "core/rounding.h"

namespace dttmm::plugin {

/// Of the least pivot of a Cholesky factor, of the largest: eigenvalues are then above 1e-6/4⁶ of the largest, far from any
/// limit asked for.
inline constexpr double kClearPivot = 1e-6, kFarFromSingular = 1e-11;

/// Whether no eigenvalue is negative, or near it; quicker than to find them.
template <class Square>
bool is_clearly_positive(const Square& block) {
    const Eigen::LLT<Square> factor(block);
    if (factor.info() != Eigen::Success) return false;
    const auto pivots = factor.matrixLLT().diagonal();
    const double least = pivots.minCoeff(), largest = pivots.maxCoeff();
    return least * least > kClearPivot * largest * largest;
}

/// The block of a pivot after full-pivot elimination, in units that balance it. An elastic one has its own size at
/// compile time: there are many.
template <class Square>
class PivotBlock {
public:
    static constexpr int kSize = Square::RowsAtCompileTime, kMost = Square::MaxRowsAtCompileTime;
    Eigen::Matrix<double, kSize, 1, 0, kMost, 1> scale;  ///< set before decompose(): one unit of each unknown

    /// smallest: least allowed eigenvalue as share of the largest; nothing: eigenvalues are not counted. Returns the unknown
    /// at fault; nothing if there is none.
    std::optional<int> decompose(const Square& block, std::optional<double> smallest) {
        const Eigen::Index n = block.rows();
        const Square scaled = scale.asDiagonal() * block * scale.asDiagonal();
        negatives_ = 0;
        lu_.setThreshold(0);
        lu_.compute(scaled);
        if (smallest && *smallest <= kFarFromSingular && is_clearly_positive(scaled)) return invert(n);
        if (smallest && scaled.allFinite()) {
            const auto eigenvalues =
                Eigen::SelfAdjointEigenSolver<Square>(scaled, Eigen::EigenvaluesOnly).eigenvalues().eval();
            const auto sizes = eigenvalues.cwiseAbs().eval();
            if (sizes.minCoeff() > *smallest * sizes.maxCoeff()) {
                negatives_ = as_int((eigenvalues.array() < 0).count());
                return invert(n);
            }
        } else if (scaled.allFinite() && lu_.matrixLU()(n - 1, n - 1) != 0) {
            // The condition from the inverse, which is wanted anyway: the library's estimate allocates
            invert(n);
            const auto norm = [](const Square& matrix) { return matrix.cwiseAbs().colwise().sum().maxCoeff(); };
            if (norm(scaled) * norm(inverse_) < 1 / kRoundingOfSums) return std::nullopt;
        }
        return as_int(lu_.permutationQ().indices()(n - 1));
    }
    /// Eigenvalues below 0, where they were counted.
    int negatives() const { return negatives_; }

    Square inverse() const { return scale.asDiagonal() * (0.5 * (inverse_ + inverse_.transpose())) * scale.asDiagonal(); }
    /// Not by its inverse: where a block is stiff in one direction and soft in another, what the inverse owes to the
    /// soft one would swamp what is handed on of the stiff one.
    template <class Columns>
    Columns solve(const Columns& B) const {
        return scale.asDiagonal() * substitute(Columns(scale.asDiagonal() * B));
    }

private:
    std::nullopt_t invert(Eigen::Index n) {
        inverse_ = substitute(Square(Square::Identity(n, n)));
        return std::nullopt;
    }
    /// By the factor in its units. Rows of the right-hand sides stand in columns, so each operation is one vector
    /// instruction or two. Eigen's own solver is made for large matrices.
    template <class Columns>
    Columns substitute(const Columns& B) const {
        const auto& LU = lu_.matrixLU();
        const auto& from = lu_.permutationP().indices();
        const auto& to = lu_.permutationQ().indices();
        const Eigen::Index n = B.rows();
        Eigen::Matrix<double, Columns::ColsAtCompileTime, kSize, 0, Columns::MaxColsAtCompileTime, kMost> rows(B.cols(), n);
        for (Eigen::Index i = 0; i < n; ++i) rows.col(from(i)) = B.row(i).transpose();
        for (Eigen::Index i = 1; i < n; ++i)
            for (Eigen::Index k = 0; k < i; ++k) rows.col(i) -= LU(i, k) * rows.col(k);
        for (Eigen::Index i = n; i-- > 0;) {
            for (Eigen::Index k = i + 1; k < n; ++k) rows.col(i) -= LU(i, k) * rows.col(k);
            rows.col(i) /= LU(i, i);
        }
        Columns x(n, B.cols());
        for (Eigen::Index i = 0; i < n; ++i) x.row(to(i)) = rows.col(i).transpose();
        return x;
    }

    Eigen::FullPivLU<Square> lu_;
    Square inverse_;  ///< of the scaled block
    int negatives_ = 0;
};

}  // namespace dttmm::plugin
