// SPDX-License-Identifier: BSD-3-Clause
#include "time/interior_matrix.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

namespace {

/// Share by which a joint at a port may have turned against its frames since the matrix was formed. Less than kSmallTurn: as
/// k h²/m of a stiff hinge is in the thousands, so is the error of the force on the ports.
constexpr double kTurnedPorts = 1e-4;

}  // namespace

InteriorMatrix::InteriorMatrix(Inside& inside)
    : inside_(inside),
      elimination_(inside.count, links_of(inside.mechanism), least_lever(inside.mechanism)),
      laws_(inside.mechanism, inside.driven),
      near_blocks_(inside.near_joints.size()),
      near_columns_(inside.near_joints.size()) {
    rigid_responses_.setZero(elimination_.rigid_count(), 6 * inside.ports);
}

void InteriorMatrix::make_room_for_steps() { responses_.assign(36 * as_size(inside_.count) * as_size(inside_.ports), 0); }

// ---- Forming it ---------------------------------------------------------------------------------------------------------

/// h² times −∂(wrench over a step)/∂(pose at its end) of a joint's frames, in their axes at t_n, when `at` has them at its
/// end: what is elastic or damped, and what stems from forces that act at t_n, which turn with the joint.
InteriorMatrix::Blocks InteriorMatrix::blocks(size_t j, const std::vector<Frame>& at) const {
    const Mechanism& mechanism = inside_.mechanism;
    const Joint& joint = mechanism.joints[j];
    const JointState& state = mechanism.states[j];
    const double weight = mechanism.scheme.elastic_weight(0);
    const Vector6 x = state.deformation(), springs = weight * joint.springs().along(x);
    const Vector3 laws =
        weight * (mechanism.pose(j).axes.transpose() * state.elastic.force) - joint.spread(x, springs).head<3>();
    const PlacedJoint placed(joint, ends(joint, at));
    return {in_frames(j, joint.stiffness(placed.pose, gain(j, placed.x))),
            turning(j, placed, springs, placed.pose.axes * laws, inside_.rigid)};
}

/// The same at the trial, under the forces there.
InteriorMatrix::Blocks InteriorMatrix::blocks_at_trial(size_t j) const {
    const Mechanism& mechanism = inside_.mechanism;
    const Joint& joint = mechanism.joints[j];
    const JointState& state = mechanism.states[j];
    const PlacedJoint placed(joint, ends(joint, inside_.trial));
    const Vector6 springs = mechanism.scheme.elastic_weight(0) * joint.springs().along(placed.x);
    const Joint::Strained strained = joint.strain(mechanism.scheme, placed.at, placed.pose, state, mechanism.memory(j));
    const JointForce force =
        joint.weigh(mechanism.scheme, strained, placed.pose, state, mechanism.damper(j), mechanism.memory(j));
    const Vector3 others = force.force - state.known.force - placed.pose.axes * joint.spread(placed.x, springs).head<3>();
    return {in_frames(j, joint.stiffness(placed.pose, gain(j, strained.deformation()))),
            turning(j, placed, springs, others, inside_.trial_q)};
}

/// What stems from forces that turn with a joint: of its springs along their strains, of rigid directions with q, both with
/// their moments; of others (laws, dampers) the force alone. Symmetric: where forces balance the sum over all joints is.
EndBlocks InteriorMatrix::turning(size_t j, const PlacedJoint& placed, const Vector6& springs, const Vector3& others,
                                  const std::vector<double>& q) const {
    const Joint& joint = placed.joint;
    Vector6 rigid = Vector6::Zero();
    if (joint.rigid().any()) rigid = inside_.mechanism.scheme.elastic_weight(0) * inside_.rigid_values(j, q);
    const EndBlocks own = turning_stiffness(placed, springs, rigid, spread_tangent(placed, springs, rigid));
    EndBlocks K = joint.acting_stiffness(placed.pose, placed.at.from, placed.at.to, others);
    for (int i : {0, 1})
        for (int k : {0, 1}) K.at[i][k] += 0.5 * (own.at[i][k] + own.at[k][i].transpose());
    return in_frames(j, K);
}

Matrix6 InteriorMatrix::gain(size_t j, const Vector6& deformation) const {
    const Mechanism& mechanism = inside_.mechanism;
    return mechanism.joints[j].gain(mechanism.scheme, mechanism.states[j].deformation(), deformation, mechanism.memory(j));
}

/// h² times such blocks, from world axes to those of the frames at t_n.
EndBlocks InteriorMatrix::in_frames(size_t j, EndBlocks K) const {
    const Mechanism& mechanism = inside_.mechanism;
    const Joint& joint = mechanism.joints[j];
    const double h = inside_.step_size();
    const Matrix3 R[2] = {mechanism.frame(joint.from()).axes(), mechanism.frame(joint.to()).axes()};
    for (int i : {0, 1})
        for (int k : {0, 1})
            for (int row : {0, 3})
                for (int column : {0, 3}) {
                    auto block = K.at[i][k].block<3, 3>(row, column);
                    block = (h * h * R[i].transpose() * block * R[k]).eval();
                }
    return K;
}

