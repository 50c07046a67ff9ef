// SPDX-License-Identifier: BSD-3-Clause
#include "statics/static_network.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"
#include "statics/frame_links.h"

namespace dttmm::plugin {

namespace {

/// Of the stiffness that holds a frame, where the equations are singular without: 1e-6 to 1e-11 pass the same tests.
constexpr double kLeastShare = 1e-9;
/// A frame that hangs on others may turn this much farther in a correction: only the lever arms of loads change by that, and
/// no joint is stretched. Of 144 bars bent into circles 1, 4, 0, 0 take more than 50 iterations with 2, 3, 4, 6, and 29
/// where all are moved by displacements. Of 72 cantilevers under forces of 10 to 200 EI/L² none takes more than 24 with 4,
/// 31 with 6, and six take 61 to 2024 with 8.
constexpr double kSwing = 4;
/// Of the eigenvalues of one frame, as where they are not counted.
constexpr double kSingular = 1e-13;

std::vector<Link> links_inside(const Mechanism& mechanism) {
    return mechanism.assembly.inner_count() > 0 ? links_of(mechanism) : std::vector<Link>{};
}

}  // namespace

StaticNetwork::StaticNetwork(const Mechanism& mechanism, Loading loading, Elimination* lent)
    : mechanism_(mechanism),
      ports_(mechanism.assembly.port_count),
      driven_(mechanism.assembly.driven_count),
      count_(mechanism.assembly.inner_count()),
      acting_{std::move(loading), Vector3::Zero(), {}},
      size_(mechanism),
      matrix_(lent ? *lent : own_.emplace(count_, links_inside(mechanism), least_lever(mechanism))),
      hanging_(mechanism),
      is_massless_(ports_ == 0 && std::ranges::all_of(mechanism.assembly.frames, [](const FrameSpec& frame) {
                       return frame.mass == 0 && frame.inertia.isZero(0);
                   })) {
    acting_.loads.assign(acting_.loading.value_count(), 0.0);
    begin();
    for (size_t j = 0; j < mechanism.joints.size(); ++j) {
        const Joint& joint = mechanism.joints[j];
        if (joint.from() < ports_ || joint.to() < ports_) at_ports_.joints.push_back(j);
    }
    at_ports_.blocks.resize(at_ports_.joints.size());
    for (auto* list : {&residual_.wrenches, &base_residual_.wrenches}) list->assign(now_.frames.size(), Vector6::Zero());
    correction_.u.assign(as_size(count_), Vector6::Zero());
    const auto rigid = as_size(matrix_.rigid_count());
    for (auto* list : {&now_.q, &base_.q, &kept_.q, &residual_.openings, &base_residual_.openings, &correction_.q})
        list->assign(rigid, 0.0);
    correction_.of_ports.assign(as_size(ports_), Vector6::Zero());
}

void StaticNetwork::begin() {
    now_.frames = described_frames(mechanism_);
    base_.frames = now_.frames;
    std::ranges::fill(now_.q, 0.0);
    predicted_.clear();
    joints_.clear();
    kept_ = now_;
}

/// A rotation vector tells no full turns: it is followed from the place kept before.
void StaticNetwork::refuse_large_rotations() const {
    for (const Joint& joint : mechanism_.joints) {
        if (!joint.turns()) continue;
        const auto rotation = [&](const Place& place) {
            return joint.rotation(place.frames[as_size(joint.from())], place.frames[as_size(joint.to())]);
        };
        joint.refuse_large_rotation(nearest_turn(rotation(now_), rotation(kept_)));
    }
}

void StaticNetwork::recall() {
    now_ = kept_;
    predicted_.clear();
    joints_.clear();
}

void StaticNetwork::set_loads(const Vector3& gravity, const double* loads) {
    acting_.gravity = gravity;
    for (size_t i = 0; i < acting_.loads.size(); ++i) acting_.loads[i] = loads ? loads[i] : 0;
}

Vector6 StaticNetwork::rigid_force(size_t j) const {
    Vector6 force = Vector6::Zero();
    if (count_ == 0) return force;
    for_each_rigid(mechanism_.joints[j],
                   [&](int i, int d) { force(d) = now_.q[as_size(matrix_.rigid_begin(as_int(j)) + i)]; });
    return force;
}

AtRest::Link StaticNetwork::link(size_t j) const {
    const Joint& joint = mechanism_.joints[j];
    const PlacedJoint placed(joint, ends(joint));
    const auto moved = [&](int frame, FrameView now) {
        const Pose& start = mechanism_.assembly.frames[as_size(frame)].pose;
        return MovedFrame{start.position, now.origin(), now.axes() * start.rotation.transpose()};
    };
    return {moved(joint.from(), placed.at.from), moved(joint.to(), placed.at.to), resting_force(joint, placed.x).force,
            rigid_force(j)};
}

// ---- What lacks ---------------------------------------------------------------------------------------------------------

/// All joints between their frames where these are.
void StaticNetwork::place_joints() {
    joints_.clear();
    std::vector<Resting> all;  // all or none: a joint may have no pose
    all.reserve(mechanism_.joints.size());
    for (const Joint& joint : mechanism_.joints) {
        const PlacedJoint placed(joint, ends(joint));
        all.push_back({placed, resting_force(joint, placed.x)});
    }
    joints_ = std::move(all);
}

/// Forces on all frames where they are, and how far rigid directions are open.
void StaticNetwork::find_residuals() {
    std::ranges::fill(residual_.wrenches, Vector6::Zero());
    residual_.force = residual_.noise = 0;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const auto& [placed, rest] = joints_[j];
        const Joint& joint = placed.joint;
        const JointForce force = carried_force(placed, rest.force, rigid_force(j));
        Joint::add_wrench(force, residual_.wrenches[as_size(joint.from())].data(),
                          residual_.wrenches[as_size(joint.to())].data());
        residual_.force = std::max({residual_.force, force.force.norm(), rest.force.tail<3>().norm() / size_.span});
        const double stiffest = joint.law().stiffness.head<3>().maxCoeff(),
                     stiffest_turning = joint.law().stiffness.tail<3>().maxCoeff();
        if (std::isfinite(stiffest))
            residual_.noise = std::max(residual_.noise, stiffest * std::numeric_limits<double>::epsilon() *
                                                            (placed.at.from.origin().norm() + placed.at.to.origin().norm() +
                                                             placed.pose.arm.norm()));
        for (int end : {0, 1})
            if (const int frame = joint.frame(end); is_inner(frame) && std::isfinite(stiffest_turning))
                residual_.noise = std::max(
                    residual_.noise, stiffest_turning * std::numeric_limits<double>::epsilon() / size_.reach[at(frame)]);
        if (count_ > 0 && joint.rigid().any()) {
            const Vector6 opening = joint.opening(placed.pose, placed.at.from, placed.at.to);
            for_each_rigid(
                joint, [&](int i, int d) { residual_.openings[as_size(matrix_.rigid_begin(as_int(j)) + i)] = opening(d); });
        }
    }
    for (int i = 0; i < count_; ++i)
        residual_.wrenches[as_size(driven_ + i)].head<3>() +=
            mechanism_.assembly.frames[as_size(driven_ + i)].mass * acting_.gravity;
    for (int f = driven_; f < driven_ + count_; ++f) {
        if (!acting_.loading.is_on(f)) continue;
        const Vector6 load = acting_.loading.wrench(f, now_.frames[as_size(f)], acting_.loads.data());
        residual_.wrenches[as_size(f)] += load;
        residual_.force = std::max({residual_.force, load.head<3>().norm(), load.tail<3>().norm() / size_.span});
    }
}

