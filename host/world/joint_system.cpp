// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "world/inertia.h"

namespace dttmm::host {

namespace {

/// J u, the rates of the equations with the velocities of `at`.
JointEquations::Values rates(const JointEquations& joint, const JointEquations::Jacobian& J,
                             const std::vector<BodyState>& at) {
    JointEquations::Values sum = JointEquations::Values::Zero(joint.count());
    for (const auto side : JointEquations::kSides) {
        if (joint.bodies()[side] < 0) continue;
        const BodyState& state = at[as_size(joint.bodies()[side])];
        sum += J[side].leftCols<3>() * state.velocity + J[side].rightCols<3>() * state.angular_velocity;
    }
    return sum;
}

}  // namespace

JointSystem::JointSystem(const std::vector<Body>& bodies, const std::vector<Joint>& joints) {
    for (const Joint& joint : joints) joints_.emplace_back(joint, bodies);
    jacobians_.resize(joints.size());
    matrix_jacobians_.resize(joints.size());
    stops_.resize(joints.size());
    drives_.resize(joints.size());
    let_go_.reserve(joints.size());
}

std::vector<BlockMatrix::JointNode> JointSystem::nodes() const {
    std::vector<BlockMatrix::JointNode> nodes;
    for (const JointEquations& joint : joints_) nodes.push_back({joint.bodies()[0], joint.bodies()[1], joint.count()});
    return nodes;
}

double JointSystem::longest_arm(int body) const {
    double longest = 0;
    for (const JointEquations& joint : joints_)
        for (const auto side : JointEquations::kSides)
            if (joint.bodies()[side] == body) longest = std::max(longest, joint.arm(side));
    return longest;
}

/// An equation that holds nothing over this step: of a stop that does not act, or let go.
bool JointSystem::is_idle(size_t joint, int row) const {
    if (row == joints_[joint].lasting()) return !stops_[joint].acts;
    return !let_go_.empty() && (let_go_[joint] >> row & 1) != 0;
}

void JointSystem::linearise(const std::vector<BodyState>& now, const std::vector<BodyState>& by,
                            const std::vector<Stop>& stops, const LetGo& let_go) {
    stops_ = stops;
    let_go_ = let_go;
    proximal_ = std::min(kProximal, proximal_ / kTighter);
    for (size_t j = 0; j < joints_.size(); ++j) {
        jacobians_[j] = joints_[j].jacobian(now);
        matrix_jacobians_[j] = joints_[j].jacobian(by);
        for (int row = 0; row < joints_[j].count(); ++row)
            if (is_idle(j, row))
                for (auto* jacobians : {&jacobians_, &matrix_jacobians_})
                    for (const auto side : JointEquations::kSides) (*jacobians)[j][side].row(row).setZero();
    }
}

void JointSystem::write(const std::vector<JointEquations::Jacobian>& jacobians, BlockMatrix& matrix) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        JointEquations::Values E = JointEquations::Values::Zero(joint.count());
        for (const auto side : JointEquations::kSides) {
            if (joint.bodies()[side] < 0) continue;
            // J K⁻¹ Jᵀ = |L⁻¹ Jᵀ|² with K = L Lᵀ
            const Eigen::LLT<BlockMatrix::Block> K(matrix.diagonal(joint.bodies()[side]));
            const auto L = K.matrixL();
            for (int row = 0; row < joint.count(); ++row) {
                Eigen::Matrix<double, 6, 1> direction = jacobians[j][side].row(row).transpose();
                L.solveInPlace(direction);
                E(row) += proximal_ * direction.squaredNorm();
            }
        }
        for (int row = 0; row < joint.count(); ++row)
            if (is_idle(j, row)) E(row) = 1;
        matrix.set_joint(as_int(j), jacobians[j][0], jacobians[j][1], E);
    }
}

double JointSystem::coordinate_speed(size_t joint, const std::vector<BodyState>& end) const {
    return rates(joints_[joint], jacobians_[joint], end)(joints_[joint].coordinate_row());
}

void JointSystem::write_openings(const BlockMatrix& matrix, const std::vector<BodyState>& end, double h,
                                 Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(as_int(j));
        rows.segment(start, joint.lasting()) = joint.residual(end, drives_[j].end) / -h;
        if (joint.has_stops()) rows(start + joint.lasting()) = joint.way(joint.coordinate(end), stops_[j].end) / h;
        for (int row = 0; row < joint.count(); ++row)
            if (is_idle(j, row)) rows(start + row) = 0;
    }
}

void JointSystem::write_speeds(const BlockMatrix& matrix, const std::vector<BodyState>& end,
                               const std::vector<BodyState>& wanted, Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j)
        rows.segment(matrix.joint_index(as_int(j)), joints_[j].count()) =
            rates(joints_[j], jacobians_[j], wanted) - rates(joints_[j], jacobians_[j], end);
}

void JointSystem::write_curvatures(const BlockMatrix& matrix, const std::vector<BodyState>& at,
                                   Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(as_int(j));
        rows.segment(start, joint.count()) = -joint.curvature(at);
        if (joint.is_driven()) rows(start + joint.coordinate_row()) += drives_[j].acceleration;
        for (int row = 0; row < joint.count(); ++row)
            if (is_idle(j, row)) rows(start + row) = 0;
    }
}

void JointSystem::add_impulses(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers, Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const double* q = multipliers.data() + matrix.joint_index(as_int(j));
        for (const auto side : JointEquations::kSides)
            if (const int body = joints_[j].bodies()[side]; body >= 0)
                rows.segment<6>(matrix.index(body)) += impulse(j, side, q);
    }
}

Eigen::Matrix<double, 6, 1> JointSystem::impulse(size_t joint, JointEquations::Side side, const double* q) const {
    return -(jacobians_[joint][side].transpose() * Eigen::Map<const Eigen::VectorXd>(q, joints_[joint].count()));
}

void JointSystem::find_stops(const std::vector<BodyState>& now, const std::vector<Stop>& before,
                             std::vector<Stop>& stops) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        if (!joint.has_stops()) continue;
        Stop& stop = stops[j] = {before[j].start, joint.coordinate(now)};
        for (int side : {1, -1}) {
            if (side * (stop.start - joint.stop(side)) > Stop::kPlay) continue;  // off it by more than rounding
            stop.acts = true;
            stop.end = std::clamp(stop.start, joint.stop(side) - Stop::kPlay, joint.stop(side) + Stop::kPlay);
            stop.side = side;
        }
    }
}

/// The impulse −q on the coordinate must have the sign of the stop's side.
bool JointSystem::release_pulling_stops(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers,
                                        std::vector<Stop>& stops) const {
    const double weak = kRounding * multipliers.cwiseAbs().maxCoeff();
    bool changed = false;
    for (size_t j = 0; j < stops.size(); ++j) {
        if (!stops[j].acts || stops[j].leaving_step > 0) continue;
        if (stops[j].side * multipliers(matrix.joint_index(as_int(j)) + joints_[j].lasting()) <= weak) continue;
        stops[j].let_go();
        changed = true;
    }
    return changed;
}

double JointSystem::opening_speed(size_t joint, const std::vector<BodyState>& at) const {
    const JointEquations& equations = joints_[joint];
    JointEquations::Values opening = rates(equations, equations.jacobian(at), at).head(equations.lasting());
    if (equations.is_driven()) opening(equations.coordinate_row()) -= drives_[joint].rate;
    return opening.cwiseAbs().maxCoeff();
}

}  // namespace dttmm::host
