// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/networks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "coupling/loads.h"
#include "coupling/network_description.h"
#include "loader/plugin_call.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr size_t kBlock = 36;

Eigen::Map<Eigen::Vector3d> vector(double* v) { return Eigen::Map<Eigen::Vector3d>(v); }

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Networks::Networks(const Model& model, const Plugins& plugins) : path_(model.path) {
    for (const Body& body : model.bodies) body_names_.push_back(body.name);
    const std::vector<std::vector<size_t>> groups = split_by_plugin(model, plugins);
    instances_.reserve(groups.size());
    for (const std::vector<size_t>& elements : groups)
        add_instance(model, NetworkDescription(model, plugins, elements), elements);
    is_implicit_ = model.simulation.coupling == Coupling::implicit;
    if (!instances_.empty()) take_weights();
    motions_.resize(model.bodies.size());
    wrenches_.resize(6 * model.bodies.size());
    for (const NetworkInstance& instance : instances_) {
        outputs_.emplace_back(instance.channels().size());
        first_part_.push_back(progress_.size());
        if (is_implicit_) progress_.resize(progress_.size() + instance.part_count());
    }
    refuse_changed_arithmetic();
}

void Networks::add_instance(const Model& model, const NetworkDescription& description, const std::vector<size_t>& elements) {
    Slot& slot = slots_.emplace_back();
    slot.first_on_body.assign(model.bodies.size(), -1);
    for (size_t e = 0; e < elements.size(); ++e) {
        const Element& element = model.elements[elements[e]];
        slot.places.push_back(element.place);
        for (const Attachment& end : element.ends)
            if (end.body >= 0 && slot.first_on_body[as_size(end.body)] < 0)
                slot.first_on_body[as_size(end.body)] = as_int(e);
    }
    std::vector<bool> is_loaded(model.nodes.size());
    for (const Load& load : model.loads)
        if (load.on.node >= 0) is_loaded[as_size(load.on.node)] = true;
    for (int node : description.inner_nodes()) {
        slot.loaded.push_back(as_size(node));
        slot.is_loaded = slot.is_loaded || is_loaded[as_size(node)];
    }
    for (size_t load : description.line_loads()) {
        slot.loaded.push_back(model.nodes.size() + load);
        slot.is_loaded = true;
    }
    for (int node : description.supported_nodes())
        slot.supported.push_back(6 * (model.nodes.size() + model.loads.size()) + kSupportNumbers * as_size(node));
    supports_.resize(std::max(supports_.size(), slot.supported.size()));
    tell_place(slots_.size() - 1, [&] { instances_.emplace_back(description.plugin(), description.network()); });
    const NetworkInstance& instance = instances_.back();
    if (!slot.supported.empty() && !instance.has_supports()) {
        const Node& node = model.nodes[as_size(description.supported_nodes().front())];
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{}: node \"{}\": plugin {} moves no fixed nodes: it is without the extension " DTTMM_SUPPORT
                                "; leave its motion out",
                                node.motion_place, node.name, instance.plugin_name()));
    }
    stand_ = stand_ && instance.stands();
    for (const dttmm_block& block : instance.blocks())
        if (block.row > block.column) neighbours_.emplace_back(as_int(block.row), as_int(block.column));
    loads_.resize(std::max(loads_.size(), 6 * slot.loaded.size()));
}

/// Of all plugins the same.
void Networks::take_weights() {
    instances_.front().load_weights(weights_);
    // A sum of three weights is exact to a few roundings of one, 1e-16 each; the formulas of a scheme to some more
    constexpr double kWeightRounding = 1e-12;
    const bool is_share =
        std::ranges::all_of(weights_, [](double w) { return w >= -kWeightRounding && w <= 1 + kWeightRounding; });
    if (!is_share || !(std::abs(weights_[0] + weights_[1] + weights_[2] - 1) < kWeightRounding))
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{}: loads are weighted by {}, {} and {}; weights lie within 0 and 1 and add up to one",
                                instances_.front().name(), weights_[0], weights_[1], weights_[2]));
    is_implicit_ = false;
    for (const NetworkInstance& instance : instances_) {
        is_implicit_ = is_implicit_ || instance.is_implicit();
        double other[3];
        instance.load_weights(other);
        if (std::equal(weights_, weights_ + 3, other)) continue;
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{} and {} weight loads differently over a step: their plugins use different time "
                                "schemes and cannot share a model",
                                instances_.front().name(), instance.name()));
    }
}

