// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/index.h"
#include "modal/frequency_model.h"

namespace dttmm::plugin {

/// The topology of a machine, from which its overall transfer equation follows.
///
/// Where elements meet there is a body, a node being one without a mass. Ends that nothing goes on from are boundaries: free
/// ends, and every end on the ground. One of them is the root; the states of all others, the tips, are transferred along
/// their paths towards it. A loop is cut: its two ends are tips with the same motion and opposite loads. A direction in
/// which a joint is free belongs to the boundary at the ground; elsewhere it is an unknown of its own, with the equation
/// that nothing is carried there.
struct TransferTopology {
    using Matrix = Eigen::MatrixXd;
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

    /// Keeps the model.
    explicit TransferTopology(const FrequencyModel& model);

    /// Size of the equation before the known is struck out.
    int columns() const { return 2 * directions * as_int(boundaries.size()) + loose; }
    /// Of a block, the directions that are left.
    Matrix restricted(const Matrix6& all) const { return all(active, active); }
    /// Of a vertex or of the boundary that it is.
    std::string name_of(int vertex) const;
    /// Boundaries, paths, inputs and the size of the equation, as text.
    std::string layout() const;

    const FrequencyModel& model;
    int directions = 0;  ///< that are left, and which
    std::vector<Eigen::Index> active;
    std::vector<Vertex> vertices;
    std::vector<Edge> edges;
    std::vector<Boundary> boundaries;
    std::vector<int> order;  ///< vertices from the root outwards, tree by tree
    int rows = 0, unknowns = 0, loose = 0, longest_path = 0;

private:
    int add_vertex(int frame);
    void add_edge(bool is_line, size_t index, int from, int to, const Vector3& start, const Vector3& finish);
    void add_boundaries();
    void grow_tree(int root);
    void cut(int edge);
    Law law_of(const Bond& bond) const;

    std::vector<int> depth_;
};

}  // namespace dttmm::plugin
