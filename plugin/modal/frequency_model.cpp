// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.h"
#include "core/state_vector.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Cosine of an angle that is round-off.
constexpr double kAligned = 1e-9;

Matrix6 mass_block(double mass, const Matrix3& inertia) {
    Matrix6 block = Matrix6::Zero();
    block.diagonal().head<3>().setConstant(mass);
    block.bottomRightCorner<3, 3>() = inertia;
    return block;
}

/// What lines of one kind share, to the bit: section, length, whether it is a rod, active directions.
using Key = std::tuple<std::array<uint64_t, sizeof(Section) / sizeof(double)>, double, bool, unsigned long>;

}  // namespace

double dot(const FrameVector& a, const FrameVector& b) {
    double sum = 0;
    for (size_t f = 0; f < a.size(); ++f) sum += a[f].dot(b[f]);
    return sum;
}

Matrix6 both(const Matrix3& R) {
    Matrix6 twice = Matrix6::Zero();
    twice.topLeftCorner<3, 3>() = twice.bottomRightCorner<3, 3>() = R;
    return twice;
}

// ---- Joined frames ------------------------------------------------------------------------------------------------------

Vector12 Joined::ends(const FrameVector& u, const Vector6& ground) const {
    Vector12 ends;
    ends << by_from * (from < 0 ? ground : u[as_size(from)]), by_to * (to < 0 ? ground : u[as_size(to)]);
    return ends;
}

Vector6 Joined::add(const Vector12& forces, FrameVector& on_frames) const {
    Vector6 on_ground = Vector6::Zero();
    (from < 0 ? on_ground : on_frames[as_size(from)]) += by_from.transpose() * forces.head<6>();
    (to < 0 ? on_ground : on_frames[as_size(to)]) += by_to.transpose() * forces.tail<6>();
    return on_ground;
}

void Joined::hold(Vector6 row_from, Vector6 row_to) {
    if (from < 0) row_from.setZero();
    if (to < 0) row_to.setZero();
    Vector12 rest;
    rest << row_from, row_to;
    const double size = rest.norm();
    if (!(size > kAligned)) return;
    std::vector<Vector12> basis;
    for (const Rigid& other : rigid) {
        Vector12 next;
        next << other.by_from, other.by_to;
        for (const Vector12& b : basis) next -= b.dot(next) * b;
        basis.push_back(next.normalized());
    }
    for (const Vector12& b : basis) rest -= b.dot(rest) * b;
    if (rest.norm() > kAligned * size) rigid.push_back({row_from, row_to});
}

// ---- The machine --------------------------------------------------------------------------------------------------------

FrequencyModel::FrequencyModel(const dttmm_modal_model& model)
    : directions(model.directions), element_count(model.network->element_count) {
    const Assembly assembly = assemble(*model.network, model.lumped_beams ? Waves::lumped : Waves::exact);
    mask.setZero();
    for (size_t d = 0; d < 6; ++d)
        if (directions[d]) mask(as_row(d), as_row(d)) = 1;
    add_bodies(*model.network);
    const std::vector<int> frame_of = add_inner_frames(assembly);
    for (const NodeSpec& node : assembly.nodes) {
        const Pose& pose = assembly.frames[as_size(node.frame)].pose;
        nodes.push_back({frame_of[as_size(node.frame)], pose.position + pose.rotation * node.offset});
    }
    if (!directions.all()) refer_to_nodes();
    for (const JointSpec& joint : assembly.joints) try {
            add_joint(joint.element, frame_of[as_size(joint.from)], frame_of[as_size(joint.to)], *joint.law, joint.pose);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), joint.element);
        }
    for (uint32_t c = 0; c < model.constraint_count; ++c) {
        const dttmm_constraint& constraint = model.constraints[c];
        JointLaw law;
        law.rigid = Directions(constraint.rigid);
        add_joint(-1, constraint.first, constraint.second, law,
                  {Eigen::Map<const Vector3>(constraint.position), Eigen::Map<const RowMajor3>(constraint.axes)});
    }
    add_lines(assembly.lines, frame_of);
    if (frames.empty()) throw Error(DTTMM_ERROR_MODEL, "nothing moves: no body and no free node");
}

