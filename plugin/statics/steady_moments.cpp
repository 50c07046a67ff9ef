// SPDX-License-Identifier: BSD-3-Clause
#include "statics/steady_moments.h"

#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

void SteadyMoments::clear() {
    frames_.clear();
    moments_.clear();
}

void SteadyMoments::add(int frame, const Vector3& moment) {
    if (moment.isZero(0)) return;
    frames_.push_back(frame);
    moments_.push_back(moment);
}

Eigen::VectorXd SteadyMoments::turns(std::span<const Vector6> u) const {
    Eigen::VectorXd turns(3 * as_row(frames_.size()));
    for (size_t k = 0; k < frames_.size(); ++k) turns.segment<3>(3 * as_row(k)) = u[as_size(frames_[k])].tail<3>();
    return turns;
}

void SteadyMoments::form(const Elimination& matrix, size_t frame_count) {
    if (frames_.empty()) return;
    const auto n = 3 * as_row(frames_.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n), C(n, n);
    columns_.resize(as_size(n));
    for (Eigen::Index c = 0; c < n; ++c) {
        Column& column = columns_[as_size(c)];
        column.u.assign(frame_count, Vector6::Zero());
        column.q.assign(as_size(matrix.rigid_count()), 0.0);
        column.u[as_size(frames_[as_size(c / 3)])](3 + c % 3) = 1;
        matrix.solve(column.u, column.q);
        C.col(c) = turns(column.u);
    }
    for (size_t k = 0; k < moments_.size(); ++k) A.block<3, 3>(3 * as_row(k), 3 * as_row(k)) = -0.5 * skew(moments_[k]);
    answer_ = (Eigen::MatrixXd::Identity(n, n) + A * C).fullPivLu().solve(A);
}

void SteadyMoments::solve(const Elimination& matrix, std::span<Vector6> r, std::span<double> g) const {
    matrix.solve(r, g);
    if (frames_.empty()) return;
    const Eigen::VectorXd shares = answer_ * turns(r);
    for (Eigen::Index c = 0; c < shares.size(); ++c) {
        const Column& column = columns_[as_size(c)];
        for (size_t i = 0; i < r.size(); ++i) r[i] -= shares(c) * column.u[i];
        for (size_t i = 0; i < g.size(); ++i) g[i] -= shares(c) * column.q[i];
    }
}

}  // namespace dttmm::plugin
