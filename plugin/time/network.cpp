// SPDX-License-Identifier: BSD-3-Clause
#include "time/network.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

namespace {

using Map3 = Eigen::Map<Vector3>;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr const char* kAxes[] = {"x", "y", "z"};

Places all_places(const dttmm_network& description) {
    Places places;
    for (auto& [list, count] : {std::pair{&places.bodies, description.body_count},
                                {&places.nodes, description.node_count},
                                {&places.elements, description.element_count}}) {
        list->resize(count);
        std::iota(list->begin(), list->end(), 0u);
    }
    return places;
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Network::Network(const dttmm_network& description) : Network(description, all_places(description)) {}

Network::Network(const dttmm_network& description, Places places)
    : places_(std::move(places)), mechanism_(description, places_.supported_by), loading_(mechanism_.assembly, description) {
    if (description.element_count == 0) throw Error(DTTMM_ERROR_MODEL, "a network without an element");
    if (mechanism_.assembly.inner_count() > 0) interior_ = std::make_unique<Interior>(mechanism_, description, loading_);
    for (Joint& joint : mechanism_.joints)
        for (int half : {0, 1})
            if (interior_ && (interior_->is_massless(joint.from(), half) || interior_->is_massless(joint.to(), half)))
                joint.take_ends(half);
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        mechanism_.joints[j].report_work(description.at_work, places_.elements[as_size(mechanism_.joints[j].element())]);
        (mechanism_.joints[j].has_laws() ? joints_with_laws_ : linear_joints_).push_back(j);
        for (int d = 0; d < 6; ++d)
            if (mechanism_.joints[j].law().laws[as_size(d)]) law_looks_.push_back({j, d, 0, 0, 0});
    }
    choose_blocks();
    declare_channels(description);
    std::vector<JointSpec>().swap(mechanism_.assembly.joints);
    earlier_.assign(mechanism_.frames.begin(), mechanism_.frames.begin() + mechanism_.assembly.driven_count);
    instant_.port_velocities.resize(places_.bodies.size());
    start_velocities_.resize(places_.bodies.size());
    instant_.forces.assign(mechanism_.joints.size(), Vector6::Zero());
    instant_.wrenches.assign(mechanism_.frames.size(), Vector6::Zero());
}

void Network::declare(const std::string& name, const char* unit, uint32_t of, uint32_t index, uint32_t role) {
    const uint32_t at = (of == DTTMM_OF_ELEMENT ? places_.elements : places_.nodes)[index];
    char* kept = static_cast<char*>(results_.names->allocate(name.size() + 1, 1));
    std::copy_n(name.c_str(), name.size() + 1, kept);
    results_.channels.push_back({kept, unit, of, at, role});
}

void Network::declare_vectors(const std::string& prefix, std::initializer_list<std::pair<const char*, const char*>> vectors,
                              uint32_t of, uint32_t index, uint32_t role) {
    for (const auto& [name, unit] : vectors)
        for (const char* axis : kAxes) declare(fmt::format("{}{}.{}", prefix, name, axis), unit, of, index, role);
}

void Network::declare_channels(const dttmm_network& description) {
    const Assembly& assembly = mechanism_.assembly;
    for (uint32_t e = 0; e < description.element_count; ++e) {
        const int first = assembly.first_joint[e], count = assembly.first_joint[e + 1] - first;
        results_.piece_begin.push_back(results_.channels.size());
        if (count == 0) continue;
        if (count == 1 && mechanism_.joints[as_size(first)].is_axial()) {
            declare("force", "N", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_RESULT);
            declare("length", "m", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_RESULT);
        } else {
            declare_vectors("", {{"force", "N"}, {"moment", "N*m"}, {"deflection", "m"}}, DTTMM_OF_ELEMENT, e,
                            DTTMM_ROLE_RESULT);
            // Where nothing resists it a rotation may go on for ever, and its vector then jumps
            const bool turns = count > 1 || mechanism_.joints[as_size(first)].turns();
            declare_vectors("", {{"rotation", "rad"}}, DTTMM_OF_ELEMENT, e,
                            turns ? DTTMM_ROLE_RESULT : DTTMM_ROLE_ON_REQUEST);
        }
        declare("strain_energy", "J", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_STRAIN_ENERGY);
        declare("dissipated_energy", "J", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_DISSIPATED_ENERGY);
        if (count == 1) continue;
        if (has_limit(first)) declare("turn_to_limit", "1", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_LIMIT);
        ChainView& chain = results_.chains.emplace_back();
        const auto segments = std::ranges::find(assembly.segments, as_int(e), &SegmentsSpec::element);
        if (segments != assembly.segments.end()) chain.moduli = segments->moduli;
        for (int k = 0; k < count; ++k) {
            declare_vectors(fmt::format("section{}.", k), {{"force", "N"}, {"moment", "N*m"}}, DTTMM_OF_ELEMENT, e,
                            DTTMM_ROLE_ON_REQUEST);
            if (chain.moduli.are_known())
                declare(fmt::format("section{}.stress", k), "Pa", DTTMM_OF_ELEMENT, e, DTTMM_ROLE_ON_REQUEST);
        }
        chain.from_node = as_int(description.elements[e].ends[0]);
        chain.to_node = as_int(description.elements[e].ends[1]);
        const Matrix3& axes = assembly.joints[as_size(first)].pose.rotation;
        const auto pose = [&](int node) -> const Pose& {
            return assembly.frames[as_size(assembly.nodes[as_size(node)].frame)].pose;
        };
        chain.from_axes = pose(chain.from_node).rotation.transpose() * axes;
        chain.to_axes = pose(chain.to_node).rotation.transpose() * axes;
        const auto place = [&](int node) { return Vector3(Eigen::Map<const Vector3>(description.nodes[node].position)); };
        chain.rest = axes.transpose() * (place(chain.to_node) - place(chain.from_node));
    }
    results_.piece_begin.push_back(results_.channels.size());
    declare_inner(description);
    declare_reactions(description);
    results_.piece_begin.push_back(results_.channels.size());
    results_.places.assign(results_.piece_begin.begin(), results_.piece_begin.end() - 1);
}

void Network::declare_inner(const dttmm_network& description) {
    if (!interior_) return;
    const Assembly& assembly = mechanism_.assembly;
    for (uint32_t n = 0; n < description.node_count; ++n) {
        if (description.nodes[n].kind != DTTMM_NODE_INNER || assembly.nodes[n].frame < assembly.driven_count) continue;
        results_.nodes.push_back(as_int(n));
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
void Network::declare_reactions(const dttmm_network& description) {
    const Assembly& assembly = mechanism_.assembly;
    auto holding = as_size(assembly.first_joint.back());
    for (uint32_t n = 0; n < description.node_count; ++n) {
        const uint32_t fixed = description.nodes[n].fixed;
        const bool is_supported = !places_.supported_by.empty() && places_.supported_by[n] >= 0;
        if (fixed == 0 || (description.nodes[n].kind != DTTMM_NODE_INNER && !is_supported)) continue;
        const bool is_driven = assembly.nodes[n].frame < assembly.driven_count;
        const int frame = is_driven ? assembly.nodes[n].frame : mechanism_.joints[holding++].from();
        results_.reactions.push_back({as_int(n), frame, (fixed & 7) != 0, (fixed & 0x38) != 0, is_driven && is_supported});
        if (results_.reactions.back().has_force)
            declare_vectors("", {{"reaction", "N"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_RESULT);
        if (results_.reactions.back().has_moment)
            declare_vectors("", {{"reaction_moment", "N*m"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_RESULT);
        if (results_.reactions.back().has_place)
            declare_vectors("", {{"position", "m"}, {"rotation", "rad"}}, DTTMM_OF_NODE, n, DTTMM_ROLE_ON_REQUEST);
    }
}

void Network::load_weights(double weights[3]) const {
    for (int back : {0, 1, 2}) weights[back] = mechanism_.scheme.weight(back);
}

// ---- What the joints do --------------------------------------------------------------------------------------------------

/// Of an interior all pairs of ports, row by row; of joints the pairs that they join.
void Network::choose_blocks() {
    const auto ports = static_cast<uint32_t>(port_count());
    const auto place = [&](uint32_t port) { return places_.bodies[port]; };
    if (interior_) {
        for (uint32_t row = 0; row < ports; ++row)
            for (uint32_t column = 0; column < ports; ++column) blocks_.list.push_back({place(row), place(column)});
        blocks_.dense.resize(36 * as_size(ports) * ports);
    } else {
        std::map<std::pair<int, int>, int> found;
        for (const Joint& joint : mechanism_.joints) {
            Blocks::OfJoint& own = blocks_.of_joints.emplace_back();
            for (int i : {0, 1})
                for (int j : {0, 1}) {
                    const int row = joint.frame(i), column = joint.frame(j);
                    own.at[i][j] = -1;
                    if (row >= port_count() || column >= port_count()) continue;
                    const auto [entry, is_new] = found.try_emplace({row, column}, as_int(blocks_.list.size()));
                    if (is_new)
                        blocks_.list.push_back({place(static_cast<uint32_t>(row)), place(static_cast<uint32_t>(column))});
                    own.at[i][j] = entry->second;
                }
        }
    }
    blocks_.places.resize(blocks_.list.size());
    std::iota(blocks_.places.begin(), blocks_.places.end(), size_t{0});
}

/// Adds a joint's blocks to the stiffness that the bodies feel.
void Network::add_stiffness(size_t joint, const EndBlocks& blocks, double* stiffness) const {
    for (int i : {0, 1})
        for (int j : {0, 1})
            if (const int block = blocks_.of_joints[joint].at[i][j]; block >= 0)
                Eigen::Map<RowMajor6>(stiffness + 36 * blocks_.places[as_size(block)]) += blocks.at[i][j];
}

/// Adds a matrix over all ports.
void Network::add_dense(const double* matrix, double* stiffness) const {
    const Eigen::Index ports = port_count();
    const Eigen::Map<const RowMajor> S(matrix, 6 * ports, 6 * ports);
    for (Eigen::Index b = 0; b < ports * ports; ++b)
        Eigen::Map<RowMajor6>(stiffness + 36 * blocks_.places[as_size(b)]) +=
            S.block<6, 6>(6 * (b / ports), 6 * (b % ports));
}

// ---- The force law at one instant ---------------------------------------------------------------------------------------

void Network::linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
    if (!interior_) return linearise_joints(bodies, wrench, stiffness, damping);
    std::vector<double> own(stiffness ? blocks_.dense.size() : 0);
    interior_->linearise(ports(bodies), wrench, stiffness ? own.data() : nullptr);
    if (stiffness) add_dense(own.data(), stiffness);
}

void Network::linearise_joints(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const auto [from, to] = seen(joint, bodies);
        const Twist v_from = velocity(joint.from(), bodies), v_to = velocity(joint.to(), bodies);
        const JointPose pose = joint.pose(from, to);
        const Vector6 deformation = joint.deformation(pose, from, to);
        add_wrench(joint,
                   pose.act(joint.force(deformation, joint.rate(from, v_from, to, v_to, deformation), mechanism_.memory(j))),
                   wrench);
        if (stiffness)
            add_stiffness(j, joint.stiffness(pose, joint.stiffness_tangent(deformation, mechanism_.memory(j))), stiffness);
        if (damping) add_stiffness(j, joint.stiffness(pose, joint.damping_tangent(deformation)), damping);
    }
}

void Network::take_up(const double* motion, double* elastic, double* damped) const {
    std::vector<Vector6> u;
    for (int p = 0; p < port_count(); ++p)
        u.emplace_back(Eigen::Map<const Vector6>(motion + 6 * places_.bodies[as_size(p)]));
    u.resize(mechanism_.frames.size(), Vector6::Zero());
    if (interior_) interior_->follow(u);
    std::vector<Frame> at;
    for (const FrameSpec& frame : mechanism_.assembly.frames) at.push_back(make_frame(frame.pose));
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const auto f = as_size(joint.from()), t = as_size(joint.to());
        const JointPose pose = joint.pose(at[f], at[t]);
        const Vector6 x = joint.deformation(pose, at[f], at[t]);
        const Vector6 q = joint.by_from(pose) * u[f] + joint.by_to(pose) * u[t];
        const size_t element = places_.elements[as_size(joint.element())];
        elastic[element] += q.dot(joint.stiffness_tangent(x, mechanism_.memory(j)) * q);
        if (!interior_) damped[element] += q.dot(joint.damping_tangent(x) * q);
    }
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

void Network::begin_statics() { statics_ = std::make_unique<StaticNetwork>(mechanism_, loading_); }

StaticNetwork& Network::statics() {
    if (!statics_) throw Error(DTTMM_ERROR_PHASE, "statics: begin has not been called");
    return *statics_;
}

void Network::form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness) {
    statics().form(ports(bodies), resistance);
    if (!interior_) {
        for (int p = 0; p < port_count(); ++p) Eigen::Map<Vector6>{on_body(p, wrench)} += statics_->formed_wrench(p);
        statics_->for_each_at_ports([&](size_t joint, const EndBlocks& blocks) { add_stiffness(joint, blocks, stiffness); });
        return;
    }
    std::vector<Vector6> own(as_size(port_count()), Vector6::Zero());
    std::ranges::fill(blocks_.dense, 0.0);
    statics_->condense(own, blocks_.dense.data());
    for (int p = 0; p < port_count(); ++p) Eigen::Map<Vector6>{on_body(p, wrench)} += own[as_size(p)];
    add_dense(blocks_.dense.data(), stiffness);
}

StaticNetwork::Measure Network::correct_static(const double* change) {
    std::vector<Vector6> own;
    for (int p = 0; p < port_count(); ++p)
        own.emplace_back(Eigen::Map<const Vector6>(change + 6 * places_.bodies[as_size(p)]));
    return statics().correct(own);
}

StaticNetwork::Measure Network::move_static(const dttmm_motion* bodies, double share, double* wrench) {
    const StaticNetwork::Measure measure = statics().move(ports(bodies), share);
    for (int p = 0; p < port_count(); ++p) Eigen::Map<Vector6>{on_body(p, wrench)} += statics_->wrench(p);
    return measure;
}

void Network::write_rest(AtRest& rest) const {
    if (!statics_) throw Error(DTTMM_ERROR_PHASE, "statics: begin has not been called");
    const auto of_elements = as_size(mechanism_.assembly.first_joint.back());
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const AtRest::Link link = statics_->link(j);
        if (j < of_elements)
            rest.elements[places_.elements[as_size(joint.element())]].push_back(link);
        else
            rest.held.push_back({mechanism_.assembly.frames[as_size(joint.from())].pose.position, link});
    }
}

void Network::start_at_rest(const dttmm_step& step, const dttmm_motion* bodies, const double* loads) {
    uint32_t last = 0;
    for (uint32_t body : places_.bodies) last = std::max(last, body + 1);
    const std::vector<double> none(6 * size_t{last}, 0.0);
    begin(step, bodies, none.data(), loads, &statics().frames());
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

void Network::start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads) {
    begin(step, bodies, accelerations, loads, nullptr);
}

/// at_rest: the frames, if it starts at rest and they are not as in the description.
void Network::begin(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads,
                    const std::vector<Frame>* at_rest) {
    if (is_open_) throw Error(DTTMM_ERROR_PHASE, "start: a step is open");
    if (!(step.size > 0) || !std::isfinite(step.size))
        throw Error(DTTMM_ERROR_ARGUMENT, "start: the step size must be positive");
    for (const Joint& joint : mechanism_.joints) {
        const auto [from, to] = seen(joint, bodies);
        joint.refuse_large_rotation(from, to);
    }
    mechanism_.steps = 0;
    mechanism_.scheme.set_step_size(step.size);
    for (Joint& joint : mechanism_.joints) joint.set_scheme(mechanism_.scheme);
    if (interior_) {
        interior_->start(ports(bodies), accelerations, loads, at_rest);
    } else {
        start_joints(bodies, accelerations);
    }
    for (int p = 0; p < port_count(); ++p) start_velocities_[as_size(p)] = ports(bodies).twist(p);
    started_ = true;
    instant_.is_known = false;
}

void Network::start_joints(const dttmm_motion* bodies, const double* accelerations) {
    for (int p = 0; p < port_count(); ++p) mechanism_.frames[as_size(p)] = seen(p, bodies).copy();
    mechanism_.start_joints([&](int frame) { return velocity(frame, bodies); },
                            [&](int frame) { return acceleration(frame, accelerations); });
}

void Network::begin_step(const dttmm_step& step, const double* loads) {
    if (!started_) throw Error(DTTMM_ERROR_PHASE, "begin_step: start has not been called");
    if (is_open_) throw Error(DTTMM_ERROR_PHASE, "begin_step: the step before is still open");
    if (step.size != mechanism_.scheme.step_size())
        throw Error(DTTMM_ERROR_ARGUMENT, "begin_step: a new step size wants a new start");
    if (interior_) interior_->begin_step(loads);
    is_open_ = true;
}

void Network::iterate(const dttmm_motion* trial, dttmm_progress& progress) {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "iterate: no step is open");
    progress = {};
    if (interior_) {
        interior_->iterate(ports(trial), progress);
    } else {
        constexpr double kPredicted = 1e-6;  // of the force; 1e-4 to 1e-9 find the same ends in the tests of kinks
        progress.correction = find_worst_prediction(trial);
        progress.enough = kPredicted;
        progress.motion = 1;
    }
    // Where a spring is not linear, a rate of convergence of another step says nothing of this one
    if (!joints_with_laws_.empty()) progress.is_new = 1;
}

/// By how much laws do otherwise at this trial than their gains at the trial before let expect, as share of their force.
/// Newton's corrections are trusted where that is little: a kink between two trials makes another force of the last one.
double Network::find_worst_prediction(const dttmm_motion* bodies) {
    double worst = 0;
    for (LawLook& last : law_looks_) {
        const Joint& joint = mechanism_.joints[last.joint];
        const Ends at = seen(joint, bodies);
        const double x = joint.deformation(joint.pose(at), at.from, at.to)(last.direction),
                     now = mechanism_.states[last.joint].deformation()(last.direction);
        const Joint::OnPath path = joint.on_path(mechanism_.scheme, last.direction, now, x, mechanism_.memory(last.joint));
        const double predicted = last.force + last.gain * (x - last.x),
                     largest = std::max(std::abs(path.force), std::abs(predicted));
        if (largest > 0) worst = std::max(worst, std::abs(path.force - predicted) / largest);
        last.x = x;
        last.force = path.force;
        last.gain = path.gain;
    }
    return worst;
}

void Network::evaluate(const dttmm_motion* bodies, double* wrench, double* stiffness) const {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "evaluate: no step is open");
    if (!interior_) return evaluate_joints(bodies, wrench, stiffness);
    interior_->evaluate(ports(bodies));
    for (int p = 0; p < port_count(); ++p) Eigen::Map<Vector6>{on_body(p, wrench)} += interior_->wrench(p);
    if (!stiffness) return;
    interior_->write_stiffness(blocks_.dense.data());
    add_dense(blocks_.dense.data(), stiffness);
}

void Network::evaluate_joints(const dttmm_motion* bodies, double* wrench, double* stiffness) const {
    if (is_implicit()) {
        evaluate_linear_joints(bodies, wrench, stiffness);
        evaluate_joints_with_laws(bodies, wrench, stiffness);
        return;
    }
    for (size_t j = 0; j < mechanism_.joints.size(); ++j)  // the trial is not looked at
        add_wrench(mechanism_.joints[j], mechanism_.states[j].known, wrench);
}

[[gnu::always_inline]] inline void Network::add_joint_stiffness(size_t j, Ends at, double* stiffness) const {
    const Joint& joint = mechanism_.joints[j];
    const JointState& state = mechanism_.states[j];
    const JointPose end = joint.pose(at);
    const Vector6 deformation = joint.deformation(end, at.from, at.to);
    add_stiffness(
        j, joint.stiffness(end, joint.gain(mechanism_.scheme, state.deformation(), deformation, mechanism_.memory(j))),
        stiffness);
    // The force that acts as at t_n: that of a trial far from the solution may be any
    const Vector3 acting = mechanism_.scheme.elastic_weight(0) * state.elastic.force;
    add_stiffness(j, joint.acting_stiffness(end, at.from, at.to, acting), stiffness);
}

DTTMM_WIDE void Network::evaluate_linear_joints(const dttmm_motion* bodies, double* wrench, double* stiffness) const {
    for (size_t j : linear_joints_) {
        const Joint& joint = mechanism_.joints[j];
        const Ends at = seen(joint, bodies);
        add_wrench(joint, joint.over_step(mechanism_.scheme, at, mechanism_.states[j], mechanism_.damper(j)), wrench);
        if (stiffness) add_joint_stiffness(j, at, stiffness);
    }
}

/// Not wide: what throws must not pass a function that is compiled for several processors (g++ 12 ends the process then).
void Network::evaluate_joints_with_laws(const dttmm_motion* bodies, double* wrench, double* stiffness) const {
    for (size_t j : joints_with_laws_) {
        const Joint& joint = mechanism_.joints[j];
        const Ends at = seen(joint, bodies);
        const JointPose at_end = joint.pose(at);
        const JointState& state = mechanism_.states[j];
        const double* const memory = mechanism_.memory(j);
        add_wrench(joint,
                   joint.weigh(mechanism_.scheme, joint.strain(mechanism_.scheme, at, at_end, state, memory), at_end, state,
                               mechanism_.damper(j), memory),
                   wrench);
        if (stiffness) add_joint_stiffness(j, at, stiffness);
    }
}

void Network::commit_step(const dttmm_motion* bodies) {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "commit_step: no step is open");
    if (interior_) {
        std::copy_n(mechanism_.before.begin(), port_count(), earlier_.begin());
        interior_->commit(ports(bodies));
    } else {
        commit_joints(bodies);
    }
    ++mechanism_.steps;
    is_open_ = instant_.is_known = false;
}

