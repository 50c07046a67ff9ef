// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_model.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.h"
#include "core/state_vector.h"
#include "element/parameters.h"
#include "statics/frame_links.h"

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
    const Vector6 row_ground = from < 0 ? row_from : to < 0 ? row_to : Vector6(Vector6::Zero());
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
    if (rest.norm() > kAligned * size) rigid.push_back({row_from, row_to, row_ground, as_int(rigid.size())});
}

void Bond::add_turning(const FrameVector& u, FrameVector& on_frames) const {
    const int ends[2] = {from, to};
    for (int i : {0, 1})
        for (int k : {0, 1})
            if (ends[i] >= 0 && ends[k] >= 0) on_frames[as_size(ends[i])] += turning->at[i][k] * u[as_size(ends[k])];
}

double Bond::turning_energy(const FrameVector& u) const {
    const int ends[2] = {from, to};
    double energy = 0;
    for (int i : {0, 1})
        for (int k : {0, 1})
            if (ends[i] >= 0 && ends[k] >= 0) energy += u[as_size(ends[i])].dot(turning->at[i][k] * u[as_size(ends[k])]);
    return energy;
}

// ---- The machine --------------------------------------------------------------------------------------------------------

FrequencyModel::FrequencyModel(const dttmm_modal_model& model, const AtRest* rest)
    : directions(model.directions), element_count(model.network->element_count), is_at_rest(rest) {
    if (rest && !directions.all())
        throw Error(DTTMM_ERROR_ARGUMENT, "about a machine at rest all directions are there, none is left out");
    std::vector<bool> lumped(element_count);
    if (rest) {
        find_resting_lines(model, *rest);
        for (size_t e = 0; e < element_count; ++e) lumped[e] = resting[e].is_lumped;
    }
    Assembly assembly = assemble(*model.network, model.lumped_beams ? Waves::lumped : Waves::exact, &lumped);
    mask.setZero();
    for (size_t d = 0; d < 6; ++d)
        if (directions[d]) mask(as_row(d), as_row(d)) = 1;
    std::vector<Joint> joints;  // as they sit in the assembled machine
    std::vector<const AtRest::Link*> links;
    if (rest) {
        for (const JointSpec& joint : assembly.joints)
            joints.emplace_back(joint, assembly, std::make_shared<JointKind>(joint.law));
        links = place_at_rest(*rest, assembly);
    }
    add_bodies(*model.network, model.rest);
    const std::vector<int> frame_of = add_inner_frames(assembly);
    for (const NodeSpec& node : assembly.nodes) {
        const Pose& pose = assembly.frames[as_size(node.frame)].pose;
        nodes.push_back({frame_of[as_size(node.frame)], pose.position + pose.rotation * node.offset});
    }
    if (!directions.all()) refer_to_nodes();
    for (uint32_t e = 0; e < model.network->element_count; ++e) {
        const dttmm_element& own = model.network->elements[e];
        ends.push_back({as_int(own.ends[0]), as_int(own.ends[own.end_count > 1 ? 1 : 0])});
    }
    for (uint32_t n = 0; n < model.network->node_count; ++n) {
        const dttmm_node& node = model.network->nodes[n];
        fixed.push_back(node.kind == DTTMM_NODE_GROUND ? 0x3f : node.kind == DTTMM_NODE_INNER ? node.fixed : 0);
    }
    are_axial.resize(element_count);
    std::vector<int> held_nodes;  // in the order of the joints that hold them
    for (uint32_t n = 0; n < model.network->node_count; ++n) {
        const dttmm_node& node = model.network->nodes[n];
        if (node.kind == DTTMM_NODE_INNER && node.fixed != 0 && node.fixed != 0x3f) held_nodes.push_back(as_int(n));
    }
    for (size_t j = 0; j < assembly.joints.size(); ++j) {
        const JointSpec& joint = assembly.joints[j];
        const size_t before = bonds.size();
        try {
            if (rest)
                add_joint_at_rest(joints[j], *links[j], frame_of[as_size(joint.from)], frame_of[as_size(joint.to)]);
            else
                add_joint(joint.element, frame_of[as_size(joint.from)], frame_of[as_size(joint.to)], *joint.law, joint.pose);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), joint.element);
        }
        if (bonds.size() > before) {
            bonds.back().loss_factor = joint.law->loss_factor;
            for (int d = 0; d < 6; ++d)
                if (auto law = std::dynamic_pointer_cast<const Viscoelastic>(joint.law->laws[as_size(d)]))
                    bonds.back().materials.push_back({d, std::move(law)});
            if (joint.law->axial) are_axial[as_size(joint.element)] = true;
        }
        if (const int h = as_int(j) - assembly.first_joint.back(); h >= 0 && bonds.size() > before)
            bonds.back().held_node = held_nodes[as_size(h)];
    }
    for (uint32_t c = 0; c < model.constraint_count; ++c) {
        const dttmm_constraint& constraint = model.constraints[c];
        JointLaw law;
        law.rigid = Directions(constraint.rigid);
        const size_t before = bonds.size();
        add_joint(-1, constraint.first, constraint.second, law,
                  {Eigen::Map<const Vector3>(constraint.position), Eigen::Map<const RowMajor3>(constraint.axes)});
        constraints.push_back(bonds.size() > before ? as_int(before) : -1);
        if (rest && bonds.size() > before) turn_constraint(model.rest->constraints + 144 * size_t{c}, model.rest->factor);
    }
    add_lines(assembly.lines, frame_of);
    if (rest) add_loads_at_rest(model, *rest);
    if (frames.empty()) throw Error(DTTMM_ERROR_MODEL, "nothing moves: no body and no free node");
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

