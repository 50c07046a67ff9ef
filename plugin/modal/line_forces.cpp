// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/rotation.h"
#include "element/parameters.h"
#include "modal/frequency_model.h"

namespace dttmm::plugin {

namespace {

/// At a place of a line: displacement, rotation, and what both change by per length.
using Place = Eigen::Matrix<double, 12, 1>;
constexpr Eigen::Index kTurn = 3, kSlope = 6, kBend = 9;  ///< where they begin

/// A quadratic form of these is added both ways round.
void add_both(Matrix12& form, Eigen::Index row, Eigen::Index column, const Matrix3& block) {
    form.block<3, 3>(row, column) += block;
    form.block<3, 3>(column, row) += block.transpose();
}

/// The integrand of LineForces::stiffness, of forces that turn; load: that turns with the line.
Matrix12 turning_of_section(const Vector6& forces, const Vector3& load) {
    const Vector3 f = forces.head<3>(), m = forces.tail<3>(), e = Vector3::UnitX();
    Matrix12 form = Matrix12::Zero();
    add_both(form, kTurn, kSlope, skew(f));
    add_both(form, kTurn, kBend, 0.5 * skew(m));
    add_both(form, kTurn, kTurn, 0.5 * f * e.transpose() - 0.5 * f.x() * Matrix3::Identity());
    add_both(form, 0, kTurn, 0.5 * skew(load));
    return form;
}

/// The strains of a section by what it does, axes of the line.
Eigen::Matrix<double, 3, 12> strains_of_section() {
    Eigen::Matrix<double, 3, 12> rows = Eigen::Matrix<double, 3, 12>::Zero();
    rows.middleCols<3>(kSlope).setIdentity();
    rows(1, kTurn + 2) = -1;
    rows(2, kTurn + 1) = 1;
    return rows;
}

/// From 0 to each of Gauss' points, of the polynomials that are 1 at one of them and 0 at the others.
Eigen::Matrix4d integrals_of_points() {
    Eigen::Matrix4d powers, integrals;
    for (Eigen::Index i = 0; i < 4; ++i)
        for (Eigen::Index k = 0; k < 4; ++k) {
            const double t = LineShapes::kPoints[as_size(i)];
            powers(i, k) = std::pow(t, k);
            integrals(i, k) = std::pow(t, k + 1) / static_cast<double>(k + 1);
        }
    return integrals * powers.inverse();
}

double least_bending(const Section& section) {
    if (!is_given(section.EIy)) return section.EIz;
    return is_given(section.EIz) ? std::min(section.EIy, section.EIz) : section.EIy;
}

/// How far a force in local axes turns the sections against the axis by their shear: by α, whose tangent is f/(GA − N) under
/// a force f across the axis. factor: of the stiffnesses; 0: nothing has turned them.
Vector3 turn_of_section(const Vector3& force, double factor, const Section& section) {
    Vector3 tangents = Vector3::Zero();
    if (factor == 0) return tangents;
    if (std::isfinite(section.GAy)) tangents.z() = -force.y() / (factor * section.GAy - force.x());
    if (std::isfinite(section.GAz)) tangents.y() = force.z() / (factor * section.GAz - force.x());
    const double size = tangents.norm();
    return size > 0 ? Vector3(std::atan(size) / size * tangents) : tangents;
}

}  // namespace

Matrix3 falling(const Vector3& weight, const Vector3& beside) {
    const Matrix3 across = weight * beside.transpose();
    return across.trace() * Matrix3::Identity() - 0.5 * (across + across.transpose());
}

LineForces::LineForces(std::vector<Vector3> points, std::vector<Vector6> forces, const Vector6& turning, double factor)
    : points_(std::move(points)), forces_(std::move(forces)), turning_(turning), factor_(factor) {}

std::pair<size_t, double> LineForces::place(double share) const {
    const double at = share * segments();
    const int k = std::clamp(static_cast<int>(at), 0, segments() - 1);
    return {as_size(k), at - k};
}

double LineForces::length() const {
    double sum = 0;
    for (size_t k = 1; k < points_.size(); ++k) sum += (points_[k] - points_[k - 1]).norm();
    return sum;
}

Vector3 LineForces::point(double share) const {
    const auto [k, t] = place(share);
    return (1 - t) * points_[k] + t * points_[k + 1];
}

Matrix3 LineForces::axes_along(const Vector3& way, double share) const {
    const Vector3 x = way.normalized(), y = sections_[place(share).first].col(1), z = x.cross(y).normalized();
    Matrix3 axes;
    axes << x, z.cross(x), z;
    return axes;
}

Vector6 LineForces::at(double share) const {
    const auto [k, t] = place(share);
    const double u = 1 - t;
    const Vector6 &a = forces_[k], &b = forces_[k + 1];
    const Vector3 way = points_[k + 1] - points_[k], at_a = -way.cross(a.head<3>()), at_b = -way.cross(b.head<3>());
    Vector6 forces;
    forces << u * a.head<3>() + t * b.head<3>() + 0.5 * t * u / (segments() * segments()) * rise(share),
        u * u * (1 + 2 * t) * a.tail<3>() + t * t * (1 + 2 * u) * b.tail<3>() + t * u * (u * at_a - t * at_b);
    return forces;
}

Vector3 LineForces::mean_force(double from, double to) const {
    const auto [first, t_first] = place(from);
    const auto [last, t_last] = place(to);
    Vector3 sum = Vector3::Zero();  // of segments
    for (size_t k = first; k <= last; ++k) {
        const double a = k == first ? t_first : 0, b = k == last ? t_last : 1, middle = 0.5 * (a + b);
        const auto bow = [](double t) { return t * t * (3 - 2 * t) / 12; };  // the integral of ½ t (1 − t)
        sum += (b - a) * ((1 - middle) * forces_[k] + middle * forces_[k + 1]).head<3>() +
               (bow(b) - bow(a)) / (segments() * segments()) * rise((static_cast<double>(k) + middle) / segments());
    }
    return sum / ((to - from) * segments());
}

Vector3 LineForces::turning_load(double share) const {
    return turning_.head<3>() + share * (turning_.tail<3>() - turning_.head<3>());
}

Vector3 LineForces::rise(double share) const {
    const Vector3 turning = length() * (turning_.tail<3>() - turning_.head<3>());
    return turning.isZero(0) ? rise_ : rise_ + sections_[place(share).first] * turning;
}

Matrix3 LineForces::falling_in(const Matrix3& axes, const Section& section) const {
    constexpr double kRounding = 1e-12;  // of the axes: without it directions couple that do not
    const Vector3 c(0, section.offset_y, section.offset_z);
    const double least = kRounding * weight_.norm() * c.norm();
    return falling(axes.transpose() * weight_, c).unaryExpr([&](double f) { return std::abs(f) > least ? f : 0.0; });
}

double LineForces::bend(const Section& section) const {
    const Vector3 chord = (points_.back() - points_.front()).normalized();
    double away = 0;
    for (const Vector3& point : points_) away = std::max(away, (point - points_.front()).cross(chord).norm());
    return away / std::sqrt(least_bending(section) / section.EA);
}

double LineForces::bend_between(const Section& section) const {
    if (factor_ == 0) return 0;
    const double bending = least_bending(section), step = length() / segments();
    double away = 0;
    for (int k = 0; k < segments(); ++k) {
        const Vector3 way = (points_[as_size(k) + 1] - points_[as_size(k)]).normalized(),
                      moment = at((k + 0.5) / segments()).tail<3>();
        away = std::max(away, moment.cross(way).norm() / (factor_ * bending) * step * step / 8);
    }
    return away / std::sqrt(bending / section.EA);
}

int LineForces::pieces(const Section& section) const {
    // Measured errors of frequencies: of a share v of the stiffness beside a linear axial force 0.03 to 0.085 v/k⁴ in k
    // pieces; of moments of a share b 0.008 b/k² (a deep cantilever); of a bend of b radii of gyration at most 0.12 b²/k²
    // (cantilevers and clamped bars, b = 0.006 to 1.7, 5 to 80 pieces).
    constexpr double kShare = 1e-5, kVaries = 1e-6, kBow = 3e-3;
    // What a moment does to a whole machine stays the same when beams are divided into n, and its share falls as 1/n²
    constexpr double kNothing = 1e-12;
    const Vector3 chord = (points_.back() - points_.front()).normalized();
    const double bending = least_bending(section), length = this->length(), axial = mean_force().dot(chord),
                 along = M_PI * M_PI * bending / (length * length) + std::abs(axial),
                 across = bending * std::min(section.GJ, bending) / (length * length);
    const double rises = std::abs(rise(0.5).dot(chord)) / (8 * along);
    double varies = std::max(std::max(turning_.head<3>().norm(), turning_.tail<3>().norm()) * length / along, rises),
           bends = 0;
    for (size_t k = 0; k < forces_.size(); ++k) {
        const Vector6& station = forces_[k];
        const double share = static_cast<double>(k) / segments();
        const Vector3 linear = first().head<3>() + share * (last() - first()).head<3>();
        varies = std::max(varies, std::abs((station.head<3>() - linear).dot(chord)) / along);
        bends = std::max(bends, station.tail<3>().squaredNorm() / across);
    }
    const double bent = bend(section);
    const double stiff = std::max(across, std::pow(along * length / (M_PI * M_PI), 2));  // of a taut wire by its tension
    if (varies <= kNothing && bends * across <= kNothing * stiff && bent <= kNothing) return 0;
    if (varies <= kShare && bends <= kShare && bent <= kShare) return 1;
    const auto by = [&](double share) { return std::min(std::pow(share / kVaries, 0.25), 1e6); };
    const double wanted = std::max({2.0, by(varies), std::sqrt(bends / kShare), bent / kBow});
    // More than its segments help where a force is quadratic in each; between its points a bent line is not straight
    const double more = bent <= kBow ? by(rises) : 0;
    return static_cast<int>(std::ceil(std::max(more, std::min(wanted, static_cast<double>(segments())))));
}

/// By the integrals of the curvature, a polynomial. The ends of the piece lie on the axis.
LineForces::Bend LineForces::bend_of(const Piece& piece, const Section& section) const {
    Bend bend{Eigen::Matrix<double, 3, 4>::Zero(), {Vector3::Zero(), Vector3::Zero()}};
    if (factor_ == 0) return bend;
    static const Eigen::Matrix4d integrals = integrals_of_points();
    const Eigen::Map<const Eigen::Vector4d> weights(LineShapes::kWeights.data());
    const Vector3 rigidities = factor_ * Vector3(section.GJ, section.EIy, section.EIz);
    Eigen::Matrix<double, 3, 4> curvatures;
    for (size_t k = 0; k < LineShapes::kPoints.size(); ++k) {
        const Vector3 moment = at(piece.share(LineShapes::kPoints[k])).tail<3>();
        curvatures.col(as_row(k)) = (piece.axes.transpose() * moment).cwiseQuotient(rigidities);
    }
    bend.turns = piece.length * curvatures * integrals.transpose();
    const Vector3 mean = bend.turns * weights;
    bend.turns.colwise() -= mean;
    bend.at_ends = {-mean, piece.length * curvatures * weights - mean};
    return bend;
}

std::vector<LineForces::Piece> LineForces::cut(int count, const Section& section) const {
    constexpr double kSameLength = 1e-12;  // a difference that is rounding
    std::vector<Piece> all;
    for (int i = 0; i < count; ++i) {
        Piece piece{double(i) / count, double(i + 1) / count, {}, 0, {}, {}};
        const Vector3 way = point(piece.to) - point(piece.from);
        piece.length = way.norm();
        if (i > 0 && std::abs(piece.length - all.back().length) <= kSameLength * piece.length)
            piece.length = all.back().length;
        piece.axes = axes_along(way, piece.share(0.5));
        const Bend bend = bend_of(piece, section);
        for (const size_t end : {0u, 1u}) {
            const Vector3 force = piece.axes.transpose() * at(end == 0 ? piece.from : piece.to).head<3>();
            piece.axial[end] = force.x();
            const Vector3 turn = bend.at_ends[end] + turn_of_section(force, factor_, section);
            piece.normals[end] = piece.axes * rotation_from_vector<double>(turn).col(0);
        }
        if (i > 0) piece.normals[0] = all.back().normals[1] = (all.back().normals[1] + piece.normals[0]).normalized();
        all.push_back(piece);
    }
    all.front().normals[0] = ends_[0];
    all.back().normals[1] = ends_[1];
    return all;
}

/// The integrands of stiffness(), by what a place does.
struct LineForces::Integrands {
    Matrix12 form;   ///< of all but the stretch, a quadratic form
    Place by_twist;  ///< the same by a twist between the ends, a parabola
    Place stretch;   ///< of the axis
    Vector3 across;  ///< what a turn about the axis of the piece adds to u', for its axis is bent
};

LineForces::Integrands LineForces::integrands(size_t k, const Piece& piece, const Section& section, const Bend& bend) const {
    const Vector3 e = Vector3::UnitX(), rigidities(section.GJ, section.EIy, section.EIz);
    const double t = LineShapes::kPoints[k], share = piece.share(t);
    const Vector3 turn = bend.turns.col(as_row(k)), slope = turn.cross(e);
    const Vector6 forces = both(piece.axes.transpose()) * at(share);
    const Vector3 force = forces.head<3>();
    const Vector3 normal = turn_of_section(force, factor_, section);
    const Matrix3 axes = rotation_from_vector<double>(turn + normal);

    Integrands all;
    all.across = e.cross(slope);
    Matrix12& form = all.form = turning_of_section(forces, turning_load(share));
    add_both(form, kTurn, kTurn, 0.5 * (force * slope.transpose() - force.dot(slope) * Matrix3::Identity()));
    form.block<3, 3>(kBend, kBend) += axes * rigidities.asDiagonal() * axes.transpose() - Matrix3(rigidities.asDiagonal());
    if (const Matrix3 known = falling_in(piece.axes, section); !known.isZero(0))
        form.block<3, 3>(kTurn, kTurn) +=
            falling(piece.axes.transpose() * weight_, axes * Vector3(0, section.offset_y, section.offset_z)) - known;
    form.col(kTurn) += (form.middleCols<3>(kSlope) * all.across).eval();
    form.row(kTurn) += (all.across.transpose() * form.middleRows<3>(kSlope)).eval();
    all.by_twist = 4 * t * (1 - t) * form.col(kTurn) + 4 * (1 - 2 * t) / piece.length * form.col(kBend);

    // What the waves know is taken off, and strains of the section are those of the shape
    form -= turning_of_section(((1 - t) * piece.axial[0] + t * piece.axial[1]) * Vector6::Unit(0), Vector3::Zero());
    const Eigen::Matrix<double, 3, 12> strains = strains_of_section(),
                                       own = rotation_from_vector<double>(normal).transpose() * strains;
    for (const auto& [i, stiffness] : {std::pair(1, section.GAy), std::pair(2, section.GAz)})
        if (std::isfinite(stiffness))
            form += stiffness * (own.row(i).transpose() * own.row(i) - strains.row(i).transpose() * strains.row(i));
    all.stretch = (own.row(0) - strains.row(0)).transpose();
    all.stretch.segment<3>(kSlope) += slope;
    return all;
}

Matrix12 LineForces::stiffness(const Piece& piece, const Section& section, const LineShapes& shapes) const {
    const Bend bend = bend_of(piece, section);
    Matrix12 K = shapes.stiffness;
    Vector12 longer = Vector12::Unit(6) - Vector12::Unit(0), by_twist = Vector12::Zero();
    K -= section.EA / piece.length * longer * longer.transpose();
    Vector3 beside = Vector3::Zero();  // where the second end comes as it turns against the first, both held
    for (size_t k = 0; k < shapes.at.size(); ++k) {
        const double weight = LineShapes::kWeights[k] * piece.length;
        const Integrands own = integrands(k, piece, section, bend);
        Matrix12 by_ends;
        by_ends << shapes.at[k].d, shapes.at[k].slope;
        const Matrix12 formed = (weight * own.form).lazyProduct(by_ends);
        K.noalias() += by_ends.transpose().lazyProduct(formed);
        by_twist += weight * (by_ends.transpose() * own.by_twist);
        longer += weight * (by_ends.transpose() * own.stretch);
        beside += weight * LineShapes::kPoints[k] * own.across;
    }
    K -= by_twist * by_twist.transpose() / (16 * section.GJ / (3 * piece.length));
    K += section.EA / piece.length * longer * longer.transpose();
    for (const auto& [turn, sign] : {std::pair(3, 1), std::pair(9, -1)}) {
        K.col(turn) += sign * (K.middleCols<3>(6) * beside).eval();
        K.row(turn) += sign * (beside.transpose() * K.middleRows<3>(6)).eval();
    }
    if (factor_ == 1 && is_round(section)) let_spin(piece, K);
    return 0.5 * (K + K.transpose()) - shapes.stiffness;
}

/// Whether it is as stiff in all directions, and nothing that acts on it turns with it.
bool LineForces::is_round(const Section& section) const {
    return section.EIy == section.EIz && section.GAy == section.GAz && section.offset_y == 0 && section.offset_z == 0 &&
           turning_.isZero(0);
}

/// The least change after which K answers a spin of all sections about their normals with the moments at the ends alone,
/// which stay where they are: ∓½ m × t, as the half that turns with them counts elsewhere.
/// Source: Powell (1970), the symmetric update of Broyden's.
void LineForces::let_spin(const Piece& piece, Matrix12& K) const {
    Vector12 spin = Vector12::Zero(), held = Vector12::Zero();
    for (int end : {0, 1}) {
        const Vector3 t = piece.axes.transpose() * piece.normals[as_size(end)],
                      m = piece.axes.transpose() * at(end == 0 ? piece.from : piece.to).tail<3>();
        spin.segment<3>(6 * end + 3) = t;
        held.segment<3>(6 * end + 3) = (end == 0 ? -0.5 : 0.5) * m.cross(t);
    }
    const double square = spin.squaredNorm();
    const Vector12 lack = (held - K * spin) / square;
    const Matrix12 half = (lack - 0.5 * lack.dot(spin) / square * spin) * spin.transpose();
    K += half + half.transpose();
}

}  // namespace dttmm::plugin
