// SPDX-License-Identifier: BSD-3-Clause
#include "support/finite_elements.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/linear_algebra.h"

namespace dttmm::test {

using Vector3 = FiniteElements::Vector3;
using Vector6 = FiniteElements::Vector6;
using Matrix3 = FiniteElements::Matrix3;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Shape = Eigen::Matrix<double, 6, 12>;

struct FiniteElements::Reduced {
    Eigen::MatrixXd K, M;
    std::function<std::string(const Eigen::VectorXd&)> name;  ///< of the largest coordinate of a vector
};

namespace {

Eigen::Matrix2d linear_mass() { return (Eigen::Matrix2d() << 2, 1, 1, 2).finished() / 6; }

Matrix3 cross(const Vector3& a) { return (Matrix3() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished(); }

Matrix6 both(const Matrix3& R) {
    Matrix6 all = Matrix6::Zero();
    all.topLeftCorner<3, 3>() = all.bottomRightCorner<3, 3>() = R;
    return all;
}

void require(bool used, double stiffness, const char* name) {
    if (used && !(stiffness > 0)) throw std::invalid_argument(std::string("a beam or rod needs a positive ") + name);
}

/// Points in (0, 1) and weights: exact up to the seventh power.
std::array<std::pair<double, double>, 4> gauss() {
    const double inner = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2)),
                 outer = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2));
    const double more = (18 + std::sqrt(30.0)) / 72, less = (18 - std::sqrt(30.0)) / 72;
    return {{{(1 - outer) / 2, less}, {(1 - inner) / 2, more}, {(1 + inner) / 2, more}, {(1 + outer) / 2, less}}};
}

/// Kinetic energy per length is v' M v / 2, v = [u θ] of the elastic axis: that of the mass axis, u − offset × θ, and
/// what is left of the inertia about it.
Matrix6 mass_of(const FiniteElements::Section& s) {
    Eigen::Matrix<double, 3, 6> velocity;
    velocity << Matrix3::Identity(), -cross({0, s.mass_offset(0), s.mass_offset(1)});
    const double rest = s.inertia - s.mass * s.mass_offset.squaredNorm();
    if (rest < -1e-12 * s.inertia) throw std::invalid_argument("the inertia is less than that of the mass axis alone");
    Matrix6 M = s.mass * velocity.transpose() * velocity;
    M.diagonal().tail<3>() += Vector3(rest, s.rotary_y, s.rotary_z);
    return M;
}

/// Motion [u θ] and strains [u_x', θx', θz', θy', shear y, shear z] at xi h of an element of length h by the 12
/// coordinates of its ends, own axes; nothing of the coordinates that are not used.
std::pair<Shape, Shape> shapes(const FiniteElements::Section& section, double h, double xi,
                               const std::array<bool, 6>& used) {
    Shape motion = Shape::Zero(), strain = Shape::Zero();
    motion(0, 0) = motion(3, 3) = 1 - xi;
    motion(0, 6) = motion(3, 9) = xi;
    strain(0, 0) = strain(1, 3) = -1 / h;
    strain(0, 6) = strain(1, 9) = 1 / h;
    // Deflection w, slope angle θ, curvature θ' and shear w' − θ by [w1 θ1 w2 θ2]
    const auto plane = [&](double EI, double shear, int deflection, int rotation, double sign, int curvature, int slip) {
        const double phi = std::isinf(shear) ? 0.0 : 12 * EI / (shear * h * h), x2 = xi * xi, x3 = x2 * xi;
        Eigen::Matrix4d f;
        f.row(0) << 1 + phi * (1 - xi) - 3 * x2 + 2 * x3, h * (xi - 2 * x2 + x3 + phi / 2 * (xi - x2)),
            3 * x2 - 2 * x3 + phi * xi, h * (-x2 + x3 - phi / 2 * (xi - x2));
        f.row(1) << 6 * (x2 - xi) / h, 1 - 4 * xi + 3 * x2 + phi * (1 - xi), 6 * (xi - x2) / h, -2 * xi + 3 * x2 + phi * xi;
        f.row(2) << 6 * (2 * xi - 1) / (h * h), (-4 + 6 * xi - phi) / h, 6 * (1 - 2 * xi) / (h * h), (-2 + 6 * xi + phi) / h;
        f.row(3) << -phi / h, -phi / 2, phi / h, -phi / 2;
        f /= 1 + phi;
        f.col(1) *= sign, f.col(3) *= sign;  // rotation coordinates: θ = sign * rotation
        const std::array<int, 4> at{deflection, rotation, deflection + 6, rotation + 6};
        for (int i = 0; i < 4; ++i) {
            motion(deflection, at[static_cast<std::size_t>(i)]) = f(0, i);
            motion(rotation, at[static_cast<std::size_t>(i)]) = sign * f(1, i);
            strain(curvature, at[static_cast<std::size_t>(i)]) = f(2, i);
            strain(slip, at[static_cast<std::size_t>(i)]) = f(3, i);
        }
    };
    plane(section.EIz, section.shear_y, 1, 5, 1, 2, 4);   // v' = θz
    plane(section.EIy, section.shear_z, 2, 4, -1, 3, 5);  // w' = −θy
    for (std::size_t d = 0; d < 6; ++d)
        if (!used[d]) {
            const auto c = static_cast<Eigen::Index>(d);
            motion.col(c).setZero(), motion.col(c + 6).setZero(), strain.col(c).setZero(), strain.col(c + 6).setZero();
        }
    return {motion, strain};
}