void Network::commit_joints(const dttmm_motion* bodies) {
    for (const Joint& joint : mechanism_.joints) {
        const auto [from, to] = seen(joint, bodies);
        joint.refuse_large_rotation(from, to);
    }
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        joint.advance(mechanism_.scheme, seen(joint, bodies), mechanism_.ends(j), mechanism_.states[j], mechanism_.damper(j),
                      mechanism_.law_memory_of(j), nullptr);
    }
    earlier_.swap(mechanism_.before);
    mechanism_.before.swap(mechanism_.frames);
    for (int p = 0; p < port_count(); ++p) mechanism_.frames[as_size(p)] = seen(p, bodies).copy();
}

void Network::discard_step() {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "discard_step: no step is open");
    is_open_ = false;
}

// ---- What stands at t_n -------------------------------------------------------------------------------------------------

Twist Network::velocity_at_start(int frame) const {
    if (frame < port_count()) return instant_.port_velocities[as_size(frame)];
    return interior_ ? interior_->instant().velocity(frame) : Twist{};
}

/// Of a joint's deformation. Where rigid directions act, whose forces are known over the step only, velocities of the
/// instant differ from each other by what these lack, of which a stiff damper would make forces: there the increments tell
/// the rate.
Vector6 Network::rate_at_start(size_t j) const {
    const Joint& joint = mechanism_.joints[j];
    const FrameView from = mechanism_.frame_before(joint.from()), to = mechanism_.frame_before(joint.to());
    const auto rate_of = [&](const Twist& v_from, const Twist& v_to) {
        if (!joint.is_line()) return joint.rate(from, v_from, to, v_to);
        return joint.rate(from, v_from, to, v_to, mechanism_.states[j].deformation_before());
    };
    const bool is_by_increments = instant_.by_increments || (interior_ && interior_->has_rigid_directions());
    if (!is_by_increments || mechanism_.steps == 1)
        return rate_of(velocity_at_start(joint.from()), velocity_at_start(joint.to()));
    const auto correction = [&](int frame) { return interior_ ? interior_->instant().correction(frame) : Twist{}; };
    Vector6 rate = rate_of(correction(joint.from()), correction(joint.to()));
    const double per_step = 0.5 / mechanism_.scheme.step_size();
    if (const DamperState* damper = mechanism_.damper(j))
        for (int half : {0, 1})
            rate.segment<3>(3 * half) += per_step * (damper->halves[half].delta[0] + damper->halves[half].delta[1]);
    return rate;
}