/// Puts the place of the element that a plugin blames before what it says.
template <class Action>
void Networks::tell_place(size_t instance, Action&& action) const {
    try {
        action();
    } catch (const NetworkError& error) {
        const std::vector<std::string>& places = slots_[instance].places;
        const bool is_one = error.element() >= 0 || places.size() == 1;
        const std::string& place = is_one ? places[as_size(std::max(error.element(), 0))] : path_;
        throw Error(error.code(), fmt::format("{}: {}", place, error.what()));
    }
}

/// Puts the time before what a plugin says while a step is open. A model that could be started is not invalid any more.
template <class Action>
void Networks::tell_time(double time, Action&& action) {
    try {
        action();
    } catch (const NetworkError& error) {
        const ExitCode code = error.code() == ExitCode::model_invalid ? ExitCode::plugin_failure : error.code();
        throw Error(code, fmt::format("t = {:.9g} s: {}", time, error.what()));
    }
}

// ---- What goes to the plugins and comes from them -----------------------------------------------------------------------

void Networks::gather(const std::vector<BodyState>& motion) {
    for (size_t b = 0; b < motions_.size(); ++b) {
        dttmm_motion& out = motions_[b];
        vector(out.position) = motion[b].position;
        Eigen::Map<RowMajor3>{out.rotation} = motion[b].rotation;
        vector(out.velocity) = motion[b].velocity;
        vector(out.angular_velocity) = motion[b].angular_velocity;
    }
}

/// Loads on one instance; null if there are none.
const double* Networks::gather_loads(size_t instance, const double* loads) {
    const Slot& slot = slots_[instance];
    if (!slot.is_loaded) [[likely]]
        return nullptr;
    double* out = loads_.data();
    for (size_t at : slot.loaded) out = std::copy_n(loads + 6 * at, 6, out);
    return loads_.data();
}

/// Hands the motions of its supports to one instance.
void Networks::move_supports(size_t instance, const double* loads) {
    const Slot& slot = slots_[instance];
    if (slot.supported.empty()) [[likely]]
        return;
    for (size_t s = 0; s < slot.supported.size(); ++s)
        std::copy_n(loads + slot.supported[s], kSupportNumbers, supports_[s].displacement);
    instances_[instance].move_supports(supports_.data());
}

/// Adds the wrenches of one instance to those of the bodies.
void Networks::scatter(size_t instance, double* wrenches) const {
    check_guards(instance, wrenches_, "wrench");
    const double* wrench = wrenches_.data();
    for (size_t b = 0; b < motions_.size(); ++b, wrench += 6, wrenches += 6) {
        double size = 0;  // not a number if one of them is not
        for (int i = 0; i < 6; ++i) size += std::abs(wrench[i]);
        if (!(size <= World::kLargestWrench)) [[unlikely]]
            refuse_wrench(instance, b);
        for (int i = 0; i < 6; ++i) wrenches[i] += wrench[i];
    }
}

void Networks::check_guards(size_t instance, const GuardedArray& array, const char* name) const {
    if (const char* end = array.overrun()) [[unlikely]]
        instances_[instance].blame(fmt::format("it wrote past the {} of the {} array", end, name));
}

/// The blocks of an instance, to be written by its plugin.
double* Networks::make_room(size_t instance, GuardedArray& matrix) const {
    matrix.resize(kBlock * instances_[instance].blocks().size());
    return matrix.data();
}