/// Throws unless every direction has mass or stiffness.
void require_solution(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M,
                      const std::function<std::string(const Eigen::VectorXd&)>& name) {
    const auto fail = [&](const Eigen::VectorXd& direction) {
        throw std::runtime_error("finite elements: neither mass nor stiffness at " + name(direction));
    };
    double highest = 0;  // [1/s²], of a coordinate: with it mass and stiffness are of one size
    for (Eigen::Index i = 0; i < K.rows(); ++i)
        if (M(i, i) > 0) highest = std::max(highest, K(i, i) / M(i, i));
    const Eigen::MatrixXd A = K + (highest > 0 ? highest : 1) * M;
    const double largest = A.diagonal().maxCoeff();
    for (Eigen::Index i = 0; i < A.rows(); ++i)
        if (!(A(i, i) > 1e-14 * largest)) fail(Eigen::VectorXd::Unit(A.rows(), i));
    const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    const Eigen::VectorXd pivots = Eigen::LDLT<Eigen::MatrixXd>(scaled).vectorD();
    if (pivots.minCoeff() > 1e-12) return;
    fail(scale.asDiagonal() * symmetric_eigenvectors(scaled).col(0));
}

}  // namespace

void FiniteElements::restrict(Dofs dofs) {
    if (!elements_.empty() || !constraints_.empty()) throw std::invalid_argument("restrict() comes before the members");
    kept_ = dofs;
}

int FiniteElements::node(const Vector3& position) {
    positions_.push_back(position);
    static constexpr std::array<const char*, 6> kNames{"x", "y", "z", "rx", "ry", "rz"};
    for (std::size_t d = 0; d < 6; ++d)
        new_coordinate("node " + std::to_string(positions_.size() - 1) + " " + kNames[d], !kept_[d]);
    node_coordinates_.push_back(coordinate_count() - 6);
    return static_cast<int>(positions_.size()) - 1;
}

void FiniteElements::fix(int node, Dofs dofs) {
    for (std::size_t d = 0; d < 6; ++d)
        if (dofs[d]) fixed_[static_cast<std::size_t>(coordinates(node)[d])] = true;
}

void FiniteElements::beam(int from, int to, const Section& section, int count, const Vector3& up) {
    const auto [R, length] = axes(from, to, up);
    if (count < 1) throw std::invalid_argument("a beam has at least one element");
    const bool axial = spans(R.col(0), 0), twist = spans(R.col(0), 3);
    const bool xy = bends(R.col(1), R.col(2)), xz = bends(R.col(2), R.col(1));
    require(axial, section.EA, "EA"), require(twist, section.GJ, "GJ");
    require(xy, section.EIz, "EIz"), require(xz, section.EIy, "EIy");
    const std::array<bool, 6> used{axial, xy, xz, twist, xz, xy};

    const double h = length / count;
    Matrix12 K = Matrix12::Zero(), M = Matrix12::Zero();
    const Matrix6 section_mass = mass_of(section);
    const Vector6 stiffness(section.EA, section.GJ, section.EIz, section.EIy, section.shear_y, section.shear_z);
    for (const auto& [xi, weight] : gauss()) {
        const auto [motion, strain] = shapes(section, h, xi, used);
        M += weight * h * motion.transpose() * section_mass * motion;
        for (int s = 0; s < 6; ++s)
            if (std::isfinite(stiffness(s))) K += weight * h * stiffness(s) * strain.row(s).transpose() * strain.row(s);
    }
    Indices left = coordinates(from);
    for (int e = 0; e < count; ++e) {
        Indices right = coordinates(to);
        if (e + 1 < count)
            for (std::size_t d = 0; d < 6; ++d) right[d] = used[d] ? new_coordinate("inside a beam", false) : -1;
        // Inner coordinates are in the beam's axes, those of the ends in the world's
        Matrix12 to_local = Matrix12::Identity();
        if (e == 0) to_local.topLeftCorner<6, 6>() = both(R.transpose());
        if (e + 1 == count) to_local.bottomRightCorner<6, 6>() = both(R.transpose());
        std::vector<int> indices(left.begin(), left.end());
        indices.insert(indices.end(), right.begin(), right.end());
        add(indices, to_local.transpose() * K * to_local, to_local.transpose() * M * to_local);
        left = right;
    }
    for (int d = 1; d < 3; ++d)  // rotations without their bending plane
        if (!used[static_cast<std::size_t>(d) + 3] && spans(R.col(d), 3)) {
            Vector6 row = Vector6::Zero();
            row.tail<3>() = R.col(d);
            constrain({{from, -row}, {to, row}});
        }
}

