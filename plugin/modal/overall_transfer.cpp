// SPDX-License-Identifier: BSD-3-Clause
#include "modal/overall_transfer.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <map>

#include "core/index.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

namespace {

/// Smaller than this, as share of the largest: a direction that carries nothing.
constexpr double kFree = 1e-12;
/// Of a balanced row: smaller entries are what cancelled.
constexpr double kRounding = 1e-10;
constexpr int kSweeps = 8;

Eigen::MatrixXd stack(const Eigen::MatrixXd& above, const Eigen::MatrixXd& below) {
    Eigen::MatrixXd both(above.rows() + below.rows(), above.cols());
    both << above, below;
    return both;
}

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

/// The smallest singular value as share of the largest; 1 of a matrix that is empty, not square or overflows.
double smallest_of(const Eigen::MatrixXd& U) {
    if (U.rows() == 0 || U.rows() != U.cols() || !U.allFinite()) return 1;
    const Eigen::VectorXd singular = U.bdcSvd().singularValues();
    return singular(singular.size() - 1) / singular(0);
}

/// A name for a heading: `ground at node "foot"` is "ground at foot".
std::string without_kind(std::string name) {
    for (const char* part : {"node \"", "body \"", "element \"", "\""})
        for (size_t at = name.find(part); at != name.npos; at = name.find(part)) name.erase(at, std::strlen(part));
    return name;
}

}  // namespace

OverallTransfer::OverallTransfer(const FrequencyModel& model) : model_(model) {
    for (size_t d = 0; d < 6; ++d)
        if (model.directions[d]) active_.push_back(as_row(d));
    directions_ = as_int(active_.size());
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
    depth_.assign(vertices_.size(), -1);
    // The last boundary of every part that hangs together is its root
    for (size_t v = vertices_.size(); v-- > 0;)
        if (depth_[v] < 0 && !vertices_[v].tips.empty()) grow_tree(as_int(v));
    for (size_t v = 0; v < vertices_.size(); ++v)
        if (depth_[v] < 0 && !vertices_[v].edges.empty()) {  // nothing but loops
            Matrix basis = Matrix::Zero(2 * directions_, directions_);
            basis.topRows(directions_).setIdentity();
            vertices_[v].tips.push_back(as_int(boundaries_.size()));
            boundaries_.push_back(
                {model.name(vertices_[v].frame) + ", free", model.origin(vertices_[v].frame), basis, unknowns_, 1});
            unknowns_ += directions_;
            grow_tree(as_int(v));
        }
    for (const Vertex& vertex : vertices_) {
        const int inputs = as_int(vertex.edges.size() + vertex.tips.size()) - (vertex.parent >= 0 ? 1 : 0);
        if (vertex.root >= 0) rows_ += 2 * directions_;
        if (inputs > 1) rows_ += directions_ * (inputs - 1);
    }
    rows_ += loose_;
    longest_path_ = depth_.empty() ? 0 : *std::ranges::max_element(depth_);
}

int OverallTransfer::add_vertex(int frame) {
    vertices_.push_back({frame, {}, {}, -1, -1});
    return as_int(vertices_.size() - 1);
}

void OverallTransfer::add_edge(bool is_line, size_t index, int from, int to, const Vector3& start, const Vector3& finish) {
    Edge edge{is_line, index, {from, to}, {start, finish}, {}, 0, -1};
    if (!is_line) edge.law = law_of(model_.bonds[index]);
    bool is_grounded = false;
    for (int end : {0, 1})
        if (edge.ends[end] < 0) {
            edge.ends[end] = add_vertex(-1);
            is_grounded = true;
        }
    if (!is_line && !is_grounded) {
        edge.loose = as_int(edge.law.loose.cols());
        edge.first_loose = unknowns_;
        unknowns_ += edge.loose;
        loose_ += edge.loose;
    }
    for (int end : {0, 1}) vertices_[as_size(edge.ends[end])].edges.push_back(as_int(edges_.size()));
    edges_.push_back(edge);
}