namespace {

/// Of a line that counts as straight: how far it may be bent, as share of its radius of gyration. An arch that rises by r
/// times that radius is stiffer along by a share of r².
constexpr double kStraight = 0.05;

}  // namespace

/// How far lines are bent, and their forces. Their joints are those of the lumps of the network that came to rest.
void FrequencyModel::find_resting_lines(const dttmm_modal_model& model, const AtRest& rest) {
    resting.resize(element_count);
    const Assembly exact = assemble(*model.network, Waves::exact), lumps = assemble(*model.network);
    for (const LineSpec& line : exact.lines) {
        const auto e = as_size(line.element);
        RestingLine& own = resting[e];
        const std::vector<AtRest::Link>& links = rest.elements[e];
        if (links.size() < 2) continue;
        std::vector<Vector3> points;
        for (size_t k = 0; k < links.size(); ++k) {
            const JointSpec& spec = lumps.joints[as_size(lumps.first_joint[e]) + k];
            const Joint joint(spec, lumps, std::make_shared<JointKind>(spec.law));
            const JointPose pose = joint.pose({links[k].from, links[k].to});
            points.push_back(FrameView(links[k].from).origin() + pose.arm);
            own.forces.push_back(both(pose.axes) * (links[k].force + links[k].rigid));
            if (k == 0) own.axes = pose.axes;
            if (k + 1 == links.size())
                own.turned = rotation_vector(Matrix3(own.axes.transpose() * joint.seat().axes_at_to(links[k].to)));
        }
        // The first joint lies a quarter of a segment from the end
        own.at_from = both(own.axes.transpose()) * own.forces.front();
        const double quarter = (line.finish - line.start).norm() / (4 * static_cast<double>(links.size() - 1));
        own.at_from.tail<3>() += quarter * Vector3::UnitX().cross(Vector3(own.at_from.head<3>()));
        if (model.lumped_beams || line.line.stretches_only) continue;
        const Vector3 chord = (points.back() - points.front()).normalized();
        double away = 0;
        for (const Vector3& point : points) away = std::max(away, (point - points.front()).cross(chord).norm());
        const Section& section = line.line.section;
        const double bending = is_given(section.EIy) && is_given(section.EIz) ? std::min(section.EIy, section.EIz)
                               : is_given(section.EIy)                        ? section.EIy
                                                                              : section.EIz;
        own.share = away / std::sqrt(bending / section.EA);
        own.is_lumped = own.share > kStraight;
    }
}

namespace {

/// What a section has per length at the start, per length at rest; stretch: of these. A run strains it per length at the
/// start.
void scale_to(Section& section, double stretch) {
    for (double* stiffness : {&section.EA, &section.EIy, &section.EIz, &section.GJ, &section.GAy, &section.GAz})
        *stiffness *= stretch;
    for (double* inertia : {&section.mass, &section.inertia, &section.rotary_y, &section.rotary_z}) *inertia /= stretch;
}

}  // namespace

