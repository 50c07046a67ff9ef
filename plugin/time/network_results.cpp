// SPDX-License-Identifier: BSD-3-Clause
#include "time/network_results.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "core/rotation.h"

namespace dttmm::plugin {

namespace {

using Map3 = Eigen::Map<Vector3>;

/// A pull N straightens a beam within a few λ = √(EI/N) of an end that a moment M bends, and which turns by M/√(EI N).
/// Segments with r = l²/λ² turn it too little, by a share of r/(1000 + r) or less: measured 0.3 % at r = 7, 0.9 % at 16, 2 %
/// at 28, 6 % at 63, 54 % at 1000. Returns that error as a share of the largest that counts as resolved.
/// section: forces of the end section; law: of the link there, half as long as a segment.
double unresolved_turn(const Vector6& section, const JointLaw& law, double segment) {
    constexpr double kMostError = 0.02;  // rad
    const double pull = section(0);
    double most = 0;
    for (const int about : {4, 5}) {
        const double bending = 0.5 * law.stiffness(about) * segment;  // EI
        if (!(pull > 0 && bending > 0)) continue;
        const double r = pull * segment * segment / bending;
        most = std::max(most, std::abs(section(about)) / std::sqrt(bending * pull) * r / (1000 + r) / kMostError);
    }
    return most;
}

}  // namespace

// ---- Channels -----------------------------------------------------------------------------------------------------------

NetworkResults::NetworkResults(const dttmm_network& description, const Places& places, const Mechanism& mechanism,
                               const Interior* interior)
    : places_(places), mechanism_(mechanism), interior_(interior) {
    constexpr size_t kOfOneJoint = 14;  // channels at most
    piece_begin_.reserve(description.element_count + 2);
    channels_.reserve(kOfOneJoint * description.element_count);
    for (uint32_t e = 0; e < description.element_count; ++e) {
        piece_begin_.push_back(channels_.size());
        declare_element(description, e);
    }
    piece_begin_.push_back(channels_.size());
    declare_inner(description);
    declare_reactions(description);
    piece_begin_.push_back(channels_.size());
    piece_places_.assign(piece_begin_.begin(), piece_begin_.end() - 1);
}

void NetworkResults::declare(std::string_view name, const char* unit, uint32_t of, uint32_t index, uint32_t role) {
    const uint32_t at = (of == DTTMM_OF_ELEMENT ? places_.elements : places_.nodes)[index];
    channels_.push_back({keep(name), unit, of, at, role});
}

/// The next channel of the element before has the same name, mostly: then that.
const char* NetworkResults::keep(std::string_view name) {
    if (const size_t elements = piece_begin_.size(); elements > 1) {
        const size_t twin = piece_begin_[elements - 2] + channels_.size() - piece_begin_[elements - 1];
        if (twin < piece_begin_[elements - 1] && channels_[twin].name == name) return channels_[twin].name;
    }
    char* kept = static_cast<char*>(names_->allocate(name.size() + 1, 1));
    *std::ranges::copy(name, kept).out = '\0';
    return kept;
}

void NetworkResults::declare_vectors(const std::string& prefix,
                                     std::initializer_list<std::pair<const char*, const char*>> vectors, uint32_t of,
                                     uint32_t index, uint32_t role) {
    for (const auto& [name, unit] : vectors) {
        std::string full = prefix + name + ". ";
        for (const char axis : {'x', 'y', 'z'}) {
            full.back() = axis;
            declare(full, unit, of, index, role);
        }
    }
}

void NetworkResults::declare_element(const dttmm_network& description, uint32_t e) {
    const int first = first_joint(e), count = joint_count(e);
    if (count == 0) return;
    if (count == 1 && mechanism_.joints[as_size(first)].is_axial()) {
        declare("force", "N", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_RESULT);
        declare("length", "m", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_RESULT);
    } else {
        declare_vectors("", {{"force", "N"}, {"moment", "N*m"}, {"deflection", "m"}}, DTTMM_OF_ELEMENT, e,
                        DTTMM_ROLE_RESULT);
        // Where nothing resists it a rotation may go on for ever, and its vector then jumps
        const bool turns = count > 1 || mechanism_.joints[as_size(first)].turns();
        declare_vectors("", {{"rotation", "rad"}}, DTTMM_OF_ELEMENT, e, turns ? DTTMM_ROLE_RESULT : DTTMM_ROLE_ON_REQUEST);
    }
    declare("strain_energy", "J", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_STRAIN_ENERGY);
    declare("dissipated_energy", "J", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_DISSIPATED_ENERGY);
    if (count > 1) declare_chain(description, e);
}

void NetworkResults::declare_chain(const dttmm_network& description, uint32_t e) {
    const Assembly& assembly = mechanism_.assembly;
    if (has_limit(first_joint(e))) declare("turn_to_limit", "1", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_LIMIT);
    ChainView& chain = chains_.emplace_back();
    const auto segments = std::ranges::find(assembly.segments, as_int(e), &SegmentsSpec::element);
    if (segments != assembly.segments.end()) chain.moduli = segments->moduli;
    for (int k = 0; k < joint_count(e); ++k) {
        declare_vectors(fmt::format("section{}.", k), {{"force", "N"}, {"moment", "N*m"}}, DTTMM_OF_ELEMENT, e,
                        DTTMM_ROLE_ON_REQUEST);
        if (chain.moduli.are_known())
            declare(fmt::format("section{}.stress", k), "Pa", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_ON_REQUEST);
    }
    chain.from_node = as_int(description.elements[e].ends[0]);
    chain.to_node = as_int(description.elements[e].ends[1]);
    const Matrix3& axes = assembly.joints[as_size(first_joint(e))].pose.rotation;
    const auto pose = [&](int node) -> const Pose& {
        return assembly.frames[as_size(assembly.nodes[as_size(node)].frame)].pose;
    };
    chain.from_axes = pose(chain.from_node).rotation.transpose() * axes;
    chain.to_axes = pose(chain.to_node).rotation.transpose() * axes;
    const auto place = [&](int node) { return Vector3(Eigen::Map<const Vector3>(description.nodes[node].position)); };
    chain.rest = axes.transpose() * (place(chain.to_node) - place(chain.from_node));
}

void NetworkResults::declare_inner(const dttmm_network& description) {
    if (!interior_) return;
    const Assembly& assembly = mechanism_.assembly;
    for (uint32_t n = 0; n < description.node_count; ++n) {
        if (description.nodes[n].kind != DTTMM_NODE_INNER || assembly.nodes[n].frame < assembly.driven_count) continue;
        nodes_.push_back(as_int(n));
        declare_vectors("",
                        {{"position", "m"},
                         {"velocity", "m/s"},
                         {"acceleration", "m/s^2"},
                         {"rotation", "rad"},
                         {"angular_velocity", "rad/s"}},
                        DTTMM_OF_NODE, n, DTTMM_ROLE_RESULT);
    }
    declare("kinetic_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_KINETIC_ENERGY);
    declare("work", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_WORK);
}

/// What supports do to nodes with fixed directions. A node with all of them is a point of the ground or of the body of its
/// support; another hangs on it by a joint of its own, behind those of the elements, in the order of the nodes.
void NetworkResults::declare_reactions(const dttmm_network& description) {
    const Assembly& assembly = mechanism_.assembly;
    auto holding = as_size(assembly.first_joint.back());
    for (uint32_t n = 0; n < description.node_count; ++n) {
        const uint32_t fixed = description.nodes[n].fixed;
        const bool is_supported = !places_.supported_by.empty() && places_.supported_by[n] >= 0;
        if (fixed == 0 || (description.nodes[n].kind != DTTMM_NODE_INNER && !is_supported)) continue;
        const bool is_driven = assembly.nodes[n].frame < assembly.driven_count;
        const int frame = is_driven ? assembly.nodes[n].frame : mechanism_.joints[holding++].from();
        reactions_.push_back({as_int(n), frame, (fixed & 7) != 0, (fixed & 0x38) != 0, is_driven && is_supported});
        if (reactions_.back().has_force) declare_vectors("", {{"reaction", "N"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_RESULT);
        if (reactions_.back().has_moment)
            declare_vectors("", {{"reaction_moment", "N*m"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_RESULT);
        if (reactions_.back().has_place)
            declare_vectors("", {{"position", "m"}, {"rotation", "rad"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_ON_REQUEST);
    }
}

// ---- What is written ---------------------------------------------------------------------------------------------------

void NetworkResults::write(const Instant& instant, double* values) const {
    const size_t elements = mechanism_.assembly.first_joint.size() - 1;
    auto chain = chains_.begin();
    for (size_t e = 0; e < elements; ++e) {
        const int count = joint_count(e);
        double* const out = values + piece_places_[e];
        if (count == 1)
            write_energies(write_joint(instant, out, as_size(first_joint(e))), first_joint(e), first_joint(e + 1));
        else if (count > 1)
            write_chain(instant, out, e, *chain++);
    }
    double* out = values + piece_places_[elements];
    if (interior_) {
        for (int node : nodes_) out = write_node(out, as_size(node));
        *out++ = interior_->instant().kinetic_energy();
        *out++ = interior_->work();
    }
    for (const ReactionView& reaction : reactions_) out = write_reaction(instant, out, reaction);
}

double* NetworkResults::write_joint(const Instant& instant, double* out, size_t j) const {
    const Joint& joint = mechanism_.joints[j];
    if (joint.is_axial()) {
        out[0] = instant.force(j)(0);
        out[1] = mechanism_.states[j].d_before(0) + joint.law().axial->natural;
        return out + 2;
    }
    Eigen::Map<Vector6>{out} = instant.force(j);
    Map3{out + 6} = mechanism_.states[j].d_before;
    const FrameView from = mechanism_.frame_before(joint.from()), to = mechanism_.frame_before(joint.to());
    Map3{out + 9} = joint.turns() ? mechanism_.states[j].theta_before : rotation_vector(joint.attitude(from, to));
    return out + 12;
}

/// Strain and dissipated energy of joints first … last − 1.
double* NetworkResults::write_energies(double* out, int first, int last) const {
    double strain = 0, dissipated = 0;
    for (auto j = as_size(first); j < as_size(last); ++j) {
        const Joint& joint = mechanism_.joints[j];
        strain += joint.strain_energy(mechanism_.states[j].d_before, mechanism_.states[j].theta_before,
                                      mechanism_.memory_before(j));
        if (const DamperState* damper = mechanism_.damper(j)) dissipated += damper->dissipated;
    }
    out[0] = strain;
    out[1] = dissipated;
    return out + 2;
}

/// A beam or rod: force and moment at its `from` end, motion of its `to` end against that, then what its sections carry.
double* NetworkResults::write_chain(const Instant& instant, double* out, size_t element, const ChainView& chain) const {
    const Assembly& assembly = mechanism_.assembly;
    const int first = assembly.first_joint[element], last = assembly.first_joint[element + 1];
    double* const total = out;
    const NodeSpec &from_node = assembly.nodes[as_size(chain.from_node)], &to_node = assembly.nodes[as_size(chain.to_node)];
    const FrameView from = mechanism_.frame_before(from_node.frame), to = mechanism_.frame_before(to_node.frame);
    const Matrix3 axes = from.axes() * chain.from_axes;
    const Vector3 way = to.origin() + to.axes() * to_node.offset - from.origin() - from.axes() * from_node.offset;
    Map3{total + 6} = axes.transpose() * way - chain.rest;
    Map3{total + 9} = rotation_vector(axes.transpose() * to.axes() * chain.to_axes);
    out = write_energies(total + 12, first, last);
    double none = 0;
    double& turn_to_limit = has_limit(first) ? *out++ : none;
    turn_to_limit = 0;
    const double segment = chain.rest.norm() / (last - first - 1);

    for (int j = first; j < last; ++j) {
        const JointLaw& law = mechanism_.joints[as_size(j)].law();
        turn_to_limit = std::max(turn_to_limit, law.used(mechanism_.states[as_size(j)].deformation_before()));
        const Vector6 f = section_forces(instant, chain, {first, last}, j);
        Eigen::Map<Vector6>{out} = f;
        if (j == first) Eigen::Map<Vector6>{total} = f;
        const bool is_end = j == first || j == last - 1;
        if (is_end) turn_to_limit = std::max(turn_to_limit, unresolved_turn(f, law, segment));
        out += 6;
        if (chain.moduli.are_known()) *out++ = chain.moduli.extreme_stress(f(0), f(4), f(5));
    }
    return out;
}

/// What the section of a joint carries, [force; moment about the section] in the section's axes. The joints of whole
/// segments sit at the sections, half way between the frames that they join. Those of the half segments lie a quarter of a
/// segment inside the ends, whose sections go with the nodes.
Vector6 NetworkResults::section_forces(const Instant& instant, const ChainView& chain, std::pair<int, int> joints,
                                       int j) const {
    const JointState& state = mechanism_.states[as_size(j)];
    const Vector6 f = instant.force(as_size(j));
    const Vector3 force = f.head<3>();
    Vector3 at_joint = f.tail<3>();
    // In the joint's axes: from the section to where the joint acts; how the section is turned against these axes
    Vector3 way = 0.5 * state.d_before, turn = 0.5 * state.theta_before;
    if (j == joints.first) {
        way = way_to_first_joint(chain, j);
        turn.setZero();
    } else if (j == joints.second - 1) {
        const double quarter = chain.rest.norm() / (4 * (joints.second - joints.first - 1));
        turn = state.theta_before;
        way = turned(turn, Vector3(-quarter, 0, 0));
    } else {
        // The stiffness times the curvature. The rest of what the joint carries balances its pull beside the bent axis
        const double arm = 2 * mechanism_.joints[as_size(j)].law().line.bow;
        at_joint.tail<2>() += arm * force.x() * state.theta_before.tail<2>();
    }
    Vector6 own;
    const Matrix3 to_section = rotation_from_vector(-turn);
    own << to_section * force, to_section * (at_joint + way.cross(force));
    return own;
}

/// From the node at the `from` end to where the first joint acts, its axes.
Vector3 NetworkResults::way_to_first_joint(const ChainView& chain, int j) const {
    const Joint& joint = mechanism_.joints[as_size(j)];
    const FrameView from = mechanism_.frame_before(joint.from());
    const JointPose pose = joint.pose(from, mechanism_.frame_before(joint.to()));
    return pose.axes.transpose() * (pose.arm - from.axes() * mechanism_.assembly.nodes[as_size(chain.from_node)].offset);
}

std::vector<uint32_t> NetworkResults::lines() const {
    const std::vector<int>& first_joint = mechanism_.assembly.first_joint;
    std::vector<uint32_t> lines;
    for (size_t e = 0; e + 1 < first_joint.size(); ++e)
        if (first_joint[e + 1] - first_joint[e] > 1) lines.push_back(places_.elements[e]);
    return lines;
}

/// Of a section of a beam or rod: its joint's, in the middle between what it joins; at the ends the node's [m, world].
Vector3 NetworkResults::section_position(size_t element, const ChainView& chain, int section) const {
    const Assembly& assembly = mechanism_.assembly;
    const int first = assembly.first_joint[element], last = assembly.first_joint[element + 1] - 1;
    if (section == 0 || first + section == last) {
        const NodeSpec& node = assembly.nodes[as_size(section == 0 ? chain.from_node : chain.to_node)];
        const FrameView at = mechanism_.frame_before(node.frame);
        return at.origin() + at.axes() * node.offset;
    }
    const auto j = as_size(first + section);
    const Joint& joint = mechanism_.joints[j];
    const FrameView from = mechanism_.frame_before(joint.from()), to = mechanism_.frame_before(joint.to());
    return to.origin() + joint.seat().lever(to) - 0.5 * (joint.seat().axes(from) * mechanism_.states[j].d_before);
}

double* NetworkResults::write_lines(uint32_t stations, double* positions) const {
    const std::vector<int>& first_joint = mechanism_.assembly.first_joint;
    auto chain = chains_.begin();
    for (size_t e = 0; e + 1 < first_joint.size(); ++e) {
        const int sections = first_joint[e + 1] - first_joint[e];
        if (sections <= 1) continue;  // a joint, or what stands at nodes
        const ChainView& view = *chain++;
        for (uint32_t s = 0; s < stations; ++s, positions += 3) {
            const double place = static_cast<double>(s) * (sections - 1) / (stations - 1);
            const int before = std::min(static_cast<int>(place), sections - 2);
            const double share = place - before;
            Map3{positions} =
                (1 - share) * section_position(e, view, before) + share * section_position(e, view, before + 1);
        }
    }
    return positions;
}

double* NetworkResults::write_node(double* out, size_t node) const {
    const NodeSpec& spec = mechanism_.assembly.nodes[node];
    const FrameView before = mechanism_.frame_before(spec.frame);
    const Matrix3& start = mechanism_.assembly.frames[as_size(spec.frame)].pose.rotation;
    const Twist v = interior_->instant().velocity(spec.frame, spec.offset);
    const Twist a = interior_->instant().acceleration(spec.frame, spec.offset);
    const Vector3 turned = rotation_vector(before.axes() * start.transpose());
    for (const Vector3& vector :
         {Vector3(before.origin() + before.axes() * spec.offset), v.linear, a.linear, turned, v.angular}) {
        Map3{out} = vector;
        out += 3;
    }
    return out;
}

/// The wrench of the joints on what holds the node, turned round, about where the node is.
double* NetworkResults::write_reaction(const Instant& instant, double* out, const ReactionView& reaction) const {
    const NodeSpec& spec = mechanism_.assembly.nodes[as_size(reaction.node)];
    const FrameView own = mechanism_.frame_before(spec.frame), support = mechanism_.frame_before(reaction.frame);
    const Vector6& wrench = instant.wrench(reaction.frame);
    const Vector3 arm = support.origin() - own.origin() - own.axes() * spec.offset, force = -wrench.head<3>();
    if (reaction.has_force) {
        Map3{out} = force;
        out += 3;
    }
    if (reaction.has_moment) {
        Map3{out} = arm.cross(force) - wrench.tail<3>();
        out += 3;
    }
    if (reaction.has_place) {
        const Matrix3& start = mechanism_.assembly.frames[as_size(spec.frame)].pose.rotation;
        Map3{out} = own.origin() + own.axes() * spec.offset;
        Map3{out + 3} = rotation_vector(own.axes() * start.transpose());
        out += 6;
    }
    return out;
}

}  // namespace dttmm::plugin
