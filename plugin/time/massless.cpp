// SPDX-License-Identifier: BSD-3-Clause
#include "time/massless.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/index.h"
#include "core/rotation.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// Share of a unit force below which it is one of those before.
constexpr double kDependent = 1e-6;
/// A direction is damped if its pivot is more than this share of the largest, in units of c + h k, what damper and spring do
/// over a step. One that is undamped but for a small turn θ of its frames has θ² of the damping, and would get any velocity.
/// Values from 1e-6 to 1e-4 pass the tests of rows; without it one fails, with 1e-2 another.
constexpr double kLeastDamping = 1e-4;
/// Of the largest diagonal, of the largest pivot: rounding.
constexpr double kNothing = 1e-13;
/// A lever [m] of a force on what moves it by one: rounding of places.
constexpr double kRoundingOfLever = 1e-12;
/// Ratios of damping to stiffness that differ by less are one.
constexpr double kSameRatio = 1e-9;

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

}  // namespace

MasslessFrames::MasslessFrames(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless)
    : index_(massless.size(), -1), settling_(mechanism.joints.size(), false), half_way_(mechanism.joints.size(), false) {
    for (size_t i = 0; i < massless.size(); ++i) {
        if (!massless[i][0] && !massless[i][1]) continue;
        index_[i] = as_int(frames_.size());
        frames_.push_back(i);
        massless_.push_back(massless[i]);
    }
    Grouping rigid = group(mechanism, [](const Joint& joint) { return joint.rigid().any(); });
    const std::vector<std::vector<size_t>> joints_of = find_joints(mechanism, rigid);
    clusters_ = std::move(rigid.clusters);
    cluster_of_ = std::move(rigid.cluster_of);
    begin_ = std::move(rigid.begin);
    size_t rigid_count = 0;
    for (const Joint& joint : mechanism.joints) {
        rigid_begin_.push_back(rigid_count);
        rigid_count += joint.rigid().count();
    }
    for (Cluster& cluster : clusters_) {
        cluster.joints = joints_of[as_size(&cluster - clusters_.data())];
        find_rows(mechanism, cluster.joints, cluster);
        const auto size = as_row(6 * cluster.frames.size());
        cluster.basis.setZero(size, size);
        for (Eigen::VectorXd* v : {&cluster.end, &cluster.step, &cluster.half_way}) v->setZero(size);
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            settling_[j] = true;
            const bool has_damped = !clusters_[as_size(cluster_of_[as_size(i)])].damped.empty();
            half_way_[j] = half_way_[j] || (has_damped && mechanism.joints[j].is_damped());
        }
    make_balances(mechanism);
}

/// By union and find.
template <class Joins>
MasslessFrames::Grouping MasslessFrames::group(const Mechanism& mechanism, const Joins& joins) const {
    Grouping grouping;
    std::vector<int> root(frames_.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
        while (root[as_size(i)] != i) i = root[as_size(i)];
        return i;
    };
    for (const Joint& joint : mechanism.joints) {
        const int a = index_of(mechanism, joint.from()), b = index_of(mechanism, joint.to());
        if (a >= 0 && b >= 0 && joins(joint)) root[as_size(find(a))] = find(b);
    }
    grouping.cluster_of.assign(frames_.size(), -1);
    grouping.begin.assign(frames_.size(), 0);
    for (int i = 0; i < as_int(frames_.size()); ++i) {
        int& cluster = grouping.cluster_of[as_size(find(i))];
        if (cluster < 0) {
            cluster = as_int(grouping.clusters.size());
            grouping.clusters.emplace_back();
        }
        grouping.cluster_of[as_size(i)] = cluster;
        Cluster& own = grouping.clusters[as_size(cluster)];
        grouping.begin[as_size(i)] = 6 * as_int(own.frames.size());
        own.frames.push_back(as_size(i));
    }
    return grouping;
}

/// The joints of the frames of every cluster.
std::vector<std::vector<size_t>> MasslessFrames::find_joints(const Mechanism& mechanism, const Grouping& grouping) const {
    std::vector<std::vector<size_t>> joints_of(grouping.clusters.size());
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            std::vector<size_t>& list = joints_of[as_size(grouping.cluster_of[as_size(i)])];
            if (list.empty() || list.back() != j) list.push_back(j);
        }
    return joints_of;
}

