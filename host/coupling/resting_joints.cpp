// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/resting_joints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "coupling/drives.h"
#include "model/index.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// The derivative of f(bodies) by the motion c of a body, its displacements and then its turns, about where it is. f is
/// linear in the displacements: any length serves, that of the arm keeps rounding small.
template <class F>
auto slope(std::vector<BodyState>& at, int body, Eigen::Index c, double length, const F& f) {
    BodyState& moving = at[as_size(body)];
    const BodyState still = moving;
    const auto odd = [&](double way) {
        const Eigen::Matrix<double, 6, 1> by = way * Eigen::Matrix<double, 6, 1>::Unit(c);
        moving = moved(still, by);
        auto value = f(at);
        moving = moved(still, -by);
        value = (0.5 * (value - f(at))).eval();
        moving = still;
        return value;
    };
    if (c >= 3) return slope_by_turn(odd);
    auto by_length = odd(length);
    by_length /= length;
    return by_length;
}

using Vector12 = Eigen::Matrix<double, 12, 1>;

double length_of(const JointEquations& joint, JointEquations::Side side) { return std::max(joint.arm(side), 1e-3); }

}  // namespace

BodyState moved(const BodyState& from, const Eigen::Matrix<double, 6, 1>& by) {
    BodyState to = from;
    to.position += by.head<3>();
    to.rotation = RotationStep(by.tail<3>()).apply(from.rotation);
    return to;
}

RestingJoints::RestingJoints(const Model& model)
    : model_(model),
      system_(model.bodies, model.joints),
      rows_(6 * as_int(model.bodies.size())),
      stops_(model.joints.size()) {
    const int bodies = rows_;
    for (const JointEquations& joint : equations()) {
        first_row_.push_back(rows_);
        rows_ += joint.count();
    }
    q_.setZero(rows_ - bodies);
}

void RestingJoints::start(double t0) {
    std::ranges::fill(stops_, Stop{});
    q_.setZero();
    keep();
    system_.drive(Drives(model_).at(t0));
}

void RestingJoints::keep() {
    kept_stops_ = stops_;
    kept_q_ = q_;
}

void RestingJoints::recall() {
    stops_ = kept_stops_;
    q_ = kept_q_;
}

/// Equations and forces of all joints. What redundant joints share is settled by a small E, which multiplies the change of q
/// only.
void RestingJoints::add(std::vector<BodyState>& at, double factor, const std::vector<double>& held, bool shares_anew,
                        Triplets& entries, Eigen::VectorXd& right_hand_side) const {
    constexpr double kProximal = 1e-10;
    for (size_t j = 0; j < equations().size(); ++j) {
        const JointEquations& joint = equations()[j];
        const int first = first_row(j), force = first_force(j);
        const JointEquations::Jacobian J = joint.jacobian(at);
        const JointEquations::Values C = joint.residual(at, factor * system_.drives()[j].end);
        double stiffest = 0;
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0) stiffest = std::max(stiffest, held[as_size(body)]);
        for (int row = 0; row < joint.count(); ++row) {
            const bool is_stop = row == joint.lasting();
            const bool is_idle = is_stop && !stops_[j].acts;  // zeros all the same: the pattern stays
            // Beyond the stop by its play, where steps keep it: just at it rounding could say that it is not reached
            const auto stop = [&] { return joint.stop(stops_[j].side) - stops_[j].side * Stop::kPlay; };
            entries.emplace_back(first + row, first + row, is_idle ? 1 : -kProximal / stiffest);
            right_hand_side(first + row) = is_idle ? -q_(force + row) : is_stop ? stop() - joint.coordinate(at) : -C(row);
            if (shares_anew && !is_idle) right_hand_side(first + row) += kProximal / stiffest * q_(force + row);
            for (const auto side : JointEquations::kSides) {
                const int body = joint.bodies()[side];
                if (body < 0) continue;
                for (int c = 0; c < 6; ++c) {
                    const double slope = is_idle ? 0 : J[side](row, c);
                    entries.emplace_back(first + row, 6 * body + c, slope);
                    entries.emplace_back(6 * body + c, first + row, slope);
                    right_hand_side(6 * body + c) -= slope * q_(force + row);
                }
            }
        }
        add_stiffness(j, at, entries);
    }
}

/// ∂(Jᵀ q)/∂(pose): the forces of a joint turn with its bodies.
void RestingJoints::add_stiffness(size_t j, std::vector<BodyState>& at, Triplets& entries) const {
    const JointEquations& joint = equations()[j];
    const Eigen::VectorXd q = reactions(j);
    if (q.isZero(0)) return;
    for (const auto moving : JointEquations::kSides) {
        const int column_body = joint.bodies()[moving];
        if (column_body < 0) continue;
        for (int c = 0; c < 6; ++c) {
            const Vector12 by_motion = slope(at, column_body, c, length_of(joint, moving), [&](const auto& bodies) {
                const JointEquations::Jacobian J = joint.jacobian(bodies);
                return Vector12(
                    (Vector12() << J[JointEquations::kFirst].transpose() * q, J[JointEquations::kSecond].transpose() * q)
                        .finished());
            });
            for (const auto side : JointEquations::kSides) {
                const int row_body = joint.bodies()[side];
                if (row_body < 0) continue;
                for (int r = 0; r < 6; ++r) {
                    const double k = 0.5 * by_motion(6 * as_row(size_t{side}) + r);
                    entries.emplace_back(6 * row_body + r, 6 * column_body + c, k);
                    entries.emplace_back(6 * column_body + c, 6 * row_body + r, k);
                }
            }
        }
    }
}