void Network::add_wrenches(double* wrench) const {
    for (int p = 0; p < port_count(); ++p) Eigen::Map<Vector6>{on_body(p, wrench)} += instant_.wrenches[as_size(p)];
}

/// Newmark's rule has (a_n + a_{n+1})/2 as the acceleration over a step, so elastic forces are means of its two ends and
/// dampers have the mean rate.
void Network::find_mean_wrenches() const {
    const double h = mechanism_.scheme.step_size();
    std::fill(instant_.wrenches.begin(), instant_.wrenches.end(), Vector6::Zero());
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const JointState& state = mechanism_.states[j];  // d_before is that at t_n
        const Vector6 x = state.deformation_before();
        Vector6 rate = Vector6::Zero();
        if (const DamperState* damper = mechanism_.damper(j)) {
            rate << damper->halves[0].delta[0], damper->halves[1].delta[0];
            rate /= h;
        }
        Vector6 f = joint.force(x, rate, mechanism_.memory_before(j), 0.5);
        if (joint.has_laws()) f += joint.beyond_mean(mechanism_.scheme, x, state.deformation(), mechanism_.memory_before(j));
        if (joint.rigid().any()) f += interior_->instant().rigid_force_over_step(j);
        const auto from = as_size(joint.from()), to = as_size(joint.to());
        JointForce force = joint.pose(mechanism_.before[from], mechanism_.before[to]).act(f);
        force.add(0.5, state.elastic);
        Joint::add_wrench(force, instant_.wrenches[from].data(), instant_.wrenches[to].data());
    }
    if (interior_) interior_->instant().find_velocities(instant_.wrenches);
}