/// What find_instant solves for together.
void MasslessFrames::make_balances(const Mechanism& mechanism) {
    balances_ = group(mechanism, [](const Joint& joint) { return joint.rigid().any() || joint.is_damped(); });
    const std::vector<std::vector<size_t>> joints_of = find_joints(mechanism, balances_);
    for (size_t c = 0; c < balances_.clusters.size(); ++c) {
        Cluster& cluster = balances_.clusters[c];
        cluster.joints = joints_of[c];
        find_rows(mechanism, cluster.joints, cluster);
        cluster.is_balanced = !cluster.rigid.empty() ||
                              std::ranges::any_of(cluster.joints, [&](size_t j) { return mechanism.joints[j].is_damped(); });
        if (!cluster.is_balanced) continue;
        const auto unknowns = as_row(6 * cluster.frames.size() + cluster.rigid.size());
        cluster.matrix.setZero(unknowns, unknowns);
        cluster.right_hand_side.setZero(unknowns);
        cluster.solution.setZero(unknowns);
        const auto motions = as_row(6 * cluster.frames.size());
        cluster.stiffness.setZero(motions, motions);
        // Forces at a massless rotation are those of masses, moments are its own: these balance it first
        std::stable_partition(cluster.rigid.begin(), cluster.rigid.end(), [](const Row& row) { return row.direction >= 3; });
        cluster.directions.setZero(motions, as_row(cluster.rigid.size()));
        for (Eigen::VectorXd* v : {&cluster.scale, &cluster.follow}) v->setOnes(unknowns);
        cluster.undamped.setZero(unknowns, unknowns);
        cluster.reduced.setZero(unknowns, unknowns);
        cluster.lu = Eigen::FullPivLU<Eigen::MatrixXd>(unknowns, unknowns);
        has_balances_ = true;
    }
}

/// Rigid directions at the frames of a cluster, and its common ratio of damping to stiffness or else its damped directions.
void MasslessFrames::find_rows(const Mechanism& mechanism, const std::vector<size_t>& joints, Cluster& cluster) const {
    double lowest = INFINITY, highest = 0;
    for (size_t j : joints) {
        const Joint& joint = mechanism.joints[j];
        size_t index = rigid_begin_[j];
        for (int d = 0; d < 6; ++d) {
            const JointHalf& half = d < 3 ? joint.translation_half() : joint.rotation_half();
            const double k = half.stiffness(d % 3), c = half.damping(d % 3);
            if (joint.rigid()[as_size(d)]) {
                cluster.rigid.push_back({j, d, index++});
            } else if (k > 0 || c > 0) {
                lowest = std::min(lowest, c / k);
                highest = std::max(highest, c / k);
                if (c > 0) cluster.damped.push_back({j, d, 0});
            }
        }
    }
    // Where something is rigid, directions that turn against each other take part in one balance: ψ is not the load's alone
    if (cluster.rigid.empty() && std::isfinite(highest) && highest - lowest <= kSameRatio * highest) {
        cluster.relaxation = highest;
        cluster.damped.clear();
    }
}

void MasslessFrames::look(const Mechanism& mechanism) {
    for (Cluster& cluster : clusters_) {
        if (cluster.is_rigid || (cluster.rigid.empty() && cluster.damped.empty())) continue;
        cluster.rank = 0;
        for (const Row& row : cluster.rigid) add_to_basis(mechanism, cluster, row, true);
        cluster.rigid_rank = cluster.rank;
        for (const Row& row : cluster.damped) add_to_basis(mechanism, cluster, row, false);
        if (!mechanism.scheme.is_trapezoidal()) cluster.rigid_rank = cluster.rank;
        int unknowns = 0;
        for (size_t i : cluster.frames) unknowns += 3 * (massless_[i][0] + massless_[i][1]);
        cluster.is_rigid = cluster.rigid_rank == unknowns;
    }
}

/// By Gram and Schmidt, twice.
void MasslessFrames::add_to_basis(const Mechanism& mechanism, Cluster& cluster, const Row& row, bool is_rigid) const {
    if (cluster.rank == cluster.basis.cols()) return;
    auto next = cluster.basis.col(cluster.rank);
    next.setZero();
    const Joint& joint = mechanism.joints[row.joint];
    for (int end : {0, 1}) {
        const int i = index_of(mechanism, end == 0 ? joint.from() : joint.to());
        if (i < 0 || std::ranges::find(cluster.frames, as_size(i)) == cluster.frames.end()) continue;
        Matrix6 G = local_columns(mechanism, row.joint, end);
        if (is_rigid) G = rigid_rows(mechanism, row.joint, G);
        for (int half : {0, 1})
            if (massless_[as_size(i)][as_size(half)])
                next.segment<3>(begin_[as_size(i)] + 3 * half) += G.block<1, 3>(row.direction, 3 * half).transpose();
    }
    const double size = next.norm();
    for ([[maybe_unused]] const int round : {0, 1})
        for (int k = 0; k < cluster.rank; ++k) next -= cluster.basis.col(k).dot(next) * cluster.basis.col(k);
    const double left = next.norm();
    if (!(left > kDependent * size)) return;
    next /= left;
    ++cluster.rank;
}

