// SPDX-License-Identifier: BSD-3-Clause
#include "world/singular_position.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "model/index.h"
#include "world/inertia.h"
#include "world/iteration.h"

namespace dttmm::host {

namespace {

constexpr Eigen::Index kMostEquations = 1000;  // a decomposition of them takes a second

/// J of the equations that always hold, by velocities and angular velocities times the longest arm.
Eigen::MatrixXd jacobian(const std::vector<JointEquations>& joints, const std::vector<BodyState>& at) {
    Eigen::Index rows = 0;
    int bodies = 0;
    double arm = 0;
    for (const JointEquations& joint : joints) {
        rows += joint.lasting();
        for (const auto side : JointEquations::kSides) {
            bodies = std::max(bodies, joint.bodies()[side] + 1);
            if (joint.bodies()[side] >= 0) arm = std::max(arm, joint.arm(side));
        }
    }
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, 6 * bodies);
    Eigen::Index row = 0;
    for (const JointEquations& joint : joints) {
        const JointEquations::Jacobian sides = joint.jacobian(at);
        for (const auto side : JointEquations::kSides) {
            if (joint.bodies()[side] < 0) continue;
            auto block = J.block(row, 6 * joint.bodies()[side], joint.lasting(), 6);
            block = sides[side].topRows(joint.lasting());
            if (arm > 0) block.rightCols<3>() /= arm;
        }
        row += joint.lasting();
    }
    return J;
}

}  // namespace

bool form_loop(const std::vector<Joint>& joints) {
    std::map<int, int> towards;  // the root of a tree of bodies; roots have none. The ground is −1
    const auto root = [&](int body) {
        for (auto next = towards.find(body); next != towards.end(); next = towards.find(body)) body = next->second;
        return body;
    };
    for (const Joint& joint : joints) {
        const int one = root(joint.first), other = root(joint.second);
        if (one == other) return true;
        towards[one] = other;
    }
    return false;
}

void SingularPosition::open() { before_ = std::exchange(found_, {}); }

bool SingularPosition::is_suspected(const JointSystem& joints, const BlockMatrix& matrix, const BlockFactor& factor) {
    // There E is the square root of itself over the distance squared: half of its digits hide. 0.003 to 0.06 pass the tests
    const double hidden = std::sqrt(std::sqrt(JointSystem::kProximal));
    distances_.resize(as_size(matrix.size()));
    bool is_suspected = before_.is_near;
    for (size_t j = 0; j < joints.joints().size(); ++j)
        for (int row = 0; row < joints.joints()[j].lasting(); ++row) {
            const int i = matrix.joint_index(as_int(j)) + row;
            const double share = factor.pivot(i) / matrix.upper().diagonal()(i);
            double distance = std::sqrt(joints.proximal() * std::max(0.0, share));
            if (distance < hidden) distance = 0;
            Distance& known = distances_[as_size(i)];
            is_suspected = is_suspected || std::abs(distance - known.last) > kSlowOnJoints * distance ||
                           (distance == 0 && known.largest > 0);
            known = {distance, std::max(distance, known.largest)};
        }
    return is_suspected;
}

void SingularPosition::find(const JointSystem& joints, const std::vector<BodyState>& now, const std::vector<BodyState>& half,
                            const std::vector<BodyState>& end) {
    found_ = decide(joints.joints(), now, half, end);
    // ODE's joints are not ours where they stand open: the step that closes them does without
    if (before_.lets_go() && found_.let_go.empty()) found_.let_go.assign(joints.joints().size(), 0);
}

bool SingularPosition::Found::lets_go() const {
    return std::ranges::any_of(let_go, [](unsigned equations) { return equations != 0; });
}

void SingularPosition::count(double time) {
    const auto joint = std::ranges::find_if(found_.let_go, [](unsigned equations) { return equations != 0; });
    if (joint == found_.let_go.end()) return;
    if (passed_.steps++ == 0) passed_ = {1, time, static_cast<size_t>(joint - found_.let_go.begin())};
}

SingularPosition::Found SingularPosition::decide(const std::vector<JointEquations>& joints,
                                                 const std::vector<BodyState>& now, const std::vector<BodyState>& half,
                                                 const std::vector<BodyState>& end) {
    // Rows at a smaller distance from the span of others say nothing: rounding of a sum of all; 1e-6 fails
    constexpr double kRedundant = kMostEquations * kRounding;
    Eigen::Index equations = 0;
    for (const JointEquations& joint : joints) equations += joint.lasting();
    if (equations == 0 || equations > kMostEquations) return {};
    // A column per equation, of length one half way
    Eigen::MatrixXd A = jacobian(joints, half).transpose(), B = jacobian(joints, end).transpose();
    const Eigen::RowVectorXd lengths = A.colwise().norm();
    const Eigen::MatrixXd turned = B - jacobian(joints, now).transpose();
    const double change = (turned.array().rowwise() / lengths.array()).matrix().colwise().norm().maxCoeff();
    if (change > kSlowOnJoints) return {};  // a step that turns joints by more [rad] decides about none
    A.array().rowwise() /= lengths.array();
    B.array().rowwise() /= lengths.array();
    // With pivoting, the diagonal of R has the distance of each column from the span of those before
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> middle(A), finish(B);
    const auto rank = [](const auto& qr, double least) {
        const Eigen::Index count = std::min(qr.matrixQR().rows(), qr.matrixQR().cols());
        return (qr.matrixQR().diagonal().head(count).array().abs() > least).count();
    };
    const double hidden = std::sqrt(JointSystem::kProximal / kSlowOnJoints);  // nearer, E makes a pass slow
    const Eigen::Index kept = rank(middle, std::max(0.5 * change / std::sqrt(kSlowOnJoints), hidden));
    const bool all_decided = kept >= std::max(rank(middle, kRedundant), rank(finish, kRedundant));
    Found found;
    if (kept > 0) found.least = std::abs(middle.matrixQR()(kept - 1, kept - 1));
    found.is_near = !all_decided || found.least < change / kSlowOnJoints;
    if (all_decided) return found;
    found.let_go.assign(joints.size(), 0);
    const auto& order = middle.colsPermutation().indices();
    for (Eigen::Index i = kept; i < order.size(); ++i) {
        Eigen::Index row = order(i);
        size_t j = 0;
        for (; row >= joints[j].lasting(); ++j) row -= joints[j].lasting();
        found.let_go[j] |= 1u << row;
    }
    return found;
}

}  // namespace dttmm::host
