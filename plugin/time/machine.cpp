// SPDX-License-Identifier: BSD-3-Clause
#include "time/machine.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/index.h"
#include "element/registry.h"
#include "mechanism/frame.h"

namespace dttmm::plugin {

namespace {

using Units = std::vector<std::vector<uint32_t>>;

/// Elements that share an inner node, and alone the others; each ascending, by its first element.
Units join_by_nodes(const dttmm_network& description) {
    std::vector<uint32_t> root(description.element_count);
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](uint32_t e) {
        while (root[e] != e) e = root[e] = root[root[e]];
        return e;
    };
    std::vector<uint32_t> first_at(description.node_count, description.element_count);
    for (uint32_t e = 0; e < description.element_count; ++e) {
        const dttmm_element& element = description.elements[e];
        for (uint32_t end : std::span(element.ends, element.end_count)) {
            if (end >= description.node_count) throw Error(DTTMM_ERROR_MODEL, "an end is no node of the network", as_int(e));
            if (description.nodes[end].kind != DTTMM_NODE_INNER) continue;
            if (first_at[end] == description.element_count) first_at[end] = e;
            const auto [low, high] = std::minmax({find(e), find(first_at[end])});  // by value: find returns no lvalue
            root[high] = low;
        }
    }
    Units units;
    std::map<uint32_t, size_t> numbers;
    for (uint32_t e = 0; e < description.element_count; ++e) {
        const auto [number, is_new] = numbers.try_emplace(find(e), units.size());
        if (is_new) units.emplace_back();
        units[number->second].push_back(e);
    }
    return units;
}

/// Whether an element is nothing but joints between bodies and the ground. What is wrong with it is said later.
bool is_joint_of_bodies(const dttmm_network& description, const dttmm_element& element) {
    std::vector<Pose> ends;
    for (uint32_t end : std::span(element.ends, element.end_count)) {
        const dttmm_node& node = description.nodes[end];
        if (node.kind == DTTMM_NODE_INNER) return false;
        ends.push_back({Eigen::Map<const Vector3>(node.position), Eigen::Map<const RowMajor3>(node.rotation)});
    }
    try {
        return make_element(element.type, element.values)->discretise(ends).lumps.empty();
    } catch (const Error&) {
        return false;
    }
}

/// The description of some elements and of the bodies and nodes that they need, and where these are in the whole.
class Extract {
public:
    Extract(const Supports& supports, std::span<const uint32_t> elements)
        : part_(supports.description()), supports_(supports) {
        const dttmm_network& whole = supports.description();
        for (uint32_t e : elements) {
            places_.elements.push_back(e);
            elements_.push_back(whole.elements[e]);
            ends_.emplace_back();
            for (uint32_t end : std::span(whole.elements[e].ends, whole.elements[e].end_count))
                ends_.back().push_back(node(whole, end));
        }
        for (size_t e = 0; e < elements_.size(); ++e) elements_[e].ends = ends_[e].data();
        for (uint32_t k = 0; k < whole.line_load_count; ++k) {
            const auto own = std::ranges::find(elements, whole.line_loads[k].element);
            if (own == elements.end()) continue;
            line_loads_.push_back({as_whole<uint32_t>(own - elements.begin()), whole.line_loads[k].axes});
            line_load_places_.push_back(k);
        }
        part_.body_count = as_whole<uint32_t>(bodies_.size());
        part_.bodies = bodies_.data();
        part_.node_count = as_whole<uint32_t>(nodes_.size());
        part_.nodes = nodes_.data();
        part_.element_count = as_whole<uint32_t>(elements_.size());
        part_.elements = elements_.data();
        part_.line_load_count = as_whole<uint32_t>(line_loads_.size());
        part_.line_loads = line_loads_.data();
    }
    const dttmm_network& description() const { return part_; }
    const Places& places() const { return places_; }
    /// Of its line loads, those in the whole.
    const std::vector<uint32_t>& line_load_places() const { return line_load_places_; }

private:
    uint32_t node(const dttmm_network& whole, uint32_t index) {
        const auto [found, is_new] = node_of_.try_emplace(index, as_whole<uint32_t>(nodes_.size()));
        if (!is_new) return found->second;
        dttmm_node own = whole.nodes[index];
        if (own.kind == DTTMM_NODE_ON_BODY && own.body < whole.body_count) own.body = body(whole, own.body);
        const int support = supports_.body_of(index);
        places_.supported_by.push_back(support < 0 ? -1 : as_int(body(whole, as_whole<uint32_t>(support))));
        nodes_.push_back(own);
        places_.nodes.push_back(index);
        return found->second;
    }

