// SPDX-License-Identifier: BSD-3-Clause
#include "core/gauss.h"

#include "core/index.h"

namespace dttmm::plugin {

namespace {
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
}

Elimination eliminate_full_pivot(SmallMatrix A, SmallMatrix B) {
    eigen_assert(A.rows() == A.cols() && A.rows() == B.rows());
    const Eigen::Index n = A.rows();
    if (n == 0) return {SmallMatrix(0, B.cols()), 1.0, 0};
    if (!A.allFinite() || !B.allFinite()) return {SmallMatrix::Zero(n, B.cols()), 0.0, 0};

    for (Eigen::Index row = 0; row < n; ++row) {
        const double largest = A.row(row).cwiseAbs().maxCoeff();
        if (largest == 0) continue;
        A.row(row) /= largest;
        B.row(row) /= largest;
    }

    Eigen::FullPivLU<Square> lu(A);
    lu.setThreshold(0);  // every pivot counts: otherwise a small one is dropped and the condition estimate is blind to it
    const int weakest = as_int(lu.permutationQ().indices()(n - 1));
    const double smallest_pivot = std::abs(lu.matrixLU()(n - 1, n - 1));
    if (smallest_pivot == 0) return {SmallMatrix::Zero(n, B.cols()), 0.0, weakest};
    return {lu.solve(B), lu.rcond(), weakest};
}

}  // namespace dttmm::plugin
