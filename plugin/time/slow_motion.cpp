// SPDX-License-Identifier: BSD-3-Clause
#include "time/slow_motion.h"

#include <algorithm>

#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// So slow [1/s] that springs alone resist; 1e-2 to 1e-6 pass the same tests.
constexpr double kSlowRate = 1e-4;

/// Of one joint, in the axes of its frames.
EndBlocks dynamic_stiffness(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at, double rate) {
    const Joint& joint = mechanism.joints[j];
    const auto [from, to] = ends(joint, at);
    const JointPose pose = joint.pose(from, to);
    const Vector6 x = joint.deformation(pose, from, to);
    EndBlocks K = joint.stiffness(pose, joint.stiffness_tangent(x, mechanism.memory(j)) + rate * joint.damping_tangent(x));
    const Matrix3 R[2] = {from.axes(), to.axes()};
    for (int i : {0, 1})
        for (int k : {0, 1})
            for (int row : {0, 3})
                for (int column : {0, 3}) {
                    auto block = K.at[i][k].block<3, 3>(row, column);
                    block = (R[i].transpose() * block * R[k]).eval();
                }
    return K;
}

/// Adds to every inertia so much that it shows beside the stiffness that holds its frame: in a slow motion it may otherwise
/// vanish in rounding, and a motion that nothing else resists be undetermined.
void make_heavier(const Inside& inside, Elimination& matrix) {
    constexpr double kLeastShare = 1e-9;  // with 1e-11 rigid directions are lost to 1e-3 in rods of a centimetre
    for (int i = 0; i < inside.count; ++i) {
        const Matrix6 own = matrix.diagonal(i);
        const double shift = own.topLeftCorner<3, 3>().trace(), arm = inside.reach[as_size(i)];
        const double held[2] = {shift, std::max(own.bottomRightCorner<3, 3>().trace(), arm * arm * shift)};
        Vector6 more = Vector6::Zero();
        for (int half : {0, 1})
            if (!inside.massless.is_massless(as_size(i), half))
                more.segment<3>(3 * half).setConstant(kLeastShare * held[half]);
        matrix.add_diagonal(i, more.asDiagonal());
    }
}

}  // namespace

void form_dynamic_stiffness(const Inside& inside, const std::vector<Frame>& at, double rate, Elimination& matrix) {
    const Mechanism& mechanism = inside.mechanism;
    matrix.set_zero();
    for (int i = 0; i < inside.count; ++i) matrix.add_diagonal(i, rate * rate * mass_matrix(inside.inertias[as_size(i)]));
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const EndBlocks K = dynamic_stiffness(mechanism, j, at, rate);
        const int frames[2] = {joint.from(), joint.to()};
        for (int end : {0, 1})
            if (inside.is_inner(frames[end])) matrix.add_diagonal(frames[end] - inside.driven, K.at[end][end]);
        if (inside.is_inner(frames[0]) && inside.is_inner(frames[1])) matrix.add_coupling(as_int(j), K.at[0][1]);
        if (joint.rigid().any()) set_rigid_rows(mechanism, j, at, matrix);
    }
}

SlowMotion::SlowMotion(const Inside& inside, const Elimination& pattern, const std::vector<Frame>& at,
                       const std::function<void(Elimination&)>& hold)
    : inside_(inside), at_(at), matrix_(pattern) {
    for (size_t j : inside.port_joints) at_ports_.push_back(dynamic_stiffness(inside.mechanism, j, at, kSlowRate));
    form_dynamic_stiffness(inside, at, kSlowRate, matrix_);
    hold(matrix_);
    if (!matrix_.factor()) return;
    form_dynamic_stiffness(inside, at, kSlowRate, matrix_);
    make_heavier(inside, matrix_);
    hold(matrix_);
    factor_or_refuse(inside.mechanism, matrix_, DTTMM_ERROR_SINGULAR);
}

void SlowMotion::follow(std::span<Vector6> motion, std::span<double> q) const {
    const auto inner = inside_.inner(motion);
    std::ranges::fill(q, 0.0);
    for (size_t k = 0; k < inside_.port_joints.size(); ++k) {
        const size_t j = inside_.port_joints[k];
        const Joint& joint = inside_.mechanism.joints[j];
        for (int end : {0, 1}) {
            if (joint.frame(end) >= inside_.ports) continue;
            const Vector6& u = motion[as_size(joint.frame(end))];
            const int other = joint.frame(1 - end);
            if (inside_.is_inner(other)) inner[inside_.at(other)] -= at_ports_[k].at[1 - end][end] * u;
            for_each_rigid(joint,
                           [&](int i, int) { q[inside_.rigid_row(j, i)] -= matrix_.rigid(as_int(j), i, end).dot(u); });
        }
    }
    matrix_.solve(inner, q);
}

void SlowMotion::write_stiffness(double* stiffness) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * inside_.ports, 6 * inside_.ports);
    S.setZero();
    std::vector<Vector6> motion(at_.size());
    std::vector<double> q(inside_.rigid.size());
    for (int column = 0; column < 6 * inside_.ports; ++column) {
        std::ranges::fill(motion, Vector6::Zero());
        const auto port = as_size(column / 6);
        motion[port] = in_axes(at_[port], Vector6::Unit(column % 6));
        follow(motion, q);
        for (size_t k = 0; k < inside_.port_joints.size(); ++k) {
            const size_t j = inside_.port_joints[k];
            const Joint& joint = inside_.mechanism.joints[j];
            for (int row : {0, 1}) {
                const int frame = joint.frame(row);
                if (frame >= inside_.ports) continue;
                Vector6 force = Vector6::Zero();
                for (int end : {0, 1}) force += at_ports_[k].at[row][end] * motion[as_size(joint.frame(end))];
                for_each_rigid(joint,
                               [&](int i, int) { force += matrix_.rigid(as_int(j), i, row) * q[inside_.rigid_row(j, i)]; });
                S.block<6, 1>(6 * frame, column) += in_world(at_[as_size(frame)], force);
            }
        }
    }
}

}  // namespace dttmm::plugin