    uint32_t body(const dttmm_network& whole, uint32_t index) {
        const auto [body, is_new] = body_of_.try_emplace(index, as_whole<uint32_t>(bodies_.size()));
        if (is_new) {
            bodies_.push_back(whole.bodies[index]);
            places_.bodies.push_back(index);
        }
        return body->second;
    }

    dttmm_network part_;
    const Supports& supports_;
    Places places_;
    std::map<uint32_t, uint32_t> node_of_, body_of_;
    std::vector<dttmm_body> bodies_;
    std::vector<dttmm_node> nodes_;
    std::vector<dttmm_element> elements_;
    std::vector<std::vector<uint32_t>> ends_;
    std::vector<dttmm_line_load> line_loads_;
    std::vector<uint32_t> line_load_places_;
};

/// What `action` does for a network; an error names the element in the whole.
template <class Action>
void in_whole(const Places& places, const Action& action) {
    try {
        action();
    } catch (const Error& error) {
        const bool is_call = error.status() == DTTMM_ERROR_PHASE || error.status() == DTTMM_ERROR_ARGUMENT;
        if (error.element() < 0 && is_call) throw;  // no element is to blame
        throw Error(error.status(), error.what(), as_int(places.elements[as_size(std::max(error.element(), 0))]));
    }
}

}  // namespace

template <class Self, class Action>
void Machine::for_each(Self& self, const Action& action) {
    for (auto& part : self.networks_) in_whole(part.network.places(), [&] { action(part); });
}

// ---- Construction -------------------------------------------------------------------------------------------------------

Machine::Machine(const dttmm_network& description)
    : body_count_(description.body_count), element_count_(description.element_count), supports_(description) {
    if (description.element_count == 0) throw Error(DTTMM_ERROR_MODEL, "a network without an element");
    for (uint32_t k = 0; k < description.line_load_count; ++k)
        if (description.line_loads[k].element >= description.element_count)
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("line load {} is on no element", k));
    const Units units = join_by_nodes(description);
    Units parts(1);  // the joints between bodies come first
    for (const std::vector<uint32_t>& unit : units) {
        const bool is_joint = unit.size() == 1 && is_joint_of_bodies(description, description.elements[unit.front()]);
        if (is_joint)
            parts.front().push_back(unit.front());
        else
            parts.push_back(unit);
    }
    std::vector<uint32_t> number_of(description.node_count);  // of the inner nodes
    uint32_t inner_count = 0;
    for (uint32_t n = 0; n < description.node_count; ++n)
        if (description.nodes[n].kind == DTTMM_NODE_INNER) number_of[n] = inner_count++;
    load_count_ = inner_count + description.line_load_count;
    for (const std::vector<uint32_t>& part : parts) {
        if (part.empty()) continue;
        const Extract extract(supports_, part);
        in_whole(extract.places(), [&] { networks_.emplace_back(extract.description(), extract.places()); });
        Part& made = networks_.back();
        for (uint32_t n : extract.places().nodes)
            if (supports_.description().nodes[n].kind == DTTMM_NODE_INNER) made.loaded.push_back(number_of[n]);
        for (uint32_t k : extract.line_load_places()) made.loaded.push_back(inner_count + k);
        made.loads.resize(6 * made.loaded.size());
    }
    is_implicit_ = networks_.front().network.is_implicit();
    const auto is_rigid = [](const Part& part) { return part.network.has_rigid_directions(); };
    if ((description.mean_velocities != 0 && is_implicit_) || std::ranges::any_of(networks_, is_rigid))
        for (Part& part : networks_) part.network.take_rates_by_increments();
    place_blocks();
    place_channels(units);
}

/// A block that several networks have is one.
void Machine::place_blocks() {
    std::map<std::pair<uint32_t, uint32_t>, size_t> places;
    const auto is_seen = [&](const dttmm_block& block) { return std::max(block.row, block.column) < body_count_; };
    for (const bool wants_seen : {true, false}) {
        for (Part& part : networks_)
            for (size_t b = 0; b < part.network.blocks().list().size(); ++b) {
                const dttmm_block& block = part.network.blocks().list()[b];
                if (is_seen(block) != wants_seen) continue;
                const auto [place, is_new] = places.try_emplace({block.row, block.column}, blocks_.size());
                if (is_new) blocks_.push_back(block);
                part.network.blocks().place(b, place->second);
            }
        if (wants_seen) seen_blocks_ = blocks_.size();
    }
    joined_.emplace(supports_, body_count_, blocks_.size(), seen_blocks_);
}

