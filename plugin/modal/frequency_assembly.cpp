// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_assembly.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/state_vector.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

/// Cosine of an angle that is round-off.
constexpr double kAligned = 1e-9;

Matrix6 mass_block(double mass, const Matrix3& inertia) {
    Matrix6 block = Matrix6::Zero();
    block.diagonal().head<3>().setConstant(mass);
    block.bottomRightCorner<3, 3>() = inertia;
    return block;
}

/// Axial forces of a load factor that no section bears: EA presses a line to no length, GA pulls it into a sideways snap
/// that only the linear law has.
void refuse_beyond_section(const LineWaves::Axial& axial, const Section& section) {
    const double shear = std::min(section.GAy, section.GAz),
                 most = is_given(shear) ? std::min(shear, section.EA) : section.EA;
    for (const double force : axial)
        if (force > most || -force > section.EA)
            throw Error(DTTMM_ERROR_NUMERIC,
                        fmt::format("its axial force of {:.3g} N is beyond its {} of {:.3g} N per length at rest", force,
                                    force > most && most < section.EA ? "GA" : "EA", force > most ? most : section.EA));
}

}  // namespace

FrequencyAssembly::FrequencyAssembly(FrequencyModel& model, const dttmm_modal_model& description, const AtRest* rest)
    : model_(model), description_(description) {
    if (rest) resting_.emplace(model, description, *rest);
}

void FrequencyAssembly::run() {
    std::vector<bool> lumped(model_.element_count);
    if (resting_) {
        resting_->find_lines();
        for (size_t e = 0; e < lumped.size(); ++e) lumped[e] = model_.resting[e].is_lumped;
    }
    Assembly assembly = assemble(*description_.network, description_.lumped_beams ? Waves::lumped : Waves::exact, &lumped);
    std::vector<Joint> joints;  // as they sit in the assembled machine
    std::vector<const AtRest::Link*> links;
    if (resting_) {
        for (const JointSpec& joint : assembly.joints)
            joints.emplace_back(joint, assembly, std::make_shared<JointKind>(joint.law));
        links = resting_->place(assembly);
    }
    add_bodies();
    add_inner_frames(assembly);
    add_nodes(assembly);
    add_joints(assembly, joints, links);
    add_constraints();
    add_lines(assembly.lines);
    if (resting_) resting_->add_loads(assembly, frame_of_);
    if (model_.frames.empty() && model_.lines.empty())
        throw Error(DTTMM_ERROR_MODEL, "nothing moves: no body and no free node");
}

void FrequencyAssembly::add_bodies() {
    const dttmm_network& network = *description_.network;
    const dttmm_rest* const rest = description_.rest;
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
        model_.frames.push_back({centre, fmt::format("body \"{}\"", body.name), -1});
        model_.centres.push_back(centre);
        model_.masses.push_back({as_int(b), mass_block(body.mass, moment)});
        model_.total_mass += body.mass;
    }
}

/// Masses and nodes of the network.
void FrequencyAssembly::add_inner_frames(const Assembly& assembly) {
    for (const FrameSpec& spec : assembly.frames) {
        const bool is_port = as_int(frame_of_.size()) < assembly.port_count;
        frame_of_.push_back(is_port ? as_int(frame_of_.size()) : -1);
        if (is_port || spec.kind != FrameSpec::Kind::inner) continue;
        const int own = frame_of_.back() = as_int(model_.frames.size());
        model_.frames.push_back({spec.pose.position, spec.name(), spec.element});
        const Matrix3& R = spec.pose.rotation;
        if (spec.mass > 0) model_.masses.push_back({own, mass_block(spec.mass, R * spec.inertia * R.transpose())});
        model_.total_mass += spec.mass;
    }
}