/// It has the masses only.
void InteriorMatrix::begin() {
    elimination_.set_zero();
    for (int i = 0; i < inside_.count; ++i) elimination_.add_diagonal(i, mass_matrix(inside_.inertias[as_size(i)]));
}

void InteriorMatrix::add_joint(size_t j, const Blocks& K) {
    const Joint& joint = inside_.mechanism.joints[j];
    const int frames[2] = {joint.from(), joint.to()};
    for (int end : {0, 1}) {
        if (!inside_.is_inner(frames[end])) continue;
        elimination_.add_diagonal(frames[end] - inside_.driven, K.own.at[end][end]);
        elimination_.add_acting(frames[end] - inside_.driven, K.acting.at[end][end]);
    }
    if (inside_.is_inner(frames[0]) && inside_.is_inner(frames[1])) elimination_.add_coupling(as_int(j), K.between(0, 1));
    if (inside_.near_index[j] < 0) return;
    const auto k = as_size(inside_.near_index[j]);
    for (int row : {0, 1})
        for (int column : {0, 1}) near_blocks_[k].at[row][column] = K.between(row, column);
    for (int end : {0, 1}) near_columns_[k].at[end] = local_columns(inside_.mechanism, j, end);
}

void InteriorMatrix::form(const std::vector<Frame>& at) {
    is_stale_ = true;
    form_by(at);
    is_stale_ = is_own_ = false;
}

void InteriorMatrix::form_by(const std::vector<Frame>& at) {
    const Mechanism& mechanism = inside_.mechanism;
    ++formed_;
    begin();
    for (size_t j = 0; j < mechanism.joints.size(); ++j) add_joint(j, blocks(j, at));
    for (size_t j : inside_.rigid_joints) set_rigid_rows(mechanism, j, mechanism.pose(j), mechanism.theta(j), elimination_);
    find_stiffest();
    factor_or_refuse(mechanism, elimination_, mechanism.steps == 0 ? DTTMM_ERROR_MODEL : DTTMM_ERROR_SINGULAR);
    take_factor(at);
}

void InteriorMatrix::form_at_trial() {
    const Mechanism& mechanism = inside_.mechanism;
    is_own_ = is_stale_ = true;
    ++formed_;
    begin();
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        add_joint(j, blocks_at_trial(j));
        if (!joint.rigid().any()) continue;
        const Ends at = ends(joint, inside_.trial);
        set_rigid_rows(mechanism, j, joint.pose(at), joint.rotation(at.from, at.to), elimination_);
    }
    find_stiffest();
    if (elimination_.factor()) return form_by(mechanism.frames);
    take_factor(inside_.trial);
}

void InteriorMatrix::find_stiffest() {
    stiffest_ = 0;
    for (int i = 0; i < inside_.count; ++i)
        stiffest_ = std::max(stiffest_, elimination_.diagonal(i).diagonal().head<3>().maxCoeff());
}

/// What follows from the factor.
void InteriorMatrix::take_factor(const std::vector<Frame>& at) {
    find_responses();
    if (!laws_.are_wanted(inside_.record.is_slow != 0)) return;
    laws_.form(inside_.mechanism, at);
    laws_.find_responses(elimination_, inside_.step_size(), inside_.motion, inside_.motion_q);
}

/// How the inside follows a unit motion of each port.
void InteriorMatrix::find_responses() {
    std::vector<Vector6>& r = inside_.motion;
    std::vector<double>& g = inside_.motion_q;
    for (int column = 0; column < 6 * inside_.ports; ++column) {
        const int port = column / 6, c = column % 6;
        std::ranges::fill(r, Vector6::Zero());
        std::ranges::fill(g, 0.0);
        for (size_t j : inside_.port_joints) {
            const Joint& joint = inside_.mechanism.joints[j];
            if (joint.from() != port && joint.to() != port) continue;
            const int end = joint.from() == port ? 0 : 1;
            const int other = joint.frame(1 - end);
            const EndBlocks& K = near_blocks_[as_size(inside_.near_index[j])];
            if (inside_.is_inner(other)) r[inside_.at(other)] -= K.at[1 - end][end].col(c);
            for_each_rigid(joint,
                           [&](int i, int) { g[inside_.rigid_row(j, i)] = -elimination_.rigid(as_int(j), i, end)(c); });
        }
        elimination_.solve(r, g);
        for (size_t i = 0; i < r.size(); ++i)
            Eigen::Map<Vector6>{&responses_[36 * i * as_size(inside_.ports) + 6 * as_size(column)]} = r[i];
        rigid_responses_.col(column) = Eigen::Map<const Eigen::VectorXd>(g.data(), as_row(g.size()));
    }
}

// ---- Whether it still serves --------------------------------------------------------------------------------------------

