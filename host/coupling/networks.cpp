// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/networks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "coupling/network_description.h"
#include "loader/plugin_call.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr size_t kBlock = NetworkExchange::kBlock;

void add_measure(const NetworkInstance& instance, const dttmm_static_measure& own, Networks::StaticMeasure& sum) {
    sum.work += own.work;
    sum.residual = std::max(sum.residual, own.residual);
    sum.force = std::max(sum.force, own.force);
    sum.noise = std::max(sum.noise, own.noise);
    sum.turn = std::max(sum.turn, own.turn);
    sum.bend = std::max(sum.bend, own.bend);
    sum.falling += own.falling;
    if (own.shift <= sum.shift) return;
    sum.shift = own.shift;
    if (own.element >= 0 && as_size(own.element) < instance.element_count())
        sum.element = instance.element_name(as_whole<uint32_t>(own.element));
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Networks::Networks(const Model& model, const Plugins& plugins) : exchange_(model) {
    const std::vector<std::vector<size_t>> groups = split_by_plugin(model, plugins);
    exchange_.instances().reserve(groups.size());
    for (const std::vector<size_t>& elements : groups) {
        exchange_.add(model, NetworkDescription(model, plugins, elements), elements);
        const NetworkInstance& instance = exchange_.instances().back();
        stand_ = stand_ && instance.stands();
        for (const dttmm_block& block : instance.blocks())
            if (block.row > block.column) neighbours_.emplace_back(as_int(block.row), as_int(block.column));
    }
    have_laws_ = std::ranges::any_of(model.elements, [&](const Element& element) {
        return has_law(*plugins.catalogue().types[as_size(element.type)], element.values);
    });
    is_implicit_ = model.simulation.coupling == Coupling::implicit;
    if (!exchange_.instances().empty()) take_weights();
    for (const NetworkInstance& instance : exchange_.instances()) {
        numbers_.reserve(std::max(instance.channel_count(), kBlock * instance.blocks().size()));
        first_part_.push_back(progress_.size());
        if (is_implicit_) progress_.resize(progress_.size() + instance.part_count());
    }
    refuse_changed_arithmetic();
}

/// Of all plugins the same.
void Networks::take_weights() {
    exchange_.instances().front().load_weights(weights_);
    // A sum of three weights is exact to a few roundings of one, 1e-16 each; the formulas of a scheme to some more
    constexpr double kWeightRounding = 1e-12;
    const bool is_share =
        std::ranges::all_of(weights_, [](double w) { return w >= -kWeightRounding && w <= 1 + kWeightRounding; });
    if (!is_share || !(std::abs(weights_[0] + weights_[1] + weights_[2] - 1) < kWeightRounding))
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{}: loads are weighted by {}, {} and {}; weights lie within 0 and 1 and add up to one",
                                exchange_.instances().front().name(), weights_[0], weights_[1], weights_[2]));
    is_implicit_ = false;
    for (const NetworkInstance& instance : exchange_.instances()) {
        is_implicit_ = is_implicit_ || instance.is_implicit();
        double other[3];
        instance.load_weights(other);
        if (std::equal(weights_, weights_ + 3, other)) continue;
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{} and {} weight loads differently over a step: their plugins use different time "
                                "schemes and cannot share a model",
                                exchange_.instances().front().name(), instance.name()));
    }
}

// ---- Phases -------------------------------------------------------------------------------------------------------------

void Networks::linearise(const std::vector<BodyState>& at, double* wrenches, const LinearSink* sink) {
    exchange_.gather(at);
    GuardedArray damping_blocks;
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        double* stiffness = sink ? exchange_.make_room(n, numbers_) : nullptr;
        double* damping = sink ? exchange_.make_room(n, damping_blocks) : nullptr;
        exchange_.tell_place(n, [&] {
            exchange_.instances()[n].linearise(exchange_.motions(), exchange_.wrenches(), stiffness, damping);
            exchange_.scatter(n, wrenches);
            if (!sink) return;
            exchange_.check_matrix(n, numbers_, "stiffness", " at the start");
            exchange_.check_matrix(n, damping_blocks, "damping", " at the start");
        });
        if (!sink) continue;
        for (const dttmm_block& block : exchange_.instances()[n].blocks()) {
            (*sink)(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness),
                    Eigen::Map<const RowMajor6>(damping));
            stiffness += kBlock;
            damping += kBlock;
        }
    }
}