/// Number of a frame of the mechanism in a cluster; −1: it is not there.
int MasslessFrames::frame_in(const Mechanism& mechanism, const Cluster& cluster, int frame) const {
    const int i = index_of(mechanism, frame);
    if (i < 0 || &balances_.clusters[as_size(balances_.cluster_of[as_size(i)])] != &cluster) return -1;
    return balances_.begin[as_size(i)] / 6;
}

/// Of a joint with f = E + c r + q, r its rate and E what else it does: −Σ Gᵀ f + load = 0 on every frame, and no rate in
/// rigid directions. The unknowns are what is to be added to the velocities and to q.
void MasslessFrames::add_balance(const Mechanism& mechanism, const Cluster& cluster, size_t j, const JointPose& pose,
                                 const Acting& acting, const std::vector<double>& q) const {
    const Joint& joint = mechanism.joints[j];
    const auto& [deformation, rate, other] = acting;
    const Vector3 theta = tail(deformation);
    const Vector6 force = other + joint.damping(deformation, rate);
    const Matrix6 per_rate = joint.damping_tangent(deformation),
                  per_deformation = joint.stiffness_tangent(deformation, mechanism.memory_before(j));
    Matrix6 G[2] = {joint.by_from(pose), joint.by_to(pose)};
    // A lever that is deformation alone damps no rotation to speak of
    if (joint.seat().rest.isZero(1e-9)) G[0].topRightCorner<3, 3>().setZero();
    const int frames[2] = {frame_in(mechanism, cluster, joint.from()), frame_in(mechanism, cluster, joint.to())};
    for (int row : {0, 1}) {
        if (frames[row] < 0) continue;
        cluster.right_hand_side.segment<6>(6 * frames[row]) -= G[row].transpose() * force;
        for (int column : {0, 1}) {
            if (frames[column] < 0) continue;
            cluster.matrix.block<6, 6>(6 * frames[row], 6 * frames[column]) += G[row].transpose() * per_rate * G[column];
            cluster.stiffness.block<6, 6>(6 * frames[row], 6 * frames[column]) +=
                G[row].transpose() * per_deformation * G[column];
        }
    }
    if (joint.rigid().none()) return;
    const Matrix6 rows[2] = {rigid_rows(theta, G[0]), rigid_rows(theta, G[1])};
    Vector6 opening = rate;
    opening.tail<3>() = (rotation_vector_rate(theta) * rate.tail<3>()).eval();
    for (size_t k = 0; k < cluster.rigid.size(); ++k) {
        const Row& row = cluster.rigid[k];
        if (row.joint != j) continue;
        const auto at = as_row(6 * cluster.frames.size() + k);
        cluster.right_hand_side(at) = -opening(row.direction);
        for (int end : {0, 1})
            if (frames[end] >= 0) {
                cluster.right_hand_side.segment<6>(6 * frames[end]) -=
                    q[row.index] * rows[end].row(row.direction).transpose();
                cluster.matrix.block<1, 6>(at, 6 * frames[end]) += rows[end].row(row.direction);
                cluster.matrix.block<6, 1>(6 * frames[end], at) += rows[end].row(row.direction).transpose();
            }
    }
}

/// Rigid directions that say of the massless halves what those before them say are left out: their forces stay as they are
/// known, and which of them balances is not left to rounding.
void MasslessFrames::drop_dependent_rows(const Cluster& cluster) const {
    const auto count = as_row(6 * cluster.frames.size());
    Eigen::Index kept = 0;
    for (Eigen::Index at = count; at < cluster.matrix.rows(); ++at) {
        auto next = cluster.directions.col(kept);
        next = cluster.matrix.row(at).head(count);
        const double size = next.norm();
        for ([[maybe_unused]] const int round : {0, 1})
            for (Eigen::Index k = 0; k < kept; ++k) next -= cluster.directions.col(k).dot(next) * cluster.directions.col(k);
        const double left = next.norm();
        if (left > kDependent * size) {
            next /= left;
            ++kept;
            continue;
        }
        cluster.matrix.row(at).setZero();
        cluster.matrix.col(at).setZero();
        cluster.right_hand_side(at) = 0;
    }
}

