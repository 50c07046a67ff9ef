// SPDX-License-Identifier: BSD-3-Clause
#include "world/joint_system.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
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
    matrix_jacobians_.resize(joints.size());
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

/// An equation that holds nothing over this step: of a stop that does not act, or let go.
bool JointSystem::is_idle(size_t joint, int row) const {
    if (row == joints_[joint].lasting()) return !stops_[joint].acts;
    return !let_go_.empty() && (let_go_[joint] >> row & 1) != 0;
}

void JointSystem::linearise(const std::vector<BodyState>& now, const std::vector<BodyState>& by,
                            const std::vector<Stop>& stops, const LetGo& let_go) {
    stops_ = stops;
    let_go_ = let_go;
    proximal_ = std::min(kProximal, 10 * proximal_);
    for (size_t j = 0; j < joints_.size(); ++j) {
        jacobians_[j] = joints_[j].jacobian(now);
        matrix_jacobians_[j] = joints_[j].jacobian(by);
        for (int row = 0; row < joints_[j].count(); ++row)
            if (is_idle(j, row))
                for (auto* jacobians : {&jacobians_, &matrix_jacobians_})
                    for (const auto side : kSides) (*jacobians)[j][side].row(row).setZero();
    }
}

/// The equations that always hold, by velocities and angular velocities times the longest arm.
Eigen::MatrixXd JointSystem::dense(const std::vector<JointEquations::Jacobian>& jacobians) const {
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
    return J;
}

bool JointSystem::may_be_near_singular(const BlockMatrix& matrix, const BlockFactor& factor) {
    constexpr double kHidden = 0.03;  // at a hundredth of it E hides the distance; 0.003 to 0.06 pass the tests
    constexpr double kFast = 0.3;     // change over the distance; 0.15 to 0.6 pass
    distances_.resize(as_size(matrix.size()));
    bool is_suspect = false;
    for (size_t j = 0; j < joints_.size(); ++j)
        for (int row = 0; row < joints_[j].lasting(); ++row) {
            const int i = matrix.joint_index(as_int(j)) + row;
            double distance = std::sqrt(proximal_ * std::max(0.0, factor.pivot(i) / matrix.upper().diagonal()(i)));
            if (distance < kHidden) distance = 0;
            Distance& known = distances_[as_size(i)];
            is_suspect =
                is_suspect || std::abs(distance - known.last) > kFast * distance || (distance == 0 && known.largest > 0);
            known = {distance, std::max(distance, known.largest)};
        }
    return is_suspect;
}

std::vector<JointEquations::Jacobian> JointSystem::jacobians_at(const std::vector<BodyState>& at) const {
    std::vector<JointEquations::Jacobian> jacobians;
    for (const JointEquations& joint : joints_) jacobians.push_back(joint.jacobian(at));
    return jacobians;
}

JointSystem::SingularPosition JointSystem::find_singular_position(const std::vector<BodyState>& now,
                                                                  const std::vector<BodyState>& half,
                                                                  const std::vector<BodyState>& end) const {
    // Half and twice pass the tests where nothing else is said
    constexpr double kRedundant = 1e-9;  // rows at a smaller distance from the span of others say nothing; 1e-6 fails
    constexpr double kSlow = 0.3;        // what a pass may leave of an error; 0.15 fails
    constexpr double kLongest = 0.5;     // a step that turns joints by more [rad] decides about none; 1 fails
    Eigen::Index equations = 0;
    for (const JointEquations& joint : joints_) equations += joint.lasting();
    if (equations == 0 || equations > kMostEquations) return {};
    // A column per equation, of length one half way
    Eigen::MatrixXd A = dense(jacobians_at(half)).transpose(), B = dense(jacobians_at(end)).transpose();
    const Eigen::RowVectorXd lengths = A.colwise().norm();
    const Eigen::MatrixXd turned = B - dense(jacobians_at(now)).transpose();
    const double change = (turned.array().rowwise() / lengths.array()).matrix().colwise().norm().maxCoeff();
    if (change > kLongest) return {};
    A.array().rowwise() /= lengths.array();
    B.array().rowwise() /= lengths.array();
    // With pivoting, the diagonal of R has the distance of each column from the span of those before
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> middle(A), finish(B);
    const auto rank = [](const auto& qr, double least) {
        const Eigen::Index count = std::min(qr.matrixQR().rows(), qr.matrixQR().cols());
        return (qr.matrixQR().diagonal().head(count).array().abs() > least).count();
    };
    const double hidden = std::sqrt(10 * kProximal);  // E leaves a tenth of an error there; twice that fails
    const Eigen::Index kept = rank(middle, std::max(0.5 * change / std::sqrt(kSlow), hidden));
    const bool all_decided = kept >= std::max(rank(middle, kRedundant), rank(finish, kRedundant));
    SingularPosition found;
    if (kept > 0) found.least = std::abs(middle.matrixQR()(kept - 1, kept - 1));
    found.is_near = !all_decided || found.least < change / kSlow;
    if (all_decided) return found;
    found.let_go.assign(joints_.size(), 0);
    const auto& order = middle.colsPermutation().indices();
    for (Eigen::Index i = kept; i < order.size(); ++i) {
        Eigen::Index row = order(i);
        size_t j = 0;
        for (; row >= joints_[j].lasting(); ++j) row -= joints_[j].lasting();
        found.let_go[j] |= 1u << row;
    }
    return found;
}

void JointSystem::write(const std::vector<JointEquations::Jacobian>& jacobians, BlockMatrix& matrix) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        JointEquations::Values E = JointEquations::Values::Zero(joint.count());
        for (const auto side : kSides) {
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
    return rates(joints_[joint], jacobians_[joint], end)(joints_[joint].lasting());
}

void JointSystem::write_openings(const BlockMatrix& matrix, const std::vector<BodyState>& end, double h,
                                 Eigen::VectorXd& rows) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointEquations& joint = joints_[j];
        const int start = matrix.joint_index(as_int(j));
        rows.segment(start, joint.lasting()) = joint.residual(end) / -h;
        if (joint.has_stops()) rows(start + joint.lasting()) = stops_[j].speed - coordinate_speed(j, end);
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
        rows.segment(start, joint.lasting()) = -joint.curvature(at);
        if (joint.has_stops()) rows(start + joint.lasting()) = 0;
        for (int row = 0; row < joint.lasting(); ++row)
            if (is_idle(j, row)) rows(start + row) = 0;
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
