// SPDX-License-Identifier: BSD-3-Clause
#include "world/singular_position.h"

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

/// Distance below which E hides how far an equation is from the span of those before. There E is the square root of itself
/// over the distance squared, and half of its digits hide. Values from 0.003 to 0.06 pass the tests.
double hidden_distance() { return std::sqrt(std::sqrt(JointSystem::kProximal)); }

Eigen::Index count_equations(const std::vector<JointEquations>& joints) {
    Eigen::Index count = 0;
    for (const JointEquations& joint : joints) count += joint.lasting();
    return count;
}

}  // namespace

bool form_loop(const std::vector<std::pair<int, int>>& links) {
    std::map<int, int> towards;  // the root of a tree; roots have none
    const auto root = [&](int of) {
        for (auto next = towards.find(of); next != towards.end(); next = towards.find(of)) {
            if (const auto after = towards.find(next->second); after != towards.end()) next->second = after->second;
            of = next->second;
        }
        return of;
    };
    for (const auto& [first, second] : links) {
        const int one = root(first), other = root(second);
        if (one == other) return true;
        towards[one] = other;
    }
    return false;
}

bool form_loop(const std::vector<Joint>& joints) {
    std::vector<std::pair<int, int>> links;
    for (const Joint& joint : joints) links.emplace_back(joint.first, joint.second);
    return form_loop(links);
}

SingularPosition::SingularPosition(const JointSystem& joints, bool have_loop) {
    for (const JointEquations& joint : joints.joints())
        for (const auto side : JointEquations::kSides)
            if (joint.bodies()[side] >= 0) longest_arm_ = std::max(longest_arm_, joint.arm(side));
    const Eigen::Index equations = count_equations(joints.joints());
    if (have_loop && equations <= kMostEquations) make_room(joints.joints(), equations);
}

void SingularPosition::make_room(const std::vector<JointEquations>& joints, Eigen::Index equations) {
    if (half_.cols() == equations) return;
    int bodies = 0;
    for (const JointEquations& joint : joints)
        for (const auto side : JointEquations::kSides) bodies = std::max(bodies, joint.bodies()[side] + 1);
    for (Eigen::MatrixXd* list : {&half_, &end_}) list->setZero(6 * bodies, equations);
    found_.let_go.reserve(joints.size());
    before_.let_go.reserve(joints.size());
    pivoted_ = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(half_.rows(), half_.cols());
}

void SingularPosition::open() {
    std::swap(before_, found_);
    found_.clear();
}

void SingularPosition::Found::clear() {
    is_near = is_clear = false;
    let_go.clear();
    least = 1;
}

/// A column per equation that always holds: its derivatives by velocities, and by angular velocities times the longest arm.
/// sign: 1 to set it, −1 to take it off.
void SingularPosition::write_columns(const std::vector<JointEquations>& joints, const std::vector<BodyState>& at,
                                     double sign, Eigen::MatrixXd& columns) const {
    if (sign > 0) columns.setZero();
    Eigen::Index column = 0;
    for (const JointEquations& joint : joints) {
        const JointEquations::Jacobian sides = joint.jacobian(at);
        for (const auto side : JointEquations::kSides) {
            if (joint.bodies()[side] < 0) continue;
            auto block = columns.block(6 * joint.bodies()[side], column, 6, joint.lasting());
            const auto own = sides[side].topRows(joint.lasting()).transpose();
            block.topRows<3>() += sign * own.topRows(3);
            block.bottomRows<3>() += (longest_arm_ > 0 ? sign / longest_arm_ : sign) * own.bottomRows(3);
        }
        column += joint.lasting();
    }
}

bool SingularPosition::is_suspected(const BlockMatrix& matrix, const BlockFactor& factor) {
    if (half_.cols() == 0) return false;  // joints without a loop are independent
    // The root of the determinant has the product of all distances. Which equation shows that one vanishes depends on axes
    // and order, and it may be that none does.
    double product = 0;
    for (int i = 0; i < as_int(as_size(matrix.size())); ++i) product += 0.5 * std::log(std::abs(factor.pivot(i)));
    const bool is_first = !product_;
    const Distance before = product_.value_or(Distance{product, product});
    product_ = {product, std::max(product, before.largest)};
    return is_first || before_.is_near || std::abs(product - before.last) > std::log1p(kSlowOnJoints) ||
           product < before.largest + std::log(hidden_distance());
}

