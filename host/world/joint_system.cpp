// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <Eigen/LU>

namespace dttmm {

namespace {

/// E of an equation over its mobility J M⁻¹ Jᵀ: a pass leaves this part of an error, and rounding feigns forces in redundant
/// joints as its inverse.
constexpr double kProximal = 1e-7;

}  // namespace

JointSystem::JointSystem(const std::vector<Body>& bodies, const std::vector<Joint>& joints) {
    for (const Joint& joint : joints) joints_.emplace_back(joint, bodies);
    for (const Body& body : bodies) inertias_.push_back({1 / body.mass, body.inertia.inverse()});
    jacobians_.resize(joints.size());
    E_.resize(joints.size());
    stops_.resize(joints.size());
    values_.resize(7);
}

std::vector<BlockMatrix::JointNode> JointSystem::nodes() const {
    std::vector<BlockMatrix::JointNode> nodes;
    for (const JointEquations& joint : joints_) nodes.push_back({joint.first(), joint.second(), joint.count()});
    return nodes;
}

/// J M⁻¹ Jᵀ of one row and one body.
double JointSystem::mobility(const Eigen::Matrix<double, 1, 6>& row, int body, const std::vector<BodyState>& now) const {
    if (body < 0) return 0;
    const Inertia& inertia = inertias_[static_cast<size_t>(body)];
    const Eigen::Vector3d turning = now[static_cast<size_t>(body)].rotation.transpose() * row.tail<3>().transpose();
    return inertia.inverse_mass * row.head<3>().squaredNorm() + turning.dot(inertia.inverse_inertia * turning);
}

void JointSystem::linearise(const std::vector<BodyState>& now, const std::vector<Stop>& stops) {
    stops_ = stops;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        JointEquations::Jacobian& J = jacobians_[j];
        joint.jacobian(now, J);
        E_[j].resize(joint.count());
        for (int row = 0; row < joint.count(); ++row)
            E_[j](row) = kProximal *
                         (mobility(J.first.row(row), joint.first(), now) + mobility(J.second.row(row), joint.second(), now));
        if (!joint.has_stops() || stops_[j].acts) continue;
        const int idle = joint.lasting();
        J.first.row(idle).setZero();
        J.second.row(idle).setZero();
        E_[j](idle) = 1;
    }
}

void JointSystem::write_to(BlockMatrix& matrix) const {
    for (size_t j = 0; j < joints_.size(); ++j)
        matrix.set_joint(static_cast<int>(j), jacobians_[j].first, jacobians_[j].second, E_[j]);
}

double JointSystem::coordinate_speed(size_t joint, const std::vector<BodyState>& end) const {
    const JointEquations& equations = joints_[joint];
    double speed = 0;
    const auto add = [&](int body, const JointEquations::Rows& J) {
        if (body < 0) return;
        const BodyState& at = end[static_cast<size_t>(body)];
        const auto row = J.row(equations.lasting());
        speed += row.head<3>().dot(at.velocity) + row.tail<3>().dot(at.angular_velocity);
    };
    add(equations.first(), jacobians_[joint].first);
    add(equations.second(), jacobians_[joint].second);
    return speed;
}

void JointSystem::write_openings(const BlockMatrix& matrix, const std::vector<BodyState>& end, double h,
                                 Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(static_cast<int>(j));
        joint.residual(end, values_);
        rows.segment(start, joint.lasting()) = values_.head(joint.lasting()) / -h;
        if (!joint.has_stops()) continue;
        rows(start + joint.lasting()) = stops_[j].acts ? stops_[j].speed - coordinate_speed(j, end) : 0;
    }
}

void JointSystem::write_curvatures(const BlockMatrix& matrix, const std::vector<BodyState>& at,
                                   Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(static_cast<int>(j));
        joint.curvature(at, values_);
        rows.segment(start, joint.lasting()) = -values_.head(joint.lasting());
        if (joint.has_stops()) rows(start + joint.lasting()) = 0;
    }
}

void JointSystem::add_impulses(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers, Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const double* q = multipliers.data() + matrix.joint_index(static_cast<int>(j));
        if (joint.first() >= 0) rows.segment<6>(matrix.index(joint.first())) += impulse_on_first(static_cast<int>(j), q);
        if (joint.second() >= 0) rows.segment<6>(matrix.index(joint.second())) += impulse_on_second(static_cast<int>(j), q);
    }
}

Eigen::Matrix<double, 6, 1> JointSystem::impulse_on_first(int joint, const double* q) const {
    const auto j = static_cast<size_t>(joint);
    return -(jacobians_[j].first.transpose() * Eigen::Map<const Eigen::VectorXd>(q, joints_[j].count()));
}

Eigen::Matrix<double, 6, 1> JointSystem::impulse_on_second(int joint, const double* q) const {
    const auto j = static_cast<size_t>(joint);
    return -(jacobians_[j].second.transpose() * Eigen::Map<const Eigen::VectorXd>(q, joints_[j].count()));
}

double JointSystem::opening_speed(const std::vector<BodyState>& at, size_t joint) const {
    const JointEquations& equations = joints_[joint];
    JointEquations::Jacobian J;
    equations.jacobian(at, J);
    Eigen::VectorXd speed = Eigen::VectorXd::Zero(equations.lasting());
    const auto add = [&](int body, const JointEquations::Rows& rows) {
        if (body < 0) return;
        const BodyState& state = at[static_cast<size_t>(body)];
        Eigen::Matrix<double, 6, 1> u;
        u << state.velocity, state.angular_velocity;
        speed += rows.topRows(equations.lasting()) * u;
    };
    add(equations.first(), J.first);
    add(equations.second(), J.second);
    return speed.cwiseAbs().maxCoeff();
}

}  // namespace dttmm