/// Moves the frames of the assembly to where they rest; the link of every joint there.
std::vector<const AtRest::Link*> FrequencyModel::place_at_rest(const AtRest& rest, Assembly& assembly) {
    std::vector<const AtRest::Link*> links;
    std::vector<Pose> start;
    for (const FrameSpec& frame : assembly.frames) start.push_back(frame.pose);
    const auto place = [&](int frame, const dttmm::plugin::Frame& at) {
        assembly.frames[as_size(frame)].pose = {Eigen::Map<const Vector3>(at.position),
                                                Eigen::Map<const RowMajor3>(at.rotation)};
    };
    for (size_t j = 0; j < assembly.joints.size(); ++j) {
        const JointSpec& joint = assembly.joints[j];
        const bool is_held = as_int(j) >= assembly.first_joint.back();
        if (is_held) {
            const auto found = std::ranges::find_if(
                rest.held, [&](const AtRest::Held& held) { return held.position == joint.pose.position; });
            if (found == rest.held.end()) throw Error(DTTMM_ERROR_INTERNAL, "a fixed node is not at rest", joint.element);
            links.push_back(&found->link);
        } else {
            links.push_back(
                &rest.elements[as_size(joint.element)][j - as_size(assembly.first_joint[as_size(joint.element)])]);
        }
        place(joint.from, links.back()->from);
        place(joint.to, links.back()->to);
    }
    for (LineSpec& line : assembly.lines) {
        const std::vector<AtRest::Link>& own = rest.elements[as_size(line.element)];
        const auto carried = [&](int frame, const dttmm::plugin::Frame& at, const Vector3& v) {
            return Vector3(FrameView(at).axes() * (start[as_size(frame)].rotation.transpose() * v));
        };
        const auto carry = [&](int frame, const dttmm::plugin::Frame& at, Vector3& point) {
            point = FrameView(at).origin() + carried(frame, at, point - start[as_size(frame)].position);
        };
        const double length = (line.finish - line.start).norm();
        carry(line.from, own.front().from, line.start);
        carry(line.to, own.back().to, line.finish);
        place(line.from, own.front().from);  // what lines alone join
        place(line.to, own.back().to);
        const double stretched = (line.finish - line.start).norm();
        scale_to(line.line.section, stretched / length);
        const Vector3 x = (line.finish - line.start) / stretched,
                      y = carried(line.from, own.front().from, line.line.axes.col(1)), z = x.cross(y).normalized();
        line.line.axes << x, z.cross(x), z;
    }
    return links;
}