/// In the order of the elements; what nodes have comes after the elements that they join.
void Machine::place_channels(std::span<const std::vector<uint32_t>> units) {
    std::vector<std::pair<Network*, size_t>> piece_of(element_count_);
    for (Part& part : networks_)
        for (size_t e = 0; e < part.network.places().elements.size(); ++e)
            piece_of[part.network.places().elements[e]] = {&part.network, e};
    // Visits the pieces in their order
    const auto for_each_piece = [&](const auto& visit) {
        for (const std::vector<uint32_t>& unit : units) {
            for (uint32_t e : unit) visit(piece_of[e].first->results(), piece_of[e].second);
            NetworkResults& results = piece_of[unit.front()].first->results();
            const size_t others = results.piece_count() - 1;
            if (!results.piece(others).empty()) visit(results, others);
        }
    };
    size_t count = 0, next = 0;
    bool is_in_order = networks_.size() == 1;
    for_each_piece([&](NetworkResults& results, size_t piece) {
        is_in_order = is_in_order && piece == next++;
        results.place(piece, count);
        count += results.piece(piece).size();
    });
    if (is_in_order) {
        channels_ = networks_.front().network.results().take_channels();
    } else {
        channels_.reserve(count);
        for_each_piece([&](NetworkResults& results, size_t piece) {
            const auto channels = results.piece(piece);
            channels_.insert(channels_.end(), channels.begin(), channels.end());
        });
    }
    if (!supports_.empty()) channels_.push_back({"work_of_supports", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_WORK});
    channel_count_ = channels_.size();
    for (Part& part : networks_) part.network.results().take_channels();
    for (const Part& part : networks_) std::ranges::copy(part.network.results().lines(), std::back_inserter(lines_));
}

void Machine::forget_channels() {
    std::vector<dttmm_channel>().swap(channels_);
    for (Part& part : networks_) part.network.results().forget_names();
}

// ---- Phases -------------------------------------------------------------------------------------------------------------

const double* Machine::gather_loads(Part& part, const double* loads) const {
    if (!loads || part.loaded.empty()) return nullptr;
    for (size_t i = 0; i < part.loaded.size(); ++i) std::copy_n(loads + 6 * part.loaded[i], 6, &part.loads[6 * i]);
    return part.loads.data();
}

void Machine::linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_start);
    double *const w = joined_->wrenches_for(wrench), *const k = joined_->blocks_for(stiffness, joined_->stiffness),
                  *const c = joined_->blocks_for(damping, joined_->damping);
    for_each(*this, [&](const Part& part) { part.network.linearise(all, w, k, c); });
    joined_->hand_out(wrench);
    joined_->hand_out(stiffness, joined_->stiffness);
    joined_->hand_out(damping, joined_->damping);
}

void Machine::take_up(const double* motion, double* elastic, double* damped) const {
    std::fill_n(elastic, element_count_, 0.0);
    std::fill_n(damped, element_count_, 0.0);
    const double* const all = joined_->with_supports(motion, nullptr);
    for_each(*this, [&](const Part& part) { part.network.take_up(all, elastic, damped); });
}

void Machine::start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads) {
    supports_.start();
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_start);
    std::vector<double> of_supports(6 * supports_.count());
    supports_.write_accelerations(of_supports.data());
    const double* const a = joined_->with_supports(accelerations, of_supports.data());
    for_each(*this, [&](Part& part) { part.network.start(step, all, a, gather_loads(part, loads)); });
    forget_channels();
}

void Machine::begin_step(const dttmm_step& step, const double* loads) {
    size_t open = 0;
    try {
        for_each(*this, [&](Part& part) {
            part.network.begin_step(step, gather_loads(part, loads));
            ++open;
        });
    } catch (...) {
        while (open > 0) networks_[--open].network.discard_step();
        throw;
    }
    supports_.begin_step(step.size);
}

uint32_t Machine::part_count() const {
    return as_whole<uint32_t>(std::ranges::count_if(networks_, [](const Part& part) { return part.network.iterates(); }));
}

void Machine::iterate(const dttmm_motion* trial, dttmm_progress* progress) {
    const dttmm_motion* const all = joined_->with_supports(trial, &Supports::write_end);
    for_each(*this, [&](Part& part) {
        if (!part.network.iterates()) return;
        part.network.iterate(all, *progress);
        const auto& elements = part.network.places().elements;
        progress->element = as_whole<int32_t>(elements[as_size(std::max(progress->element, 0))]);
        ++progress;
    });
}

