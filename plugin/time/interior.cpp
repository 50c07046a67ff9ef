// SPDX-License-Identifier: BSD-3-Clause
//
// What a network has inside, its matrix and its results; its start and its steps are in files of their own.
#include "time/interior.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"
#include "core/state_vector.h"
#include "statics/frame_links.h"
#include "time/interior_parts.h"

namespace dttmm::plugin {

namespace {

/// Radius of gyration below which a mass is a point [m].
constexpr double kSmallestGyration = 1e-7;
/// At which a network is first looked at, to see that it can be solved [1/s]; 10 and 1e5 pass the same tests.
constexpr double kTrialRate = 1e3;

/// Translation and rotation of every inner frame: whether it has no mass, no inertia.
std::vector<std::array<bool, 2>> massless_halves(const Mechanism& mechanism) {
    std::vector<std::array<bool, 2>> halves;
    for (auto f = as_size(mechanism.assembly.driven_count); f < mechanism.assembly.frames.size(); ++f) {
        const FrameSpec& frame = mechanism.assembly.frames[f];
        halves.push_back({frame.mass == 0, frame.inertia.trace() <= kSmallestGyration * kSmallestGyration * frame.mass});
    }
    return halves;
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Interior::Interior(const Mechanism& mechanism, const dttmm_network& description, Loading loading)
    : massless_(mechanism, massless_halves(mechanism)),
      loading_(std::move(loading)),
      layout_(mechanism, description, massless_, loading_),
      matrix_(Elimination(layout_.count, links_of(mechanism), least_lever(mechanism))),
      work_(LawRows(mechanism, layout_.driven)) {
    if (!mechanism.scheme.is_implicit())
        throw Error(DTTMM_ERROR_MODEL,
                    "it hangs on a node that is no body, or has a mass of its own: that wants the implicit coupling", 0);
    choose_lanes(mechanism);
    make_room();
    form_dynamic_stiffness(mechanism, mechanism.frames, kTrialRate, matrix_.factor);
    factor(mechanism, matrix_.factor, DTTMM_ERROR_MODEL);
}

/// The joints that go by four, and the others.
void Interior::choose_lanes(const Mechanism& mechanism) {
    std::vector<size_t> plain;
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const bool is_plain = layout_.near_index[j] < 0 && layout_.rigid_index[j] < 0 && !massless_.is_settling(j) &&
                              !mechanism.joints[j].has_laws();
        (is_plain ? plain : others_).push_back(j);
    }
    by_four_ = {mechanism, plain};
    others_.insert(others_.end(), by_four_.others().begin(), by_four_.others().end());
    std::sort(others_.begin(), others_.end());
}

/// Of what is kept from step to step, and of what is small.
void Interior::make_room() {
    const size_t n = as_size(layout_.count), rigid = as_size(matrix_.factor.rigid_count()), ports = as_size(layout_.ports);
    matrix_.near_blocks.resize(layout_.near_joints.size());
    matrix_.near_columns.resize(layout_.near_joints.size());
    matrix_.rigid_responses.setZero(as_row(rigid), 6 * layout_.ports);

    for (auto* list : {&past_.u, &past_.u_before}) list->assign(n, Vector6::Zero());
    for (auto* list : {&past_.velocity, &past_.velocity_before}) list->resize(n);
    momenta_.assign(n, Vector6::Zero());
    frame_loads_.resize(layout_.loaded.size());
    rigid_.assign(rigid, 0);
    for (auto* list : {&port_u_, &port_u_before_}) list->assign(ports, Vector6::Zero());

    instant_.of_ports.resize(ports);
    instant_.rigid = instant_.rigid_rates = rigid_;

    open_.rigid_known.resize(layout_.rigid_joints.size());
    open_.loads.assign(loading_.value_count(), 0);
    open_.solution.q.assign(rigid, 0);
    open_.solution.q_change.assign(rigid, 0);
    open_.solution.near.resize(layout_.near_joints.size());
    open_.solution.laws.assign(work_.laws.count(), 0);

    work_.column_q.assign(rigid, 0);
    work_.port_change.setZero(6 * layout_.ports);
    work_.rigid_change.setZero(as_row(rigid));
    for (auto* list : {&work_.end_wrench, &work_.damping_wrench}) list->assign(massless_.frames().size(), Vector6::Zero());
    work_.massless_residuals.resize(massless_.frames().size());
    work_.q = rigid_;
}

/// Of all frames, for the steps to come: nothing is allocated later. Not before the start, as linearise() takes much memory
/// for a while.
void Interior::make_room_for_steps(const Mechanism& mechanism) {
    const size_t n = as_size(layout_.count);
    matrix_.responses.assign(36 * n * as_size(layout_.ports), 0);
    for (auto* list : {&instant_.velocities, &instant_.accelerations}) list->resize(n);
    if (massless_.has_balances()) {
        instant_.corrections.resize(n);
        instant_.wrench_rates.resize(n);
    }
    open_.solution.ports.assign(mechanism.frames.begin(), mechanism.frames.begin() + layout_.ports);
    for (auto* list : {&open_.solution.u, &open_.solution.change, &work_.motion}) list->assign(n, Vector6::Zero());
    work_.wrench.assign(mechanism.frames.size(), Vector6::Zero());
    work_.trial = mechanism.frames;
}

// ---- The matrix ---------------------------------------------------------------------------------------------------------

Matrix6 local_columns(const Mechanism& mechanism, size_t j, int end) {
    return local_columns(mechanism, j, mechanism.pose(j), end);
}

Matrix6 local_columns(const Mechanism& mechanism, size_t j, const JointPose& pose, int end) {
    const Joint& joint = mechanism.joints[j];
    return local_columns(joint, pose, end, mechanism.frame(joint.frame(end)));
}

Matrix6 local_columns(const Joint& joint, const JointPose& pose, int end, FrameView frame) {
    Matrix6 G = end == 0 ? joint.by_from(pose) : joint.by_to(pose);
    for (int c : {0, 3}) G.middleCols<3>(c) = (G.middleCols<3>(c) * frame.axes()).eval();
    return G;
}

Matrix6 rigid_rows(const Mechanism& mechanism, size_t j, const Matrix6& columns) {
    return rigid_rows(mechanism.theta(j), columns);
}

Matrix6 Interior::mass_matrix(size_t frame) const {
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>().diagonal().setConstant(layout_.inertias[frame].mass);
    M.bottomRightCorner<3, 3>() = layout_.inertias[frame].moment;
    return M;
}

/// h² times −∂(wrench over a step)/∂(pose at its end) of a joint's frames, in their axes at t_n, when `at` has them at its
/// end: what is elastic or damped, and what stems from forces that act at t_n, which turn with the joint.
Interior::Blocks Interior::blocks(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at) const {
    const Joint& joint = mechanism.joints[j];
    const FrameView from = at[as_size(joint.from())], to = at[as_size(joint.to())];
    const JointPose pose = joint.pose(from, to);
    const Vector3 acting = mechanism.pose(j).axes.transpose() * mechanism.states[j].elastic.force;
    return blocks(mechanism, j, {from, to}, pose, joint.deformation(pose, from, to), pose.axes * acting, rigid_);
}

/// The same with the joint elsewhere, deformed, under the elastic force `acting`, its rigid directions carrying q.
Interior::Blocks Interior::blocks(const Mechanism& mechanism, size_t j, Ends at, const JointPose& pose,
                                  const Vector6& deformation, Vector3 acting, const std::vector<double>& q) const {
    const Joint& joint = mechanism.joints[j];
    if (joint.rigid().any()) acting += pose.axes * head(rigid_values(mechanism, j, q));
    const double h = mechanism.scheme.step_size();
    const Matrix3 R[2] = {mechanism.frame(joint.from()).axes(), mechanism.frame(joint.to()).axes()};
    const auto in_frames = [&](EndBlocks K) {
        for (int i : {0, 1})
            for (int k : {0, 1})
                for (int row : {0, 3})
                    for (int column : {0, 3}) {
                        auto block = K.at[i][k].block<3, 3>(row, column);
                        block = (h * h * R[i].transpose() * block * R[k]).eval();
                    }
        return K;
    };
    return {in_frames(joint.stiffness(
                pose, joint.gain(mechanism.scheme, mechanism.states[j].deformation(), deformation, mechanism.memory(j)))),
            in_frames(joint.acting_stiffness(pose, at.from, at.to, mechanism.scheme.elastic_weight(0) * acting))};
}

/// Adds a joint to the matrix.
void Interior::add_joint(const Mechanism& mechanism, size_t j, const Blocks& K) {
    const Joint& joint = mechanism.joints[j];
    const int frames[2] = {joint.from(), joint.to()};
    for (int end : {0, 1}) {
        if (!is_inner(frames[end])) continue;
        matrix_.factor.add_diagonal(frames[end] - layout_.driven, K.own.at[end][end]);
        matrix_.factor.add_acting(frames[end] - layout_.driven, K.acting.at[end][end]);
    }
    if (is_inner(frames[0]) && is_inner(frames[1])) matrix_.factor.add_coupling(as_int(j), K.between(0, 1));
    if (layout_.near_index[j] < 0) return;
    const auto k = as_size(layout_.near_index[j]);
    for (int row : {0, 1})
        for (int column : {0, 1}) matrix_.near_blocks[k].at[row][column] = K.between(row, column);
    for (int end : {0, 1}) matrix_.near_columns[k].at[end] = local_columns(mechanism, j, end);
}

/// at: the frames at the end of the step, as far as they are known.
void Interior::assemble(const Mechanism& mechanism, const std::vector<Frame>& at) {
    matrix_.factor.set_zero();
    for (int i = 0; i < layout_.count; ++i) matrix_.factor.add_diagonal(i, mass_matrix(as_size(i)));
    for (size_t j = 0; j < mechanism.joints.size(); ++j) add_joint(mechanism, j, blocks(mechanism, j, at));
    for (size_t j : layout_.rigid_joints)
        set_rigid_rows(mechanism, j, mechanism.pose(j), mechanism.theta(j), matrix_.factor);
}

/// K + s C + s² M in the frames' axes, s a rate [1/s], with the frames where they are in `at`: springs, dampers and masses
/// under motions that grow like exp(s t). Forces that act already have no stiffness in it.
void Interior::form_dynamic_stiffness(const Mechanism& mechanism, const std::vector<Frame>& at, double rate,
                                      Elimination& matrix) const {
    matrix.set_zero();
    for (int i = 0; i < layout_.count; ++i) matrix.add_diagonal(i, rate * rate * mass_matrix(as_size(i)));
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const EndBlocks K = dynamic_stiffness(mechanism, j, at, rate);
        const int frames[2] = {joint.from(), joint.to()};
        for (int end : {0, 1})
            if (is_inner(frames[end])) matrix.add_diagonal(frames[end] - layout_.driven, K.at[end][end]);
        if (is_inner(frames[0]) && is_inner(frames[1])) matrix.add_coupling(as_int(j), K.at[0][1]);
        if (joint.rigid().any()) set_rigid_rows(mechanism, j, at, matrix);
    }
}

/// Of one joint, in the axes of its frames.
EndBlocks Interior::dynamic_stiffness(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at,
                                      double rate) const {
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
void Interior::make_heavier(Elimination& matrix) const {
    constexpr double kLeastShare = 1e-9;  // with 1e-11 rigid directions are lost to 1e-3 in rods of a centimetre
    for (int i = 0; i < layout_.count; ++i) {
        const Matrix6 own = matrix.diagonal(i);
        const double shift = own.topLeftCorner<3, 3>().trace(), arm = layout_.reach[as_size(i)];
        const double held[2] = {shift, std::max(own.bottomRightCorner<3, 3>().trace(), arm * arm * shift)};
        Vector6 more = Vector6::Zero();
        for (int half : {0, 1})
            if (!massless_.is_massless(as_size(i), half)) more.segment<3>(3 * half).setConstant(kLeastShare * held[half]);
        matrix.add_diagonal(i, more.asDiagonal());
    }
}

void Interior::set_rigid_rows(const Mechanism& mechanism, size_t j, const JointPose& pose, const Vector3& theta,
                              Elimination& matrix) const {
    const Matrix6 rows[2] = {rigid_rows(theta, local_columns(mechanism, j, pose, 0)),
                             rigid_rows(theta, local_columns(mechanism, j, pose, 1))};
    for_each_rigid(mechanism.joints[j], [&](int i, int d) {
        matrix.set_rigid(as_int(j), i, rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
}

/// The same in the axes of the frames where they are in `at`.
void Interior::set_rigid_rows(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at,
                              Elimination& matrix) const {
    const Joint& joint = mechanism.joints[j];
    const auto [from, to] = ends(joint, at);
    const JointPose pose = joint.pose(from, to);
    const Vector3 theta = joint.rotation(from, to);
    const Matrix6 rows[2] = {rigid_rows(theta, local_columns(joint, pose, 0, from)),
                             rigid_rows(theta, local_columns(joint, pose, 1, to))};
    for_each_rigid(joint, [&](int i, int d) {
        matrix.set_rigid(as_int(j), i, rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
}

/// The matrix where the last iteration has brought everything, under the forces there; if that is singular, where the step
/// began. It serves for this step.
void Interior::form_at_trial(const Mechanism& mechanism) {
    matrix_.is_own = true;
    matrix_.is_stale = true;
    matrix_.factor.set_zero();
    for (int i = 0; i < layout_.count; ++i) matrix_.factor.add_diagonal(i, mass_matrix(as_size(i)));
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        const FrameView from = work_.trial[as_size(joint.from())], to = work_.trial[as_size(joint.to())];
        const JointPose pose = joint.pose(from, to);
        const Joint::Strained strained =
            joint.strain(mechanism.scheme, {from, to}, pose, mechanism.states[j], mechanism.memory(j));
        add_joint(mechanism, j,
                  blocks(mechanism, j, {from, to}, pose, strained.deformation(), strained.elastic.force, work_.q));
        if (joint.rigid().any()) set_rigid_rows(mechanism, j, pose, strained.theta, matrix_.factor);
    }
    find_stiffest();
    ++work_.factorisations;
    if (matrix_.factor.factor()) return form_matrix(mechanism, mechanism.frames);
    take_factor(mechanism, work_.trial);
}

void Interior::factor(const Mechanism& mechanism, Elimination& matrix, dttmm_status status) const {
    ++work_.factorisations;
    if (const auto fault = matrix.factor()) refuse_singular(mechanism, *fault, status);
}

void Interior::refactor(const Mechanism& mechanism) {
    predict(mechanism);
    std::copy(open_.solution.ports.begin(), open_.solution.ports.end(), work_.trial.begin());
    place(mechanism, open_.solution.u);
    form_matrix(mechanism, work_.trial);
    look_at_joints(mechanism);
    matrix_.is_stale = matrix_.is_own = false;
    matrix_.is_fresh = true;
}

void Interior::form_matrix(const Mechanism& mechanism, const std::vector<Frame>& at) {
    matrix_.is_stale = true;
    assemble(mechanism, at);
    find_stiffest();
    factor(mechanism, matrix_.factor, DTTMM_ERROR_SINGULAR);
    take_factor(mechanism, at);
}

void Interior::find_stiffest() {
    matrix_.stiffest = 0;
    for (int i = 0; i < layout_.count; ++i)
        matrix_.stiffest = std::max(matrix_.stiffest, matrix_.factor.diagonal(i).diagonal().head<3>().maxCoeff());
}

/// What follows from the factor.
void Interior::take_factor(const Mechanism& mechanism, const std::vector<Frame>& at) {
    find_responses(mechanism);
    if (!work_.laws.are_wanted(record_.is_slow != 0)) return;
    work_.laws.form(mechanism, at);
    work_.laws.find_responses(matrix_.factor, mechanism.scheme.step_size(), work_.motion, work_.column_q);
}

/// How the inside follows a unit motion of each port.
void Interior::find_responses(const Mechanism& mechanism) {
    std::vector<Vector6>& r = work_.motion;
    std::vector<double>& g = work_.column_q;
    for (int column = 0; column < 6 * layout_.ports; ++column) {
        const int port = column / 6, c = column % 6;
        std::fill(r.begin(), r.end(), Vector6::Zero());
        std::fill(g.begin(), g.end(), 0.0);
        for (size_t j : layout_.port_joints) {
            const Joint& joint = mechanism.joints[j];
            if (joint.from() != port && joint.to() != port) continue;
            const int end = joint.from() == port ? 0 : 1;
            const int other = end == 0 ? joint.to() : joint.from();
            const EndBlocks& K = matrix_.near_blocks[as_size(layout_.near_index[j])];
            if (is_inner(other)) r[at(other)] -= K.at[1 - end][end].col(c);
            for_each_rigid(joint, [&](int i, int) { g[rigid_row(j, i)] = -matrix_.factor.rigid(as_int(j), i, end)(c); });
        }
        matrix_.factor.solve(r, g);
        for (size_t i = 0; i < r.size(); ++i) {
            Eigen::Map<Vector6>{&matrix_.responses[36 * i * as_size(layout_.ports) + 6 * as_size(column)]} = r[i];
        }
        matrix_.rigid_responses.col(column) = Eigen::Map<const Eigen::VectorXd>(g.data(), as_row(g.size()));
    }
}

void Interior::write_stiffness(const Mechanism& mechanism, double* stiffness) const {
    // −δ(h W_p) = Σ K δu + Jᵀ q over the ends of the joints of port p
    const double h = mechanism.scheme.step_size();
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * layout_.ports, 6 * layout_.ports);
    S.setZero();
    for (size_t j : layout_.port_joints) {
        const Joint& joint = mechanism.joints[j];
        const EndBlocks& K = matrix_.near_blocks[as_size(layout_.near_index[j])];
        const int frames[2] = {joint.from(), joint.to()};
        for (int row : {0, 1}) {
            if (frames[row] >= layout_.ports) continue;
            for (int column = 0; column < layout_.ports; ++column) {
                auto block = S.block<6, 6>(6 * frames[row], 6 * column);
                for (int end : {0, 1}) {
                    if (is_inner(frames[end])) block += K.at[row][end] * response(at(frames[end])).middleCols<6>(6 * column);
                    if (frames[end] == column) block += K.at[row][end];
                }
                for_each_rigid(joint, [&](int i, int) {
                    block += matrix_.factor.rigid(as_int(j), i, row) *
                             matrix_.rigid_responses.block<1, 6>(as_row(rigid_row(j, i)), 6 * column);
                });
            }
        }
    }
    for (int row = 0; row < 2 * layout_.ports; ++row)
        for (int column = 0; column < 2 * layout_.ports; ++column) {
            auto block = S.block<3, 3>(3 * row, 3 * column);
            block =
                (mechanism.frame(row / 2).axes() * block * mechanism.frame(column / 2).axes().transpose() / (h * h)).eval();
        }
}

// ---- Results ------------------------------------------------------------------------------------------------------------

double Interior::work(const Mechanism& mechanism) const {
    double work = record_.load_work;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const Vector3& start = mechanism.assembly.frames[as_size(layout_.driven) + i].pose.position;
        work += layout_.inertias[i].mass *
                layout_.gravity.dot(mechanism.frame_before(layout_.driven + as_int(i)).origin() - start);
    }
    return work;
}

Twist Interior::momentum(const Mechanism& mechanism) const {
    // x_n × p = x_{n−1} × p, for p is along what leads from one to the other
    Twist total;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        const Vector3 p = head(momenta_[i]);
        total.linear += p;
        total.angular += mechanism.frame(layout_.driven + as_int(i)).origin().cross(p) + tail(momenta_[i]);
    }
    return total;
}

Twist Interior::newmark_momentum(const Mechanism& mechanism) const {
    // With F the elastic force on a frame, y = x − β h² F/m and P − β h (F_n − F_{n−1}) move in leap-frog by F_n alone.
    // Their moment does not change: y × F = x × F.
    const Scheme& scheme = mechanism.scheme;
    std::vector<Vector6> now(mechanism.frames.size(), Vector6::Zero()), before = now;
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const auto a = as_size(mechanism.joints[j].from()), b = as_size(mechanism.joints[j].to());
        Joint::add_wrench(mechanism.states[j].elastic, now[a].data(), now[b].data());
        JointForce force = mechanism.states[j].known;  // without a damper (1 − 2s) F_n + s F_{n−1}
        force.add(-scheme.elastic_weight(1), mechanism.states[j].elastic);
        JointForce earlier;
        earlier.add(1 / scheme.elastic_weight(2), force);
        Joint::add_wrench(earlier, before[a].data(), before[b].data());
    }
    for (size_t i : massless_.frames()) {
        if (!is_inner(layout_.receivers[i])) continue;
        const auto f = as_size(layout_.driven) + i, receiver = as_size(layout_.receivers[i]);
        now[receiver] += passed_on(mechanism.frames, i, massless_part(i, now[f]));
        before[receiver] += passed_on(mechanism.before, i, massless_part(i, before[f]));
    }
    const double h = mechanism.scheme.step_size(), beta = mechanism.scheme.elastic_weight(0);
    Twist total;
    for (size_t i = 0; i < layout_.inertias.size(); ++i) {
        if (massless_.is_massless(i, 0)) continue;
        const auto f = as_size(layout_.driven) + i;
        Vector6 P = momenta_[i] - beta * h * (now[f] - before[f]);
        if (massless_.is_massless(i, 1)) P.tail<3>().setZero();
        const Vector3 y = FrameView(mechanism.frames[f]).origin() - beta * h * h / layout_.inertias[i].mass * head(now[f]);
        total.linear += head(P);
        total.angular += y.cross(head(P)) + tail(P);
    }
    return total;
}

/// Forces of a joint's rigid directions out of those of all, joint axes.
Vector6 Interior::rigid_values(const Mechanism& mechanism, size_t j, const std::vector<double>& q) const {
    Vector6 f = Vector6::Zero();
    for_each_rigid(mechanism.joints[j], [&](int i, int d) { f(d) = q[rigid_row(j, i)]; });
    return f;
}

}  // namespace dttmm::plugin