std::vector<Networks::TakenUp> Networks::take_up(const std::vector<BodyState>& at, const double* motion) {
    std::vector<TakenUp> list;
    exchange_.gather(at);
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        const NetworkInstance& instance = exchange_.instances()[n];
        list.reserve(list.size() + instance.element_count());
        if (instance.takes_up()) {
            GuardedArray elastic(instance.element_count()), damped(instance.element_count());
            exchange_.tell_place(n, [&] {
                instance.take_up(motion, elastic.data(), damped.data());
                exchange_.check_matrix(n, elastic, "share of a motion");
                exchange_.check_matrix(n, damped, "share of a motion");
            });
            for (uint32_t e = 0; e < instance.element_count(); ++e)
                list.push_back({instance.element_name(e), elastic[e], damped[e]});
            continue;
        }
        GuardedArray damping_blocks;
        double *stiffness = exchange_.make_room(n, numbers_), *damping = exchange_.make_room(n, damping_blocks);
        exchange_.tell_place(n, [&] {
            instance.linearise(exchange_.motions(), exchange_.wrenches(), stiffness, damping);
            exchange_.check_matrix(n, numbers_, "stiffness", " at the start");
            exchange_.check_matrix(n, damping_blocks, "damping", " at the start");
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
    exchange_.set_time(step.time);
    exchange_.gather(at);
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] {
            exchange_.move_supports(n, loads);
            exchange_.instances()[n].start(step, exchange_.motions(), accelerations, exchange_.gather_loads(n, loads));
        });
}

void Networks::begin_step(const dttmm_step& step, const double* loads) {
    exchange_.set_time(step.time);
    exchange_.tell_time(exchange_.time(), [&] {
        for (size_t n = 0; n < exchange_.instances().size(); ++n) {
            exchange_.move_supports(n, loads);
            exchange_.instances()[n].begin_step(step, exchange_.gather_loads(n, loads));
        }
    });
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink* sink) {
    if (is_implicit_ || sink) exchange_.gather(trial);
    exchange_.forget_large();
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        const double* stiffness = sink ? exchange_.make_room(n, numbers_) : nullptr;
        exchange_.tell_time(exchange_.time(), [&] {
            if (is_implicit_)
                std::ranges::copy(exchange_.instances()[n].iterate(exchange_.motions()),
                                  progress_.begin() + as_row(first_part_[n]));
            exchange_.instances()[n].evaluate(exchange_.motions(), exchange_.wrenches(), sink ? numbers_.data() : nullptr);
            exchange_.scatter_trial(n, wrenches);
            if (sink) exchange_.check_matrix(n, numbers_, "stiffness");
        });
        if (!sink) continue;
        for (const dttmm_block& block : exchange_.instances()[n].blocks()) {
            (*sink)(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness));
            stiffness += kBlock;
        }
    }
}

void Networks::centre(Networks& above, Networks& below) const {
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        if (!exchange_.instances()[n].has_derivative())
            throw Error(ExitCode::plugin_failure,
                        fmt::format("{}: its plugin {} is without the extension " DTTMM_DERIVATIVE,
                                    exchange_.instances()[n].name(), exchange_.instances()[n].plugin_name()));
        exchange_.tell_place(
            n, [&] { exchange_.instances()[n].centre(above.exchange_.instances()[n], below.exchange_.instances()[n]); });
    }
}

std::string Networks::whose_part(size_t part) const {
    const auto instance = std::ranges::upper_bound(first_part_, part) - first_part_.begin() - 1;
    return exchange_.instances()[as_size(instance)].whose(progress_[part].element);
}

void Networks::commit_step(const std::vector<BodyState>& accepted) {
    exchange_.gather(accepted);
    exchange_.tell_time(exchange_.time() + step_size_, [&] {
        for (NetworkInstance& instance : exchange_.instances()) instance.commit_step(exchange_.motions());
    });
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

void Networks::begin_statics() {
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] {
            if (!exchange_.instances()[n].has_statics())
                exchange_.instances()[n].blame("it knows no equilibrium: it is without the extension " DTTMM_STATIC
                                               "; a damped run comes to rest without");
            exchange_.instances()[n].begin_statics();
        });
}

void Networks::keep_statics() {
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] { exchange_.instances()[n].keep_statics(); });
}

void Networks::recall_statics() {
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] { exchange_.instances()[n].recall_statics(); });
}

void Networks::set_static_loads(const Eigen::Vector3d& gravity, const double* node_loads) {
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] {
            exchange_.move_supports(n, node_loads);
            exchange_.instances()[n].set_static_loads(gravity.data(), exchange_.gather_loads(n, node_loads));
        });
}

