// SPDX-License-Identifier: BSD-3-Clause
#include "time/slow_motion.h"

#include <algorithm>
#include <utility>

#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// Rate s of the motion [1/s]; 1e-3 to 1e-5 pass the same tests. A spring that makes its frames swing at ω needs about
/// 14/log10(1 + ω²/s²) solutions, and a damper C on a spring K 14/log10(1 + K/(s C)).
constexpr double kRate = 1e-4;

/// Of one joint, in the axes of its frames. tangent: as Joint::stiffness_tangent() has it.
template <class Tangent>
EndBlocks end_blocks(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at, const Tangent& tangent) {
    const Joint& joint = mechanism.joints[j];
    const auto [from, to] = ends(joint, at);
    const JointPose pose = joint.pose(from, to);
    EndBlocks K = joint.stiffness(pose, tangent(joint, joint.deformation(pose, from, to)));
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

EndBlocks springs_of(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at) {
    return end_blocks(mechanism, j, at,
                      [&](const Joint& joint, const Vector6& x) { return joint.stiffness_tangent(x, mechanism.memory(j)); });
}

EndBlocks dampers_of(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at, double rate) {
    return end_blocks(mechanism, j, at,
                      [&](const Joint& joint, const Vector6& x) { return Matrix6(rate * joint.damping_tangent(x)); });
}

EndBlocks dynamic_stiffness(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at, double rate) {
    return end_blocks(mechanism, j, at, [&](const Joint& joint, const Vector6& x) {
        return Matrix6(joint.stiffness_tangent(x, mechanism.memory(j)) + rate * joint.damping_tangent(x));
    });
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
                       std::vector<GivenVelocity> given)
    : inside_(inside), at_(at), given_(std::move(given)), matrix_(pattern) {
    for (size_t j : inside.port_joints)
        at_ports_.push_back({springs_of(inside.mechanism, j, at), dampers_of(inside.mechanism, j, at, kRate)});
    form_dynamic_stiffness(inside, at, kRate, matrix_);
    hold_given();
    if (!matrix_.factor()) return;
    form_dynamic_stiffness(inside, at, kRate, matrix_);
    make_heavier();
    hold_given();
    factor_or_refuse(inside.mechanism, matrix_, DTTMM_ERROR_MODEL);
}

/// Adds to every inertia so much that it shows beside the stiffness that holds its frame: in a slow motion it may otherwise
/// vanish in rounding, and a motion that nothing else resists be undetermined.
void SlowMotion::make_heavier() {
    constexpr double kLeastShare = 1e-9;  // 1e-7 to 1e-11 pass the same tests
    heavier_.assign(inside_.inertias.size(), Vector6::Zero());
    for (size_t i = 0; i < heavier_.size(); ++i) {
        const Matrix6& own = matrix_.diagonal(as_int(i));
        const double shift = own.topLeftCorner<3, 3>().trace(), arm = inside_.reach[i];
        const double held[2] = {shift, std::max(own.bottomRightCorner<3, 3>().trace(), arm * arm * shift)};
        for (int half : {0, 1})
            if (!inside_.massless.is_massless(i, half))
                heavier_[i].segment<3>(3 * half).setConstant(kLeastShare * held[half]);
        matrix_.add_diagonal(as_int(i), heavier_[i].asDiagonal());
    }
}

/// The stiffness of the rows of given velocities.
void SlowMotion::hold_given() {
    constexpr double kHold = 1e4;  // of the stiffest frame: a solution leaves at most 1e-4. 1e2 to 1e8 pass the same tests
    Eigen::Vector2d largest(0, 0);
    for (int i = 0; !given_.empty() && i < inside_.count; ++i) {
        const Matrix6& K = matrix_.diagonal(i);
        largest = largest.cwiseMax(Eigen::Vector2d(K.topLeftCorner<3, 3>().trace(), K.bottomRightCorner<3, 3>().trace()));
    }
    for (double& held : largest)
        if (!(held > 0)) held = 1;
    rows_.clear();
    for (const GivenVelocity& given : given_) {
        const double translation = kHold * largest(0);
        // What holds the translation at a lever turns the frame too, and must not drown what holds the rotation
        const double rotation = std::max(kHold * largest(1), given.offset.squaredNorm() * translation);
        Row& row = rows_.emplace_back();
        // v_node = v − offset × ω in the frame's axes
        row.G.setIdentity();
        row.G.topRightCorner<3, 3>() = -skew(given.offset);
        row.weight << Vector3::Constant(translation), Vector3::Constant(rotation);
        matrix_.add_diagonal(as_int(given.inner), row.G.transpose() * row.weight.asDiagonal() * row.G);
    }
}

/// The load on the inside by the ports; with_dampers: they, too, pull it along.
void SlowMotion::load_by_ports(std::span<const Vector6> motion, bool with_dampers, std::span<Vector6> load,
                               std::span<double> q) const {
    std::ranges::fill(load, Vector6::Zero());
    std::ranges::fill(q, 0.0);
    for (size_t k = 0; k < inside_.port_joints.size(); ++k) {
        const size_t j = inside_.port_joints[k];
        const Joint& joint = inside_.mechanism.joints[j];
        for (int end : {0, 1}) {
            if (joint.frame(end) >= inside_.ports) continue;
            const Vector6& u = motion[as_size(joint.frame(end))];
            if (const int other = joint.frame(1 - end); inside_.is_inner(other)) {
                Vector6& on_other = load[inside_.at(other)];
                on_other -= at_ports_[k].springs.at[1 - end][end] * u;
                if (with_dampers) on_other -= at_ports_[k].dampers.at[1 - end][end] * u;
            }
            for_each_rigid(joint,
                           [&](int i, int) { q[inside_.rigid_row(j, i)] -= matrix_.rigid(as_int(j), i, end).dot(u); });
        }
    }
}

/// What masses, with_dampers: and dampers, would exert on the inside against a motion of it, with the ports at rest. Blocks
/// of dampers are not kept: of a beam of 10 000 lumps they have 12 MB.
void SlowMotion::add_resistance(std::span<const Vector6> motion, bool with_dampers, std::span<Vector6> load) const {
    const Mechanism& mechanism = inside_.mechanism;
    for (size_t i = 0; i < load.size(); ++i) {
        load[i] += kRate * kRate * mass_matrix(inside_.inertias[i]) * motion[i];
        if (!heavier_.empty()) load[i] += heavier_[i].cwiseProduct(motion[i]);
    }
    for (size_t j = 0; with_dampers && j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (!joint.is_damped()) continue;
        const EndBlocks C = dampers_of(mechanism, j, at_, kRate);
        for (int row : {0, 1})
            for (int column : {0, 1})
                if (inside_.is_inner(joint.frame(row)) && inside_.is_inner(joint.frame(column)))
                    load[inside_.at(joint.frame(row))] += C.at[row][column] * motion[inside_.at(joint.frame(column))];
    }
}

/// Of the motions of the inner frames [m/s], rotations at the reach of the frame.
double SlowMotion::largest(std::span<const Vector6> of_inner) const {
    double size = 0;
    for (size_t i = 0; i < of_inner.size(); ++i)
        size = std::max({size, of_inner[i].head<3>().norm(), inside_.reach[i] * of_inner[i].tail<3>().norm()});
    return size;
}

void SlowMotion::follow(std::span<Vector6> motion, std::span<double> q) const {
    std::ranges::fill(inside_.inner(motion), Vector6::Zero());
    settle(false, motion, q);
    if (std::ranges::any_of(inside_.mechanism.joints, &Joint::is_damped)) settle(true, motion, q);
}

/// Repeats the solution about the one before until nothing changes. by_springs: dampers, too, count for the proximal term
/// alone; otherwise masses do.
void SlowMotion::settle(bool by_springs, std::span<Vector6> motion, std::span<double> q) const {
    const auto inner = inside_.inner(motion);
    std::vector<Vector6> next(inner.size()), multipliers(given_.size(), Vector6::Zero());
    double change = 0;
    for (int pass = 0; pass < kMostPassesOfStep; ++pass) {
        load_by_ports(motion, !by_springs, next, q);
        add_resistance(inner, by_springs, next);
        for (size_t k = 0; k < given_.size(); ++k)
            next[given_[k].inner] +=
                rows_[k].G.transpose() * (rows_[k].weight.cwiseProduct(given_[k].value) + multipliers[k]);
        matrix_.solve(next, q);
        for (size_t k = 0; k < given_.size(); ++k)
            multipliers[k] += rows_[k].weight.cwiseProduct(given_[k].value - rows_[k].G * next[given_[k].inner]);
        for (size_t i = 0; i < next.size(); ++i) inner[i] = next[i] - inner[i];
        const double before = std::exchange(change, largest(inner));
        std::ranges::copy(next, inner.begin());
        const double size = largest(inner);
        if (change <= kRoundingOfSums * size) return;
        if (pass > 1 && change > 0.5 * before && change <= kNextToNothing * size) return;  // rounding
    }
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
        // One solution: dampers are to springs as the rate is to theirs
        load_by_ports(motion, true, inside_.inner(motion), q);
        matrix_.solve(inside_.inner(motion), q);
        for (size_t k = 0; k < inside_.port_joints.size(); ++k) {
            const size_t j = inside_.port_joints[k];
            const Joint& joint = inside_.mechanism.joints[j];
            for (int row : {0, 1}) {
                const int frame = joint.frame(row);
                if (frame >= inside_.ports) continue;
                Vector6 force = Vector6::Zero();
                for (int end : {0, 1}) force += at_ports_[k].springs.at[row][end] * motion[as_size(joint.frame(end))];
                for_each_rigid(joint,
                               [&](int i, int) { force += matrix_.rigid(as_int(j), i, row) * q[inside_.rigid_row(j, i)]; });
                S.block<6, 1>(6 * frame, column) += in_world(at_[as_size(frame)], force);
            }
        }
    }
}

}  // namespace dttmm::plugin