/// Free ends and ends on the ground. What a joint leaves free at the ground moves there.
void OverallTransfer::add_boundaries() {
    const Eigen::Index n = directions_;
    for (size_t v = 0; v < vertices_.size(); ++v) {
        Vertex& vertex = vertices_[v];
        if (vertex.edges.size() != 1) continue;
        const Edge& edge = edges_[as_size(vertex.edges.front())];
        Matrix basis = Matrix::Zero(2 * n, n);
        std::string name;
        if (vertex.frame >= 0) {
            basis.topRows(n).setIdentity();
            name = model_.name(vertex.frame) + ", free";
        } else {
            const Matrix loose = edge.is_line ? Matrix(n, 0) : edge.law.loose;
            basis.topLeftCorner(n, loose.cols()) = loose;
            basis.bottomRightCorner(n, n - loose.cols()) = complement(loose, n);
            const int other = edge.ends[edge.ends[0] == as_int(v) ? 1 : 0];
            name = "ground at " + (vertices_[as_size(other)].frame >= 0 ? model_.name(vertices_[as_size(other)].frame)
                                                                        : std::string("the ground"));
        }
        vertex.tips.push_back(as_int(boundaries_.size()));
        const Vector3 point = vertex.frame >= 0 ? model_.origin(vertex.frame) : Vector3(Vector3::Zero());
        boundaries_.push_back({name, point, basis, unknowns_, 1});
        unknowns_ += directions_;
    }
}

/// Paths from a root to everything that hangs together with it; edges that close a loop are cut.
void OverallTransfer::grow_tree(int root) {
    const auto at = [](int i) { return as_size(i); };
    vertices_[at(root)].root = vertices_[at(root)].tips.back();
    vertices_[at(root)].tips.pop_back();
    std::deque<int> next = {root};
    depth_[at(root)] = 0;
    std::vector<int> closing;
    while (!next.empty()) {
        const int v = next.front();
        next.pop_front();
        order_.push_back(v);
        for (int e : std::vector<int>(vertices_[at(v)].edges)) {
            if (e == vertices_[at(v)].parent) continue;
            const Edge& edge = edges_[at(e)];
            const int other = edge.ends[edge.ends[0] == v ? 1 : 0];
            if (depth_[at(other)] < 0) {
                depth_[at(other)] = depth_[at(v)] + 1;
                vertices_[at(other)].parent = e;
                next.push_back(other);
            } else if (std::ranges::find(closing, e) == closing.end()) {
                closing.push_back(e);
            }
        }
    }
    for (int e : closing) cut(e);
}

/// The `to` end of a line or joint that closes a loop becomes a tip, and what it was attached to gets another.
void OverallTransfer::cut(int e) {
    const auto at = [](int i) { return as_size(i); };
    const int behind = edges_[at(e)].ends[1];
    std::erase(vertices_[at(behind)].edges, e);
    const Eigen::Index n = directions_;
    const Matrix basis = Matrix::Identity(2 * n, 2 * n);
    const std::string name = model_.name(vertices_[at(behind)].frame) + ", cut";
    const int end = add_vertex(-1);
    depth_.push_back(depth_[at(edges_[at(e)].ends[0])] + 1);
    order_.push_back(end);
    edges_[at(e)].ends[1] = end;
    vertices_[at(end)].edges.push_back(e);
    vertices_[at(end)].parent = e;
    for (const auto& [vertex, sign] : {std::pair(end, 1.0), std::pair(behind, -1.0)}) {
        vertices_[at(vertex)].tips.push_back(as_int(boundaries_.size()));
        boundaries_.push_back({name, edges_[at(e)].points[1], basis, unknowns_, sign});
    }
    unknowns_ += 2 * directions_;
}

OverallTransfer::Matrix OverallTransfer::restricted(const Matrix6& all) const { return all(active_, active_); }

/// Displacement at a point of a vertex by its motion; an end on the ground is its own point.
OverallTransfer::Matrix OverallTransfer::by_point(const Vertex& vertex, const Vector3& point) const {
    if (vertex.frame < 0) return Matrix::Identity(directions_, directions_);
    return restricted(FrequencyModel::at_point(point, model_.origin(vertex.frame)));
}