void Networks::check_matrix(size_t instance, const GuardedArray& matrix, const char* name, const char* when) const {
    check_guards(instance, matrix, name);
    for (size_t i = 0; i < matrix.size(); ++i)
        if (!std::isfinite(matrix[i]))
            instances_[instance].blame(fmt::format("it says that its {}{} is {}; it must be finite", name, when, matrix[i]));
}

void Networks::refuse_wrench(size_t instance, size_t body) const {
    const double* wrench = wrenches_.data() + 6 * body;
    const NetworkInstance& blamed = instances_[instance];
    const int known = blamed.culprit(-1), first = slots_[instance].first_on_body[body];
    const auto name = [&](int element) { return blamed.element_name(static_cast<uint32_t>(element)); };
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "{} (plugin {}) on body \"{}\" at t = {:.9g} s: force ({:.4g}, {:.4g}, {:.4g}) N, moment ({:.4g}, {:.4g}, "
            "{:.4g}) N m is not finite or beyond the cap of {:.0e}; the run ends before it reaches ODE. Try a smaller "
            "step, or look for a fault of the plugin",
            known >= 0   ? fmt::format("element \"{}\"", name(known))
            : first >= 0 ? fmt::format("element \"{}\" or another", name(first))
                         : "an element",
            blamed.plugin_name(), body_names_[body], time_, wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5],
            World::kLargestWrench));
}

// ---- Phases -------------------------------------------------------------------------------------------------------------

void Networks::linearise(const std::vector<BodyState>& at, double* wrenches, const LinearSink* sink) {
    gather(at);
    GuardedArray damping_blocks;
    for (size_t n = 0; n < instances_.size(); ++n) {
        double* stiffness = sink ? make_room(n, stiffness_) : nullptr;
        double* damping = sink ? make_room(n, damping_blocks) : nullptr;
        tell_place(n, [&] {
            instances_[n].linearise(motions_.data(), wrenches_.data(), stiffness, damping);
            scatter(n, wrenches);
            if (!sink) return;
            check_matrix(n, stiffness_, "stiffness", " at the start");
            check_matrix(n, damping_blocks, "damping", " at the start");
        });
        if (!sink) continue;
        for (const dttmm_block& block : instances_[n].blocks()) {
            (*sink)(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness),
                    Eigen::Map<const RowMajor6>(damping));
            stiffness += kBlock;
            damping += kBlock;
        }
    }
}

std::vector<Networks::TakenUp> Networks::take_up(const std::vector<BodyState>& at, const double* motion) {
    std::vector<TakenUp> list;
    gather(at);
    for (size_t n = 0; n < instances_.size(); ++n) {
        const NetworkInstance& instance = instances_[n];
        if (instance.takes_up()) {
            GuardedArray elastic(instance.element_count()), damped(instance.element_count());
            tell_place(n, [&] {
                instance.take_up(motion, elastic.data(), damped.data());
                check_matrix(n, elastic, "share of a motion");
                check_matrix(n, damped, "share of a motion");
            });
            for (uint32_t e = 0; e < instance.element_count(); ++e)
                list.push_back({instance.element_name(e), elastic[e], damped[e]});
            continue;
        }
        GuardedArray damping_blocks;
        double *stiffness = make_room(n, stiffness_), *damping = make_room(n, damping_blocks);
        tell_place(n, [&] {
            instance.linearise(motions_.data(), wrenches_.data(), stiffness, damping);
            check_matrix(n, stiffness_, "stiffness", " at the start");
            check_matrix(n, damping_blocks, "damping", " at the start");
        });
        TakenUp& all = list.emplace_back(instance.name(), 0.0, 0.0);
        using Map = Eigen::Map<const Eigen::Matrix<double, 6, 1>>;
        for (const dttmm_block& block : instance.blocks()) {
            const Map row(motion + 6 * block.row), column(motion + 6 * block.column);
            all.elastic += row.dot(Eigen::Map<const RowMajor6>(stiffness) * column);
            all.damped += row.dot(Eigen::Map<const RowMajor6>(damping) * column);
            stiffness += kBlock;
            damping += kBlock;
        }
    }
    return list;
}

