// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr JointEquations::Side kSides[] = {JointEquations::kFirst, JointEquations::kSecond};

/// J u, the rates of the equations with the velocities of `at`.
JointEquations::Values rates(const JointEquations& joint, const JointEquations::Jacobian& J,
                             const std::vector<BodyState>& at) {
    JointEquations::Values sum = JointEquations::Values::Zero(joint.count());
    for (const auto side : kSides) {
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
    stops_.resize(joints.size());
}

std::vector<BlockMatrix::JointNode> JointSystem::nodes() const {
    std::vector<BlockMatrix::JointNode> nodes;
    for (const JointEquations& joint : joints_) nodes.push_back({joint.bodies()[0], joint.bodies()[1], joint.count()});
    return nodes;
}

double JointSystem::longest_arm(int body) const {
    double longest = 0;
    for (const JointEquations& joint : joints_)
        for (const auto side : kSides)
            if (joint.bodies()[side] == body) longest = std::max(longest, joint.arm(side));
    return longest;
}

void JointSystem::linearise(const std::vector<BodyState>& now, const std::vector<Stop>& stops) {
    stops_ = stops;
    proximal_ = std::min(kProximal, 10 * proximal_);
    for (size_t j = 0; j < joints_.size(); ++j) {
        jacobians_[j] = joints_[j].jacobian(now);
        if (!joints_[j].has_stops() || stops_[j].acts) continue;
        for (const auto side : kSides) jacobians_[j][side].row(joints_[j].lasting()).setZero();
    }
    if (first_jacobians_.empty()) first_jacobians_ = jacobians_;
}

/// Of the equations that always hold, by velocities and angular velocities times the longest arm; the largest first.
std::vector<double> JointSystem::singular_values(const std::vector<JointEquations::Jacobian>& jacobians) const {
    Eigen::Index rows = 0;
    int bodies = 0;
    double arm = 0;
    for (const JointEquations& joint : joints_) {
        rows += joint.lasting();
        for (const auto side : kSides) {
            bodies = std::max(bodies, joint.bodies()[side] + 1);
            if (joint.bodies()[side] >= 0) arm = std::max(arm, joint.arm(side));
        }
    }
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, 6 * bodies);
    Eigen::Index row = 0;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const int count = joints_[j].lasting();
        for (const auto side : kSides) {
            if (joints_[j].bodies()[side] < 0) continue;
            auto block = J.block(row, 6 * joints_[j].bodies()[side], count, 6);
            block = jacobians[j][side].topRows(count);
            if (arm > 0) block.rightCols<3>() /= arm;
        }
        row += count;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> squares(J * J.transpose(), Eigen::EigenvaluesOnly);
    std::vector<double> values;
    for (Eigen::Index i = rows; i-- > 0;) values.push_back(std::sqrt(std::max(squares.eigenvalues()(i), 0.0)));
    return values;
}

bool JointSystem::is_near_singular() const {
    constexpr Eigen::Index kMostEquations = 1000;  // a decomposition of them takes a second
    constexpr double kNone = 1e-6;  // of the largest: squares of singular values are found to 1e-16 of its square, and some
    constexpr double kNear = 0.2;   // of the value at the start: it falls in proportion to the angle that is left
    Eigen::Index rows = 0;
    for (const JointEquations& joint : joints_) rows += joint.lasting();
    if (rows == 0 || rows > kMostEquations || first_jacobians_.empty()) return false;
    const std::vector<double> first = singular_values(first_jacobians_), now = singular_values(jacobians_);
    size_t rank = 0;
    while (rank < first.size() && first[rank] > kNone * first[0]) ++rank;
    return rank > 0 && now[rank - 1] < kNear * first[rank - 1];
}

void JointSystem::write_to(BlockMatrix& matrix) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        JointEquations::Values E = JointEquations::Values::Zero(joint.count());
        for (const auto side : kSides) {
            if (joint.bodies()[side] < 0) continue;
            // J K⁻¹ Jᵀ = |L⁻¹ Jᵀ|² with K = L Lᵀ
            const Eigen::LLT<BlockMatrix::Block> K(matrix.diagonal(joint.bodies()[side]));
            const auto L = K.matrixL();
            for (int row = 0; row < joint.count(); ++row) {
                Eigen::Matrix<double, 6, 1> direction = jacobians_[j][side].row(row).transpose();
                L.solveInPlace(direction);
                E(row) += proximal_ * direction.squaredNorm();
            }
        }
        if (joint.has_stops() && !stops_[j].acts) E(joint.lasting()) = 1;
        matrix.set_joint(as_int(j), jacobians_[j][0], jacobians_[j][1], E);
    }
}

double JointSystem::coordinate_speed(size_t joint, const std::vector<BodyState>& end) const {
    return rates(joints_[joint], jacobians_[joint], end)(joints_[joint].lasting());
}

void JointSystem::write_openings(const BlockMatrix& matrix, const std::vector<BodyState>& end, double h,
                                 Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(as_int(j));
        rows.segment(start, joint.lasting()) = joint.residual(end) / -h;
        if (!joint.has_stops()) continue;
        rows(start + joint.lasting()) = stops_[j].acts ? stops_[j].speed - coordinate_speed(j, end) : 0;
    }
}

void JointSystem::write_curvatures(const BlockMatrix& matrix, const std::vector<BodyState>& at,
                                   Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(as_int(j));
        rows.segment(start, joint.lasting()) = -joint.curvature(at);
        if (joint.has_stops()) rows(start + joint.lasting()) = 0;
    }
}

void JointSystem::add_impulses(const BlockMatrix& matrix, const Eigen::VectorXd& multipliers, Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const double* q = multipliers.data() + matrix.joint_index(as_int(j));
        for (const auto side : kSides)
            if (const int body = joints_[j].bodies()[side]; body >= 0)
                rows.segment<6>(matrix.index(body)) += impulse(j, side, q);
    }
}

Eigen::Matrix<double, 6, 1> JointSystem::impulse(size_t joint, JointEquations::Side side, const double* q) const {
    return -(jacobians_[joint][side].transpose() * Eigen::Map<const Eigen::VectorXd>(q, joints_[joint].count()));
}

double JointSystem::opening_speed(size_t joint, const std::vector<BodyState>& at) const {
    const JointEquations& equations = joints_[joint];
    return rates(equations, equations.jacobian(at), at).head(equations.lasting()).cwiseAbs().maxCoeff();
}

}  // namespace dttmm::host
