// SPDX-License-Identifier: BSD-3-Clause
#include "world/block_factor.h"

#include <Eigen/Cholesky>

#include "model/index.h"

namespace dttmm::host {

BlockFactor::BlockFactor(const BlockMatrix& matrix) {
    if (matrix.is_coupled()) {
        solver_.analyzePattern(matrix.upper());
        return;
    }
    for (int body = 0; 6 * body < matrix.size(); ++body) starts_.push_back(matrix.index(body));
    inverses_.resize(starts_.size());
}

bool BlockFactor::factor(const BlockMatrix& matrix) {
    if (matrix.is_coupled()) {
        solver_.refactor(matrix.upper());
        return solver_.info() == Eigen::Success;
    }
    for (size_t b = 0; b < starts_.size(); ++b) {
        const Eigen::LDLT<BlockMatrix::Block> block(matrix.diagonal(as_int(b)));
        if (!(block.vectorD().minCoeff() > 0)) return false;
        inverses_[b] = block.solve(BlockMatrix::Block::Identity());
    }
    return true;
}

void BlockFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const {
    if (b.size() == 0) return;  // no body, and no pattern
    if (starts_.empty())
        x = solver_.solve(b);
    else
        for (size_t body = 0; body < starts_.size(); ++body)
            x.segment<6>(starts_[body]).noalias() = inverses_[body] * b.segment<6>(starts_[body]);
}

}  // namespace dttmm::host
