// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "modal/transfer_topology.h"

namespace dttmm::plugin {

/// The overall transfer equation of a machine, U_all Z_all = 0, deduced from its topology.
///
/// The states of the tips are transferred along their paths towards the root. At a body with several inputs the first one,
/// the main input, gives the motion; the others add their loads (auxiliary matrices) and a geometric equation each: the
/// motion there is that of the same body. Hence, with n directions left,
///     − z_root + Σ T_t z_t = 0   2n rows,      H_1 z_I1 − H_j z_Ij = 0   n rows per further input,
/// which is 24 × 48 for the hydroplane system. With what is known at the boundaries struck out the matrix is square, and
/// singular at every natural frequency: a second way to them, beside the count.
///
/// A state is [displacement; load handed on], the load being [q; −m] in the letters of the state vector; world axes.
/// Source: Rui, Wang and Zhou (2014), Transfer matrix method for multibody systems of tree topology: automatic deduction of
/// the overall transfer equation; the hydroplane paper, eq. (4)–(8) and (36), (8) without its redundant factor and (34) with
/// the H of its own input.
class OverallTransfer {
public:
    /// Deduces the topology. The model must live on.
    explicit OverallTransfer(const FrequencyModel& model) : topology_(model) {}

    /// Size of U_all before the known is struck out.
    int rows() const { return topology_.rows; }
    int columns() const { return topology_.columns(); }
    /// Whether paths are so short that products of matrices still have digits, and the matrix small.
    bool is_short() const { return rows() <= 400 && topology_.longest_path <= 60; }

    /// Of the square matrix at λ: its smallest singular value as share of the largest, in given units; sign and log10 of its
    /// determinant, in SI. {1, 0, 0} for one that is empty, not square or overflows.
    struct Check {
        double smallest, sign, log10_determinant;
    };
    /// In units in which it is about one at another λ, `beside`. Not at a natural frequency: what vanishes there would be
    /// blown up to one.
    Check check(double lambda, double beside) const;
    /// The square matrix at λ, in SI, and what its rows and columns are: "tip_left.free.x" in "m". A column is an unknown at
    /// a boundary, displacements and the force and moment that it hands on towards the root, or the free motion of a joint.
    struct Line {
        std::string name, unit;
    };
    struct Written {
        Eigen::MatrixXd U;
        std::vector<Line> rows, columns;
    };
    Written written(double lambda) const;
    /// The last pivot of full-pivot elimination at λ as share of what it is at λ `beside`: zero where the matrix is
    /// singular.
    double residual(double lambda, double beside) const;

    /// Boundaries, paths, inputs and the size of the equation, as text.
    std::string layout() const { return topology_.layout(); }

private:
    using Matrix = Eigen::MatrixXd;
    using Edge = TransferTopology::Edge;
    using Boundary = TransferTopology::Boundary;
    using Vertex = TransferTopology::Vertex;
    struct Units {
        Eigen::VectorXd rows, columns;
    };
    Matrix by_point(const Vertex& vertex, const Vector3& point) const;
    Matrix through(const Edge& edge, bool is_forward, const Matrix& state, std::vector<Matrix>& lines, double lambda) const;
    Matrix line_transfer(const LineModel& line, double lambda) const;
    Matrix state_of(const Boundary& boundary) const;
    /// rows: where they are wanted, what they are.
    Matrix assemble(double lambda, std::vector<Line>* rows = nullptr) const;
    std::vector<Line> columns_of_matrix() const;
    Line line_of(const std::string& owner, Eigen::Index entry) const;
    static Units units_of(Matrix U);

    TransferTopology topology_;
};

}  // namespace dttmm::plugin
