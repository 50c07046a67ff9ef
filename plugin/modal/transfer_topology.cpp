// SPDX-License-Identifier: BSD-3-Clause
#include "modal/transfer_topology.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

namespace dttmm::plugin {

namespace {

/// Smaller than this, as share of the largest: a direction that carries nothing.
constexpr double kFree = 1e-12;

/// Orthonormal columns that are at right angles to those given, the largest entry of each positive.
Eigen::MatrixXd complement(const Eigen::MatrixXd& columns, Eigen::Index size) {
    if (columns.cols() == 0) return Eigen::MatrixXd::Identity(size, size);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    Eigen::MatrixXd right = Eigen::MatrixXd(qr.householderQ()).rightCols(size - qr.rank());
    for (Eigen::Index c = 0; c < right.cols(); ++c) {
        Eigen::Index largest = 0;
        right.col(c).cwiseAbs().maxCoeff(&largest);
        if (right(largest, c) < 0) right.col(c) = -right.col(c);
    }
    return right;
}

}  // namespace

TransferTopology::TransferTopology(const FrequencyModel& of) : model(of) {
    for (size_t d = 0; d < 6; ++d)
        if (model.directions[d]) active.push_back(as_row(d));
    directions = as_int(active.size());
    for (int f = 0; f < as_int(model.frames.size()); ++f) add_vertex(f);
    for (size_t b = 0; b < model.bonds.size(); ++b) {
        const auto& bond = model.bonds[b];
        add_edge(false, b, bond.from, bond.to, bond.points[0], bond.points[1]);
    }
    for (size_t l = 0; l < model.lines.size(); ++l) {
        const auto& line = model.lines[l];
        add_edge(true, l, line.from, line.to, line.start, line.finish);
    }
    add_boundaries();
    depth_.assign(vertices.size(), -1);
    // The last boundary of every part that hangs together is its root
    for (size_t v = vertices.size(); v-- > 0;)
        if (depth_[v] < 0 && !vertices[v].tips.empty()) grow_tree(as_int(v));
    for (size_t v = 0; v < vertices.size(); ++v)
        if (depth_[v] < 0 && !vertices[v].edges.empty()) {  // nothing but loops
            Matrix basis = Matrix::Zero(2 * directions, directions);
            basis.topRows(directions).setIdentity();
            vertices[v].tips.push_back(as_int(boundaries.size()));
            boundaries.push_back(
                {model.name(vertices[v].frame) + ", free", model.origin(vertices[v].frame), basis, unknowns, 1});
            unknowns += directions;
            grow_tree(as_int(v));
        }
    for (const Vertex& vertex : vertices) {
        const int inputs = as_int(vertex.edges.size() + vertex.tips.size()) - (vertex.parent >= 0 ? 1 : 0);
        if (vertex.root >= 0) rows += 2 * directions;
        if (inputs > 1) rows += directions * (inputs - 1);
    }
    rows += loose;
    longest_path = depth_.empty() ? 0 : *std::ranges::max_element(depth_);
}

int TransferTopology::add_vertex(int frame) {
    vertices.push_back({frame, {}, {}, -1, -1});
    return as_int(vertices.size() - 1);
}

void TransferTopology::add_edge(bool is_line, size_t index, int from, int to, const Vector3& start, const Vector3& finish) {
    Edge edge{is_line, index, {from, to}, {start, finish}, {}, 0, -1};
    if (!is_line) edge.law = law_of(model.bonds[index]);
    bool is_grounded = false;
    for (int end : {0, 1})
        if (edge.ends[end] < 0) {
            edge.ends[end] = add_vertex(-1);
            is_grounded = true;
        }
    if (!is_line && !is_grounded) {
        edge.loose = as_int(edge.law.loose.cols());
        edge.first_loose = unknowns;
        unknowns += edge.loose;
        loose += edge.loose;
    }
    for (int end : {0, 1}) vertices[as_size(edge.ends[end])].edges.push_back(as_int(edges.size()));
    edges.push_back(edge);
}

/// Free ends and ends on the ground. What a joint leaves free at the ground moves there.
void TransferTopology::add_boundaries() {
    const Eigen::Index n = directions;
    for (size_t v = 0; v < vertices.size(); ++v) {
        Vertex& vertex = vertices[v];
        if (vertex.edges.size() != 1) continue;
        const Edge& edge = edges[as_size(vertex.edges.front())];
        Matrix basis = Matrix::Zero(2 * n, n);
        std::string name;
        if (vertex.frame >= 0) {
            basis.topRows(n).setIdentity();
            name = model.name(vertex.frame) + ", free";
        } else {
            const Matrix moving = edge.is_line ? Matrix(n, 0) : edge.law.loose;
            basis.topLeftCorner(n, moving.cols()) = moving;
            basis.bottomRightCorner(n, n - moving.cols()) = complement(moving, n);
            const int other = edge.ends[edge.ends[0] == as_int(v) ? 1 : 0];
            name = "ground at " + (vertices[as_size(other)].frame >= 0 ? model.name(vertices[as_size(other)].frame)
                                                                       : std::string("the ground"));
        }
        vertex.tips.push_back(as_int(boundaries.size()));
        const Vector3 point = vertex.frame >= 0 ? model.origin(vertex.frame) : Vector3(Vector3::Zero());
        boundaries.push_back({name, point, basis, unknowns, 1});
        unknowns += directions;
    }
}

/// Paths from a root to everything that hangs together with it; edges that close a loop are cut.
void TransferTopology::grow_tree(int root) {
    const auto at = [](int i) { return as_size(i); };
    vertices[at(root)].root = vertices[at(root)].tips.back();
    vertices[at(root)].tips.pop_back();
    std::deque<int> next = {root};
    depth_[at(root)] = 0;
    std::vector<int> closing;
    while (!next.empty()) {
        const int v = next.front();
        next.pop_front();
        order.push_back(v);
        for (int e : std::vector<int>(vertices[at(v)].edges)) {
            if (e == vertices[at(v)].parent) continue;
            const Edge& edge = edges[at(e)];
            const int other = edge.ends[edge.ends[0] == v ? 1 : 0];
            if (depth_[at(other)] < 0) {
                depth_[at(other)] = depth_[at(v)] + 1;
                vertices[at(other)].parent = e;
                next.push_back(other);
            } else if (std::ranges::find(closing, e) == closing.end()) {
                closing.push_back(e);
            }
        }
    }
    for (int e : closing) cut(e);
}

/// The `to` end of a line or joint that closes a loop becomes a tip, and what it was attached to gets another.
void TransferTopology::cut(int e) {
    const auto at = [](int i) { return as_size(i); };
    const int behind = edges[at(e)].ends[1];
    std::erase(vertices[at(behind)].edges, e);
    const Eigen::Index n = directions;
    const Matrix basis = Matrix::Identity(2 * n, 2 * n);
    const std::string name = model.name(vertices[at(behind)].frame) + ", cut";
    const int end = add_vertex(-1);
    depth_.push_back(depth_[at(edges[at(e)].ends[0])] + 1);
    order.push_back(end);
    edges[at(e)].ends[1] = end;
    vertices[at(end)].edges.push_back(e);
    vertices[at(end)].parent = e;
    for (const auto& [vertex, sign] : {std::pair(end, 1.0), std::pair(behind, -1.0)}) {
        vertices[at(vertex)].tips.push_back(as_int(boundaries.size()));
        boundaries.push_back({name, edges[at(e)].points[1], basis, unknowns, sign});
    }
    unknowns += 2 * directions;
}

/// A joint's compliance and the directions in which it carries nothing, among those that are left.
TransferTopology::Law TransferTopology::law_of(const Bond& bond) const {
    const Eigen::Index n = directions;
    Matrix held(n, 0);
    for (const Vector6& direction : bond.held) {
        const Eigen::VectorXd own = direction(active);
        if (own.norm() < 1e-9) continue;
        held.conservativeResize(n, held.cols() + 1);
        held.rightCols(1) = own;
    }
    const Matrix N = complement(held, n);
    Law law{Matrix::Zero(n, n), Matrix(n, 0)};
    if (N.cols() == 0) return law;
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(N.transpose() * restricted(bond.stiffness) * N);
    const double largest = solver.eigenvalues().cwiseAbs().maxCoeff();
    for (Eigen::Index k = 0; k < solver.eigenvalues().size(); ++k) {
        const Eigen::VectorXd direction = N * solver.eigenvectors().col(k);
        if (std::abs(solver.eigenvalues()(k)) > kFree * largest) {
            law.compliance += direction * direction.transpose() / solver.eigenvalues()(k);
        } else {
            law.loose.conservativeResize(n, law.loose.cols() + 1);
            law.loose.rightCols(1) = direction;
        }
    }
    return law;
}

std::string TransferTopology::name_of(int v) const {
    const Vertex& vertex = vertices[as_size(v)];
    if (vertex.frame >= 0) return model.name(vertex.frame);
    const int boundary = vertex.root >= 0 ? vertex.root : vertex.tips.empty() ? -1 : vertex.tips.front();
    return boundary >= 0 ? boundaries[as_size(boundary)].name : std::string("an end");
}

std::string TransferTopology::layout() const {
    std::string text = fmt::format(
        "overall transfer equation: {} x {}, {} directions per state; known boundary entries struck out: {} x {}\n", rows,
        columns(), directions, rows, unknowns);
    for (int v : order) {
        const Vertex& vertex = vertices[as_size(v)];
        if (vertex.root >= 0) text += fmt::format("root: {}\n", boundaries[as_size(vertex.root)].name);
    }
    for (int v : order) {
        const Vertex& vertex = vertices[as_size(v)];
        for (int b : vertex.tips) {
            const Boundary& boundary = boundaries[as_size(b)];
            text += fmt::format("tip: {} -> ", boundary.name);
            int steps = 0;
            for (int at = v; vertices[as_size(at)].parent >= 0; ++steps) {
                const Edge& edge = edges[as_size(vertices[as_size(at)].parent)];
                at = edge.ends[edge.ends[0] == at ? 1 : 0];
            }
            text += fmt::format("root, over {} elements\n", steps);
        }
    }
    for (int v : order) {
        const Vertex& vertex = vertices[as_size(v)];
        const int inputs = as_int(vertex.edges.size() + vertex.tips.size()) - (vertex.parent >= 0 ? 1 : 0);
        if (inputs > 1)
            text += fmt::format("{}: {} inputs, {} geometric equations\n", name_of(v), inputs, directions * (inputs - 1));
    }
    return text;
}

}  // namespace dttmm::plugin