StaticNetwork::Measure StaticNetwork::measure() const {
    Measure measure{};
    measure.force = residual_.force;
    measure.noise = residual_.noise;
    measure.element = -1;
    if (count_ > 0) measure.falling = matrix_.negatives();
    for (size_t i = 0; i < correction_.u.size(); ++i) {
        const Vector6& r = residual_.wrenches[as_size(driven_) + i];
        const Vector6& u = correction_.u[i];
        measure.work += u.dot(r);
        measure.residual = std::max({measure.residual, r.head<3>().norm(), r.tail<3>().norm() / size_.reach[i]});
        const double shift = std::max(u.head<3>().norm(), size_.reach[i] * u.tail<3>().norm());
        if (shift > measure.shift || !std::isfinite(shift)) {
            measure.shift = shift;
            measure.element = mechanism_.assembly.frames[as_size(driven_) + i].element;
        }
        measure.turn = std::max(measure.turn, u.tail<3>().norm() / (hanging_.hangs(driven_ + as_int(i)) ? kSwing : 1));
    }
    for (size_t p = 0; p < correction_.of_ports.size(); ++p)
        measure.work += correction_.of_ports[p].dot(residual_.wrenches[p]);
    hanging_.for_each_joint([&](size_t j) {
        const Joint& joint = mechanism_.joints[j];
        const Vector3 turn = motion_of(joint.to()).tail<3>() - motion_of(joint.from()).tail<3>();
        measure.turn = std::max(measure.turn, turn.norm());
    });
    for (size_t k = 0; k < correction_.q.size(); ++k) measure.work += correction_.q[k] * residual_.openings[k];
    return measure;
}

