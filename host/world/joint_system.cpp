// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <Eigen/Cholesky>

namespace dttmm {

JointSystem::JointSystem(const std::vector<Body>& bodies, const std::vector<Joint>& joints) {
    for (const Joint& joint : joints) joints_.emplace_back(joint, bodies);
    jacobians_.resize(joints.size());
    stops_.resize(joints.size());
}

std::vector<BlockMatrix::JointNode> JointSystem::nodes() const {
    std::vector<BlockMatrix::JointNode> nodes;
    for (const JointEquations& joint : joints_) nodes.push_back({joint.first(), joint.second(), joint.count()});
    return nodes;
}

void JointSystem::linearise(const std::vector<BodyState>& now, const std::vector<Stop>& stops) {
    stops_ = stops;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        JointEquations::Jacobian& J = jacobians_[j];
        joint.jacobian(now, J);
        if (!joint.has_stops() || stops_[j].acts) continue;
        const int idle = joint.lasting();
        J.first.row(idle).setZero();
        J.second.row(idle).setZero();
    }
}

void JointSystem::write_to(BlockMatrix& matrix) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        values_.setZero(joint.count());
        const auto add_mobility = [&](int body, const JointEquations::Rows& J) {
            if (body < 0) return;
            // J K⁻¹ Jᵀ = |L⁻¹ Jᵀ|² with K = L Lᵀ
            const Eigen::LLT<BlockMatrix::Block> K(matrix.diagonal(body));
            const auto L = K.matrixL();
            for (int row = 0; row < joint.count(); ++row) {
                Eigen::Matrix<double, 6, 1> direction = J.row(row).transpose();
                L.solveInPlace(direction);
                values_(row) += proximal_ * direction.squaredNorm();
            }
        };
        add_mobility(joint.first(), jacobians_[j].first);
        add_mobility(joint.second(), jacobians_[j].second);
        if (joint.has_stops() && !stops_[j].acts) values_(joint.lasting()) = 1;
        matrix.set_joint(static_cast<int>(j), jacobians_[j].first, jacobians_[j].second, values_);
    }
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
