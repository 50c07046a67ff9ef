// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace dttmm {

/// A symmetric sparse matrix of 6×6 blocks, one row of blocks per body, its upper triangle stored. The pattern is fixed at
/// construction and the bodies are reordered for a sparse factor; `index(body)` is where a body's six unknowns begin.
class BlockMatrix {
public:
    using Block = Eigen::Matrix<double, 6, 6>;

    /// Diagonal blocks are always there; `pairs` lists the off-diagonal ones (either order, repeats allowed).
    BlockMatrix(int body_count, const std::vector<std::pair<int, int>>& pairs);

    int index(int body) const { return 6 * order_[static_cast<size_t>(body)]; }
    void set_zero();
    /// Adds a block at (row body, column body). Only what falls into the upper triangle of the reordered matrix is kept: add
    /// both (i, j) and (j, i), as an assembly over ports does by itself.
    void add(int row_body, int column_body, const Block& block);

    const Eigen::SparseMatrix<double>& upper() const { return matrix_; }

private:
    std::vector<int> order_;
    std::map<std::pair<int, int>, std::array<int, 6>> places_;  ///< of each column of a block in the value array
    Eigen::SparseMatrix<double> matrix_;
};

}  // namespace dttmm