void FrequencyAssembly::add_nodes(const Assembly& assembly) {
    const dttmm_network& network = *description_.network;
    for (const NodeSpec& node : assembly.nodes) {
        const Pose& pose = assembly.frames[as_size(node.frame)].pose;
        model_.nodes.push_back({frame_of_[as_size(node.frame)], pose.position + pose.rotation * node.offset});
    }
    if (!model_.directions.all()) refer_masses(assembly);
    for (uint32_t e = 0; e < network.element_count; ++e) {
        const dttmm_element& own = network.elements[e];
        model_.ends.push_back({as_int(own.ends[0]), as_int(own.ends[own.end_count > 1 ? 1 : 0])});
    }
    for (uint32_t n = 0; n < network.node_count; ++n) {
        const dttmm_node& node = network.nodes[n];
        model_.fixed.push_back(node.kind == DTTMM_NODE_GROUND ? 0x3f : node.kind == DTTMM_NODE_INNER ? node.fixed : 0);
    }
}

/// In a reduced state directions are left out at the first node of a frame, and of a segment on the elastic axis. The centre
/// of mass keeps all the velocity that the rotations give it, as in the paper's J_xx + m (c2² + c3²).
void FrequencyAssembly::refer_masses(const Assembly& assembly) {
    std::vector<std::optional<Vector3>> points(model_.frames.size());
    for (const FrequencyModel::Node& node : model_.nodes)
        if (node.frame >= 0 && !points[as_size(node.frame)]) points[as_size(node.frame)] = node.position;
    for (const SegmentsSpec& line : assembly.segments)
        for (int s = line.first; s < line.first + line.count; ++s) {
            const Pose& pose = assembly.frames[as_size(s)].pose;
            points[as_size(frame_of_[as_size(s)])] = pose.position + pose.rotation * line.arm;
        }
    for (FrequencyModel::Mass& mass : model_.masses) {
        const std::optional<Vector3>& point = points[as_size(mass.frame)];
        if (!point) continue;
        const Matrix6 to_centre = FrequencyModel::at_point(model_.frames[as_size(mass.frame)].position, *point);
        mass.block = to_centre.transpose() * mass.block * to_centre;
    }
    for (size_t f = 0; f < points.size(); ++f)
        if (points[f]) model_.frames[f].position = *points[f];
}

/// joints, links: of a machine at rest.
void FrequencyAssembly::add_joints(const Assembly& assembly, const std::vector<Joint>& joints,
                                   const std::vector<const AtRest::Link*>& links) {
    model_.are_axial.resize(model_.element_count);
    for (size_t j = 0; j < assembly.joints.size(); ++j) {
        const JointSpec& joint = assembly.joints[j];
        const int from = frame_of_[as_size(joint.from)], to = frame_of_[as_size(joint.to)];
        const size_t before = model_.bonds.size();
        try {
            if (resting_) {
                const Frame at_from = make_frame(assembly.frames[as_size(joint.from)].pose),
                            at_to = make_frame(assembly.frames[as_size(joint.to)].pose);
                resting_->add_joint(joints[j], *links[j], {at_from, at_to}, from, to);
            } else {
                add_joint(joint.element, from, to, *joint.law, joint.pose);
            }
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), joint.element);
        }
        if (model_.bonds.size() == before) continue;
        Bond& bond = model_.bonds.back();
        bond.loss_factor = joint.law->loss_factor;
        for (int d = 0; d < 6; ++d)
            if (auto law = std::dynamic_pointer_cast<const Viscoelastic>(joint.law->laws[as_size(d)]))
                bond.materials.push_back({d, std::move(law)});
        if (joint.law->axial) model_.are_axial[as_size(joint.element)] = true;
        if (const int h = as_int(j) - assembly.first_joint.back(); h >= 0) bond.held_node = assembly.held_nodes[as_size(h)];
    }
}

