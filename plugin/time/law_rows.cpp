// SPDX-License-Identifier: BSD-3-Clause
#include "time/law_rows.h"

#include <algorithm>
#include <cmath>

#include "core/index.h"
#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

LawRows::LawRows(const Mechanism& mechanism, int driven) {
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const auto inner = [&](int frame) { return frame >= driven ? frame - driven : -1; };
        for (int d = 0; d < 6; ++d)
            if (joint.law().laws[as_size(d)])
                rows_.push_back({j, d, {inner(joint.from()), inner(joint.to())}, {Vector6::Zero(), Vector6::Zero()}, 0});
    }
    // Measured: 3.3 ns a step times the cube of the rows; without them some passes more, about 0.5 us for a frame
    constexpr double kCubePerFrame = 150;
    const auto count = static_cast<double>(rows_.size());
    is_cheap_ = count * count * count <= kCubePerFrame * mechanism.assembly.inner_count();
    if (rows_.size() > kMostRows) rows_.clear();
    const auto n = as_row(rows_.size());
    for (Eigen::VectorXd* list : {&start_, &base_, &wanted_, &z_, &change_, &psi_, &slope_, &lack_}) list->setZero(n);
    for (Eigen::MatrixXd* matrix : {&compliance_, &newton_}) matrix->setZero(n, n);
    if (n > 0) factor_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
    size_t rigid = 0;
    for (const Joint& joint : mechanism.joints) rigid += joint.rigid().count();
    responses_.reserve(rows_.size() * as_size(mechanism.assembly.inner_count()));
    rigid_responses_.reserve(rows_.size() * rigid);
}

void LawRows::form(const Mechanism& mechanism, const std::vector<Frame>& at) {
    for (Row& row : rows_) {
        const Joint& joint = mechanism.joints[row.joint];
        const FrameView from = at[as_size(joint.from())], to = at[as_size(joint.to())];
        const JointPose pose = joint.pose(from, to);
        const Vector6 x = joint.deformation(pose, from, to);
        for (int end : {0, 1}) {
            Matrix6 G = local_columns(joint, pose, end, mechanism.frame(joint.frame(end)));
            G.bottomRows<3>() = (rotation_vector_rate(x.tail<3>()) * G.bottomRows<3>()).eval();
            row.G[end] = G.row(row.direction);
        }
        row.gain = joint
                       .on_path(mechanism.scheme, row.direction, mechanism.states[row.joint].deformation()(row.direction),
                                x(row.direction), mechanism.memory(row.joint))
                       .gain;
    }
}

void LawRows::find_responses(const Elimination& matrix, double step_size, std::vector<Vector6>& u, std::vector<double>& q) {
    h_ = step_size;
    frames_ = u.size();
    rigid_ = q.size();
    responses_.resize(rows_.size() * frames_);
    rigid_responses_.resize(rows_.size() * rigid_);
    for (size_t c = 0; c < rows_.size(); ++c) {
        std::fill(u.begin(), u.end(), Vector6::Zero());
        std::fill(q.begin(), q.end(), 0.0);
        for (int end : {0, 1})
            if (rows_[c].frame[end] >= 0) u[as_size(rows_[c].frame[end])] += rows_[c].G[end];
        matrix.solve(u, q);
        std::copy(u.begin(), u.end(), responses_.begin() + as_row(c * frames_));
        std::copy(q.begin(), q.end(), rigid_responses_.begin() + as_row(c * rigid_));
        for (size_t r = 0; r < rows_.size(); ++r) {
            double sum = 0;
            for (int end : {0, 1})
                if (rows_[r].frame[end] >= 0) sum += rows_[r].G[end].dot(u[as_size(rows_[r].frame[end])]);
            compliance_(as_row(r), as_row(c)) = h_ * h_ * sum;
        }
    }
}

Joint::OnPath LawRows::on_path(const Mechanism& mechanism, Eigen::Index r, double z) const {
    const Row& row = rows_[as_size(r)];
    const double now = mechanism.states[row.joint].deformation()(row.direction);
    return mechanism.joints[row.joint].on_path(mechanism.scheme, row.direction, now, start_(r) + z,
                                               mechanism.memory(row.joint));
}

/// Where the laws are, and what they are asked for.
void LawRows::look(const Mechanism& mechanism, const std::vector<Frame>& trial, std::span<const Vector6> change) {
    for (Eigen::Index r = 0; r < start_.size(); ++r) {
        const Row& row = rows_[as_size(r)];
        const Joint& joint = mechanism.joints[row.joint];
        const FrameView from = trial[as_size(joint.from())], to = trial[as_size(joint.to())];
        start_(r) = joint.deformation(joint.pose(from, to), from, to)(row.direction);
        base_(r) = on_path(mechanism, r, 0).force;
        wanted_(r) = 0;
        for (int end : {0, 1})
            if (row.frame[end] >= 0) wanted_(r) += h_ * row.G[end].dot(change[as_size(row.frame[end])]);
    }
}

/// What z lacks of the motion wanted, with the laws there.
void LawRows::find_lack(const Mechanism& mechanism) {
    for (Eigen::Index r = 0; r < z_.size(); ++r) {
        const Joint::OnPath path = on_path(mechanism, r, z_(r));
        const double gain = rows_[as_size(r)].gain;
        psi_(r) = path.force - base_(r) - gain * z_(r);
        slope_(r) = path.gain - gain;
    }
    lack_ = wanted_ - z_;
    lack_.noalias() -= compliance_ * psi_;
}

/// Newton's iteration for z, until its last digits no longer fall. A correction that makes it worse, as across the kink of a
/// law, is halved until it does not: a small enough part of it never does.
bool LawRows::solve(const Mechanism& mechanism) {
    z_.setZero();
    find_lack(mechanism);
    for (int pass = 0; pass < kMostPassesOfStep; ++pass) {
        newton_ = compliance_ * slope_.asDiagonal();
        newton_.diagonal().array() += 1;
        factor_.compute(newton_);
        change_ = factor_.solve(lack_);
        if (!change_.allFinite()) return false;
        const double lacking = lack_.norm();
        for (z_ += change_;; z_ -= change_) {
            find_lack(mechanism);
            if (lack_.norm() < lacking) break;
            if (change_.norm() <= kRoundingOfSums * (start_.norm() + z_.norm() + wanted_.norm())) return true;
            change_ *= 0.5;
        }
    }
    return false;
}

void LawRows::correct(const Mechanism& mechanism, const std::vector<Frame>& trial, std::span<Vector6> change,
                      std::span<double> q_change, std::vector<double>& psi) {
    if (rows_.empty()) return;
    look(mechanism, trial, change);
    std::fill(psi.begin(), psi.end(), 0.0);
    if (!solve(mechanism)) return;
    for (size_t c = 0; c < rows_.size(); ++c) {
        psi[c] = psi_(as_row(c));
        for (size_t i = 0; i < frames_; ++i) change[i] -= h_ * psi[c] * responses_[c * frames_ + i];
        for (size_t i = 0; i < rigid_; ++i) q_change[i] -= h_ * psi[c] * rigid_responses_[c * rigid_ + i];
    }
}

void LawRows::add_force(size_t joint, const std::vector<double>& psi, Vector6& on_from, Vector6& on_to) const {
    for (size_t r = 0; r < rows_.size(); ++r) {
        if (rows_[r].joint != joint) continue;
        on_from -= psi[r] * rows_[r].G[0];
        on_to += psi[r] * rows_[r].G[1];
    }
}

}  // namespace dttmm::plugin
