// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_equations.h"

#include <Eigen/Geometry>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

const BodyState kGround = {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(),
                           Eigen::Vector3d::Zero()};

Eigen::Matrix3d start_rotation(int body, const std::vector<Body>& bodies) {
    return body < 0 ? Eigen::Matrix3d::Identity() : bodies[as_size(body)].rotation;
}

/// From a body's centre of mass to a point of the world at the start, body axes.
Eigen::Vector3d start_arm(int body, const std::vector<Body>& bodies, const Eigen::Vector3d& point) {
    if (body < 0) return point;
    const Body& b = bodies[as_size(body)];
    return b.rotation.transpose() * (point - b.position) - b.center_of_mass;
}

}  // namespace

JointEquations::JointEquations(const Joint& joint, const std::vector<Body>& bodies)
    : bodies_{joint.first, joint.second},
      arm_first_(start_arm(joint.first, bodies, joint.anchor)),
      arm_second_(start_arm(joint.second, bodies, joint.anchor)),
      has_coordinate_(joint.type == JointType::hinge || joint.type == JointType::slider),
      turns_(joint.type == JointType::hinge),
      has_stops_(has_coordinate_ && joint.limits),
      is_driven_(has_coordinate_ && joint.drive),
      stops_(joint.limits.value_or(std::array{0.0, 0.0})) {
    const Eigen::Matrix3d to_first = start_rotation(joint.first, bodies).transpose();
    const Eigen::Matrix3d to_second = start_rotation(joint.second, bodies).transpose();
    const Eigen::Vector3d a = joint.axis.normalized(), b = a.unitOrthogonal(), c = a.cross(b);
    const auto keep_anchor = [&](const Eigen::Vector3d& d) { anchors_.push_back({d, false}); };
    const auto keep_right_angle = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& w) {
        angles_.push_back({to_first * u, to_second * w});
    };
    const auto keep_attitude = [&] {
        keep_right_angle(b, c);
        keep_right_angle(c, a);
        keep_right_angle(a, b);
    };
    axis_ = to_first * a;
    zero_ = to_first * b;
    quarter_ = to_first * c;
    pointer_ = to_second * b;

    if (joint.type == JointType::slider) {
        anchors_.push_back({zero_, true});
        anchors_.push_back({quarter_, true});
        keep_attitude();
        return;
    }
    for (int i = 0; i < 3; ++i) keep_anchor(Eigen::Vector3d::Unit(i));
    switch (joint.type) {
        case JointType::hinge:
            keep_right_angle(b, a);
            keep_right_angle(c, a);
            break;
        case JointType::universal:
            keep_right_angle(a, joint.axis2.normalized());
            break;
        case JointType::fixed:
            keep_attitude();
            break;
        default:
            break;
    }
}

const BodyState& JointEquations::state(Side side, const std::vector<BodyState>& at) const {
    return bodies_[side] < 0 ? kGround : at[as_size(bodies_[side])];
}

Eigen::Vector3d JointEquations::direction(const AnchorEquation& equation, const BodyState& first) const {
    return equation.on_first ? Eigen::Vector3d(first.rotation * equation.d) : equation.d;
}

JointEquations::Values JointEquations::residual(const std::vector<BodyState>& at, double driven_to) const {
    const BodyState &first = state(kFirst, at), &second = state(kSecond, at);
    const Eigen::Vector3d gap =
        second.position + second.rotation * arm_second_ - first.position - first.rotation * arm_first_;
    Values C(lasting());
    int row = 0;
    for (const AnchorEquation& equation : anchors_) C(row++) = direction(equation, first).dot(gap);
    for (const AngleEquation& equation : angles_) C(row++) = (first.rotation * equation.u).dot(second.rotation * equation.w);
    if (is_driven_) C(row) = way(driven_to, coordinate(at));
    return C;
}