void FrequencyModel::add_bodies(const dttmm_network& network) {
    for (uint32_t b = 0; b < network.body_count; ++b) {
        const dttmm_body& body = network.bodies[b];
        const Eigen::Map<const Vector3> position(body.position);
        const Eigen::Map<const RowMajor3> inertia(body.inertia);
        if (!position.allFinite() || !inertia.allFinite() || !(body.mass > 0 && std::isfinite(body.mass)))
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("body \"{}\": its numbers must be finite", body.name));
        frames.push_back({position, fmt::format("body \"{}\"", body.name), -1});
        centres.push_back(position);
        masses.push_back({as_int(b), mass_block(body.mass, inertia)});
        total_mass += body.mass;
    }
}

/// Masses and nodes of the network; the frame of each of the assembly's, −1: the ground.
std::vector<int> FrequencyModel::add_inner_frames(const Assembly& assembly) {
    std::vector<int> frame_of;
    for (const FrameSpec& spec : assembly.frames) {
        const bool is_port = as_int(frame_of.size()) < assembly.port_count;
        frame_of.push_back(is_port ? as_int(frame_of.size()) : -1);
        if (is_port || spec.kind != FrameSpec::Kind::inner) continue;
        const int own = frame_of.back() = as_int(frames.size());
        frames.push_back({spec.pose.position, spec.name(), spec.element});
        const Matrix3& R = spec.pose.rotation;
        if (spec.mass > 0) masses.push_back({own, mass_block(spec.mass, R * spec.inertia * R.transpose())});
        total_mass += spec.mass;
    }
    return frame_of;
}

/// In a reduced state directions are left out at the first node of a frame. The centre of mass keeps all the velocity that
/// the rotations give it, as in the paper's J_xx + m (c2² + c3²).
void FrequencyModel::refer_to_nodes() {
    std::vector<bool> is_referred(frames.size());
    for (const Node& node : nodes) {
        if (node.frame < 0 || is_referred[as_size(node.frame)]) continue;
        is_referred[as_size(node.frame)] = true;
        Vector3& origin = frames[as_size(node.frame)].position;
        const Matrix6 to_centre = at_point(origin, node.position);
        for (Mass& mass : masses)
            if (mass.frame == node.frame) mass.block = to_centre.transpose() * mass.block * to_centre;
        origin = node.position;
    }
}

void FrequencyModel::add_joint(int element, int from, int to, const JointLaw& law, const Pose& pose) {
    if (from < 0 && to < 0) return;
    Bond bond;
    bond.element = element;
    bond.from = from;
    bond.to = to;
    bond.points[0] = bond.points[1] = pose.position;
    const Matrix6 axes = both(pose.rotation);
    Vector6 stiffness = law.stiffness, damping = law.damping;
    if (law.axial) {  // the tangent of its force along the line, and F/L across it
        const double length = law.axial->length, elongation = length - law.axial->natural;
        bond.points[0] -= length * pose.rotation.col(0);
        std::array<double, Law::kMostMemory> nothing{}, memory{};
        law.along(0, {0, elongation, 0, nothing.data(), memory.data()});
        const LawOnPath at_start = law.at(0, elongation, memory.data());
        bond.tension = at_start.force;
        stiffness.head<3>() << at_start.tangent, at_start.force / length, at_start.force / length;
    }
    bond.by_from = masked_at(bond.points[0], origin(from));
    bond.by_to = masked_at(bond.points[1], origin(to));
    for (size_t d = 0; d < 6; ++d) {
        const auto i = as_row(d);
        if (!law.rigid[d]) continue;
        stiffness(i) = damping(i) = 0;
        const Eigen::Matrix<double, 1, 6> row = axes.col(i).transpose();
        bond.held.push_back(mask * axes.col(i));
        bond.hold(-(row * bond.by_from).transpose(), (row * bond.by_to).transpose());
    }
    bond.axes = axes;
    bond.springs = stiffness;
    bond.stiffness = axes * stiffness.asDiagonal() * axes.transpose();
    bond.damping = axes * damping.asDiagonal() * axes.transpose();
    bonds.push_back(std::move(bond));
}

