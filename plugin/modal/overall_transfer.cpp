// SPDX-License-Identifier: BSD-3-Clause
#include "modal/overall_transfer.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Of a balanced row: smaller entries are what cancelled.
constexpr double kRounding = 1e-10;
constexpr int kSweeps = 8;

Eigen::MatrixXd stack(const Eigen::MatrixXd& above, const Eigen::MatrixXd& below) {
    Eigen::MatrixXd both(above.rows() + below.rows(), above.cols());
    both << above, below;
    return both;
}

bool can_be_singular(const Eigen::MatrixXd& U) { return U.rows() > 0 && U.rows() == U.cols() && U.allFinite(); }

/// The smallest singular value as share of the largest; 1 of a matrix that is empty, not square or overflows.
double smallest_of(const Eigen::MatrixXd& U) {
    if (!can_be_singular(U)) return 1;
    const Eigen::VectorXd singular = U.jacobiSvd().singularValues();
    return singular(singular.size() - 1) / singular(0);
}

/// The last pivot of full-pivot elimination as share of the largest; 1 as above.
double last_pivot_of(const Eigen::MatrixXd& U) {
    if (!can_be_singular(U)) return 1;
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(U);
    return std::abs(lu.matrixLU()(U.rows() - 1, U.rows() - 1)) / lu.maxPivot();
}

/// A name for a heading: `ground at node "foot"` is "ground at foot".
std::string without_kind(std::string name) {
    for (const char* part : {"node \"", "body \"", "element \"", "\""})
        for (size_t at = name.find(part); at != name.npos; at = name.find(part)) name.erase(at, std::strlen(part));
    return name;
}

}  // namespace

/// Displacement at a point of a vertex by its motion; an end on the ground is its own point.
OverallTransfer::Matrix OverallTransfer::by_point(const Vertex& vertex, const Vector3& point) const {
    if (vertex.frame < 0) return Matrix::Identity(topology_.directions, topology_.directions);
    return topology_.restricted(FrequencyModel::at_point(point, topology_.model.origin(vertex.frame)));
}

/// A state handed through a joint or a line; the free directions of a joint move by unknowns of their own. lines: transfer
/// matrices as far as they are known.
OverallTransfer::Matrix OverallTransfer::through(const Edge& edge, bool is_forward, const Matrix& state,
                                                 std::vector<Matrix>& lines, double lambda) const {
    const Eigen::Index n = topology_.directions;
    if (!edge.is_line) {
        Matrix out = state;
        out.topRows(n) -= edge.law.compliance * state.bottomRows(n);
        if (edge.loose > 0) out.block(0, edge.first_loose, n, edge.loose) += edge.law.loose;
        return out;
    }
    const LineModel& line = topology_.model.lines[edge.index];
    Matrix& local = lines[line.kind];
    if (local.size() == 0) local = line_transfer(line, lambda);
    // Local [d; n] → world [u; w], w = −n; the way back inverts a symplectic matrix and turns the loads round
    Matrix12 turn = Matrix12::Zero();
    turn << both(line.axes), Matrix6::Zero(), Matrix6::Zero(), -both(line.axes);
    const Matrix12 world = turn * local * turn.transpose();
    std::vector<Eigen::Index> halves = topology_.active;
    for (Eigen::Index d : topology_.active) halves.push_back(6 + d);
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
    if (!topology_.model.is_bar(line)) return U;
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
    Matrix state = Matrix::Zero(2 * topology_.directions, topology_.unknowns);
    state.middleCols(boundary.first, boundary.basis.cols()) = boundary.basis;
    state.bottomRows(topology_.directions) *= boundary.sign;
    return state;
}

