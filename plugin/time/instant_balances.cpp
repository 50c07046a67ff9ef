// SPDX-License-Identifier: BSD-3-Clause
#include "time/instant_balances.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/rotation.h"
#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// A direction is damped if its pivot is more than this share of the largest, in units of c + h k, what damper and spring do
/// over a step. One that is undamped but for a small turn θ of its frames has θ² of the damping, and would get any velocity.
/// The tests of instants fail with 1e-6 and with 4e-4.
constexpr double kLeastDamping = kSmallTurn * kSmallTurn;

/// x of P A Q = L U with the right-hand side r, by the pivots above `least` of the largest; the rest of x is zero. Returns
/// their number.
Eigen::Index solve_by_rank(const Eigen::FullPivLU<Eigen::MatrixXd>& lu, double least, Eigen::VectorXd& r,
                           Eigen::VectorXd& z) {
    const Eigen::MatrixXd& LU = lu.matrixLU();
    const auto& rows = lu.permutationP().indices();
    const auto& columns = lu.permutationQ().indices();
    const Eigen::Index n = LU.rows();
    for (Eigen::Index i = 0; i < n; ++i) z(rows(i)) = r(i);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index k = 0; k < i; ++k) z(i) -= LU(i, k) * z(k);
    Eigen::Index rank = 0;
    while (rank < n && std::abs(LU(rank, rank)) > least * std::abs(LU(0, 0))) ++rank;
    for (Eigen::Index i = rank; i-- > 0;) {
        for (Eigen::Index k = i + 1; k < rank; ++k) z(i) -= LU(i, k) * z(k);
        z(i) /= LU(i, i);
    }
    r.setZero();
    for (Eigen::Index i = 0; i < rank; ++i) r(columns(i)) = z(i);
    return rank;
}

/// Columns behind the pivots: motions x with A x = 0 but for the pivots left out.
void find_undamped(const Eigen::FullPivLU<Eigen::MatrixXd>& lu, Eigen::Index rank, Eigen::VectorXd& w, Eigen::MatrixXd& N) {
    const Eigen::MatrixXd& LU = lu.matrixLU();
    const auto& columns = lu.permutationQ().indices();
    N.setZero();
    for (Eigen::Index free = rank; free < LU.cols(); ++free) {
        for (Eigen::Index i = rank; i-- > 0;) {
            w(i) = -LU(i, free);
            for (Eigen::Index k = i + 1; k < rank; ++k) w(i) -= LU(i, k) * w(k);
            w(i) /= LU(i, i);
            N(columns(i), free - rank) = w(i);
        }
        N(columns(free), free - rank) = 1;
    }
}

/// Whether the motion of a massless half at one end of a joint makes a force on one at the other: through a force where the
/// `to` end has no mass, or through a moment where neither has inertia. A frame without inertia is a point, so that a force
/// at a `to` end does not turn it.
bool joins_massless_halves(const Mechanism& mechanism, const MasslessSet& set, const Joint& joint) {
    const int from = set.index_of(mechanism, joint.from()), to = set.index_of(mechanism, joint.to());
    if (from < 0 || to < 0) return false;
    const Directions carried = joint.law().carried();
    return ((carried << 3).any() && set.has_none(as_size(to), 0)) ||
           ((carried >> 3).any() && set.has_none(as_size(from), 1) && set.has_none(as_size(to), 1));
}

}  // namespace

InstantBalances::InstantBalances(const Mechanism& mechanism, const MasslessSet& set) : set_(set) {
    MasslessGroups groups = set.group(mechanism, [&](const Joint& joint) {
        return (joint.rigid().any() || joint.is_damped()) && joins_massless_halves(mechanism, set, joint);
    });
    std::vector<int> number_of(groups.all.size(), -1);
    for (size_t g = 0; g < groups.all.size(); ++g) {
        MasslessGroup& group = groups.all[g];
        const auto is_damped = [&](size_t j) { return mechanism.joints[j].is_damped(); };
        if (group.rigid.empty() && std::ranges::none_of(group.joints, is_damped)) continue;
        number_of[g] = as_int(balances_.size());
        // What a support does to a massless node is the node's own, so are moments at a massless rotation, and balance it
        // first; forces between it and masses are those of masses
        std::ranges::stable_sort(group.rigid, {}, [&](const MasslessRow& row) {
            const Joint& joint = mechanism.joints[row.joint];
            const auto is_ground = [&](int frame) {
                return mechanism.assembly.frames[as_size(frame)].kind == FrameSpec::Kind::ground;
            };
            return is_ground(joint.from()) || is_ground(joint.to()) ? 0 : row.direction >= 3 ? 1 : 2;
        });
        Balance& balance = balances_.emplace_back();
        balance.group = std::move(group);
        const auto motions = as_row(6 * balance.group.frames.size()), rigid = as_row(balance.group.rigid.size()),
                   unknowns = motions + rigid;
        for (Eigen::MatrixXd* matrix : {&balance.matrix, &balance.undamped, &balance.reduced})
            matrix->setZero(unknowns, unknowns);
        for (Eigen::VectorXd* v : {&balance.right_hand_side, &balance.solution}) v->setZero(unknowns);
        for (Eigen::VectorXd* v : {&balance.scale, &balance.follow}) v->setOnes(unknowns);
        balance.stiffness.setZero(motions, motions);
        balance.directions.setZero(motions, rigid);
        balance.lu = Eigen::FullPivLU<Eigen::MatrixXd>(unknowns, unknowns);
    }
    for (int group : groups.of) balance_of_.push_back(number_of[as_size(group)]);
    begin_ = std::move(groups.begin);
}