void FiniteElements::rod(int from, int to, double EA, double mass, int count, Across across) {
    const auto [R, length] = axes(from, to, default_up(from, to));
    if (count < 1) throw std::invalid_argument("a rod has at least one element");
    if (spans(R.col(0), 0)) {
        require(true, EA, "EA");
        const double h = length / count;
        const auto ends = [&](int node) {  // axial displacement of a node
            const Indices c = coordinates(node);
            return std::pair(std::vector<int>{c[0], c[1], c[2]}, Eigen::MatrixXd(R.col(0).transpose()));
        };
        auto [left, left_row] = ends(from);
        for (int e = 0; e < count; ++e) {
            auto [right, right_row] = ends(to);
            if (e + 1 < count) right = {new_coordinate("inside a rod", false)}, right_row = Eigen::MatrixXd::Ones(1, 1);
            Eigen::MatrixXd u = Eigen::MatrixXd::Zero(2, left_row.cols() + right_row.cols());
            u.block(0, 0, 1, left_row.cols()) = left_row;
            u.block(1, left_row.cols(), 1, right_row.cols()) = right_row;
            std::vector<int> indices = left;
            indices.insert(indices.end(), right.begin(), right.end());
            const Eigen::Matrix2d k = EA / h * (Eigen::Matrix2d() << 1, -1, -1, 1).finished(), m = mass * h * linear_mass();
            add(indices, u.transpose() * k * u, u.transpose() * m * u);
            left = right, left_row = right_row;
        }
    }
    for (int d = 1; d < 3; ++d) {
        if (!spans(R.col(d), 0)) continue;
        const Vector3 t = R.col(d);
        Vector6 at_from = Vector6::Zero(), at_to = Vector6::Zero();
        at_to.head<3>() = t, at_from.head<3>() = -t;
        if (across == Across::rigid_bar) {  // t·(u_to − u_from − θ × l) = 0; a transverse velocity linear along the bar
            at_from.tail<3>() = -(length * R.col(0)).cross(t);
            const Indices a = coordinates(from), b = coordinates(to);
            Eigen::Matrix<double, 2, 6> v = Eigen::Matrix<double, 2, 6>::Zero();
            v.block<1, 3>(0, 0) = t.transpose(), v.block<1, 3>(1, 3) = t.transpose();
            add({a[0], a[1], a[2], b[0], b[1], b[2]}, Eigen::MatrixXd::Zero(6, 6),
                v.transpose() * (mass * length * linear_mass()) * v);
        }
        constrain({{from, at_from}, {to, at_to}});
    }
    for (int d = 3; d < 6; ++d) constrain({{from, -Vector6::Unit(d)}, {to, Vector6::Unit(d)}});
}

void FiniteElements::mass(int node, double mass, const Vector3& center, const Matrix3& inertia) {
    Eigen::Matrix<double, 3, 6> velocity;  // of the centre: u − c × θ
    velocity << Matrix3::Identity(), -cross(center);
    Matrix6 M = mass * velocity.transpose() * velocity;
    M.bottomRightCorner<3, 3>() += inertia;
    const Indices c = coordinates(node);
    add({c.begin(), c.end()}, Matrix6::Zero(), M);
}

