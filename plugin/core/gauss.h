// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>

#include "core/rounding.h"
#include "core/types.h"

namespace dttmm::plugin {

/// At most 12 unknowns with up to 13 right-hand sides: the end forces of one element. Lives on the stack.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 13>;

/// Gaussian elimination with full pivoting of A X = B, and how far to trust it.
struct Elimination {
    SmallMatrix X;  ///< n×m; meaningless unless regular()
    double
        reciprocal_condition;  ///< 1-norm estimate of 1/cond(A) after the rows were scaled to largest entry one; 0: singular
    int weakest_unknown;       ///< column of A eliminated last: the unknown that a singular system leaves undetermined
    /// Below rounding of sums fewer than two digits of a double survive.
    bool regular() const { return reciprocal_condition > kRoundingOfSums; }
};

/// A: n×n, B: n×m, n ≤ 12, m ≤ 13. Rows are scaled to a largest entry of one first, so that compliances of 1e-9 m/N beside
/// ones do not pass for singularity. Never throws on singularity: the caller knows the element and the direction to name.
/// An A that is not finite counts as singular.
Elimination eliminate_full_pivot(SmallMatrix A, SmallMatrix B);

}  // namespace dttmm::plugin