JointEquations::Jacobian JointEquations::jacobian(const std::vector<BodyState>& at) const {
    const BodyState &first = state(kFirst, at), &second = state(kSecond, at);
    const Eigen::Vector3d r1 = first.rotation * arm_first_, r2 = second.rotation * arm_second_;
    const Eigen::Vector3d gap = second.position + r2 - first.position - r1;
    Jacobian J{Rows(count(), 6), Rows(count(), 6)};
    // d·(p₂ − p₁): d·(v₂ + ω₂ × r₂ − v₁ − ω₁ × r₁) + ḋ·gap,  ḋ = ω₁ × d where d is fixed on the first body
    const auto set_anchor_row = [&](int row, const Eigen::Vector3d& d, bool on_first) {
        J[kSecond].row(row) << d.transpose(), r2.cross(d).transpose();
        J[kFirst].row(row) << -d.transpose(), -r1.cross(d).transpose();
        if (on_first) J[kFirst].row(row).tail<3>() += d.cross(gap).transpose();
    };
    int row = 0;
    for (const AnchorEquation& equation : anchors_) set_anchor_row(row++, direction(equation, first), equation.on_first);
    for (const AngleEquation& equation : angles_) {
        // u·w: (ω₁ − ω₂)·(u × w)
        const Eigen::Vector3d n = (first.rotation * equation.u).cross(second.rotation * equation.w);
        J[kFirst].row(row) << 0, 0, 0, n.transpose();
        J[kSecond].row(row++) << 0, 0, 0, -n.transpose();
    }
    if (has_stops_ || is_driven_) {
        const Eigen::Vector3d a = first.rotation * axis_;
        if (turns_) {
            J[kFirst].row(row) << 0, 0, 0, -a.transpose();
            J[kSecond].row(row) << 0, 0, 0, a.transpose();
        } else {
            set_anchor_row(row, a, true);
        }
    }
    for (Side side : {kFirst, kSecond})
        if (bodies_[side] < 0) J[side].setZero();
    return J;
}

JointEquations::Values JointEquations::curvature(const std::vector<BodyState>& at) const {
    const BodyState &first = state(kFirst, at), &second = state(kSecond, at);
    const Eigen::Vector3d &w1 = first.angular_velocity, &w2 = second.angular_velocity;
    const Eigen::Vector3d r1 = first.rotation * arm_first_, r2 = second.rotation * arm_second_;
    const Eigen::Vector3d gap = second.position + r2 - first.position - r1;
    const Eigen::Vector3d gap_rate = second.velocity + w2.cross(r2) - first.velocity - w1.cross(r1);
    const Eigen::Vector3d gap_curvature = w2.cross(w2.cross(r2)) - w1.cross(w1.cross(r1));
    Values rate(count());
    const auto along = [&](const Eigen::Vector3d& d, bool on_first) {
        return d.dot(gap_curvature) + (on_first ? 2 * w1.cross(d).dot(gap_rate) + w1.cross(w1.cross(d)).dot(gap) : 0);
    };
    int row = 0;
    for (const AnchorEquation& equation : anchors_) rate(row++) = along(direction(equation, first), equation.on_first);
    for (const AngleEquation& equation : angles_) {
        const Eigen::Vector3d u = first.rotation * equation.u, w = second.rotation * equation.w;
        rate(row++) = w1.cross(w1.cross(u)).dot(w) + 2 * w1.cross(u).dot(w2.cross(w)) + u.dot(w2.cross(w2.cross(w)));
    }
    if (has_stops_ || is_driven_) {
        const Eigen::Vector3d a = first.rotation * axis_;
        rate(row) = turns_ ? w1.cross(a).dot(w2 - w1) : along(a, true);
    }
    return rate;
}

Eigen::Vector3d JointEquations::anchor(const std::vector<BodyState>& at) const {
    const BodyState& first = state(kFirst, at);
    return first.position + first.rotation * arm_first_;
}

double JointEquations::coordinate(const std::vector<BodyState>& at) const {
    const BodyState &first = state(kFirst, at), &second = state(kSecond, at);
    if (turns_) {
        const Eigen::Vector3d pointer = second.rotation * pointer_;
        return std::atan2(pointer.dot(first.rotation * quarter_), pointer.dot(first.rotation * zero_));
    }
    return (first.rotation * axis_)
        .dot(second.position + second.rotation * arm_second_ - first.position - first.rotation * arm_first_);
}

double JointEquations::coordinate_speed(const std::vector<BodyState>& at, const std::vector<BodyState>& moving) const {
    const Jacobian J = jacobian(at);
    double speed = 0;
    for (Side side : kSides) {
        if (bodies_[side] < 0) continue;
        const BodyState& body = moving[as_size(bodies_[side])];
        const auto row = J[side].row(coordinate_row());
        speed += row.head<3>().dot(body.velocity.transpose()) + row.tail<3>().dot(body.angular_velocity.transpose());
    }
    return speed;
}

}  // namespace dttmm::host