void Networks::start(const dttmm_step& step, const std::vector<BodyState>& at, const double* accelerations,
                     const double* loads) {
    step_size_ = step.size;
    time_ = step.time;
    gather(at);
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] {
            move_supports(n, loads);
            instances_[n].start(step, motions_.data(), accelerations, gather_loads(n, loads));
        });
}

void Networks::begin_step(const dttmm_step& step, const double* loads) {
    time_ = step.time;
    tell_time(time_, [&] {
        for (size_t n = 0; n < instances_.size(); ++n) {
            move_supports(n, loads);
            instances_[n].begin_step(step, gather_loads(n, loads));
        }
    });
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink* sink) {
    if (is_implicit_ || sink) gather(trial);
    for (size_t n = 0; n < instances_.size(); ++n) {
        const double* stiffness = sink ? make_room(n, stiffness_) : nullptr;
        tell_time(time_, [&] {
            if (is_implicit_)
                std::ranges::copy(instances_[n].iterate(motions_.data()), progress_.begin() + as_row(first_part_[n]));
            instances_[n].evaluate(motions_.data(), wrenches_.data(), sink ? stiffness_.data() : nullptr);
            scatter(n, wrenches);
            if (sink) check_matrix(n, stiffness_, "stiffness");
        });
        if (!sink) continue;
        for (const dttmm_block& block : instances_[n].blocks()) {
            (*sink)(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness));
            stiffness += kBlock;
        }
    }
}

void Networks::centre(Networks& above, Networks& below) const {
    for (size_t n = 0; n < instances_.size(); ++n) {
        if (!instances_[n].has_derivative())
            throw Error(ExitCode::plugin_failure, fmt::format("{}: its plugin {} is without the extension " DTTMM_DERIVATIVE,
                                                              instances_[n].name(), instances_[n].plugin_name()));
        tell_place(n, [&] { instances_[n].centre(above.instances_[n], below.instances_[n]); });
    }
}

std::string Networks::whose_part(size_t part) const {
    const auto instance = std::ranges::upper_bound(first_part_, part) - first_part_.begin() - 1;
    return instances_[as_size(instance)].whose(progress_[part].element);
}

void Networks::commit_step(const std::vector<BodyState>& accepted) {
    gather(accepted);
    tell_time(time_ + step_size_, [&] {
        for (NetworkInstance& instance : instances_) instance.commit_step(motions_.data());
    });
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

void Networks::begin_statics() {
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] {
            if (!instances_[n].has_statics())
                instances_[n].blame("it knows no equilibrium: it is without the extension " DTTMM_STATIC);
            instances_[n].begin_statics();
        });
}

void Networks::keep_statics() {
    for (size_t n = 0; n < instances_.size(); ++n) tell_place(n, [&] { instances_[n].keep_statics(); });
}

void Networks::recall_statics() {
    for (size_t n = 0; n < instances_.size(); ++n) tell_place(n, [&] { instances_[n].recall_statics(); });
}

void Networks::set_static_loads(const Eigen::Vector3d& gravity, const double* node_loads) {
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] {
            move_supports(n, node_loads);
            instances_[n].set_static_loads(gravity.data(), gather_loads(n, node_loads));
        });
}

void Networks::form_static(const std::vector<BodyState>& at, double resistance, double* wrenches,
                           const StiffnessSink& sink) {
    gather(at);
    for (size_t n = 0; n < instances_.size(); ++n) {
        const double* stiffness = make_room(n, stiffness_);
        tell_place(n, [&] {
            instances_[n].form_static(motions_.data(), resistance, wrenches_.data(), stiffness_.data());
            scatter(n, wrenches);
            check_matrix(n, stiffness_, "stiffness", " at rest");
        });
        for (const dttmm_block& block : instances_[n].blocks()) {
            sink(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness));
            stiffness += kBlock;
        }
    }
}