/// The local directions of a line that the model leaves. Throws Error where one lies at an angle to these.
Directions FrequencyModel::active_axes(const LineSpec& spec) const {
    Directions active;
    for (size_t d = 0; d < 6; ++d) {
        const auto half = as_row(3 * (d / 3));
        const double share = (mask.diagonal().segment<3>(half).cwiseProduct(spec.line.axes.col(as_row(d % 3)))).norm();
        if (share > kAligned && share < 1 - kAligned)
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("dofs: its local {} lies at an angle to the directions that are left: turn the beam or "
                                    "its `up`, or leave all directions",
                                    kDirectionNames[d]),
                        spec.element);
        active[d] = share > 0.5;
    }
    return active;
}

void FrequencyModel::add_lines(const std::vector<LineSpec>& specs, const std::vector<int>& frame_of) {
    std::map<Key, size_t> known;
    for (const LineSpec& spec : specs) {
        const Directions active = active_axes(spec);
        const double length = (spec.finish - spec.start).norm();
        const Key key = {std::bit_cast<std::tuple_element_t<0, Key>>(spec.line.section), length, spec.line.stretches_only,
                         active.to_ulong()};
        const auto [kind, is_new] = known.try_emplace(key, kinds.size());
        if (is_new) try {
                kinds.push_back(std::make_unique<LineWaves>(spec.line, length, active));
            } catch (const Error& error) {
                throw Error(error.status(), error.what(), spec.element);
            }
        lines.push_back({spec.element, frame_of[as_size(spec.from)], frame_of[as_size(spec.to)], spec.start, spec.finish,
                         spec.line.axes, spec.line, kind->second, kinds[kind->second].get()});
        total_mass += spec.line.section.mass * length;
        if (lines.back().waves->pinned().any()) add_pin(lines.back());
    }
}

void FrequencyModel::add_pin(const LineModel& line) {
    const Matrix6 to_local = both(line.axes.transpose());
    Pin pin{{line.element,
             line.from,
             line.to,
             to_local * masked_at(line.start, origin(line.from)),
             to_local * masked_at(line.finish, origin(line.to)),
             {}},
            Matrix6::Zero()};
    for (Eigen::Index d : {1, 2})
        if (line.waves->pinned()[as_size(d)]) pin.mass(d, d) = line.line.section.mass * line.length();
    pins.push_back(pin);
}

bool FrequencyModel::is_elastic() const {
    return !lines.empty() || std::ranges::any_of(bonds, [&](const Bond& bond) {
        return (mask * bond.stiffness * mask).diagonal().maxCoeff() > 0;
    });
}

double FrequencyModel::force_at_start(size_t element) const {
    const auto own =
        std::ranges::find_if(bonds, [&](const Bond& bond) { return bond.element == as_int(element) && bond.tension != 0; });
    return own == bonds.end() ? 0 : own->tension;
}

Matrix6 FrequencyModel::at_point(const Vector3& point, const Vector3& origin) {
    Matrix6 by = Matrix6::Identity();
    by.topRightCorner<3, 3>() = -skew(point - origin);
    return by;
}

Matrix6 FrequencyModel::by_centre(int body) const { return at_point(centres[as_size(body)], origin(body)); }

Matrix6 FrequencyModel::by_node(size_t node) const { return masked_at(nodes[node].position, origin(nodes[node].frame)); }

Vector6 FrequencyModel::node_motion(size_t node, const FrameVector& u) const {
    const int frame = nodes[node].frame;
    return frame < 0 ? Vector6(Vector6::Zero()) : Vector6(by_node(node) * u[as_size(frame)]);
}

Matrix6 bar_mass(const Section& section, double length) {
    const double m = section.mass * length, J = m * length * length / 12;
    const double polar = is_given(section.inertia) ? section.inertia : 0;
    Matrix6 bar = Matrix6::Zero();
    bar.diagonal() << 0, m, m, polar * length, J, J;
    return bar;
}

}  // namespace dttmm::plugin
