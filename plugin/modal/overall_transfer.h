// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/index.h"
#include "modal/frequency_model.h"

namespace dttmm::plugin {

/// The overall transfer equation of a machine, U_all Z_all = 0, deduced from its topology.
///
/// Where elements meet there is a body, a node being one without a mass. Ends that nothing goes on from are boundaries: free
/// ends, and every end on the ground. One of them is the root; the states of all others, the tips, are transferred along
/// their paths towards it. At a body with several inputs the first one, the main input, gives the motion; the others add
/// their loads (auxiliary matrices) and a geometric equation each: the motion there is that of the same body. Hence, with n
/// directions left,
///     − z_root + Σ T_t z_t = 0   2n rows,      H_1 z_I1 − H_j z_Ij = 0   n rows per further input,
/// which is 24 × 48 for the hydroplane system. A loop is cut: its two ends are tips with the same motion and opposite loads.
/// A direction in which a joint is free belongs to the boundary at the ground; elsewhere it is an unknown of its own, with
/// the equation that nothing is carried there. With what is known at the boundaries struck out the matrix is square, and
/// singular at every natural frequency: a second way to them, beside the count.
///
/// A state is [displacement; load handed on], the load being [q; −m] in the letters of the state vector; world axes.
/// Source: Rui, Wang and Zhou (2014), Transfer matrix method for multibody systems of tree topology: automatic deduction of
/// the overall transfer equation; the hydroplane paper, eq. (4)–(8) and (36), (8) without its redundant factor and (34) with
/// the H of its own input.
class OverallTransfer {
public:
    /// Deduces the topology. The model must live on.
    explicit OverallTransfer(const FrequencyModel& model);

    /// Size of U_all before the known is struck out.
    int rows() const { return rows_; }
    int columns() const { return 2 * directions_ * as_int(boundaries_.size()) + loose_; }
    /// Whether paths are so short that products of matrices still have digits, and the matrix small.
    bool is_short() const { return rows_ <= 400 && longest_path_ <= 60; }

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
    /// The smallest singular value at λ as share of what it is at λ `beside`.
    double residual(double lambda, double beside) const;

    /// Boundaries, paths, inputs and the size of the equation, as text.
    std::string layout() const;

private:
    using Matrix = Eigen::MatrixXd;
    struct Units {
        Eigen::VectorXd rows, columns;
    };
    struct Law {
        Matrix compliance, loose;  ///< of a joint: u_O = u_I − C w + F α
    };
    /// A joint or a line between two vertices: frames, ends on the ground, ends of cut loops.
    struct Edge {
        bool is_line;
        size_t index;
        int ends[2];                      ///< vertices of `from` and `to`
        Vector3 points[2];                ///< where they are attached
        Law law;                          ///< of a joint
        int loose = 0, first_loose = -1;  ///< free directions that are unknowns, the first of them
    };
    struct Boundary {
        std::string name;
        Vector3 point;    ///< where its state stands
        Matrix basis;     ///< state = basis · unknowns
        int first = 0;    ///< of its unknowns
        double sign = 1;  ///< of the load where unknowns are shared with the other end of a cut
    };
    struct Vertex {
        int frame = -1;  ///< −1: an end on the ground or of a cut
        std::vector<int> edges;
        std::vector<int> tips;  ///< boundaries that end here as inputs
        int parent = -1;        ///< edge towards the root; −1: the root itself
        int root = -1;          ///< boundary at the root
    };

    int add_vertex(int frame);
    void add_edge(bool is_line, size_t index, int from, int to, const Vector3& start, const Vector3& finish);
    void add_boundaries();
    void grow_tree(int root);
    void cut(int edge);
    Law law_of(const Bond& bond) const;
    Matrix restricted(const Matrix6& all) const;
    Matrix by_point(const Vertex& vertex, const Vector3& point) const;
    Matrix through(const Edge& edge, bool is_forward, const Matrix& state, std::vector<Matrix>& lines, double lambda) const;
    Matrix line_transfer(const LineModel& line, double lambda) const;
    Matrix state_of(const Boundary& boundary) const;
    /// rows: where they are wanted, what they are.
    Matrix assemble(double lambda, std::vector<Line>* rows = nullptr) const;
    std::vector<Line> columns_of_matrix() const;
    std::string name_of(int vertex) const;
    Line line_of(const std::string& owner, Eigen::Index entry) const;
    static Units units_of(Matrix U);

    const FrequencyModel& model_;
    int directions_;
    std::vector<Eigen::Index> active_;
    std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
    std::vector<Boundary> boundaries_;
    std::vector<int> order_;  ///< vertices from the root outwards, tree by tree
    int rows_ = 0, unknowns_ = 0, loose_ = 0, longest_path_ = 0;
    std::vector<int> depth_;
};

}  // namespace dttmm::plugin