void Network::mean_wrench(double* wrench) const {
    if (mechanism_.steps == 0 || is_open_) throw Error(DTTMM_ERROR_PHASE, "mean_wrench: only after a commit");
    find_mean_wrenches();
    add_wrenches(wrench);
}

void Network::add_rigid_wrenches(double* wrench) const {
    if (!interior_ || !interior_->has_rigid_directions()) return;
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        if (joint.rigid().none() || std::min(joint.from(), joint.to()) >= port_count()) continue;
        const JointPose pose = joint.pose(mechanism_.frame_before(joint.from()), mechanism_.frame_before(joint.to()));
        add_wrench(joint, pose.act(interior_->instant().rigid_force_over_step(j)), wrench);
    }
}

void Network::stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const {
    if (mechanism_.steps == 0 || is_open_) throw Error(DTTMM_ERROR_PHASE, "stand: only after a commit");
    for (int p = 0; p < port_count(); ++p) instant_.port_velocities[as_size(p)] = ports(bodies).twist(p);
    if (accelerations && interior_)
        for (int p = 0; p < port_count(); ++p) interior_->instant().set_port_acceleration(p, acceleration(p, accelerations));
    stand_by_port_velocities();
    add_wrenches(wrench);
}

/// For a host that does not say how the ports move at t_n.
void Network::stand_by_centred_velocities() const {
    find_mean_wrenches();
    const double per_step = 0.5 / mechanism_.scheme.step_size();
    for (size_t p = 0; p < instant_.port_velocities.size(); ++p) {
        if (mechanism_.steps == 1) {
            instant_.port_velocities[p] = start_velocities_[p];
            continue;
        }
        const FrameView earlier = earlier_[p], at = mechanism_.before[p], later = mechanism_.frames[p];
        instant_.port_velocities[p] = {per_step * (later.origin() - earlier.origin()),
                                       per_step * (rotation_vector(later.axes() * at.axes().transpose()) +
                                                   rotation_vector(at.axes() * earlier.axes().transpose()))};
    }
    instant_.by_increments = true;
    stand_by_port_velocities();
    instant_.by_increments = false;
}

