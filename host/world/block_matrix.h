// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

/// A symmetric sparse matrix over bodies and joints, its upper triangle stored:
///     | K   Jᵀ |     K: a 6×6 block for every body and every pair of bodies that an element couples, positive definite
///     | J  −E  |     J: the equations of the joints, E: a small positive diagonal
/// The pattern is fixed at construction. Bodies are reordered for a sparse factor and every joint follows the first of its
/// bodies, so that its pivot block is J K⁻¹ Jᵀ + E, not the tiny E alone. `index(body)` is where a body's six unknowns
/// begin. That LDLᵀ needs no pivoting: Vanderbei (1995), SIAM J. Optim. 5(1), 100–113, on symmetric quasi-definite matrices.
class BlockMatrix {
public:
    using Block = Eigen::Matrix<double, 6, 6>;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor, 7, 6>;  ///< equations of a joint, one side
    using Values = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 7, 1>;              ///< one per equation of a joint

    /// A joint between two bodies (−1: the ground) and the number of its equations.
    struct JointNode {
        int first, second, equations;
    };

    /// Diagonal blocks of bodies are always there; `pairs` lists the off-diagonal ones (either order, repeats allowed).
    BlockMatrix(int body_count, const std::vector<std::pair<int, int>>& pairs, const std::vector<JointNode>& joints = {});

    int index(int body) const { return start_[as_size(body)]; }
    int joint_index(int joint) const { return start_[as_size(body_count_ + joint)]; }
    int size() const { return as_int(matrix_.rows()); }
    /// Whether there is anything but the diagonal blocks of bodies.
    bool is_coupled() const { return is_coupled_; }

    void set_zero();
    /// Adds a block at (row body, column body). Only what falls into the upper triangle of the reordered matrix is kept: add
    /// both (i, j) and (j, i), as an assembly over ports does by itself.
    void add(int row_body, int column_body, const Block& block);
    /// The block of a body on the diagonal as summed up so far.
    Block diagonal(int body) const;
    /// Sets the equations of a joint: `first` and `second` by the velocities of its bodies (that of the ground is not looked
    /// at), `E` positive.
    void set_joint(int joint, const Rows& first, const Rows& second, const Values& E);

    const Eigen::SparseMatrix<double>& upper() const { return matrix_; }

private:
    using Places = std::array<int, 7>;  ///< of each column of a block in the value array
    const Places& places(int row_node, int column_node) const;
    void set_side(int joint, int body, const Rows& rows);

    int body_count_;
    bool is_coupled_;
    std::vector<JointNode> joints_;
    std::vector<int> order_;                        ///< position of every node, the bodies first, then the joints
    std::vector<int> start_;                        ///< first unknown of every node
    std::map<std::pair<int, int>, Places> places_;  ///< by positions
    Eigen::SparseMatrix<double> matrix_;
};

}  // namespace dttmm::host