void FrequencyAssembly::add_constraints() {
    for (uint32_t c = 0; c < description_.constraint_count; ++c) {
        const dttmm_constraint& constraint = description_.constraints[c];
        JointLaw law;
        law.rigid = Directions(constraint.rigid);
        const size_t before = model_.bonds.size();
        add_joint(-1, constraint.first, constraint.second, law,
                  {Eigen::Map<const Vector3>(constraint.position), Eigen::Map<const RowMajor3>(constraint.axes)});
        const bool is_new = model_.bonds.size() > before;
        model_.constraints.push_back(is_new ? as_int(before) : -1);
        if (resting_ && is_new)
            resting_->turn_constraint(description_.rest->constraints + 144 * size_t{c}, description_.rest->factor);
    }
}

void FrequencyAssembly::add_joint(int element, int from, int to, const JointLaw& law, const Pose& pose) {
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
    bond.by_from = model_.masked_at(bond.points[0], model_.origin(from));
    bond.by_to = model_.masked_at(bond.points[1], model_.origin(to));
    for (size_t d = 0; d < 6; ++d) {
        const auto i = as_row(d);
        if (!law.rigid[d]) continue;
        stiffness(i) = damping(i) = 0;
        const Eigen::Matrix<double, 1, 6> row = axes.col(i).transpose();
        bond.held.push_back(model_.mask * axes.col(i));
        bond.hold(-(row * bond.by_from).transpose(), (row * bond.by_to).transpose());
    }
    bond.axes = axes;
    bond.springs = stiffness;
    bond.stiffness = axes * stiffness.asDiagonal() * axes.transpose();
    bond.damping = axes * damping.asDiagonal() * axes.transpose();
    model_.bonds.push_back(std::move(bond));
}

/// The local directions of a line that the model leaves. Throws Error where one lies at an angle to these.
Directions FrequencyAssembly::active_axes(const LineSpec& spec) const {
    Directions active;
    for (size_t d = 0; d < 6; ++d) {
        const auto half = as_row(3 * (d / 3));
        const double share =
            (model_.mask.diagonal().segment<3>(half).cwiseProduct(spec.line.axes.col(as_row(d % 3)))).norm();
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

void FrequencyAssembly::add_lines(const std::vector<LineSpec>& specs) {
    for (const LineSpec& spec : specs) try {
            if (resting_)
                add_resting_line(spec);
            else
                add_line(spec, {}, Matrix3::Zero());
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), spec.element);
        }
}

/// A line between two points of one frame is cut: what it does is seen at the point between, and links join different
/// frames.
void FrequencyAssembly::add_line(const LineSpec& spec, LineWaves::Axial axial, const Matrix3& falling) {
    const int pieces = spec.from == spec.to ? 2 : 1;
    const double length = (spec.finish - spec.start).norm() / pieces;
    model_.total_mass += spec.line.section.mass * pieces * length;
    const auto point = [&](int i) { return Vector3(spec.start + double(i) / pieces * (spec.finish - spec.start)); };
    for (int i = 0; i < pieces; ++i) {
        const auto at = [&](int k) { return axial[0] + double(k) / pieces * (axial[1] - axial[0]); };
        add_piece(spec, i, pieces, point(i), point(i + 1), spec.line.axes, length, {at(i), at(i + 1)}, falling);
    }
    if (!resting_ && model_.lines.back().waves->pinned().any()) add_pin(model_.lines.back());
}

/// The next piece of a line, from where the last one ends.
void FrequencyAssembly::add_piece(const LineSpec& spec, int index, int count, const Vector3& start, const Vector3& finish,
                                  const Matrix3& axes, double length, LineWaves::Axial axial, const Matrix3& falling) {
    const int from = index == 0 ? frame_of_[as_size(spec.from)] : model_.lines.back().to;
    int to = frame_of_[as_size(spec.to)];
    if (index + 1 < count) {
        to = as_int(model_.frames.size());
        model_.frames.push_back({finish, "a point of it", spec.element});
    }
    const size_t kind = find_kind(spec, length, axial, falling);
    model_.lines.push_back({spec.element, from, to, start, finish, axes, spec.line, kind, model_.kinds[kind].get()});
}

