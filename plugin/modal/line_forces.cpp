// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

/// By the motion of the ends and a twist between them.
struct TwistedShape {
    Eigen::Matrix<double, 6, 13> d, slope;
};
using Matrix13 = Eigen::Matrix<double, 13, 13>;

/// m' of a section force.
Vector3 moment_slope(const Vector6& forces) { return -Vector3::UnitX().cross(forces.head<3>()); }

/// The integrand of LineForces::stiffness; load: that turns with the line.
Matrix13 turning_of_section(const Vector6& forces, const Vector3& load, const TwistedShape& shape) {
    const Vector3 f = forces.head<3>(), m = forces.tail<3>(), e = Vector3::UnitX();
    const auto turn = shape.d.bottomRows<3>();
    const auto shear = shape.slope.topRows<3>(), bend = shape.slope.bottomRows<3>();
    const Matrix13 half = turn.transpose() * (skew(f) * shear + 0.5 * skew(m) * bend +
                                              (0.5 * f * e.transpose() - 0.5 * f.x() * Matrix3::Identity()) * turn) +
                          0.5 * shape.d.topRows<3>().transpose() * skew(load) * turn;
    return half + half.transpose();
}

}  // namespace

LineForces::LineForces(std::vector<Vector6> forces, double length, const Vector6& turning, const Section* section)
    : stations_(std::move(forces)), length_(length), turning_(turning) {
    const double quarter = 0.25 * length_ / segments();
    stations_.front().tail<3>() -= quarter * moment_slope(stations_.front());
    stations_.back().tail<3>() += quarter * moment_slope(stations_.back());
    if (!section) return;
    bends_ << 1 / section->EIz, 1 / section->EIy;
    shears_ << 1 / section->GAy, 1 / section->GAz;
    const double step = length_ / segments();
    turns_ = {Eigen::Vector2d::Zero()};
    Eigen::Vector2d rise = Eigen::Vector2d::Zero();
    for (int k = 0; k < segments(); ++k) {
        const double s = k * step;
        turns_.push_back(turns_.back() + step / 6 * (bend(s) + 4 * bend(s + 0.5 * step) + bend(s + step)));
        for (size_t i = 0; i < LineShapes::kPoints.size(); ++i)
            rise += LineShapes::kWeights[i] * step * slope(s + LineShapes::kPoints[i] * step);
    }
    mean_slope_ = rise / length_;
}

Vector3 LineForces::turning_load(double s) const {
    return turning_.head<3>() + s / length_ * (turning_.tail<3>() - turning_.head<3>());
}

Vector6 LineForces::at(double s) const {
    const double step = length_ / segments();
    const int k = std::clamp(static_cast<int>(s / step), 0, segments() - 1);
    const Vector6 &a = stations_[as_size(k)], &b = stations_[as_size(k + 1)];
    const double t = s / step - k, u = 1 - t;
    Vector6 forces;
    forces << u * a.head<3>() + t * b.head<3>(), u * u * (1 + 2 * t) * a.tail<3>() + t * t * (1 + 2 * u) * b.tail<3>() +
                                                     step * t * u * (u * moment_slope(a) - t * moment_slope(b));
    return forces;
}

Vector3 LineForces::mean_force() const {
    Vector3 sum = -0.5 * (first() + last()).head<3>();
    for (const Vector6& station : stations_) sum += station.head<3>();
    return sum / segments();
}

/// In k pieces an axial force that varies by a share a of the stiffness leaves 0.03 to 0.085 a/k⁴ of a frequency: masts of
/// a = 0.001 to 0.1 in 2 to 10 pieces. Moments of a share b leave 0.008 b/k²: a deep cantilever.
/// A bend of b radii of gyration leaves at most 0.008 b/k²: a bar across an oblique guide, b = 0.008 in 3 to 17 pieces.
int LineForces::pieces(const Section& section) const {
    constexpr double kShare = 1e-5, kVaries = 1e-6, kBend = 5e-5;
    const double bending = std::min(section.EIy, section.EIz), axial = mean_force().x();
    const double along = M_PI * M_PI * bending / (length_ * length_) + std::abs(axial),
                 across = bending * std::min(section.GJ, bending) / (length_ * length_);
    double varies = 0, bends = 0;
    for (const Vector6& station : stations_) {
        varies = std::max(varies, std::abs(station(0) - axial) / along);
        bends = std::max(bends, station.tail<3>().squaredNorm() / across);
    }
    double steepest = 0;
    for (size_t k = 0; k < turns_.size(); ++k)
        steepest = std::max(steepest, slope(length_ * static_cast<double>(k) / segments()).norm());
    const double bent = steepest * length_ / 4 * std::sqrt(section.EA / bending);  // of the radius of gyration
    if (varies <= kShare && bends <= kShare && bent <= kShare) return 1;
    const double wanted =
        std::max({2.0, std::pow(varies / kVaries, 0.25), std::sqrt(bends / kShare), std::sqrt(bent / kBend)});
    return std::clamp(static_cast<int>(std::ceil(std::min(wanted, 1e6))), 1, segments());
}

Matrix12 LineForces::stiffness(double start, double length, double axial, double GJ, const LineShapes& shapes) const {
    Matrix13 sum = Matrix13::Zero();
    for (size_t k = 0; k < shapes.at.size(); ++k) {
        const double t = LineShapes::kPoints[k];
        Vector6 forces = at(start + t * length);
        forces(0) -= axial;
        TwistedShape twisted;
        twisted.d << shapes.at[k].d, Vector6::Unit(3) * (4 * t * (1 - t));
        twisted.slope << shapes.at[k].slope, Vector6::Unit(3) * (4 * (1 - 2 * t) / length);
        sum += LineShapes::kWeights[k] * length * turning_of_section(forces, turning_load(start + t * length), twisted);
    }
    const Vector12 by_twist = sum.topRightCorner<12, 1>();
    return sum.topLeftCorner<12, 12>() - by_twist * by_twist.transpose() / (16 * GJ / (3 * length));
}

/// The curvature of the axis but for what shear makes of it, as the slope of its y and z.
Eigen::Vector2d LineForces::bend(double s) const {
    const Vector6 forces = at(s);
    return bends_.cwiseProduct(Eigen::Vector2d(forces(5), -forces(4)));
}

/// How far it has turned from its start, by Simpson's rule: moments are cubics.
Eigen::Vector2d LineForces::turn(double s) const {
    const double step = length_ / segments();
    const int k = std::clamp(static_cast<int>(s / step), 0, segments() - 1);
    const double from = k * step, part = s - from;
    return turns_[as_size(k)] + part / 6 * (bend(from) + 4 * bend(from + 0.5 * part) + bend(s));
}

/// Of the axis against the line between its ends.
Eigen::Vector2d LineForces::slope(double s) const {
    return turn(s) + shears_.cwiseProduct(at(s).segment<2>(1)) - mean_slope_;
}

Matrix12 LineForces::stiffness_of_axis(double start, double length, double EA, const LineShapes& shapes) const {
    if (turns_.empty()) return Matrix12::Zero();
    Vector12 longer = Vector12::Zero();
    for (size_t k = 0; k < shapes.at.size(); ++k)
        longer += LineShapes::kWeights[k] * length * shapes.at[k].slope.middleRows<2>(1).transpose() *
                  slope(start + LineShapes::kPoints[k] * length);
    const Vector12 drawn = Vector12::Unit(6) - Vector12::Unit(0), all = drawn + longer;
    return EA / length * (all * all.transpose() - drawn * drawn.transpose());
}

}  // namespace dttmm::plugin