void Networks::add_measure(size_t instance, const dttmm_static_measure& own, StaticMeasure& sum) const {
    sum.work += own.work;
    sum.residual = std::max(sum.residual, own.residual);
    sum.force = std::max(sum.force, own.force);
    sum.noise = std::max(sum.noise, own.noise);
    sum.turn = std::max(sum.turn, own.turn);
    if (own.shift <= sum.shift) return;
    sum.shift = own.shift;
    if (own.element >= 0 && as_size(own.element) < instances_[instance].element_count())
        sum.element = instances_[instance].element_name(static_cast<uint32_t>(own.element));
}

Networks::StaticMeasure Networks::correct_static(const double* change) {
    StaticMeasure sum;
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] { add_measure(n, instances_[n].correct_static(change), sum); });
    return sum;
}

Networks::StaticMeasure Networks::move_static(const std::vector<BodyState>& at, double share, double* wrenches) {
    gather(at);
    StaticMeasure sum;
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] {
            add_measure(n, instances_[n].move_static(motions_.data(), share, wrenches_.data()), sum);
            scatter(n, wrenches);
        });
    return sum;
}

void Networks::start_at_rest(const dttmm_step& step, const std::vector<BodyState>& at, const double* node_loads) {
    step_size_ = step.size;
    time_ = step.time;
    gather(at);
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] { instances_[n].start_at_rest(step, motions_.data(), gather_loads(n, node_loads)); });
}

// ---- Results ------------------------------------------------------------------------------------------------------------

size_t Networks::output_count() const {
    size_t count = 0;
    for (const NetworkInstance& instance : instances_) count += instance.channels().size();
    return count;
}

void Networks::add_mean_wrenches(double* wrenches) {
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_time(time_, [&] {
            instances_[n].mean_wrench(wrenches_.data());
            scatter(n, wrenches);
        });
}

void Networks::stand_at(const std::vector<BodyState>& at, const double* accelerations, double* wrenches) {
    gather(at);
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_time(time_, [&] {
            instances_[n].stand(motions_.data(), accelerations, wrenches_.data());
            scatter(n, wrenches);
        });
}

void Networks::watch_lines(uint32_t stations) {
    stations_ = stations;
    positions_.clear();
    for (const NetworkInstance& instance : instances_) positions_.emplace_back(3 * stations * instance.lines().size());
}

double* Networks::positions(double* values) const {
    for (size_t n = 0; n < instances_.size(); ++n) {
        const NetworkInstance& instance = instances_[n];
        if (instance.lines().empty()) continue;
        GuardedArray& own = positions_[n];
        tell_time(time_, [&] {
            instance.positions(stations_, own.data());
            check_guards(n, own, "position");
        });
        for (size_t i = 0; i < own.size(); ++i) {
            if (!std::isfinite(own[i])) [[unlikely]]
                throw Error(
                    ExitCode::plugin_failure,
                    fmt::format("element \"{}\" at t = {:.9g} s: plugin {} gives {} as a coordinate of one of its points",
                                instance.element_name(instance.lines()[i / (3 * stations_)]), time_, instance.plugin_name(),
                                own[i]));
            *values++ = own[i];
        }
    }
    refuse_changed_arithmetic();
    return values;
}

void Networks::outputs(double* values) const {
    for (size_t n = 0; n < instances_.size(); ++n) {
        const NetworkInstance& instance = instances_[n];
        GuardedArray& own = outputs_[n];
        tell_time(time_, [&] {
            instance.outputs(own.data());
            check_guards(n, own, "output");
        });
        for (size_t c = 0; c < instance.channels().size(); ++c) {
            values[c] = own[c];
            if (std::isfinite(values[c])) [[likely]]
                continue;
            const Channel& channel = instance.channels()[c];
            throw Error(ExitCode::plugin_failure,
                        fmt::format("{} \"{}\" at t = {:.9g} s: plugin {} says {} is {}",
                                    channel.of() == Channel::Of::node ? "node" : "element", channel.owner(), time_,
                                    instance.plugin_name(), channel.name_in_owner(), values[c]));
        }
        values += instance.channels().size();
    }
    refuse_changed_arithmetic();
}

}  // namespace dttmm::host