/// The square matrix: what is known at the boundaries struck out.
OverallTransfer::Matrix OverallTransfer::assemble(double lambda, std::vector<Line>* names) const {
    const Eigen::Index n = topology_.directions;
    Matrix U = Matrix::Zero(topology_.rows, topology_.unknowns);
    Eigen::Index row = 0;
    const auto add = [&](const Matrix& rows, int vertex, const char* what, Eigen::Index first) {
        U.middleRows(row, rows.rows()) = rows;
        row += rows.rows();
        for (Eigen::Index i = 0; names && i < rows.rows(); ++i)
            names->push_back(line_of(without_kind(topology_.name_of(vertex)) + what, first + i));
    };
    std::vector<Matrix> handed_on(topology_.edges.size()), lines(topology_.model.kinds.size());
    std::vector<Matrix6> inertial(topology_.model.frames.size(), Matrix6::Zero());
    for (const auto& mass : topology_.model.masses) inertial[as_size(mass.frame)] += lambda * mass.block;
    for (const auto& lever : topology_.model.levers) inertial[as_size(lever.frame)] -= lever.stiffness;
    for (size_t k = topology_.order.size(); k-- > 0;) {
        const Vertex& vertex = topology_.vertices[as_size(topology_.order[k])];
        if (vertex.edges.empty()) continue;
        Matrix motion, load = Matrix::Zero(n, topology_.unknowns);
        const auto take = [&](const Matrix& by, const Matrix& state) {
            if (motion.size() == 0)
                motion = by.partialPivLu().solve(state.topRows(n));
            else
                add(by * motion - state.topRows(n), topology_.order[k], ".geometry", 0);
            load += by.transpose() * state.bottomRows(n);
        };
        const auto point = [&](int e) {
            const Edge& edge = topology_.edges[as_size(e)];
            return edge.points[edge.ends[0] == topology_.order[k] ? 0 : 1];
        };
        for (int e : vertex.edges)
            if (e != vertex.parent) take(by_point(vertex, point(e)), handed_on[as_size(e)]);
        for (int b : vertex.tips) {
            const Boundary& boundary = topology_.boundaries[as_size(b)];
            take(by_point(vertex, boundary.point), state_of(boundary));
        }
        if (vertex.frame >= 0) load += topology_.restricted(inertial[as_size(vertex.frame)]) * motion;
        if (vertex.root >= 0) {
            add(stack(motion, load) - state_of(topology_.boundaries[as_size(vertex.root)]), topology_.order[k], ".root", 0);
            continue;
        }
        const Matrix by = by_point(vertex, point(vertex.parent));
        const Edge& edge = topology_.edges[as_size(vertex.parent)];
        const Matrix state = stack(by * motion, by.transpose().partialPivLu().solve(load));
        handed_on[as_size(vertex.parent)] = through(edge, edge.ends[0] == topology_.order[k], state, lines, lambda);
        if (edge.loose > 0)
            add(edge.law.loose.transpose() * state.bottomRows(n), topology_.order[k], ".carries nothing", -1);
    }
    return U;
}

/// An entry of a state: its symbol behind the owner, and its unit. Negative: a direction of a joint, which has no symbol.
OverallTransfer::Line OverallTransfer::line_of(const std::string& owner, Eigen::Index entry) const {
    constexpr const char* kSymbols[] = {"x", "y", "z", "rx", "ry", "rz", "fx", "fy", "fz", "mx", "my", "mz"};
    constexpr const char* kUnits[] = {"m", "rad", "N", "N*m"};
    if (entry < 0) return {owner, ""};
    const Eigen::Index half = entry / topology_.directions, d = topology_.active[as_size(entry % topology_.directions)];
    return {owner + "." + kSymbols[6 * half + d], kUnits[2 * half + d / 3]};
}

std::vector<OverallTransfer::Line> OverallTransfer::columns_of_matrix() const {
    std::vector<Line> columns(as_size(topology_.unknowns));
    std::map<std::string, int> counts;  // a frame may have several ends on the ground
    for (const Boundary& boundary : topology_.boundaries) {
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
    for (const Edge& edge : topology_.edges)
        for (int k = 0; k < edge.loose; ++k)
            columns[as_size(edge.first_loose + k)] = {
                fmt::format("{} to {}.free{}", without_kind(topology_.name_of(edge.ends[0])),
                            without_kind(topology_.name_of(edge.ends[1])), k + 1),
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
    if (!can_be_singular(U)) return {1, 0, 0};
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
    return last_pivot_of(in_units(assemble(lambda))) / last_pivot_of(in_units(there));
}

}  // namespace dttmm::plugin