/// A line at rest follows its bent axis in straight pieces, each with waves under its own axial force.
void FrequencyAssembly::add_resting_line(const LineSpec& spec) {
    const LineForces forces = resting_->forces_of(spec);
    const Section& section = spec.line.section;
    const bool is_bar = spec.line.stretches_only;
    const Vector3 along = spec.line.axes.col(0);
    const LineWaves::Axial axial = {forces.first().head<3>().dot(along), forces.last().head<3>().dot(along)};
    if (description_.rest->factor > 1) refuse_beyond_section(axial, section);
    const int from = frame_of_[as_size(spec.from)], to = frame_of_[as_size(spec.to)],
              by_forces = is_bar ? 0 : forces.pieces(section);
    int count = std::max(from == to ? 2 : 1, by_forces);
    // The shapes of pieces at rest are those of their waves, which a strong axial force bends sharply at the ends
    if (by_forces > 0)
        count = std::max(count,
                         LineWaves(spec.line, forces.length(), active_axes(spec), axial).pieces(0, LineWaves::kMostPieces));
    if (count > LineWaves::kMostPieces) throw Error(DTTMM_ERROR_MEMORY, LineWaves::too_strong_to_cut());
    if (by_forces == 0) {
        add_line(spec, axial, forces.falling_in(spec.line.axes, section));
        if (is_bar) resting_->add_bar_force(model_.lines.back(), forces);
    } else {
        const std::vector<LineForces::Piece> pieces = forces.cut(count, section);
        for (int i = 0; i < count; ++i) {
            const LineForces::Piece& piece = pieces[as_size(i)];
            LineSpec scaled = spec;
            scale_to(scaled.line.section, piece.length * count / forces.length());
            add_piece(scaled, i, count, forces.point(piece.from), forces.point(piece.to), piece.axes, piece.length,
                      piece.axial, forces.falling_in(piece.axes, scaled.line.section));
            const LineModel& line = model_.lines.back();
            if (!shapes_ || shapes_->kind != line.kind) shapes_ = {line.kind, line.waves->static_shapes()};
            resting_->add_deviation(line, forces.stiffness(piece, scaled.line.section, shapes_->at_rest));
            model_.lines.back().deviation = as_int(model_.bonds.size()) - 1;
            model_.total_mass += scaled.line.section.mass * piece.length;
        }
    }
    if (from >= 0) resting_->add_lever(spec.element, from, spec.start, forces.first().head<3>());
    if (to >= 0) resting_->add_lever(spec.element, to, spec.finish, -forces.last().head<3>());
}

/// The waves of a line of that length; lines alike share them.
size_t FrequencyAssembly::find_kind(const LineSpec& spec, double length, LineWaves::Axial axial, const Matrix3& falling) {
    const Directions active = active_axes(spec);
    std::array<double, 9> numbers{};
    Eigen::Map<Matrix3>(numbers.data()) = falling;
    const Key key = {std::bit_cast<std::tuple_element_t<0, Key>>(spec.line.section),
                     length,
                     spec.line.stretches_only,
                     active.to_ulong(),
                     axial,
                     numbers};
    const auto [kind, is_new] = known_kinds_.try_emplace(key, model_.kinds.size());
    if (is_new) model_.kinds.push_back(std::make_unique<LineWaves>(spec.line, length, active, axial, falling));
    return kind->second;
}

void FrequencyAssembly::add_pin(const LineModel& line) {
    const Matrix6 to_local = both(line.axes.transpose());
    Pin pin{{line.element,
             line.from,
             line.to,
             to_local * model_.masked_at(line.start, model_.origin(line.from)),
             to_local * model_.masked_at(line.finish, model_.origin(line.to)),
             {}},
            Matrix6::Zero()};
    for (Eigen::Index d : {1, 2})
        if (line.waves->pinned()[as_size(d)]) pin.mass(d, d) = line.line.section.mass * line.length();
    model_.pins.push_back(pin);
}

}  // namespace dttmm::plugin