/// Leaves out halves with a mass, and rigid directions of which nothing but rounding is left then, as of a force along the
/// arm of a point mass; brings the rest to units of what damper and spring do over a step: a weak damper is a small pivot in
/// them.
void MasslessFrames::scale_balance(const Cluster& cluster, double h) const {
    Eigen::MatrixXd &A = cluster.matrix, &K = cluster.stiffness;
    Eigen::VectorXd &r = cluster.right_hand_side, &d = cluster.scale;
    const auto count = as_row(6 * cluster.frames.size());
    for (Eigen::Index i = count; i < A.rows(); ++i) d(i) = A.row(i).head(count).norm();
    for (size_t k = 0; k < cluster.frames.size(); ++k)
        for (int half : {0, 1}) {
            if (massless_[cluster.frames[k]][as_size(half)]) continue;
            const auto at = as_row(6 * k) + 3 * half;
            A.middleRows<3>(at).setZero();
            A.middleCols<3>(at).setZero();
            K.middleRows<3>(at).setZero();
            K.middleCols<3>(at).setZero();
            r.segment<3>(at).setZero();
        }
    for (Eigen::Index i = count; i < A.rows(); ++i) {
        if (A.row(i).head(count).norm() > kRoundingOfLever * d(i)) continue;
        A.row(i).setZero();
        A.col(i).setZero();
        r(i) = 0;
    }
    double largest[2] = {0, 0};
    for (Eigen::Index i = 0; i < count; ++i) {
        double& of_half = largest[i / 3 % 2];
        of_half = std::max(of_half, A(i, i) + h * K(i, i));
    }
    for (Eigen::Index i = 0; i < count; ++i) {
        const double size = std::max(A(i, i) + h * K(i, i), kNothing * largest[i / 3 % 2]);
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
void MasslessFrames::add_undamped(const Cluster& cluster, Eigen::Index rank) const {
    Eigen::MatrixXd &N = cluster.undamped, &B = cluster.reduced;
    Eigen::VectorXd &r = cluster.right_hand_side, &z = cluster.follow;
    const auto count = as_row(6 * cluster.frames.size());
    const Eigen::Index free = cluster.matrix.rows() - rank;
    find_undamped(cluster.lu, rank, cluster.solution, N);
    B.setIdentity();  // the rest of the matrix is one, so that its size stays
    for (Eigen::Index i = 0; i < free; ++i) {
        cluster.solution.head(count).noalias() = cluster.stiffness * N.col(i).head(count);
        for (Eigen::Index k = 0; k < free; ++k) B(k, i) = N.col(k).head(count).dot(cluster.solution.head(count));
        z(i) = -r.head(count).dot(cluster.solution.head(count));
    }
    z.tail(cluster.matrix.rows() - free).setZero();
    cluster.lu.compute(B);
    solve_by_rank(cluster.lu, kNothing, z, cluster.solution);
    r.noalias() += N.leftCols(free) * z.head(free);
}

/// By full-pivot elimination: what dampers hold balances by them, the rest keeps what its springs do.
void MasslessFrames::solve_balance(const Cluster& cluster, double h, std::vector<Twist>& velocities,
                                   std::vector<Twist>& corrections, std::vector<double>& q) const {
    Eigen::VectorXd& r = cluster.right_hand_side;
    scale_balance(cluster, h);
    drop_dependent_rows(cluster);
    cluster.lu.compute(cluster.matrix);
    const Eigen::Index rank = solve_by_rank(cluster.lu, kLeastDamping, r, cluster.solution);
    if (rank < cluster.matrix.rows()) add_undamped(cluster, rank);
    r.array() *= cluster.scale.array();
    for (size_t k = 0; k < cluster.frames.size(); ++k) {
        const size_t i = frames_[cluster.frames[k]];
        corrections[i] = {r.segment<3>(as_row(6 * k)), r.segment<3>(as_row(6 * k + 3))};
        velocities[i].linear += corrections[i].linear;
        velocities[i].angular += corrections[i].angular;
    }
    for (size_t k = 0; k < cluster.rigid.size(); ++k) q[cluster.rigid[k].index] += r(as_row(6 * cluster.frames.size() + k));
}

void MasslessFrames::combine(std::span<Residual> residuals) const {
    for (const Cluster& cluster : clusters_) {
        if (cluster.is_rigid) continue;
        for (size_t k = 0; k < cluster.frames.size(); ++k) {
            const Residual& own = residuals[cluster.frames[k]];
            cluster.end.segment<6>(as_row(6 * k)) = own.end;
            cluster.step.segment<6>(as_row(6 * k)) = own.step - own.end;
            cluster.half_way.segment<6>(as_row(6 * k)) = own.half_way - own.end;
        }
        for (int k = 0; k < cluster.rank; ++k) {
            const auto direction = cluster.basis.col(k);
            cluster.end += direction.dot(k < cluster.rigid_rank ? cluster.step : cluster.half_way) * direction;
        }
        for (size_t k = 0; k < cluster.frames.size(); ++k)
            for (int half : {0, 1})
                if (massless_[cluster.frames[k]][as_size(half)])
                    residuals[cluster.frames[k]].step.segment<3>(3 * half) =
                        cluster.end.segment<3>(as_row(6 * k) + 3 * half);
    }
}

}  // namespace dttmm::plugin