void FiniteElements::joint(int from, int to, const Vector6& stiffness, const Matrix3& axes) {
    const Vector3 arm = from == kGround || to == kGround ? Vector3(0, 0, 0) : position(to) - position(from);
    for (int d = 0; d < 6; ++d) {
        Vector3 axis = axes.col(d % 3);
        for (int w = 0; w < 3; ++w)
            if (!kept_[static_cast<std::size_t>(d < 3 ? w : w + 3)]) axis(w) = 0;
        Vector6 at_to = Vector6::Zero(), at_from = Vector6::Zero();
        at_to.segment<3>(d < 3 ? 0 : 3) = axis;
        at_from.segment<3>(d < 3 ? 0 : 3) = -axis;
        if (d < 3) at_from.tail<3>() = -arm.cross(axis);
        if (!(stiffness(d) >= 0)) throw std::invalid_argument("a stiffness is 0 or more");
        if (std::isinf(stiffness(d))) {
            constrain({{from, at_from}, {to, at_to}});
        } else if (stiffness(d) > 0) {
            std::vector<int> indices;
            Eigen::VectorXd row(12);
            row << at_from, at_to;
            for (const int node : {from, to})
                for (const int i : coordinates(node)) indices.push_back(i);
            add(indices, stiffness(d) * row * row.transpose(), Eigen::MatrixXd::Zero(12, 12));
        }
    }
}

std::vector<double> FiniteElements::frequencies(double near) const {
    const auto [K, M, basis_names] = reduced();
    const Eigen::Index n = K.rows();
    if (n == 0) return {};
    require_solution(K, M, basis_names);
    // M x = μ (K + σ M) x, ω² = 1/μ − σ: definite although both may be singular; what has no mass has μ = 0
    const double sigma = std::pow(2 * std::numbers::pi * near, 2);
    const Eigen::VectorXd scale = (K + sigma * M).diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd A = scale.asDiagonal() * (K + sigma * M) * scale.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> cholesky(A);
    if (cholesky.info() != Eigen::Success) throw std::runtime_error("finite elements: stiffness is not definite");
    Eigen::MatrixXd B = scale.asDiagonal() * M * scale.asDiagonal();
    cholesky.matrixL().solveInPlace(B);
    B.transposeInPlace();
    cholesky.matrixL().solveInPlace(B);
    const Eigen::VectorXd mu = symmetric_eigenvalues(B).reverse();
    std::vector<double> hertz;
    for (Eigen::Index i = 0; i < n && mu(i) > 1e-13 * mu(0); ++i)
        hertz.push_back(std::sqrt(std::max(0.0, 1 / mu(i) - sigma)) / (2 * std::numbers::pi));
    return hertz;
}

Vector3 FiniteElements::default_up(int from, int to) const {
    const Vector3 x = (position(to) - position(from)).normalized();
    return std::hypot(x.x(), x.y()) > 1e-9 ? Vector3::UnitZ() : Vector3::UnitX();
}

std::pair<Matrix3, double> FiniteElements::axes(int from, int to, const Vector3& up) const {
    const Vector3 span = position(to) - position(from);
    const double length = span.norm();
    if (!(length > 0)) throw std::invalid_argument("a beam or rod without length");
    Matrix3 R;
    R.col(0) = span / length;
    if (R.col(0).cross(up).norm() < 1e-9 * up.norm()) throw std::invalid_argument("up is along the beam");
    R.col(1) = up.cross(R.col(0)).normalized();
    R.col(2) = R.col(0).cross(R.col(1));
    return {R, length};
}

bool FiniteElements::spans(const Vector3& direction, std::size_t first) const {
    double inside = 0, outside = 0;
    for (std::size_t w = 0; w < 3; ++w)
        (kept_[first + w] ? inside : outside) += std::pow(direction(static_cast<Eigen::Index>(w)), 2);
    if (std::min(inside, outside) > 1e-18) throw std::invalid_argument("an axis is only partly in the kept directions");
    return inside > outside;
}

bool FiniteElements::bends(const Vector3& deflection, const Vector3& rotation) const {
    if (spans(deflection, 0) && !spans(rotation, 3))
        throw std::invalid_argument("a beam deflects in a direction whose rotation is not kept");
    return spans(deflection, 0);
}

int FiniteElements::new_coordinate(std::string name, bool is_fixed) {
    names_.push_back(std::move(name));
    fixed_.push_back(is_fixed);
    return coordinate_count() - 1;
}

FiniteElements::Indices FiniteElements::coordinates(int node) const {
    Indices all{-1, -1, -1, -1, -1, -1};
    if (node == kGround) return all;
    for (int d = 0; d < 6; ++d) all[static_cast<std::size_t>(d)] = node_coordinates_.at(static_cast<std::size_t>(node)) + d;
    return all;
}

void FiniteElements::add(std::vector<int> indices, const Eigen::MatrixXd& K, const Eigen::MatrixXd& M) {
    elements_.push_back({std::move(indices), K, M});
}