/// Number of a frame of the mechanism in a balance; −1: it is not there.
int InstantBalances::frame_in(const Mechanism& mechanism, const Balance& balance, int frame) const {
    const int i = set_.index_of(mechanism, frame);
    if (i < 0 || balance_of_[as_size(i)] != &balance - balances_.data()) return -1;
    return begin_[as_size(i)] / 6;
}

/// Of a joint with f = E + c r + q, r its rate and E what else it does: −Σ Gᵀ f + load = 0 on every frame, and no rate in
/// rigid directions. The unknowns are what is to be added to the velocities and to q.
void InstantBalances::add_balance(const Mechanism& mechanism, const Balance& balance, size_t j, const JointPose& pose,
                                  const Acting& acting, const std::vector<double>& q) const {
    const Joint& joint = mechanism.joints[j];
    const auto& [deformation, rate, other] = acting;
    const Vector3 theta = tail(deformation);
    const Vector6 force = other + joint.damping(deformation, rate);
    const Matrix6 per_rate = joint.damping_tangent(deformation),
                  per_deformation = joint.stiffness_tangent(deformation, mechanism.memory_before(j));
    const Matrix6 G[2] = {joint.by_from(pose), joint.by_to(pose)};
    // A lever that is only deformation is left out of the damping, not of the moments of forces
    Matrix6 damped[2] = {G[0], G[1]};
    if (joint.seat().rest.isZero(kSamePoint)) damped[0].topRightCorner<3, 3>().setZero();
    const int frames[2] = {frame_in(mechanism, balance, joint.from()), frame_in(mechanism, balance, joint.to())};
    for (int row : {0, 1}) {
        if (frames[row] < 0) continue;
        balance.right_hand_side.segment<6>(6 * frames[row]) -= G[row].transpose() * force;
        for (int column : {0, 1}) {
            if (frames[column] < 0) continue;
            balance.matrix.block<6, 6>(6 * frames[row], 6 * frames[column]) +=
                damped[row].transpose() * per_rate * damped[column];
            balance.stiffness.block<6, 6>(6 * frames[row], 6 * frames[column]) +=
                damped[row].transpose() * per_deformation * damped[column];
        }
    }
    if (joint.rigid().none()) return;
    const Matrix6 rows[2] = {rigid_rows(joint, theta, G[0]), rigid_rows(joint, theta, G[1])};
    Vector6 opening = rate;
    opening.tail<3>() = joint.opening_of_turn(theta) * rate.tail<3>();
    for (size_t k = 0; k < balance.group.rigid.size(); ++k) {
        const MasslessRow& row = balance.group.rigid[k];
        if (row.joint != j) continue;
        const auto at = as_row(6 * balance.group.frames.size() + k);
        balance.right_hand_side(at) = -opening(row.direction);
        for (int end : {0, 1})
            if (frames[end] >= 0) {
                balance.right_hand_side.segment<6>(6 * frames[end]) -=
                    q[row.index] * rows[end].row(row.direction).transpose();
                balance.matrix.block<1, 6>(at, 6 * frames[end]) += rows[end].row(row.direction);
                balance.matrix.block<6, 1>(6 * frames[end], at) += rows[end].row(row.direction).transpose();
            }
    }
}

/// Rigid directions that say of the massless halves what those before them say are left out: their forces stay as they are
/// known, and which of them balances is not left to rounding.
void InstantBalances::drop_dependent_rows(const Balance& balance) const {
    const auto count = as_row(6 * balance.group.frames.size());
    Eigen::Index kept = 0;
    for (Eigen::Index at = count; at < balance.matrix.rows(); ++at) {
        auto next = balance.directions.col(kept);
        next = balance.matrix.row(at).head(count);
        const double size = next.norm();
        for ([[maybe_unused]] const int round : {0, 1})
            for (Eigen::Index k = 0; k < kept; ++k) next -= balance.directions.col(k).dot(next) * balance.directions.col(k);
        const double left = next.norm();
        if (left > kNextToNothing * size) {
            next /= left;
            ++kept;
            continue;
        }
        balance.matrix.row(at).setZero();
        balance.matrix.col(at).setZero();
        balance.right_hand_side(at) = 0;
    }
}