/// A joint's compliance and the directions in which it carries nothing, among those that are left.
OverallTransfer::Law OverallTransfer::law_of(const Bond& bond) const {
    const Eigen::Index n = directions_;
    Matrix held(n, 0);
    for (const Vector6& direction : bond.held) {
        const Eigen::VectorXd own = direction(active_);
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

/// A state handed through a joint or a line; the free directions of a joint move by unknowns of their own. lines: transfer
/// matrices as far as they are known.
OverallTransfer::Matrix OverallTransfer::through(const Edge& edge, bool is_forward, const Matrix& state,
                                                 std::vector<Matrix>& lines, double lambda) const {
    const Eigen::Index n = directions_;
    if (!edge.is_line) {
        Matrix out = state;
        out.topRows(n) -= edge.law.compliance * state.bottomRows(n);
        if (edge.loose > 0) out.block(0, edge.first_loose, n, edge.loose) += edge.law.loose;
        return out;
    }
    const LineModel& line = model_.lines[edge.index];
    Matrix& local = lines[line.kind];
    if (local.size() == 0) local = line_transfer(line, lambda);
    // Local [d; n] → world [u; w], w = −n; the way back inverts a symplectic matrix and turns the loads round
    Matrix12 turn = Matrix12::Zero();
    turn << both(line.axes), Matrix6::Zero(), Matrix6::Zero(), -both(line.axes);
    const Matrix12 world = turn * local * turn.transpose();
    std::vector<Eigen::Index> halves = active_;
    for (Eigen::Index d : active_) halves.push_back(6 + d);
    const Matrix own = world(halves, halves);
    if (is_forward) return own * state;
    Matrix inverse(2 * n, 2 * n);
    inverse << own.bottomRightCorner(n, n).transpose(), own.topRightCorner(n, n).transpose(),
        own.bottomLeftCorner(n, n).transpose(), own.topLeftCorner(n, n).transpose();
    return inverse * state;
}

/// [d; n] at the end of a line by that at its start, local axes.
OverallTransfer::Matrix OverallTransfer::line_transfer(const LineModel& line, double lambda) const {
    const double length = line.length();
    const Matrix12 U = line.waves->transfer(lambda, length);
    if (!model_.is_bar(line)) return U;
    Matrix6 lever = Matrix6::Identity(), middle = Matrix6::Identity();
    lever.topRightCorner<3, 3>() = -skew(Vector3(length, 0, 0));
    middle.topRightCorner<3, 3>() = -skew(Vector3(0.5 * length, 0, 0));
    // As a rigid body but for x: n_O = G⁻ᵀ (n_I − λ M d)
    const Matrix6 back = lever.inverse().transpose(),
                  mass = middle.transpose() * bar_mass(line.line.section, length) * middle;
    Matrix12 body = Matrix12::Zero();
    body.topLeftCorner<6, 6>() = lever;
    body.bottomRightCorner<6, 6>() = back;
    body.bottomLeftCorner<6, 6>() = -lambda * back * mass;
    for (Eigen::Index i : {0, 6}) body.row(i) = U.row(i);
    return body;
}

OverallTransfer::Matrix OverallTransfer::state_of(const Boundary& boundary) const {
    Matrix state = Matrix::Zero(2 * directions_, unknowns_);
    state.middleCols(boundary.first, boundary.basis.cols()) = boundary.basis;
    state.bottomRows(directions_) *= boundary.sign;
    return state;
}

/// The square matrix: what is known at the boundaries struck out.
OverallTransfer::Matrix OverallTransfer::assemble(double lambda, std::vector<Line>* names) const {
    const Eigen::Index n = directions_;
    Matrix U = Matrix::Zero(rows_, unknowns_);
    Eigen::Index row = 0;
    const auto add = [&](const Matrix& rows, int vertex, const char* what, Eigen::Index first) {
        U.middleRows(row, rows.rows()) = rows;
        row += rows.rows();
        for (Eigen::Index i = 0; names && i < rows.rows(); ++i)
            names->push_back(line_of(without_kind(name_of(vertex)) + what, first + i));
    };
    std::vector<Matrix> handed_on(edges_.size()), lines(model_.kinds.size());
    std::vector<Matrix6> inertial(model_.frames.size(), Matrix6::Zero());
    for (const auto& mass : model_.masses) inertial[as_size(mass.frame)] += lambda * mass.block;
    for (const auto& lever : model_.levers) inertial[as_size(lever.frame)] -= lever.stiffness;
    for (size_t k = order_.size(); k-- > 0;) {
        const Vertex& vertex = vertices_[as_size(order_[k])];
        if (vertex.edges.empty()) continue;
        Matrix motion, load = Matrix::Zero(n, unknowns_);
        const auto take = [&](const Matrix& by, const Matrix& state) {
            if (motion.size() == 0)
                motion = by.partialPivLu().solve(state.topRows(n));
            else
                add(by * motion - state.topRows(n), order_[k], ".geometry", 0);
            load += by.transpose() * state.bottomRows(n);
        };
        const auto point = [&](int e) {
            const Edge& edge = edges_[as_size(e)];
            return edge.points[edge.ends[0] == order_[k] ? 0 : 1];
        };
        for (int e : vertex.edges)
            if (e != vertex.parent) take(by_point(vertex, point(e)), handed_on[as_size(e)]);
        for (int b : vertex.tips) {
            const Boundary& boundary = boundaries_[as_size(b)];
            take(by_point(vertex, boundary.point), state_of(boundary));
        }
        if (vertex.frame >= 0) load += restricted(inertial[as_size(vertex.frame)]) * motion;
        if (vertex.root >= 0) {
            add(stack(motion, load) - state_of(boundaries_[as_size(vertex.root)]), order_[k], ".root", 0);
            continue;
        }
        const Matrix by = by_point(vertex, point(vertex.parent));
        const Edge& edge = edges_[as_size(vertex.parent)];
        const Matrix state = stack(by * motion, by.transpose().partialPivLu().solve(load));
        handed_on[as_size(vertex.parent)] = through(edge, edge.ends[0] == order_[k], state, lines, lambda);
        if (edge.loose > 0) add(edge.law.loose.transpose() * state.bottomRows(n), order_[k], ".carries nothing", -1);
    }
    return U;
}

/// An entry of a state: its symbol behind the owner, and its unit. Negative: a direction of a joint, which has no symbol.
OverallTransfer::Line OverallTransfer::line_of(const std::string& owner, Eigen::Index entry) const {
    constexpr const char* kSymbols[] = {"x", "y", "z", "rx", "ry", "rz", "fx", "fy", "fz", "mx", "my", "mz"};
    constexpr const char* kUnits[] = {"m", "rad", "N", "N*m"};
    if (entry < 0) return {owner, ""};
    const Eigen::Index half = entry / directions_, d = active_[as_size(entry % directions_)];
    return {owner + "." + kSymbols[6 * half + d], kUnits[2 * half + d / 3]};
}

/// Of a vertex or of the boundary that it is.
std::string OverallTransfer::name_of(int v) const {
    const Vertex& vertex = vertices_[as_size(v)];
    if (vertex.frame >= 0) return model_.name(vertex.frame);
    const int boundary = vertex.root >= 0 ? vertex.root : vertex.tips.empty() ? -1 : vertex.tips.front();
    return boundary >= 0 ? boundaries_[as_size(boundary)].name : std::string("an end");
}

std::vector<OverallTransfer::Line> OverallTransfer::columns_of_matrix() const {
    std::vector<Line> columns(as_size(unknowns_));
    std::map<std::string, int> counts;  // a frame may have several ends on the ground
    for (const Boundary& boundary : boundaries_) {
        std::string owner = without_kind(boundary.name);
        if (const size_t comma = owner.find(", "); comma != owner.npos) owner.replace(comma, 2, ".");
        if (boundary.sign < 0) continue;  // the other end of a cut has its unknowns
        if (const int count = ++counts[owner]; count > 1) owner += fmt::format(" {}", count);
        for (Eigen::Index c = 0; c < boundary.basis.cols(); ++c) {
            Eigen::Index entry = 0;
            const bool is_one = boundary.basis.col(c).cwiseAbs().maxCoeff(&entry) == boundary.basis.col(c).norm();
            columns[as_size(boundary.first + c)] =
                is_one ? line_of(owner, entry) : Line{fmt::format("{}.u{}", owner, c + 1), ""};
        }
    }
    for (const Edge& edge : edges_)
        for (int k = 0; k < edge.loose; ++k)
            columns[as_size(edge.first_loose + k)] = {fmt::format("{} to {}.free{}", without_kind(name_of(edge.ends[0])),
                                                                  without_kind(name_of(edge.ends[1])), k + 1),
                                                      ""};
    return columns;
}

OverallTransfer::Written OverallTransfer::written(double lambda) const {
    Written found;
    found.U = assemble(lambda, &found.rows);
    found.columns = columns_of_matrix();
    return found;
}

/// Units in which rows and columns are about one, first by their largest entries, then by all that are not rounding.
OverallTransfer::Units OverallTransfer::units_of(Matrix U) {
    Units units{Eigen::VectorXd::Ones(U.rows()), Eigen::VectorXd::Ones(U.cols())};
    const auto balance = [&](auto&& line, double& unit, double rounding) {
        const double largest = line.cwiseAbs().maxCoeff();
        if (!(largest > 0) || !std::isfinite(largest)) return;
        double smallest = largest;
        for (double x : line)
            if (std::abs(x) > rounding * largest) smallest = std::min(smallest, std::abs(x));
        const double factor = std::exp2(-std::round(0.5 * (std::log2(largest) + std::log2(smallest))));
        line *= factor;
        unit *= factor;
    };
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        const double rounding = sweep < kSweeps / 2 ? 1 : kRounding;
        for (Eigen::Index i = 0; i < U.rows(); ++i) balance(U.row(i), units.rows(i), rounding);
        for (Eigen::Index i = 0; i < U.cols(); ++i) balance(U.col(i), units.columns(i), rounding);
    }
    for (Eigen::Index i = 0; i < U.rows(); ++i)
        if (const double size = U.row(i).norm(); size > 0 && std::isfinite(size)) units.rows(i) /= size;
    return units;
}

OverallTransfer::Check OverallTransfer::check(double lambda, double beside) const {
    const Units units = units_of(assemble(beside));
    const Matrix U = units.rows.asDiagonal() * assemble(lambda) * units.columns.asDiagonal();
    if (U.rows() == 0 || U.rows() != U.cols() || !U.allFinite()) return {1, 0, 0};
    const Eigen::FullPivLU<Matrix> lu(U);
    auto sign = static_cast<double>(lu.permutationP().determinant() * lu.permutationQ().determinant());
    double logarithm = -units.rows.array().log10().sum() - units.columns.array().log10().sum();
    for (Eigen::Index i = 0; i < U.rows(); ++i) {
        const double pivot = lu.matrixLU()(i, i);
        sign *= pivot > 0 ? 1 : pivot < 0 ? -1 : 0;
        logarithm += std::log10(std::max(std::abs(pivot), std::numeric_limits<double>::min()));
    }
    return {smallest_of(U), sign, logarithm};
}

double OverallTransfer::residual(double lambda, double beside) const {
    const Matrix there = assemble(beside);
    const Units units = units_of(there);
    const auto in_units = [&](const Matrix& U) { return Matrix(units.rows.asDiagonal() * U * units.columns.asDiagonal()); };
    return smallest_of(in_units(assemble(lambda))) / smallest_of(in_units(there));
}

std::string OverallTransfer::layout() const {
    std::string text = fmt::format(
        "overall transfer equation: {} x {}, {} directions per state; known boundary entries struck out: {} x {}\n", rows_,
        columns(), directions_, rows_, unknowns_);
    for (int v : order_) {
        const Vertex& vertex = vertices_[as_size(v)];
        if (vertex.root >= 0) text += fmt::format("root: {}\n", boundaries_[as_size(vertex.root)].name);
    }
    for (int v : order_) {
        const Vertex& vertex = vertices_[as_size(v)];
        for (int b : vertex.tips) {
            const Boundary& boundary = boundaries_[as_size(b)];
            text += fmt::format("tip: {} -> ", boundary.name);
            int steps = 0;
            for (int at = v; vertices_[as_size(at)].parent >= 0; ++steps) {
                const Edge& edge = edges_[as_size(vertices_[as_size(at)].parent)];
                at = edge.ends[edge.ends[0] == at ? 1 : 0];
            }
            text += fmt::format("root, over {} elements\n", steps);
        }
    }
    for (int v : order_) {
        const Vertex& vertex = vertices_[as_size(v)];
        const int inputs = as_int(vertex.edges.size() + vertex.tips.size()) - (vertex.parent >= 0 ? 1 : 0);
        if (inputs > 1)
            text += fmt::format("{}: {} inputs, {} geometric equations\n", name_of(v), inputs, directions_ * (inputs - 1));
    }
    return text;
}

}  // namespace dttmm::plugin
