// SPDX-License-Identifier: BSD-3-Clause
#include "modal/balanced_lu.h"

#include <algorithm>
#include <cmath>

namespace dttmm::plugin {

namespace {

bool is_alike(const BalancedLu::Sparse& a, const BalancedLu::Sparse& b) {
    return a.rows() == b.rows() && a.nonZeros() == b.nonZeros() &&
           std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.outerSize() + 1, b.outerIndexPtr()) &&
           std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

}  // namespace

/// From column to column the largest entry is brought near one. A diagonal takes its own unit twice.
void BalancedLu::find_units(const Sparse& matrix) {
    units_.setOnes(matrix.rows());
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
        double largest = 0;
        bool has_diagonal = false;
        for (Sparse::InnerIterator entry(matrix, c); entry; ++entry) {
            largest = std::max(largest, std::abs(entry.value()) * units_(entry.row()));
            has_diagonal = has_diagonal || entry.row() == c;
        }
        if (largest > 0 && std::isfinite(largest))
            units_(c) = std::ldexp(1.0, -std::ilogb(has_diagonal ? std::sqrt(largest) : largest));
    }
}

bool BalancedLu::factor(const Sparse& matrix) {
    find_units(matrix);
    const bool is_new = !is_alike(matrix, balanced_);
    balanced_ = units_.asDiagonal() * matrix * units_.asDiagonal();
    if (is_new) lu_.analyzePattern(balanced_);
    lu_.factorize(balanced_);
    return lu_.info() == Eigen::Success;
}

Eigen::VectorXcd BalancedLu::solve(const Eigen::VectorXcd& right_hand_side) const {
    return units_.cwiseProduct(lu_.solve(units_.cwiseProduct(right_hand_side)));
}

}  // namespace dttmm::plugin