void FrequencyModel::add_joint_at_rest(const dttmm::plugin::Joint& joint, const AtRest::Link& link, int from, int to) {
    if (from < 0 && to < 0) return;
    const Ends at{link.from, link.to};
    const JointPose pose = joint.pose(at);
    const Vector6 x = joint.deformation(pose, at.from, at.to);
    const Vector3 point = at.from.origin() + pose.arm;
    Bond bond;
    bond.element = joint.element();
    bond.from = from;
    bond.to = to;
    bond.points[0] = bond.points[1] = point;
    bond.by_from = at_point(point, origin(from));
    bond.by_to = at_point(point, origin(to));
    bond.axes = both(pose.axes);
    Vector6 tangent = joint.unloading(x);
    for (size_t d = 0; d < 6; ++d)
        if (joint.rigid()[d]) tangent(as_row(d)) = 0;
    const Matrix6 damping = joint.damping_tangent(x);
    bond.springs = tangent;
    bond.stiffness = bond.axes * joint.rest_tangent(x, tangent) * bond.axes.transpose();
    bond.damping = bond.axes * damping * bond.axes.transpose();
    const Matrix6 rows[2] = {rigid_rows(x.tail<3>(), joint.by_from(pose)), rigid_rows(x.tail<3>(), joint.by_to(pose))};
    for_each_rigid(joint, [&](int, int d) {
        bond.held.push_back(bond.axes.col(d));
        bond.hold(rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
    EndBlocks turning = joint.turning_stiffness(at, link.force, link.rigid), both_ways;
    for (int i : {0, 1})
        for (int k : {0, 1}) both_ways.at[i][k] = 0.5 * (turning.at[i][k] + turning.at[k][i].transpose());
    bond.turning = std::make_shared<const EndBlocks>(both_ways);
    bond.spread = joint.spread_tangent(at, link.force, link.rigid);
    bond.turned = joint.turns() ? Vector3(x.tail<3>()) : rotation_vector(joint.attitude(at.from, at.to));
    bonds.push_back(std::move(bond));
}

/// What the forces of the constraint last added do as they turn with its bodies.
void FrequencyModel::turn_constraint(const double* stiffness, double factor) {
    EndBlocks turning;
    const Eigen::Map<const Eigen::Matrix<double, 12, 12, Eigen::RowMajor>> K(stiffness);
    for (int i : {0, 1})
        for (int k : {0, 1}) turning.at[i][k] = factor * K.block<6, 6>(6 * i, 6 * k);
    bonds.back().turning = std::make_shared<const EndBlocks>(turning);
}

/// What loads add whose lever arms turn with the frames that they act on.
void FrequencyModel::add_loads_at_rest(const dttmm_modal_model& model, const AtRest& rest) {
    for (uint32_t b = 0; b < model.network->body_count; ++b)
        levers.push_back(
            {-1, as_int(b), model.rest->factor * Eigen::Map<const Matrix6>(model.rest->loads + 36 * size_t{b})});
    size_t inner = 0;
    for (size_t n = 0; n < nodes.size(); ++n) {
        if (model.network->nodes[n].kind != DTTMM_NODE_INNER) continue;
        const size_t load = inner++;
        if (nodes[n].frame >= 0 && load < rest.loads.size())
            add_lever(-1, nodes[n].frame, nodes[n].position, rest.loads[load].head<3>());
    }
}

/// What a force that keeps its direction adds as its lever arm turns with a frame: symmetric part.
void FrequencyModel::add_lever(int element, int frame, const Vector3& point, const Vector3& force) {
    const Matrix3 aF = skew(point - origin(frame)) * skew(force);
    Matrix6 stiffness = Matrix6::Zero();
    stiffness.bottomRightCorner<3, 3>() = -0.5 * (aF + aF.transpose());
    levers.push_back({element, frame, mask * stiffness * mask});
}

/// What the forces of a bar do as it turns with a frame.
void FrequencyModel::add_bar_force(const LineModel& line, const LineForces& forces) {
    const int frame = line.from >= 0 ? line.from : line.to;
    if (frame < 0) return;
    const Vector3 f = line.axes * forces.mean_force(), e = line.axes.col(0);
    Matrix6 stiffness = Matrix6::Zero();
    stiffness.bottomRightCorner<3, 3>() =
        forces.length() * (f.dot(e) * Matrix3::Identity() - 0.5 * (e * f.transpose() + f * e.transpose()));
    levers.push_back({line.element, frame, stiffness, true});
}

/// What forces of a line but the axial one of its waves do from `start` of it on, where this segment of it begins.
void FrequencyModel::add_deviation(const LineModel& line, const LineForces& forces, double start, const LineShapes& shapes) {
    const Matrix12 K = forces.stiffness(start, line.length(), line.axial, line.line.section.GJ, shapes);
    Bond turning;
    turning.element = line.element;
    turning.from = line.from;
    turning.to = line.to;
    turning.points[0] = line.start;
    turning.points[1] = line.finish;
    turning.by_from = at_point(line.start, origin(line.from));
    turning.by_to = at_point(line.finish, origin(line.to));
    turning.axes = both(line.axes);
    turning.springs.setZero();
    turning.stiffness.setZero();
    turning.damping.setZero();
    const Matrix6 by[2] = {turning.axes.transpose() * turning.by_from, turning.axes.transpose() * turning.by_to};
    EndBlocks blocks;
    for (int i : {0, 1})
        for (int k : {0, 1}) blocks.at[i][k] = by[i].transpose() * K.block<6, 6>(6 * i, 6 * k) * by[k];
    turning.turning = std::make_shared<const EndBlocks>(blocks);
    bonds.push_back(std::move(turning));
}

// ---- The parts ----------------------------------------------------------------------------------------------------------

void FrequencyModel::add_bodies(const dttmm_network& network, const dttmm_rest* rest) {
    for (uint32_t b = 0; b < network.body_count; ++b) {
        const dttmm_body& body = network.bodies[b];
        const Eigen::Map<const Vector3> position(body.position);
        const Eigen::Map<const RowMajor3> inertia(body.inertia);
        if (!position.allFinite() || !inertia.allFinite() || !(body.mass > 0 && std::isfinite(body.mass)))
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("body \"{}\": its numbers must be finite", body.name));
        Vector3 centre = position;
        Matrix3 moment = inertia;
        if (rest) {
            const dttmm_motion& now = rest->bodies[b];
            const Matrix3 turn =
                Eigen::Map<const RowMajor3>(now.rotation) * Eigen::Map<const RowMajor3>(body.rotation).transpose();
            centre = Eigen::Map<const Vector3>(now.position);
            moment = turn * moment * turn.transpose();
        }
        frames.push_back({centre, fmt::format("body \"{}\"", body.name), -1});
        centres.push_back(centre);
        masses.push_back({as_int(b), mass_block(body.mass, moment)});
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
    for (const LineSpec& spec : specs) {
        const int from = frame_of[as_size(spec.from)], to = frame_of[as_size(spec.to)];
        total_mass += spec.line.section.mass * (spec.finish - spec.start).norm();
        try {
            if (!is_at_rest) {
                add_line(spec, from, to, {});
                if (lines.back().waves->pinned().any()) add_pin(lines.back());
                continue;
            }
            std::vector<Vector6> forces = resting[as_size(spec.element)].forces;
            for (Vector6& own : forces) own = both(spec.line.axes.transpose()) * own;
            add_line(spec, from, to, LineForces(std::move(forces), (spec.finish - spec.start).norm()));
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), spec.element);
        }
    }
}

/// forces: at rest. Where they are not uniform the line is cut.
void FrequencyModel::add_line(const LineSpec& spec, int from, int to, const std::optional<LineForces>& forces) {
    const bool is_bar = spec.line.stretches_only;
    const int segments = !forces || is_bar ? 1 : forces->pieces(spec.line.section);
    const double axial = forces ? forces->mean_force().x() : 0, step = (spec.finish - spec.start).norm() / segments;
    const size_t kind = find_kind(spec, step, axial);
    const LineShapes shapes = segments > 1 ? kinds[kind]->static_shapes() : LineShapes{};
    int last = from;
    for (int i = 0; i < segments; ++i) {
        const auto point = [&](int k) { return Vector3(spec.start + double(k) / segments * (spec.finish - spec.start)); };
        int next = to;
        if (i + 1 < segments) {
            next = as_int(frames.size());
            frames.push_back({point(i + 1), "a point of it", spec.element});
        }
        lines.push_back(
            {spec.element, last, next, point(i), point(i + 1), spec.line.axes, spec.line, kind, kinds[kind].get(), axial});
        if (segments > 1) {
            add_deviation(lines.back(), *forces, i * step, shapes);
            lines.back().deviation = as_int(bonds.size()) - 1;
        }
        last = next;
    }
    if (!forces) return;
    if (is_bar) add_bar_force(lines.back(), *forces);
    if (from >= 0) add_lever(spec.element, from, spec.start, spec.line.axes * forces->first().head<3>());
    if (to >= 0) add_lever(spec.element, to, spec.finish, -spec.line.axes * forces->last().head<3>());
}

/// The waves of a line of that length; lines alike share them.
size_t FrequencyModel::find_kind(const LineSpec& spec, double length, double axial) {
    const Directions active = active_axes(spec);
    const Key key = {std::bit_cast<std::tuple_element_t<0, Key>>(spec.line.section), length, spec.line.stretches_only,
                     active.to_ulong(), axial};
    const auto [kind, is_new] = known_kinds_.try_emplace(key, kinds.size());
    if (is_new) kinds.push_back(std::make_unique<LineWaves>(spec.line, length, active, axial));
    return kind->second;
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
    }) || stiffest_turning() > 0;
}