/// Forces of the joints and wrenches on the frames, as velocities and rigid directions are known.
void Network::find_forces() const {
    std::fill(instant_.wrenches.begin(), instant_.wrenches.end(), Vector6::Zero());
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const JointState& state = mechanism_.states[j];
        const auto from = as_size(joint.from()), to = as_size(joint.to());
        Vector6& f = instant_.forces[j] =
            joint.force(state.deformation_before(), mechanism_.damper(j) ? rate_at_start(j) : Vector6(Vector6::Zero()),
                        mechanism_.memory_before(j));
        if (joint.rigid().any()) f += interior_->instant().rigid_force(j);
        const JointForce force = joint.pose(mechanism_.before[from], mechanism_.before[to]).act(f);
        Joint::add_wrench(force, instant_.wrenches[from].data(), instant_.wrenches[to].data());
    }
}

void Network::stand_by_port_velocities() const {
    const auto velocity = [&](int frame) { return velocity_at_start(frame); };
    if (interior_) interior_->instant().find_massless_velocities([&](size_t j) { return rate_at_start(j); });
    find_forces();
    if (interior_ && interior_->instant().is_to_balance_rigid()) {
        interior_->instant().balance_rigid(instant_.wrenches, velocity);
        find_forces();
    }
    if (interior_)
        interior_->instant().find_accelerations(instant_.wrenches, velocity,
                                                [&](size_t j) -> const Vector6& { return instant_.forces[j]; });
    instant_.is_known = true;
}

