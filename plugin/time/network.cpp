// SPDX-License-Identifier: BSD-3-Clause
#include "time/network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/rounding.h"

namespace dttmm::plugin {

namespace {

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
    : places_(std::move(places)),
      mechanism_(description, places_.supported_by),
      bodies_{mechanism_, places_.bodies},
      loading_(mechanism_.assembly, description),
      interior_(make_interior(description)),
      blocks_(interior_ ? PortBlocks::dense(bodies_) : PortBlocks::of_joints(bodies_)),
      joints_(interior_ ? nullptr : std::make_unique<BodyJoints>(mechanism_, bodies_, blocks_)),
      has_laws_(std::ranges::any_of(mechanism_.joints, &Joint::has_laws)),
      start_velocities_(places_.bodies.size()),
      instant_(bodies_, interior_.get(), interior_ ? interior_->by_four() : joints_->by_four()),
      results_(description, places_, mechanism_, interior_.get()) {
    for (Joint& joint : mechanism_.joints)
        joint.report_work(description.at_work, places_.elements[as_size(joint.element())]);
    std::vector<JointSpec>().swap(mechanism_.assembly.joints);
    for (int f = 0; f < mechanism_.assembly.driven_count; ++f)  // of these no message tells any more
        mechanism_.assembly.frames[as_size(f)].label.reset();
    if (!interior_ && !results_.shows_nodes()) std::vector<NodeSpec>().swap(mechanism_.assembly.nodes);
    earlier_.assign(mechanism_.frames.begin(), mechanism_.frames.begin() + mechanism_.assembly.driven_count);
    if (interior_) dense_.resize(blocks_.dense_size());
}

std::unique_ptr<Interior> Network::make_interior(const dttmm_network& description) {
    if (description.element_count == 0) throw Error(DTTMM_ERROR_MODEL, "a network without an element");
    if (mechanism_.assembly.inner_count() == 0) return nullptr;
    auto interior = std::make_unique<Interior>(mechanism_, description, loading_);
    for (Joint& joint : mechanism_.joints)
        for (int half : {0, 1})
            if (interior->is_massless(joint.from(), half) || interior->is_massless(joint.to(), half)) joint.take_ends(half);
    return interior;
}

void Network::load_weights(double weights[3]) const {
    for (int back : {0, 1, 2}) weights[back] = mechanism_.scheme.weight(back);
}

// ---- The force law at one instant ---------------------------------------------------------------------------------------

void Network::linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
    if (joints_) return joints_->linearise(bodies, wrench, stiffness, damping);
    std::vector<double> own(stiffness ? blocks_.dense_size() : 0);
    interior_->linearise(ports(bodies), wrench, stiffness ? own.data() : nullptr);
    if (stiffness) blocks_.add_dense(own.data(), stiffness);
}

void Network::take_up(const double* motion, double* elastic, double* damped) const {
    std::vector<Vector6> u = bodies_.gather(motion);
    u.resize(mechanism_.frames.size(), Vector6::Zero());
    if (interior_) interior_->follow(u);
    const std::vector<Frame> at = described_frames(mechanism_);
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

void Network::begin_statics() {
    statics_ = std::make_unique<StaticNetwork>(mechanism_, loading_, interior_ ? &interior_->lend_matrix() : nullptr);
}

StaticNetwork& Network::statics() {
    if (!statics_) throw Error(DTTMM_ERROR_PHASE, "statics: begin has not been called");
    return *statics_;
}

void Network::form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness) {
    statics().form(ports(bodies), resistance);
    if (!interior_) {
        for (int p = 0; p < port_count(); ++p) bodies_.add_wrench(p, statics_->formed_wrench(p), wrench);
        statics_->for_each_at_ports([&](size_t joint, const EndBlocks& blocks) { blocks_.add(joint, blocks, stiffness); });
        return;
    }
    std::vector<Vector6> own(as_size(port_count()), Vector6::Zero());
    std::ranges::fill(dense_, 0.0);
    statics_->condense(own, dense_.data());
    for (int p = 0; p < port_count(); ++p) bodies_.add_wrench(p, own[as_size(p)], wrench);
    blocks_.add_dense(dense_.data(), stiffness);
}

StaticNetwork::Measure Network::correct_static(const double* change) { return statics().correct(bodies_.gather(change)); }

StaticNetwork::Measure Network::move_static(const dttmm_motion* bodies, double share, double* wrench) {
    const StaticNetwork::Measure measure = statics().move(ports(bodies), share);
    for (int p = 0; p < port_count(); ++p) bodies_.add_wrench(p, statics_->wrench(p), wrench);
    return measure;
}

void Network::write_rest(AtRest& rest) const {
    if (!statics_) throw Error(DTTMM_ERROR_PHASE, "statics: begin has not been called");
    const Assembly& assembly = mechanism_.assembly;
    const auto of_elements = as_size(assembly.first_joint.back());
    rest.gravity = statics_->gravity();
    for (size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const AtRest::Link link = statics_->link(j);
        if (j < of_elements)
            rest.elements[places_.elements[as_size(joint.element())]].push_back(link);
        else
            rest.held.push_back({places_.nodes[as_size(assembly.held_nodes[j - of_elements])], link});
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
        const auto frame = [&](int f) { return at_rest ? FrameView((*at_rest)[as_size(f)]) : bodies_.seen(f, bodies); };
        joint.refuse_large_rotation(frame(joint.from()), frame(joint.to()));
    }
    mechanism_.steps = 0;
    mechanism_.scheme.set_step_size(step.size);
    for (Joint& joint : mechanism_.joints) joint.set_scheme(mechanism_.scheme);
    if (interior_) {
        interior_->start(ports(bodies), accelerations, loads, at_rest);
    } else {
        joints_->start(bodies, accelerations);
    }
    for (int p = 0; p < port_count(); ++p) start_velocities_[as_size(p)] = ports(bodies).twist(p);
    started_ = true;
    instant_.forget();
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
        progress.correction = joints_->find_worst_prediction(trial);
        progress.enough = kRoundingOfSums;  // of the force
        progress.motion = 1;
    }
    // Where a spring is not linear, a rate of convergence of another step says nothing of this one
    if (has_laws_ && progress.is_new == 0) progress.is_new = -1;
}