void Networks::form_static(const std::vector<BodyState>& at, double resistance, double* wrenches,
                           const StiffnessSink& sink) {
    exchange_.gather(at);
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        const double* stiffness = exchange_.make_room(n, numbers_);
        exchange_.tell_place(n, [&] {
            exchange_.instances()[n].form_static(exchange_.motions(), resistance, exchange_.wrenches(), numbers_.data());
            exchange_.scatter(n, wrenches);
            exchange_.check_matrix(n, numbers_, "stiffness", " at rest");
        });
        for (const dttmm_block& block : exchange_.instances()[n].blocks()) {
            sink(as_int(block.row), as_int(block.column), Eigen::Map<const RowMajor6>(stiffness));
            stiffness += kBlock;
        }
    }
}

Networks::StaticMeasure Networks::correct_static(const double* change) {
    StaticMeasure sum;
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(
            n, [&] { add_measure(exchange_.instances()[n], exchange_.instances()[n].correct_static(change), sum); });
    return sum;
}

Networks::StaticMeasure Networks::move_static(const std::vector<BodyState>& at, double share, double* wrenches) {
    exchange_.gather(at);
    StaticMeasure sum;
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] {
            add_measure(exchange_.instances()[n],
                        exchange_.instances()[n].move_static(exchange_.motions(), share, exchange_.wrenches()), sum);
            exchange_.scatter(n, wrenches);
        });
    return sum;
}

void Networks::start_at_rest(const dttmm_step& step, const std::vector<BodyState>& at, const double* node_loads) {
    step_size_ = step.size;
    exchange_.set_time(step.time);
    exchange_.gather(at);
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_place(n, [&] {
            exchange_.instances()[n].start_at_rest(step, exchange_.motions(), exchange_.gather_loads(n, node_loads));
        });
}

// ---- Results ------------------------------------------------------------------------------------------------------------

size_t Networks::output_count() const {
    size_t count = 0;
    for (const NetworkInstance& instance : exchange_.instances()) count += instance.channel_count();
    return count;
}

void Networks::share_channels(std::span<const Channel> others) {
    for (NetworkInstance& instance : exchange_.instances()) others = instance.share_channels(others);
}

void Networks::add_mean_wrenches(double* wrenches) {
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_time(exchange_.time(), [&] {
            exchange_.instances()[n].mean_wrench(exchange_.wrenches());
            exchange_.scatter(n, wrenches);
        });
}

void Networks::stand_at(const std::vector<BodyState>& at, const double* accelerations, double* wrenches) {
    exchange_.gather(at);
    for (size_t n = 0; n < exchange_.instances().size(); ++n)
        exchange_.tell_time(exchange_.time(), [&] {
            exchange_.instances()[n].stand(exchange_.motions(), accelerations, exchange_.wrenches());
            exchange_.scatter(n, wrenches);
        });
}

void Networks::watch_lines(uint32_t stations) {
    stations_ = stations;
    positions_.clear();
    for (const NetworkInstance& instance : exchange_.instances())
        positions_.emplace_back(3 * stations * instance.lines().size());
}

double* Networks::positions(double* values) const {
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        const NetworkInstance& instance = exchange_.instances()[n];
        if (instance.lines().empty()) continue;
        GuardedArray& own = positions_[n];
        exchange_.tell_time(exchange_.time(), [&] {
            instance.positions(stations_, own.data());
            exchange_.check_guards(n, own, "position");
        });
        for (size_t i = 0; i < own.size(); ++i) {
            if (!std::isfinite(own[i])) [[unlikely]]
                throw Error(
                    ExitCode::plugin_failure,
                    fmt::format("element \"{}\" at t = {:.9g} s: plugin {} gives {} as a coordinate of one of its points",
                                instance.element_name(instance.lines()[i / (3 * stations_)]), exchange_.time(),
                                instance.plugin_name(), own[i]));
            *values++ = own[i];
        }
    }
    refuse_changed_arithmetic();
    return values;
}

void Networks::outputs(double* values) const {
    for (size_t n = 0; n < exchange_.instances().size(); ++n) {
        const NetworkInstance& instance = exchange_.instances()[n];
        numbers_.resize(instance.channel_count());
        exchange_.tell_time(exchange_.time(), [&] {
            instance.outputs(numbers_.data());
            exchange_.check_guards(n, numbers_, "output");
        });
        for (size_t c = 0; c < instance.channel_count(); ++c) {
            values[c] = numbers_[c];
            if (std::isfinite(values[c])) [[likely]]
                continue;
            const Channel channel = instance.channel(c);
            throw Error(ExitCode::plugin_failure,
                        fmt::format("{} \"{}\" at t = {:.9g} s: plugin {} says {} is {}",
                                    channel.of() == Channel::Of::node ? "node" : "element", channel.owner(),
                                    exchange_.time(), instance.plugin_name(), channel.name_in_owner(), values[c]));
        }
        values += instance.channel_count();
    }
    refuse_changed_arithmetic();
}

}  // namespace dttmm::host