void SingularPosition::find(const JointSystem& joints, const std::vector<BodyState>& now, const std::vector<BodyState>& half,
                            const std::vector<BodyState>& end) {
    decide(joints.joints(), now, half, end);
    // What is hidden is redundant here
    if (found_.is_clear) product_->largest = product_->last;
    // ODE's joints are not ours where they stand open: the step that closes them does without
    if (before_.lets_go() && found_.let_go.empty()) found_.let_go.assign(joints.joints().size(), 0);
}

bool SingularPosition::Found::lets_go() const {
    return std::ranges::any_of(let_go, [](unsigned equations) { return equations != 0; });
}

void SingularPosition::count(double time) {
    const auto joint = std::ranges::find_if(found_.let_go, [](unsigned equations) { return equations != 0; });
    if (joint == found_.let_go.end()) return;
    if (passed_.steps++ == 0) passed_ = {1, time, as_size(joint - found_.let_go.begin())};
}

void SingularPosition::decide(const std::vector<JointEquations>& joints, const std::vector<BodyState>& now,
                              const std::vector<BodyState>& half, const std::vector<BodyState>& end) {
    // Rows at a smaller distance from the span of others say nothing: rounding of a sum of all; 1e-6 fails
    constexpr double kRedundant = kMostEquations * kRounding;
    const Eigen::Index equations = count_equations(joints);
    if (equations == 0 || equations > kMostEquations) return;
    make_room(joints, equations);
    write_columns(joints, half, 1, half_);
    write_columns(joints, end, 1, end_);
    write_columns(joints, now, -1, end_);
    double change = 0;
    for (Eigen::Index i = 0; i < equations; ++i) change = std::max(change, end_.col(i).norm() / half_.col(i).norm());
    if (change > kSlowOnJoints) return;  // a step that turns joints by more [rad] decides about none
    // Of length one half way
    write_columns(joints, end, 1, end_);
    for (Eigen::Index i = 0; i < equations; ++i) {
        const double length = half_.col(i).norm();
        half_.col(i) /= length;
        end_.col(i) /= length;
    }
    // With pivoting, the diagonal of R has the distance of each column from the span of those before
    const auto rank = [&](double least) {
        const Eigen::Index count = std::min(pivoted_.matrixQR().rows(), pivoted_.matrixQR().cols());
        return (pivoted_.matrixQR().diagonal().head(count).array().abs() > least).count();
    };
    pivoted_.compute(end_);
    const Eigen::Index independent_at_end = rank(kRedundant);
    pivoted_.compute(half_);
    const auto& order = pivoted_.colsPermutation().indices();
    const double hidden = std::sqrt(JointSystem::kProximal / kSlowOnJoints);  // nearer, E makes a pass slow
    const Eigen::Index kept = rank(std::max(0.5 * change / std::sqrt(kSlowOnJoints), hidden)),
                       independent = rank(kRedundant);
    const bool all_decided = kept >= std::max(independent, independent_at_end);
    if (kept > 0) found_.least = std::abs(pivoted_.matrixQR()(kept - 1, kept - 1));
    found_.is_near = !all_decided || found_.least < change / kSlowOnJoints;
    found_.is_clear = !found_.is_near && kept == independent && found_.least > hidden_distance();
    if (all_decided) return;
    found_.let_go.assign(joints.size(), 0);
    for (Eigen::Index i = kept; i < order.size(); ++i) {
        Eigen::Index row = order(i);
        size_t j = 0;
        for (; row >= joints[j].lasting(); ++j) row -= joints[j].lasting();
        found_.let_go[j] |= 1u << row;
    }
}

}  // namespace dttmm::host