void Machine::evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const {
    const dttmm_motion* const all = joined_->with_supports(trial, &Supports::write_end);
    double *const w = joined_->wrenches_for(wrench), *const k = joined_->blocks_for(stiffness, joined_->stiffness);
    for_each(*this, [&](const Part& part) { part.network.evaluate(all, w, k); });
    joined_->hand_out(wrench);
    joined_->hand_out(stiffness, joined_->stiffness);
}

void Machine::commit_step(const dttmm_motion* accepted) {
    const dttmm_motion* const all = joined_->with_supports(accepted, &Supports::write_end);
    for_each(*this, [&](Part& part) { part.network.commit_step(all); });
    if (supports_.empty()) return;
    supports_.commit_step();
    std::ranges::fill(joined_->wrenches, 0.0);
    for_each(*this, [&](const Part& part) {
        part.network.mean_wrench(joined_->wrenches.data());
        part.network.add_turned_dampers(joined_->wrenches.data());
    });
    std::ranges::fill(joined_->numbers, 0.0);
    for_each(*this, [&](const Part& part) { part.network.add_rigid_wrenches(joined_->numbers.data()); });
    supports_.add_work(&joined_->wrenches[6 * size_t{body_count_}], &joined_->numbers[6 * size_t{body_count_}]);
}

void Machine::discard_step() {
    for_each(*this, [&](Part& part) { part.network.discard_step(); });
}

void Machine::mean_wrench(double* wrench) const {
    double* const w = joined_->wrenches_for(wrench);
    for_each(*this, [&](const Part& part) { part.network.mean_wrench(w); });
    joined_->hand_out(wrench);
}

void Machine::stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const {
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_instant);
    if (!supports_.empty()) supports_.write_accelerations(joined_->changes.data());
    const double* const a = accelerations ? joined_->with_supports(accelerations, joined_->changes.data()) : nullptr;
    double* const w = joined_->wrenches_for(wrench);
    for_each(*this, [&](const Part& part) { part.network.stand(all, a, w); });
    joined_->hand_out(wrench);
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

void Machine::begin_statics() {
    supports_.begin_statics();
    for_each(*this, [](Part& part) { part.network.begin_statics(); });
}

void Machine::keep_statics() {
    for_each(*this, [](Part& part) { part.network.statics().refuse_large_rotations(); });  // before any is kept
    supports_.keep_statics();
    for_each(*this, [](Part& part) { part.network.statics().keep(); });
}

void Machine::recall_statics() {
    supports_.recall_statics();
    for_each(*this, [](Part& part) { part.network.statics().recall(); });
}

void Machine::set_static_loads(const double* gravity, const double* loads) {
    for_each(*this, [&](Part& part) {
        part.network.statics().set_loads(Eigen::Map<const Vector3>(gravity), gather_loads(part, loads));
    });
}

void Machine::form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness) {
    supports_.form_statics();
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_at_rest);
    double *const w = joined_->wrenches_for(wrench), *const k = joined_->blocks_for(stiffness, joined_->stiffness);
    for_each(*this, [&](Part& part) { part.network.form_static(all, resistance, w, k); });
    if (supports_.empty()) return;
    // What supports are to do is known: it is a wrench on the bodies
    using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
    double* const change = joined_->changes.data();
    supports_.write_change(change);
    for (size_t b = seen_blocks_; b < blocks_.size(); ++b)
        if (blocks_[b].row < body_count_)
            Eigen::Map<Vector6>(w + 6 * blocks_[b].row) -=
                Eigen::Map<const RowMajor6>(k + 36 * b) *
                Eigen::Map<const Vector6>(change + 6 * (blocks_[b].column - body_count_));
    joined_->hand_out(wrench);
    joined_->hand_out(stiffness, joined_->stiffness);
}

/// Of all networks what finds asks of each.
template <class Find>
dttmm_static_measure Machine::measure_static(const Find& find) {
    dttmm_static_measure all{};
    all.element = -1;
    for_each(*this, [&](Part& part) {
        const dttmm_static_measure own = find(part.network);
        all.work += own.work;
        all.residual = std::max(all.residual, own.residual);
        all.force = std::max(all.force, own.force);
        all.noise = std::max(all.noise, own.noise);
        all.turn = std::max(all.turn, own.turn);
        all.bend = std::max(all.bend, own.bend);
        all.falling += own.falling;
        if (own.element < 0 || own.shift < all.shift) return;
        all.shift = own.shift;
        all.element = static_cast<int32_t>(part.network.places().elements[as_size(own.element)]);
    });
    return all;
}