void InteriorMatrix::take_step() {
    is_stale_ = is_own_ || turn_at_ports() > kTurnedPorts || rigid_directions_have_turned();
    formed_ = 0;
}

/// Against their frames, since the matrix was formed: their forces would be found slowly, or not at all, and no motion would
/// show it.
bool InteriorMatrix::rigid_directions_have_turned() const {
    for (size_t j : inside_.rigid_joints)
        for (int end : {0, 1}) {
            const Matrix6 rows = rigid_rows(inside_.mechanism, j, local_columns(inside_.mechanism, j, end));
            bool turned = false;
            for_each_rigid(inside_.mechanism.joints[j], [&](int i, int d) {
                const Vector6& then = elimination_.rigid(as_int(j), i, end);
                turned =
                    turned || (rows.row(d).transpose() - then).squaredNorm() > kSmallTurn * kSmallTurn * then.squaredNorm();
            });
            if (turned) return true;
        }
    return false;
}

/// Of the joints at ports since the matrix was formed, as share of their directions and arms: the linear answer to the ports
/// goes by them, and no pass in here shows how far that is wrong.
double InteriorMatrix::turn_at_ports() const {
    double largest = 0;
    for (size_t k = 0; k < inside_.near_joints.size(); ++k)
        for (int end : {0, 1}) {
            const Matrix6& then = near_columns_[k].at[end];
            const Matrix6 now = local_columns(inside_.mechanism, inside_.near_joints[k], end);
            largest = std::max(largest, (now - then).squaredNorm() / then.squaredNorm());
        }
    return std::sqrt(largest);
}

// ---- What it answers ----------------------------------------------------------------------------------------------------

void InteriorMatrix::solve(std::span<Vector6> change, std::span<double> q_change, std::vector<double>& psi) {
    elimination_.solve(change, q_change);
    if (laws_.are_wanted(inside_.record.is_slow != 0))
        laws_.correct(inside_.mechanism, inside_.trial, change, q_change, psi);
}

JointForce InteriorMatrix::near_change(size_t k, const Vector6& u_from, const Vector6& u_to, const std::vector<double>& q,
                                       const std::vector<double>& psi) const {
    const size_t j = inside_.near_joints[k];
    const Joint& joint = inside_.mechanism.joints[j];
    const EndBlocks& K = near_blocks_[k];
    const double h = inside_.step_size();
    Vector6 on_from = (K.at[0][0] * u_from + K.at[0][1] * u_to) / -h, on_to = (K.at[1][0] * u_from + K.at[1][1] * u_to) / h;
    for_each_rigid(joint, [&](int i, int) {
        const double more = inside_.trial_q[inside_.rigid_row(j, i)] - q[inside_.rigid_row(j, i)];
        on_from -= more * elimination_.rigid(as_int(j), i, 0);
        on_to += more * elimination_.rigid(as_int(j), i, 1);
    });
    if (joint.has_laws()) laws_.add_force(j, psi, on_from, on_to);
    const RowMajor3 R_from = inside_.mechanism.frame(joint.from()).axes(), R_to = inside_.mechanism.frame(joint.to()).axes();
    return {R_from * head(on_from), R_from * tail(on_from), R_to * tail(on_to)};
}

void InteriorMatrix::write_stiffness(double* stiffness) const {
    // −δ(h W_p) = Σ K δu + Jᵀ q over the ends of the joints of port p
    const double h = inside_.step_size();
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * inside_.ports, 6 * inside_.ports);
    S.setZero();
    for (size_t j : inside_.port_joints) {
        const Joint& joint = inside_.mechanism.joints[j];
        const EndBlocks& K = near_blocks_[as_size(inside_.near_index[j])];
        const int frames[2] = {joint.from(), joint.to()};
        for (int row : {0, 1}) {
            if (frames[row] >= inside_.ports) continue;
            for (int column = 0; column < inside_.ports; ++column) {
                auto block = S.block<6, 6>(6 * frames[row], 6 * column);
                for (int end : {0, 1}) {
                    if (inside_.is_inner(frames[end]))
                        block += K.at[row][end] * response(inside_.at(frames[end])).middleCols<6>(6 * column);
                    if (frames[end] == column) block += K.at[row][end];
                }
                for_each_rigid(joint, [&](int i, int) {
                    block += elimination_.rigid(as_int(j), i, row) *
                             rigid_responses_.block<1, 6>(as_row(inside_.rigid_row(j, i)), 6 * column);
                });
            }
        }
    }
    for (int row = 0; row < 2 * inside_.ports; ++row)
        for (int column = 0; column < 2 * inside_.ports; ++column) {
            auto block = S.block<3, 3>(3 * row, 3 * column);
            block = (inside_.mechanism.frame(row / 2).axes() * block *
                     inside_.mechanism.frame(column / 2).axes().transpose() / (h * h))
                        .eval();
        }
}

}  // namespace dttmm::plugin