double FrequencyModel::stiffest_turning() const {
    struct Turned {
        double stiffness = 0, mass = 0, inertia = 0, arm = 0;
    };
    std::vector<Turned> turned(frames.size());
    const auto add = [&](int frame, const Matrix6& K) {
        if (frame >= 0) turned[as_size(frame)].stiffness += K.bottomRightCorner<3, 3>().norm();
    };
    const auto hang = [&](int frame, const Vector6& row) {
        if (frame < 0 || row.head<3>().isZero(0)) return;
        double& arm = turned[as_size(frame)].arm;
        arm = std::max(arm, row.tail<3>().norm() / row.head<3>().norm());
    };
    for (const Lever& lever : levers) add(lever.frame, lever.stiffness);
    for (const Mass& mass : masses) {
        turned[as_size(mass.frame)].mass += mass.block.topLeftCorner<3, 3>().trace() / 3;
        turned[as_size(mass.frame)].inertia += mass.block.bottomRightCorner<3, 3>().trace() / 3;
    }
    for (const Bond& bond : bonds) {
        if (bond.turning) add(bond.from, bond.turning->at[0][0]);
        if (bond.turning) add(bond.to, bond.turning->at[1][1]);
        for (const Rigid& rigid : bond.rigid) {
            hang(bond.from, rigid.by_from);
            hang(bond.to, rigid.by_to);
        }
    }
    double largest = 0;
    for (const Turned& frame : turned) {
        const double inertia = frame.inertia + frame.mass * frame.arm * frame.arm;
        if (inertia > 0) largest = std::max(largest, frame.stiffness / inertia);
    }
    return largest;
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