void Machine::correct_static(const double* change, dttmm_static_measure* measure) {
    const std::optional<double> turn_of_supports = supports_.write_change(joined_->changes.data());
    const double* const all = joined_->with_supports(change, joined_->changes.data());
    *measure = measure_static([&](Network& network) { return network.correct_static(all); });
    if (!turn_of_supports) return;
    measure->turn = std::max(measure->turn, *turn_of_supports);
    // Supports that move do work of their own, which does not tell uphill from downhill
    measure->work = std::abs(measure->work);
}

void Machine::move_static(const dttmm_motion* bodies, double share, double* wrench, dttmm_static_measure* measure) {
    supports_.move_statics(share);
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_at_rest);
    double* const w = joined_->wrenches_for(wrench);
    *measure = measure_static([&](Network& network) { return network.move_static(all, share, w); });
    joined_->hand_out(wrench);
}

AtRest Machine::at_rest() const {
    AtRest rest;
    rest.elements.resize(element_count_);
    rest.loads.assign(load_count_, Vector6::Zero());
    for_each(*this, [&](const Part& part) {
        part.network.write_rest(rest);
        const std::vector<double>& loads = part.network.static_loads();
        for (size_t i = 0; i < part.loaded.size(); ++i)
            rest.loads[part.loaded[i]] = Eigen::Map<const Vector6>(&loads[6 * i]);
    });
    return rest;
}

void Machine::start_at_rest(const dttmm_step& step, const dttmm_motion* bodies, const double* loads) {
    supports_.start_at_rest();
    const dttmm_motion* const all = joined_->with_supports(bodies, &Supports::write_start);
    for_each(*this, [&](Part& part) { part.network.start_at_rest(step, all, gather_loads(part, loads)); });
    forget_channels();
}

// ---- State and results --------------------------------------------------------------------------------------------------

size_t Machine::state_size() const {
    size_t size = 0;
    for (const Part& part : networks_) size += part.network.state_size();
    Supports::for_each_state(supports_, [&](auto piece) { size += piece.size_bytes(); });
    return size;
}

void Machine::save_state(void* buffer, size_t size) const {
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("save_state: the state has {} bytes, not {}", state_size(), size));
    char* out = static_cast<char*>(buffer);
    for_each(*this, [&](const Part& part) {
        part.network.save_state(out, part.network.state_size());
        out += part.network.state_size();
    });
    Supports::for_each_state(supports_, [&](auto piece) {
        if (!piece.empty()) std::memcpy(out, piece.data(), piece.size_bytes());
        out += piece.size_bytes();
    });
}

void Machine::restore_state(const void* buffer, size_t size) {
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("restore_state: the state has {} bytes, not {}", state_size(), size));
    const char* in = static_cast<const char*>(buffer);
    for_each(*this, [&](Part& part) {
        part.network.restore_state(in, part.network.state_size());
        in += part.network.state_size();
    });
    Supports::for_each_state(supports_, [&](auto piece) {
        if (!piece.empty()) std::memcpy(static_cast<void*>(piece.data()), in, piece.size_bytes());
        in += piece.size_bytes();
    });
}

void Machine::centre(Machine& above, Machine& below, const Machine& middle) {
    const size_t count = middle.networks_.size();
    const auto show = [](auto& machine) {
        return [&](const auto& visit) { Supports::for_each_state(machine.supports_, visit); };
    };
    Centring supports(show(above), show(below), show(middle));
    if (above.networks_.size() != count || below.networks_.size() != count || !supports.is_possible())
        throw Error(DTTMM_ERROR_ARGUMENT, "centre: the machines differ in more than numbers");
    const auto for_each_network = [&](const auto& action) {
        for (size_t n = 0; n < count; ++n)
            action(above.networks_[n].network, below.networks_[n].network, middle.networks_[n].network);
    };
    for_each_network(Network::refuse_centre);
    for_each_network(Network::centre);
    supports.centre();
}

void Machine::positions(uint32_t stations, double* positions) const {
    if (stations < 2) throw Error(DTTMM_ERROR_ARGUMENT, "positions: a line has two stations at least");
    for_each(*this, [&](const Part& part) { positions = part.network.write_lines(stations, positions); });
}

void Machine::outputs(double* values) const {
    for_each(*this, [&](const Part& part) { part.network.outputs(values); });
    if (!supports_.empty()) values[channel_count_ - 1] = supports_.work();
}

}  // namespace dttmm::plugin