/// Leaves out halves with a mass, and rigid directions of which nothing but rounding is left then, as of a force along the
/// arm of a point mass; brings the rest to units of what damper and spring do over a step: a weak damper is a small pivot in
/// them. A lever that is rounding gives a rotation no damping of its own: the unit is not taken from that. Only rigid
/// directions hold such a rotation.
void InstantBalances::scale_balance(const Balance& balance, double h) const {
    Eigen::MatrixXd &A = balance.matrix, &K = balance.stiffness;
    Eigen::VectorXd &r = balance.right_hand_side, &d = balance.scale;
    const auto count = as_row(6 * balance.group.frames.size());
    const double lever = kRoundingOfSums * std::max(1.0, balance.farthest);
    for (Eigen::Index i = 0; i < count; ++i) d(i) = A(i, i) + h * K(i, i);
    for (Eigen::Index i = 0; i < count; i += 6) {
        const double least = lever * lever * d.segment<3>(i).maxCoeff();
        for (double& turning : d.segment<3>(i + 3))
            if (turning <= least) turning = 0;
    }
    for (Eigen::Index i = count; i < A.rows(); ++i) d(i) = A.row(i).head(count).norm();
    for (size_t k = 0; k < balance.group.frames.size(); ++k)
        for (int half : {0, 1}) {
            if (set_.has_none(balance.group.frames[k], half)) continue;
            const auto at = as_row(6 * k) + 3 * half;
            A.middleRows<3>(at).setZero();
            A.middleCols<3>(at).setZero();
            K.middleRows<3>(at).setZero();
            K.middleCols<3>(at).setZero();
            r.segment<3>(at).setZero();
            d.segment<3>(at).setZero();
        }
    for (Eigen::Index i = count; i < A.rows(); ++i) {
        if (A.row(i).head(count).norm() > lever * d(i)) continue;
        A.row(i).setZero();
        A.col(i).setZero();
        r(i) = 0;
    }
    double largest[2] = {0, 0};
    for (Eigen::Index i = 0; i < count; ++i) {
        largest[i / 3 % 2] = std::max(largest[i / 3 % 2], d(i));
    }
    for (Eigen::Index i = 0; i < count; ++i) {
        const double size = std::max(d(i), kRoundingOfSums * largest[i / 3 % 2]);
        d(i) = size > 0 ? 1 / std::sqrt(size) : 1;
    }
    for (Eigen::Index i = count; i < A.rows(); ++i) {
        const double size = A.row(i).head(count).cwiseProduct(d.head(count).transpose()).norm();
        d(i) = size > 0 ? 1 / size : 1;
    }
    A.array().colwise() *= d.array();
    A.array().rowwise() *= d.transpose().array();
    K.array().colwise() *= d.head(count).array();
    K.array().rowwise() *= d.head(count).transpose().array();
    r.array() *= d.array();
}

/// Adds to the solution r the motions N z that no damper resists, so that springs do no work on them: Nᵀ K (r + N z) = 0.
void InstantBalances::add_undamped(const Balance& balance, Eigen::Index rank) const {
    Eigen::MatrixXd &N = balance.undamped, &B = balance.reduced;
    Eigen::VectorXd &r = balance.right_hand_side, &z = balance.follow;
    const auto count = as_row(6 * balance.group.frames.size());
    const Eigen::Index free = balance.matrix.rows() - rank;
    find_undamped(balance.lu, rank, balance.solution, N);
    B.setIdentity();  // the rest of the matrix is one, so that its size stays
    for (Eigen::Index i = 0; i < free; ++i) {
        balance.solution.head(count).noalias() = balance.stiffness * N.col(i).head(count);
        for (Eigen::Index k = 0; k < free; ++k) B(k, i) = N.col(k).head(count).dot(balance.solution.head(count));
        z(i) = -r.head(count).dot(balance.solution.head(count));
    }
    z.tail(balance.matrix.rows() - free).setZero();
    balance.lu.compute(B);
    solve_by_rank(balance.lu, kRoundingOfSums, z, balance.solution);
    r.noalias() += N.leftCols(free) * z.head(free);
}

/// By full-pivot elimination: what dampers hold balances by them, the rest keeps what its springs do.
void InstantBalances::solve_balance(const Balance& balance, double h, std::vector<Twist>& velocities,
                                    std::vector<Twist>& corrections, std::vector<double>& q) const {
    Eigen::VectorXd& r = balance.right_hand_side;
    scale_balance(balance, h);
    drop_dependent_rows(balance);
    balance.lu.compute(balance.matrix);
    const Eigen::Index rank = solve_by_rank(balance.lu, kLeastDamping, r, balance.solution);
    if (rank < balance.matrix.rows()) add_undamped(balance, rank);
    r.array() *= balance.scale.array();
    for (size_t k = 0; k < balance.group.frames.size(); ++k) {
        const size_t i = set_.frames()[balance.group.frames[k]];
        corrections[i] = {r.segment<3>(as_row(6 * k)), r.segment<3>(as_row(6 * k + 3))};
        velocities[i].linear += corrections[i].linear;
        velocities[i].angular += corrections[i].angular;
    }
    for (size_t k = 0; k < balance.group.rigid.size(); ++k)
        q[balance.group.rigid[k].index] += r(as_row(6 * balance.group.frames.size() + k));
}

}  // namespace dttmm::plugin