// ---- State --------------------------------------------------------------------------------------------------------------

/// Everything that changes from step to step, piece by piece; in a saved state the step size comes before it.
template <class Self, class Visit>
void Network::for_each_state(Self& self, const Visit& visit) {
    auto& mechanism = self.mechanism_;
    visit(std::span(&mechanism.steps, 1));
    visit(std::span(mechanism.states));
    visit(std::span(mechanism.dampers));
    visit(std::span(mechanism.law_memory));
    visit(std::span(mechanism.law_memory_before));
    const auto ports = as_size(self.port_count()), driven = as_size(mechanism.assembly.driven_count);
    for (auto* frames : {&mechanism.frames, &mechanism.before}) {  // the ground behind the ports stays where it is
        visit(std::span(*frames).first(ports));
        visit(std::span(*frames).subspan(driven));
    }
    visit(std::span(self.earlier_).first(ports));
    visit(std::span(self.start_velocities_));
    if (self.interior_) Interior::for_each_state(*self.interior_, visit);
}

size_t Network::state_size() const {
    size_t size = sizeof(double);  // of the step size
    for_each_state(*this, [&](auto piece) { size += piece.size_bytes(); });
    return size;
}

void Network::save_state(void* buffer, size_t size) const {
    if (!started_ || is_open_) throw Error(DTTMM_ERROR_PHASE, "save_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("save_state: the state has {} bytes, not {}", state_size(), size));
    char* out = static_cast<char*>(buffer);
    const double step_size = mechanism_.scheme.step_size();
    std::memcpy(out, &step_size, sizeof step_size);
    out += sizeof step_size;
    for_each_state(*this, [&](auto piece) {
        if (!piece.empty()) std::memcpy(out, piece.data(), piece.size_bytes());
        out += piece.size_bytes();
    });
    if (interior_) interior_->refactor();  // as a restored one does: both futures are then the same to the bit
}

void Network::restore_state(const void* buffer, size_t size) {
    if (!started_ || is_open_) throw Error(DTTMM_ERROR_PHASE, "restore_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("restore_state: the state has {} bytes, not {}", state_size(), size));
    const char* in = static_cast<const char*>(buffer);
    double saved;
    std::memcpy(&saved, in, sizeof saved);
    in += sizeof saved;
    if (saved != mechanism_.scheme.step_size())
        throw Error(DTTMM_ERROR_ARGUMENT, "restore_state: saved at another step size, or by another network");
    for_each_state(*this, [&](auto piece) {
        if (!piece.empty()) std::memcpy(static_cast<void*>(piece.data()), in, piece.size_bytes());
        in += piece.size_bytes();
    });
    if (interior_) {
        interior_->refactor();
        interior_->instant().form_first_balance();
    }
    instant_.is_known = false;
}

Centring Network::centring(Network& above, Network& below, const Network& middle) {
    const auto show = [](auto& network) { return [&](const auto& visit) { for_each_state(network, visit); }; };
    return {show(above), show(below), show(middle)};
}

void Network::refuse_rough_memory() const {
    for (const Joint& joint : mechanism_.joints)
        for (const auto& law : joint.law().laws)
            if (law && !law->remembers_smoothly())
                throw Error(DTTMM_ERROR_MODEL,
                            "its law remembers numbers of its own: how they change with a parameter is not known",
                            joint.element());
}

void Network::refuse_centre(Network& above, Network& below, const Network& middle) {
    for (const Network* one : std::initializer_list<const Network*>{&above, &below, &middle})
        if (!one->started_ || one->is_open_) throw Error(DTTMM_ERROR_PHASE, "centre: only between steps, after start");
    const auto is_beside = [&](const Network& one) {
        return one.mechanism_.steps == middle.mechanism_.steps &&
               one.mechanism_.scheme.step_size() == middle.mechanism_.scheme.step_size();
    };
    if (!centring(above, below, middle).is_possible() || !is_beside(above) || !is_beside(below))
        throw Error(DTTMM_ERROR_ARGUMENT, "centre: the networks differ in more than numbers, or in their steps");
    middle.refuse_rough_memory();
}

void Network::centre(Network& above, Network& below, const Network& middle) {
    centring(above, below, middle).centre();
    // What an Interior has worked out for the coming step stays: it is off by the second order, alike in both
    above.instant_.is_known = below.instant_.is_known = false;
}

// ---- Results ------------------------------------------------------------------------------------------------------------

double* Network::write_joint(double* out, size_t j) const {
    const Joint& joint = mechanism_.joints[j];
    if (joint.is_axial()) {
        out[0] = instant_.forces[j](0);
        out[1] = mechanism_.states[j].d_before(0) + joint.law().axial->natural;
        return out + 2;
    }
    Eigen::Map<Vector6>{out} = instant_.forces[j];
    Map3{out + 6} = mechanism_.states[j].d_before;
    const FrameView from = mechanism_.frame_before(joint.from()), to = mechanism_.frame_before(joint.to());
    Map3{out + 9} = joint.turns() ? mechanism_.states[j].theta_before : rotation_vector(joint.attitude(from, to));
    return out + 12;
}

/// Strain and dissipated energy of joints first … last − 1.
double* Network::write_energies(double* out, int first, int last) const {
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
double* Network::write_chain(double* out, size_t element, const ChainView& chain) const {
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

    // The joints of whole segments sit at the sections; those of the half segments at the ends, a quarter segment off
    const double quarter = chain.rest.norm() / (4 * (last - first - 1));
    for (int j = first; j < last; ++j) {
        Vector6 f = instant_.forces[as_size(j)];
        turn_to_limit = std::max(turn_to_limit, mechanism_.states[as_size(j)].theta_before.norm() /
                                                    mechanism_.joints[as_size(j)].law().most_turn);
        const double way_to_joint = j == first ? quarter : j == last - 1 ? -quarter : 0;
        f.tail<3>() += Vector3(way_to_joint, 0, 0).cross(Vector3(f.head<3>()));
        Eigen::Map<Vector6>{out} = f;
        if (j == first) Eigen::Map<Vector6>{total} = f;
        out += 6;
        if (chain.moduli.are_known()) *out++ = chain.moduli.extreme_stress(f(0), f(4), f(5));
    }
    return out;
}

std::vector<uint32_t> Network::lines() const {
    const std::vector<int>& first_joint = mechanism_.assembly.first_joint;
    std::vector<uint32_t> lines;
    for (size_t e = 0; e + 1 < first_joint.size(); ++e)
        if (first_joint[e + 1] - first_joint[e] > 1) lines.push_back(places_.elements[e]);
    return lines;
}

/// Of a section of a beam or rod: its joint's, in the middle between what it joins; at the ends the node's [m, world].
Vector3 Network::section_position(size_t element, const ChainView& chain, int section) const {
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

double* Network::write_lines(uint32_t stations, double* positions) const {
    if (mechanism_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "positions: no step has been committed");
    const std::vector<int>& first_joint = mechanism_.assembly.first_joint;
    auto chain = results_.chains.begin();
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

double* Network::write_node(double* out, size_t node) const {
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
double* Network::write_reaction(double* out, const ReactionView& reaction) const {
    const NodeSpec& spec = mechanism_.assembly.nodes[as_size(reaction.node)];
    const FrameView own = mechanism_.frame_before(spec.frame), support = mechanism_.frame_before(reaction.frame);
    const Vector6& wrench = instant_.wrenches[as_size(reaction.frame)];
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

void Network::outputs(double* values) const {
    if (mechanism_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    if (!instant_.is_known) stand_by_centred_velocities();
    const std::vector<int>& first_joint = mechanism_.assembly.first_joint;
    const size_t elements = first_joint.size() - 1;
    auto chain = results_.chains.begin();
    for (size_t e = 0; e < elements; ++e) {
        const int count = first_joint[e + 1] - first_joint[e];
        double* const out = values + results_.places[e];
        if (count == 1)
            write_energies(write_joint(out, as_size(first_joint[e])), first_joint[e], first_joint[e + 1]);
        else if (count > 1)
            write_chain(out, e, *chain++);
    }
    double* out = values + results_.places[elements];
    if (interior_) {
        for (int node : results_.nodes) out = write_node(out, as_size(node));
        *out++ = interior_->instant().kinetic_energy();
        *out++ = interior_->work();
    }
    for (const ReactionView& reaction : results_.reactions) out = write_reaction(out, reaction);
}

}  // namespace dttmm::plugin
