// SPDX-License-Identifier: BSD-3-Clause
#include "network/massless.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "network/interior_parts.h"

namespace dttmm {

namespace {

/// Share of a unit force below which it is one of those before.
constexpr double kDependent = 1e-6;
/// Ratios of damping to stiffness that differ by less are one.
constexpr double kSameRatio = 1e-9;

}  // namespace

MasslessFrames::MasslessFrames(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless)
    : index_(massless.size(), -1), settling_(mechanism.joints.size(), false), half_way_(mechanism.joints.size(), false) {
    for (size_t i = 0; i < massless.size(); ++i) {
        if (!massless[i][0] && !massless[i][1]) continue;
        index_[i] = static_cast<int>(frames_.size());
        frames_.push_back(i);
        massless_.push_back(massless[i]);
    }
    make_clusters(mechanism);
    std::vector<std::vector<size_t>> joints_of(clusters_.size());
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            std::vector<size_t>& list = joints_of[static_cast<size_t>(cluster_of_[static_cast<size_t>(i)])];
            if (list.empty() || list.back() != j) list.push_back(j);
        }
    for (Cluster& cluster : clusters_) {
        find_rows(mechanism, joints_of[static_cast<size_t>(&cluster - clusters_.data())], cluster);
        const auto size = static_cast<Eigen::Index>(6 * cluster.frames.size());
        cluster.basis.setZero(size, size);
        for (Eigen::VectorXd* v : {&cluster.end, &cluster.step, &cluster.half_way}) v->setZero(size);
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            settling_[j] = true;
            const bool has_damped = !clusters_[static_cast<size_t>(cluster_of_[static_cast<size_t>(i)])].damped.empty();
            half_way_[j] = half_way_[j] || (has_damped && mechanism.joints[j].is_damped());
        }
}

/// The massless frames in clusters, by union and find over the joints that are rigid in some direction.
void MasslessFrames::make_clusters(const Mechanism& mechanism) {
    std::vector<int> root(frames_.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
        while (root[static_cast<size_t>(i)] != i) i = root[static_cast<size_t>(i)];
        return i;
    };
    for (const Joint& joint : mechanism.joints) {
        const int a = index_of(mechanism, joint.from()), b = index_of(mechanism, joint.to());
        if (joint.rigid().any() && a >= 0 && b >= 0) root[static_cast<size_t>(find(a))] = find(b);
    }
    cluster_of_.assign(frames_.size(), -1);
    begin_.assign(frames_.size(), 0);
    for (int i = 0; i < static_cast<int>(frames_.size()); ++i) {
        int& cluster = cluster_of_[static_cast<size_t>(find(i))];
        if (cluster < 0) {
            cluster = static_cast<int>(clusters_.size());
            clusters_.emplace_back();
        }
        cluster_of_[static_cast<size_t>(i)] = cluster;
        Cluster& own = clusters_[static_cast<size_t>(cluster)];
        begin_[static_cast<size_t>(i)] = 6 * static_cast<int>(own.frames.size());
        own.frames.push_back(static_cast<size_t>(i));
    }
}

/// Rigid directions at the frames of a cluster, and its common ratio of damping to stiffness or else its damped directions.
void MasslessFrames::find_rows(const Mechanism& mechanism, const std::vector<size_t>& joints, Cluster& cluster) {
    double lowest = INFINITY, highest = 0;
    for (size_t j : joints) {
        const Joint& joint = mechanism.joints[j];
        for (int d = 0; d < 6; ++d) {
            const JointHalf& half = d < 3 ? joint.translation_half() : joint.rotation_half();
            const double k = half.stiffness(d % 3), c = half.damping(d % 3);
            if (joint.rigid()[static_cast<size_t>(d)]) {
                cluster.rigid.push_back({j, d});
            } else if (k > 0 || c > 0) {
                lowest = std::min(lowest, c / k);
                highest = std::max(highest, c / k);
                if (c > 0) cluster.damped.push_back({j, d});
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
        if (i < 0 || std::ranges::find(cluster.frames, static_cast<size_t>(i)) == cluster.frames.end()) continue;
        Matrix6 G = local_columns(mechanism, row.joint, end);
        if (is_rigid) G = rigid_rows(mechanism, row.joint, G);
        for (int half : {0, 1})
            if (massless_[static_cast<size_t>(i)][static_cast<size_t>(half)])
                next.segment<3>(begin_[static_cast<size_t>(i)] + 3 * half) +=
                    G.block<1, 3>(row.direction, 3 * half).transpose();
    }
    const double size = next.norm();
    for ([[maybe_unused]] const int round : {0, 1})
        for (int k = 0; k < cluster.rank; ++k) next -= cluster.basis.col(k).dot(next) * cluster.basis.col(k);
    const double left = next.norm();
    if (!(left > kDependent * size)) return;
    next /= left;
    ++cluster.rank;
}

void MasslessFrames::combine(std::span<Residual> residuals) const {
    for (const Cluster& cluster : clusters_) {
        if (cluster.is_rigid) continue;
        for (size_t k = 0; k < cluster.frames.size(); ++k) {
            const Residual& own = residuals[cluster.frames[k]];
            cluster.end.segment<6>(static_cast<Eigen::Index>(6 * k)) = own.end;
            cluster.step.segment<6>(static_cast<Eigen::Index>(6 * k)) = own.step - own.end;
            cluster.half_way.segment<6>(static_cast<Eigen::Index>(6 * k)) = own.half_way - own.end;
        }
        for (int k = 0; k < cluster.rank; ++k) {
            const auto direction = cluster.basis.col(k);
            cluster.end += direction.dot(k < cluster.rigid_rank ? cluster.step : cluster.half_way) * direction;
        }
        for (size_t k = 0; k < cluster.frames.size(); ++k)
            for (int half : {0, 1})
                if (massless_[cluster.frames[k]][static_cast<size_t>(half)])
                    residuals[cluster.frames[k]].step.segment<3>(3 * half) =
                        cluster.end.segment<3>(static_cast<Eigen::Index>(6 * k) + 3 * half);
    }
}

}  // namespace dttmm