Vector6 StaticNetwork::motion_of(int frame) const {
    if (frame < ports_) return correction_.of_ports[as_size(frame)];
    return is_inner(frame) ? correction_.u[at(frame)] : Vector6(Vector6::Zero());
}

/// The forces of all joints that a share of the correction leads to expect, from where the equations were formed.
void StaticNetwork::predict_forces(double share) {
    predicted_.clear();
    for (const auto& [placed, rest] : joints_) {
        const Vector6 change = change_of_deformation(placed, motion_of(placed.joint.from()), motion_of(placed.joint.to()));
        predicted_.push_back(rest.force + share * rest.tangent.cwiseProduct(change));
    }
}

// ---- The equations ------------------------------------------------------------------------------------------------------

/// Adds a joint to the matrix; what couples ports to the inside is kept apart.
void StaticNetwork::add_joint(size_t j) {
    const auto& [placed, rest] = joints_[j];
    const Joint& joint = placed.joint;
    const Vector6 &force = predicted_.empty() ? rest.force : predicted_[j], rigid = rigid_force(j);
    const EndBlocks own = joint.stiffness(placed.pose, joint.along(placed.x, rest.tangent)),
                    turning = turning_stiffness(placed, force, rigid, spread_tangent(placed, force, rigid));
    for (int end : {0, 1}) {
        if (!is_inner(joint.frame(end))) continue;
        matrix_.add_diagonal(joint.frame(end) - driven_, own.at[end][end]);
        const Matrix6& acting = turning.at[end][end];
        matrix_.add_acting(joint.frame(end) - driven_, 0.5 * (acting + acting.transpose()));
    }
    EndBlocks all;
    for (int row : {0, 1})
        for (int column : {0, 1}) {
            const Matrix6 between = turning.at[row][column] + turning.at[column][row].transpose();
            all.at[row][column] = own.at[row][column] + 0.5 * between;
        }
    if (is_inner(joint.from()) && is_inner(joint.to())) matrix_.add_coupling(as_int(j), all.at[0][1]);
    if (joint.from() < ports_ || joint.to() < ports_) {
        const auto k = std::ranges::lower_bound(at_ports_.joints, j) - at_ports_.joints.begin();
        at_ports_.blocks[as_size(as_int(k))] = all;
    }
    if (count_ == 0 || joint.rigid().none()) return;
    const Vector3 theta = placed.x.tail<3>();
    const Matrix6 rows[2] = {rigid_rows(joint, theta, joint.by_from(placed.pose)),
                             rigid_rows(joint, theta, joint.by_to(placed.pose))};
    for_each_rigid(joint, [&](int i, int d) {
        matrix_.set_rigid(as_int(j), i, rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
}

/// s M of an inner frame, world axes.
Matrix6 StaticNetwork::resistance_of(int frame) const {
    const FrameSpec& spec = mechanism_.assembly.frames[as_size(frame)];
    const RowMajor3 R = FrameView(now_.frames[as_size(frame)]).axes();
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>().diagonal().setConstant(resistance_ * spec.mass);
    M.bottomRightCorner<3, 3>() = resistance_ * R * spec.inertia * R.transpose();
    return M;
}

/// Joints are placed anew where ports have moved.
void StaticNetwork::take_ports(Ports ports) {
    for (size_t p = 0; p < as_size(ports_); ++p) {
        const Frame port = ports[p].copy();
        if (!(port == now_.frames[p])) joints_.clear();
        now_.frames[p] = port;
    }
}

void StaticNetwork::form(Ports ports, double resistance) {
    resistance_ = resistance;
    has_moved_ = false;
    take_ports(ports);
    base_ = now_;
    if (joints_.empty()) place_joints();
    find_residuals();
    base_residual_ = residual_;
    // Where nothing has a mass: of the stiffness that holds a frame, as if all vibrated at 10 rad/s; any ω serves
    const double of_massless = is_massless_ ? 0.01 * resistance_ : 0;
    for (const bool is_held : {false, true}) {
        matrix_.set_zero();
        for (size_t j = 0; j < mechanism_.joints.size(); ++j) add_joint(j);
        for (int i = 0; i < count_; ++i) {
            const Matrix6 own = matrix_.diagonal(i);
            matrix_.add_diagonal(i, resistance_of(driven_ + i));
            if (acting_.loading.is_on(driven_ + i)) {
                const Frame& at = now_.frames[as_size(driven_ + i)];
                matrix_.add_acting(i,
                                   acting_.loading.stiffness(driven_ + i, at, FrameView(at).origin(), acting_.loads.data()));
            }
            const double share = of_massless + (is_held ? kLeastShare : 0);
            if (share == 0) continue;
            const double shift = own.topLeftCorner<3, 3>().cwiseAbs().trace(), arm = size_.reach[as_size(i)],
                         turn = std::max(own.bottomRightCorner<3, 3>().cwiseAbs().trace(), arm * arm * shift);
            Vector6 more;
            more << Vector3::Constant(share * shift), Vector3::Constant(share * turn);
            matrix_.add_diagonal(i, more.asDiagonal());
        }
        const auto fault = matrix_.factor_counting(kSingular);
        if (!fault) break;
        if (is_held) refuse_singular(mechanism_, *fault, DTTMM_ERROR_SINGULAR);
    }
    unsymmetric_.clear();
    for (int i = 0; i < count_; ++i)
        if (const int frame = driven_ + i; acting_.loading.is_on(frame))
            unsymmetric_.add(
                i, acting_.loading.unsymmetric_stiffness(frame, now_.frames[as_size(frame)], acting_.loads.data()));
}

void StaticNetwork::condense(std::span<Vector6> wrench, double* stiffness) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * ports_, 6 * ports_);
    for (int p = 0; p < ports_; ++p) wrench[as_size(p)] += base_residual_.wrenches[as_size(p)];
    // Of a motion of the ports (zero: none) and what the inside does with it: the wrench that it takes from the ports
    const auto add_taken = [&](const auto& port_motion, double sign, const auto& take) {
        for (size_t k = 0; k < at_ports_.joints.size(); ++k) {
            const size_t j = at_ports_.joints[k];
            const Joint& joint = mechanism_.joints[j];
            for (int row : {0, 1}) {
                if (joint.frame(row) >= ports_) continue;
                Vector6 force = Vector6::Zero();
                for (int end : {0, 1}) {
                    const int frame = joint.frame(end);
                    if (frame < ports_)
                        force += at_ports_.blocks[k].at[row][end] * port_motion(frame);
                    else if (is_inner(frame))
                        force += at_ports_.blocks[k].at[row][end] * correction_.u[at(frame)];
                }
                if (count_ > 0)
                    for_each_rigid(joint, [&](int i, int) {
                        force +=
                            matrix_.rigid(as_int(j), i, row) * correction_.q[as_size(matrix_.rigid_begin(as_int(j)) + i)];
                    });
                take(joint.frame(row), sign * force);
            }
        }
    };
    if (count_ > 0) {
        const std::vector<Vector6> none(as_size(ports_), Vector6::Zero());
        correct(none);
        add_taken([](int) { return Vector6(Vector6::Zero()); }, -1,
                  [&](int port, const Vector6& force) { wrench[as_size(port)] += force; });
    }
    std::vector<Vector6> unit(as_size(ports_), Vector6::Zero());
    for (int column = 0; column < 6 * ports_; ++column) {
        unit[as_size(column / 6)] = Vector6::Unit(column % 6);
        if (count_ > 0) {
            std::ranges::fill(correction_.u, Vector6::Zero());
            std::ranges::fill(correction_.q, 0.0);
            add_port_motion(unit);
            solve();
        }
        add_taken([&](int port) { return unit[as_size(port)]; }, 1,
                  [&](int port, const Vector6& force) { S.block<6, 1>(6 * port, column) += force; });
        unit[as_size(column / 6)].setZero();
    }
}

/// Adds what a motion of the ports does to the loads and the openings of the inside.
void StaticNetwork::add_port_motion(std::span<const Vector6> motion) {
    for (size_t k = 0; k < at_ports_.joints.size(); ++k) {
        const size_t j = at_ports_.joints[k];
        const Joint& joint = mechanism_.joints[j];
        for (int end : {0, 1}) {
            if (joint.frame(end) >= ports_) continue;
            const Vector6& u = motion[as_size(joint.frame(end))];
            const int other = joint.frame(1 - end);
            if (is_inner(other)) correction_.u[at(other)] -= at_ports_.blocks[k].at[1 - end][end] * u;
            for_each_rigid(joint, [&](int i, int) {
                correction_.q[as_size(matrix_.rigid_begin(as_int(j)) + i)] -= matrix_.rigid(as_int(j), i, end).dot(u);
            });
        }
    }
}

StaticNetwork::Measure StaticNetwork::correct(std::span<const Vector6> port_change) {
    correction_.of_ports.assign(port_change.begin(), port_change.end());
    if (count_ > 0) {
        std::copy(base_residual_.wrenches.begin() + driven_, base_residual_.wrenches.end(), correction_.u.begin());
        for (size_t k = 0; k < correction_.q.size(); ++k) correction_.q[k] = -base_residual_.openings[k];
        add_port_motion(port_change);
        solve();
    }
    Measure found = measure();
    for (const auto& [placed, rest] : joints_) {
        const Joint& joint = placed.joint;
        if (!std::isfinite(joint.law().most_turn)) continue;
        const Vector6 change = change_of_motion(placed, motion_of(joint.from()), motion_of(joint.to()));
        found.bend = std::max(found.bend, joint.law().used(change));
    }
    return found;
}

StaticNetwork::Measure StaticNetwork::move(Ports ports, double share) {
    if (has_moved_) {
        now_ = base_;
        place_joints();
    }
    has_moved_ = true;
    predict_forces(share);
    move_frames(ports, share);
    for (size_t k = 0; k < now_.q.size(); ++k) now_.q[k] = base_.q[k] + share * correction_.q[k];
    place_joints();
    find_residuals();
    Measure found = measure();
    found.turn = largest_turn();
    for (const auto& [placed, rest] : joints_) found.bend = std::max(found.bend, placed.joint.law().used(placed.x));
    return found;
}

/// Of a frame inside, from where it was assembled.
double StaticNetwork::largest_turn() const {
    double least = 3;  // trace of a rotation
    for (auto f = as_size(driven_); f < now_.frames.size(); ++f) {
        const Matrix3 start = mechanism_.assembly.frames[f].pose.rotation;
        least = std::min(least, FrameView(now_.frames[f]).axes().cwiseProduct(start).sum());
    }
    return std::acos(std::clamp(0.5 * (least - 1), -1.0, 1.0));
}

/// Takes ports to where they are given, and the inside by a share of the correction.
void StaticNetwork::move_frames(Ports ports, double share) {
    hanging_.deform([&](size_t j) -> const PlacedJoint& { return joints_[j].placed; },
                    [&](int frame) { return Vector6(share * motion_of(frame)); });
    take_ports(ports);
    for (int i = 0; i < count_; ++i) {
        const auto f = as_size(driven_ + i);
        if (hanging_.hangs(as_int(f))) continue;
        const Vector6 u = share * correction_.u[as_size(i)];
        Eigen::Map<Vector3>{now_.frames[f].position} = FrameView(base_.frames[f]).origin() + u.head<3>();
        Eigen::Map<RowMajor3>{now_.frames[f].rotation}.noalias() =
            rotation_from_vector<double>(u.tail<3>()) * FrameView(base_.frames[f]).axes();
    }
    hanging_.place(mechanism_, now_.frames);
}

}  // namespace dttmm::plugin