void FiniteElements::constrain(const std::vector<std::pair<int, Vector6>>& rows) {
    Constraint all;
    for (const auto& [node, row] : rows)
        for (int d = 0; d < 6; ++d) {
            const int i = coordinates(node)[static_cast<std::size_t>(d)];
            if (i >= 0 && row(d) != 0) all.terms.emplace_back(i, row(d));
        }
    constraints_.push_back(all);
}

FiniteElements::Reduced FiniteElements::reduced() const {
    std::vector<bool> tied(names_.size(), false);
    for (const Constraint& c : constraints_)
        for (const auto& [i, factor] : c.terms) tied[static_cast<std::size_t>(i)] = true;
    std::vector<int> place(names_.size(), -1), names;  // the untied coordinates first
    for (const bool second : {false, true})
        for (std::size_t i = 0; i < names_.size(); ++i)
            if (!fixed_[i] && tied[i] == second)
                place[i] = static_cast<int>(names.size()), names.push_back(static_cast<int>(i));
    const auto n = static_cast<Eigen::Index>(names.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), M = K;
    for (const Element& e : elements_)
        for (std::size_t r = 0; r < e.indices.size(); ++r)
            for (std::size_t c = 0; c < e.indices.size(); ++c) {
                const int i = e.indices[r] < 0 ? -1 : place[static_cast<std::size_t>(e.indices[r])];
                const int j = e.indices[c] < 0 ? -1 : place[static_cast<std::size_t>(e.indices[c])];
                if (i < 0 || j < 0) continue;
                K(i, j) += e.K(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
                M(i, j) += e.M(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
            }
    const Eigen::Index free =
        std::count_if(names.begin(), names.end(), [&](int i) { return !tied[static_cast<std::size_t>(i)]; });
    const Eigen::Index bound = n - free;
    Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(bound, bound);
    if (bound > 0) {
        Eigen::MatrixXd C = Eigen::MatrixXd::Zero(bound, static_cast<Eigen::Index>(constraints_.size()));  // a column each
        for (std::size_t c = 0; c < constraints_.size(); ++c) {
            auto column = C.col(static_cast<Eigen::Index>(c));
            for (const auto& [i, factor] : constraints_[c].terms)
                if (const int p = place[static_cast<std::size_t>(i)]; p >= 0) column(p - free) += factor;
            if (column.norm() > 1e-12) column.normalize();
        }
        Eigen::FullPivHouseholderQR<Eigen::MatrixXd> qr(C);
        qr.setThreshold(1e-10);
        Z = Eigen::MatrixXd(qr.matrixQ()).rightCols(bound - qr.rank());
    }
    const auto reduce = [&](const Eigen::MatrixXd& full) {
        Eigen::MatrixXd small(free + Z.cols(), free + Z.cols());
        small << full.topLeftCorner(free, free), full.topRightCorner(free, bound) * Z,
            Z.transpose() * full.bottomLeftCorner(bound, free), Z.transpose() * full.bottomRightCorner(bound, bound) * Z;
        return Eigen::MatrixXd((small + small.transpose()) / 2);
    };
    const auto name = [this, names, Z, free](const Eigen::VectorXd& p) {
        Eigen::VectorXd q(free + Z.rows());
        q << p.head(free), Z * p.tail(Z.cols());
        Eigen::Index largest;
        q.cwiseAbs().maxCoeff(&largest);
        return names_[static_cast<std::size_t>(names[static_cast<std::size_t>(largest)])];
    };
    return {reduce(K), reduce(M), name};
}

std::vector<double> extrapolate(const std::vector<double>& f1, const std::vector<double>& f2,
                                const std::vector<double>& f4) {
    std::vector<double> limit(std::min({f1.size(), f2.size(), f4.size()}));
    for (std::size_t i = 0; i < limit.size(); ++i) limit[i] = (f1[i] - 20 * f2[i] + 64 * f4[i]) / 45;
    return limit;
}

std::vector<double> extrapolate(const std::vector<double>& f1, const std::vector<double>& f2, int order) {
    std::vector<double> limit(std::min(f1.size(), f2.size()));
    for (std::size_t i = 0; i < limit.size(); ++i) limit[i] = f2[i] + (f2[i] - f1[i]) / (std::pow(2.0, order) - 1);
    return limit;
}

std::vector<double> extrapolate(const std::function<std::vector<double>(int)>& frequencies, int n) {
    return extrapolate(frequencies(n), frequencies(2 * n), frequencies(4 * n));
}

}  // namespace dttmm::test