void Network::evaluate(const dttmm_motion* bodies, double* wrench, double* stiffness) const {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "evaluate: no step is open");
    if (joints_) return joints_->evaluate(bodies, wrench, stiffness);
    interior_->evaluate(ports(bodies));
    for (int p = 0; p < port_count(); ++p) bodies_.add_wrench(p, interior_->wrench(p), wrench);
    if (!stiffness) return;
    interior_->write_stiffness(dense_.data());
    blocks_.add_dense(dense_.data(), stiffness);
}

void Network::commit_step(const dttmm_motion* bodies) {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "commit_step: no step is open");
    if (interior_) {
        std::copy_n(mechanism_.before.begin(), port_count(), earlier_.begin());
        interior_->commit(ports(bodies));
    } else {
        joints_->commit(bodies, earlier_);
    }
    ++mechanism_.steps;
    is_open_ = false;
    instant_.forget();
}

void Network::discard_step() {
    if (!is_open_) throw Error(DTTMM_ERROR_PHASE, "discard_step: no step is open");
    is_open_ = false;
}

// ---- Results ------------------------------------------------------------------------------------------------------------

void Network::require_committed(const char* what) const {
    if (mechanism_.steps == 0 || is_open_) throw Error(DTTMM_ERROR_PHASE, fmt::format("{}: only after a commit", what));
}

void Network::mean_wrench(double* wrench) const {
    require_committed("mean_wrench");
    instant_.find_mean_wrenches();
    instant_.add_wrenches(wrench);
}

void Network::stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const {
    require_committed("stand");
    instant_.find(bodies, accelerations);
    instant_.add_wrenches(wrench);
}

void Network::outputs(double* values) const {
    if (mechanism_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    if (!instant_.is_known()) instant_.find_by_centred_velocities(earlier_, start_velocities_);
    results_.write(instant_, values);
}

double* Network::write_lines(uint32_t stations, double* positions) const {
    if (mechanism_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "positions: no step has been committed");
    return results_.write_lines(stations, positions);
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

void Network::require_between_steps(const char* what) const {
    if (!started_ || is_open_) throw Error(DTTMM_ERROR_PHASE, fmt::format("{}: only between steps, after start", what));
}

size_t Network::state_size() const {
    size_t size = sizeof(double);  // of the step size
    for_each_state(*this, [&](auto piece) { size += piece.size_bytes(); });
    return size;
}

void Network::save_state(void* buffer, size_t size) const {
    require_between_steps("save_state");
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
    require_between_steps("restore_state");
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
    instant_.forget();
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
        one->require_between_steps("centre");
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
    above.instant_.forget();
    below.instant_.forget();
}

}  // namespace dttmm::plugin