double RestingJoints::take_off(const std::vector<BodyState>& at, std::vector<double>& wrenches) const {
    double strongest = 0;
    for (size_t j = 0; j < equations().size(); ++j) {
        const JointEquations& joint = equations()[j];
        const JointEquations::Jacobian J = joint.jacobian(at);
        const Eigen::VectorXd q = reactions(j);
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0) {
                const Vector6 force = J[side].transpose() * q;
                Eigen::Map<Vector6>(&wrenches[6 * as_size(body)]) -= force;
                strongest = std::max(strongest, force.head<3>().norm());
            }
    }
    return strongest;
}

std::vector<double> RestingJoints::stiffness(std::vector<BodyState>& at) const {
    std::vector<double> all(144 * model_.joints.size(), 0.0);
    for (size_t j = 0; j < model_.joints.size(); ++j) {
        Triplets entries;
        add_stiffness(j, at, entries);
        const auto place = [&](int index) {
            const size_t side = index / 6 == equations()[j].bodies()[JointEquations::kFirst] ? 0 : 6;
            return side + as_size(index % 6);
        };
        for (const auto& entry : entries) all[144 * j + 12 * place(entry.row()) + place(entry.col())] += entry.value();
    }
    return all;
}

/// Of its equations; of a stop that does not act 0.
Eigen::VectorXd RestingJoints::reactions(size_t j) const {
    const JointEquations& joint = equations()[j];
    Eigen::VectorXd q = q_.segment(first_force(j), joint.count());
    if (joint.has_stops() && !stops_[j].acts) q(joint.lasting()) = 0;
    return q;
}

/// On the first body at the anchor, in the axes of that body.
RestingJoints::Vector6 RestingJoints::wrench(size_t j, const std::vector<BodyState>& at) const {
    const JointEquations& joint = equations()[j];
    const bool is_on_ground = joint.bodies()[JointEquations::kFirst] < 0;
    const auto side = is_on_ground ? JointEquations::kSecond : JointEquations::kFirst;
    const Vector6 all = (is_on_ground ? 1.0 : -1.0) * joint.jacobian(at)[side].transpose() * reactions(j);
    const Eigen::Vector3d arm = joint.anchor(at) - at[as_size(joint.bodies()[side])].position;
    const Eigen::Matrix3d axes = joint.axes(at);
    Vector6 own;
    own << axes.transpose() * all.head<3>(), axes.transpose() * (all.tail<3>() - arm.cross(all.head<3>()));
    return own;
}

Eigen::Matrix<double, 6, 12> RestingJoints::turning(size_t j, const std::vector<BodyState>& start) const {
    const JointEquations& joint = equations()[j];
    Eigen::Matrix<double, 6, 12> all = Eigen::Matrix<double, 6, 12>::Zero();
    std::vector<BodyState> at = start;
    for (const auto side : JointEquations::kSides) {
        const int body = joint.bodies()[side];
        if (body < 0) continue;
        for (int c = 0; c < 6; ++c)
            all.col(6 * as_row(size_t{side}) + c) =
                slope(at, body, c, length_of(joint, side), [&](const auto& bodies) { return wrench(j, bodies); });
    }
    return all;
}

RestingJoints::Opening RestingJoints::widest_opening(const std::vector<BodyState>& at, double factor, double extent) const {
    Opening widest;
    for (size_t j = 0; j < equations().size(); ++j) {
        const JointEquations& joint = equations()[j];
        const JointEquations::Values C = joint.residual(at, factor * system_.drives()[j].end);
        for (int row = 0; row < joint.lasting(); ++row) {
            const bool is_length = joint.is_of_length(row);
            const double size = std::abs(C(row)), share = is_length ? size / extent : size;
            if (share > widest.share) widest = {share, j, size, is_length};
        }
    }
    return widest;
}

bool RestingJoints::reach_stops(const std::vector<BodyState>& at) {
    bool is_reached = false;
    for (size_t j = 0; j < stops_.size(); ++j) {
        const JointEquations& joint = equations()[j];
        if (!joint.has_stops() || stops_[j].acts) continue;
        const double place = joint.coordinate(at);
        const int side = place < joint.stop(1) - Stop::kPlay ? 1 : place > joint.stop(-1) + Stop::kPlay ? -1 : 0;
        if (side == 0) continue;
        stops_[j].acts = is_reached = true;
        stops_[j].side = side;
    }
    return is_reached;
}

bool RestingJoints::release_stops() {
    bool is_released = false;
    for (size_t j = 0; j < stops_.size(); ++j) {
        if (!stops_[j].acts) continue;
        const double q = q_(first_force(j) + equations()[j].lasting());
        if (stops_[j].side * q <= 0) continue;  // the force along the coordinate is −q: up from the lower stop
        stops_[j] = {};
        is_released = true;
    }
    return is_released;
}

}  // namespace dttmm::host
