// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/networks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "coupling/network_description.h"
#include "loader/plugin_call.h"
#include "model/error.h"

namespace dttmm::host {

namespace {

/// Stands before and after what a plugin writes; one that writes past its array changes it. A quiet NaN with a pattern.
constexpr uint64_t kGuardPattern = 0x7ffadadadadadadaULL;

void set_guard(double* word) { std::memcpy(word, &kGuardPattern, sizeof kGuardPattern); }
bool is_guard(const double* word) { return std::memcmp(word, &kGuardPattern, sizeof kGuardPattern) == 0; }

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<Eigen::Vector3d> vector(double* v) { return Eigen::Map<Eigen::Vector3d>(v); }

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Networks::Networks(const Model& model, const Plugins& plugins) {
    for (const Body& body : model.bodies) body_names_.push_back(body.name);
    std::vector<bool> is_loaded(model.nodes.size());
    for (const Load& load : model.loads)
        if (load.on.node >= 0) is_loaded[static_cast<size_t>(load.on.node)] = true;
    for (const std::vector<size_t>& elements : split_into_networks(model)) add_network(model, plugins, elements, is_loaded);

    for (const NetworkInstance& instance : instances_) stand_ = stand_ && instance.stands();
    is_implicit_ = model.simulation.coupling == Coupling::implicit;
    if (!instances_.empty()) {
        refuse_mixed_weights();
        instances_.front().load_weights(weights_);
        // A sum of three weights is exact to a few roundings of one, 1e-16 each; the formulas of a scheme to some more
        constexpr double kWeightRounding = 1e-12;
        const bool is_share =
            std::ranges::all_of(weights_, [](double w) { return w >= -kWeightRounding && w <= 1 + kWeightRounding; });
        if (!is_share || !(std::abs(weights_[0] + weights_[1] + weights_[2] - 1) < kWeightRounding))
            throw Error(
                ExitCode::plugin_failure,
                fmt::format("{}: its plugin weights loads by {}, {} and {}; weights lie within 0 and 1 and add up to "
                            "one",
                            instances_.front().label(), weights_[0], weights_[1], weights_[2]));
        is_implicit_ = false;
        for (const NetworkInstance& instance : instances_) is_implicit_ = is_implicit_ || instance.is_implicit();
    }
    motions_.resize(ports_.size());
    loads_.resize(6 * inner_nodes_.size());
    arms_.resize(ports_.size());
    next_arms_.resize(ports_.size());
    wrenches_.resize(1 + 6 * ports_.size() + instances_.size());
    set_guard(&wrenches_[0]);
    for (size_t n = 0; n < instances_.size(); ++n)
        set_guard(&wrenches_[slots_[n].wrench + 6 * static_cast<size_t>(instances_[n].port_count())]);
    outputs_.resize(output_count() + 2);
    refuse_changed_arithmetic();
}

Networks::Port Networks::port_at(const Model& model, const NetworkDescription::Port& port) const {
    const Body& body = model.bodies[static_cast<size_t>(port.at.body)];
    const Marker marker = port.at.marker < 0 ? Marker{} : body.markers[static_cast<size_t>(port.at.marker)];
    // Rounding of the turn there and back is no turn
    const bool is_turned = !port.rotation.isIdentity(1e-14);
    return {port.at.body, marker.position - body.center_of_mass, is_turned, port.rotation};
}

void Networks::add_network(const Model& model, const Plugins& plugins, const std::vector<size_t>& elements,
                           const std::vector<bool>& is_loaded) {
    const NetworkDescription description(model, plugins, elements);
    const size_t first_port = ports_.size();
    places_.emplace_back();
    for (size_t e : elements) places_.back().push_back(model.elements[e].place);
    tell_place(places_.size() - 1, [&] { instances_.emplace_back(description.plugin(), description.network()); });

    for (const NetworkDescription::Port& port : description.ports()) ports_.push_back(port_at(model, port));
    slots_.push_back({first_port, 1 + 6 * first_port + slots_.size(), inner_nodes_.size(), false});
    for (int node : description.inner_nodes()) {
        inner_nodes_.push_back(static_cast<size_t>(node));
        slots_.back().is_loaded = slots_.back().is_loaded || is_loaded[static_cast<size_t>(node)];
    }
    for (size_t i = first_port; i < ports_.size(); ++i)
        for (size_t j = first_port; j < i; ++j)
            if (ports_[i].body != ports_[j].body) neighbours_.emplace_back(ports_[i].body, ports_[j].body);
}

/// Puts the place of the element that a plugin blames, or of the first of the network, before what it says.
template <class Action>
void Networks::tell_place(size_t network, Action&& action) const {
    try {
        action();
    } catch (const NetworkError& error) {
        const auto element = static_cast<size_t>(std::max(error.element(), 0));
        throw Error(error.code(), fmt::format("{}: {}", places_[network][element], error.what()));
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

std::string Networks::name(size_t network) const {
    const NetworkInstance& instance = instances_[network];
    return instance.element_count() == 1 ? instance.element_name(0) : instance.label();
}

void Networks::refuse_mixed_weights() const {
    double first[3], other[3];
    instances_.front().load_weights(first);
    for (const NetworkInstance& instance : instances_) {
        instance.load_weights(other);
        if (std::equal(first, first + 3, other)) continue;
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{} and {} weight loads differently over a step: their plugins use different time "
                                "schemes and cannot share a model",
                                instances_.front().label(), instance.label()));
    }
}

// ---- Bodies to ports and back -------------------------------------------------------------------------------------------

/// Motion of every port from that of the bodies; step_size 0: the velocities are those of the instant.
void Networks::gather(const std::vector<BodyState>& motion, double step_size) {
    const double per_step = step_size > 0 ? 1 / step_size : 0;
    for (size_t p = 0; p < ports_.size(); ++p) {
        const Port& port = ports_[p];
        const BodyState& body = motion[static_cast<size_t>(port.body)];
        dttmm_motion& out = motions_[p];
        const Eigen::Vector3d arm = body.rotation * port.arm;
        vector(out.position) = body.position + arm;
        if (port.turned)
            Eigen::Map<RowMajor3>{out.rotation} = body.rotation * port.rotation;
        else
            Eigen::Map<RowMajor3>{out.rotation} = body.rotation;
        if (step_size > 0)
            vector(out.velocity) = body.velocity + per_step * (arm - arms_[p]);
        else
            vector(out.velocity) = body.velocity + body.angular_velocity.cross(arm);
        vector(out.angular_velocity) = body.angular_velocity;
        next_arms_[p] = arm;
    }
}

/// Adds the wrenches of one network to those of the bodies, with the lever arms of t_n.
void Networks::scatter(size_t network, double* wrenches) const {
    const Slot& slot = slots_[network];
    const auto count = static_cast<size_t>(instances_[network].port_count());
    const double* wrench = &wrenches_[slot.wrench];
    for (size_t p = slot.port; p < slot.port + count; ++p, wrench += 6) {
        double size = 0;  // not a number if one of them is not
        for (int i = 0; i < 6; ++i) size += std::abs(wrench[i]);
        if (!(size <= World::kLargestWrench)) [[unlikely]]
            refuse_wrench(network, p);
        const Eigen::Map<const Eigen::Vector3d> force(wrench), moment(wrench + 3);
        double* on_body = wrenches + 6 * ports_[p].body;
        vector(on_body) += force;
        vector(on_body + 3) += arms_[p].cross(force) + moment;
    }
    check_guards(network, &wrenches_[slot.wrench], wrench, "wrench");
}

/// The words before `begin` and at `end` must be as they were.
void Networks::check_guards(size_t network, const double* begin, const double* end, const char* array) const {
    if (is_guard(begin - 1) && is_guard(end)) [[likely]]
        return;
    throw NetworkError(ExitCode::plugin_failure,
                       fmt::format("{}: its plugin wrote past the {} of the {} array", instances_[network].label(),
                                   is_guard(end) ? "start" : "end", array),
                       -1);
}

/// A square matrix over the ports of a network, between two guards, to be written by its plugin.
double* Networks::make_room(size_t network, std::vector<double>& matrix) const {
    const auto size = 6 * static_cast<size_t>(instances_[network].port_count());
    matrix.resize(size * size + 2);
    set_guard(&matrix.front());
    set_guard(&matrix.back());
    return matrix.data() + 1;
}

void Networks::check_matrix(size_t network, const std::vector<double>& matrix, const char* name) const {
    check_guards(network, matrix.data() + 1, &matrix.back(), name);
    for (size_t i = 1; i + 1 < matrix.size(); ++i)
        if (!std::isfinite(matrix[i]))
            throw NetworkError(ExitCode::plugin_failure,
                               fmt::format("{}: its plugin says that its {} at the start is {}; it must be finite",
                                           instances_[network].label(), name, matrix[i]),
                               -1);
}

void Networks::refuse_wrench(size_t network, size_t port) const {
    const double* wrench = &wrenches_[slots_[network].wrench + 6 * (port - slots_[network].port)];
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "{} on body \"{}\" at t = {:.9g} s: force ({:.4g}, {:.4g}, {:.4g}) N, moment ({:.4g}, {:.4g}, "
            "{:.4g}) N m is not finite or beyond the cap of {:.0e}; the run ends before it reaches ODE. Try a smaller "
            "step, or look for a fault of the plugin",
            instances_[network].label(), body_names_[static_cast<size_t>(ports_[port].body)], time_, wrench[0], wrench[1],
            wrench[2], wrench[3], wrench[4], wrench[5], World::kLargestWrench));
}

/// Block (row port, column port) of a matrix over the ports, as one over the poses of their bodies.
Networks::Block Networks::seen_from_bodies(size_t network, const std::vector<double>& port_matrix, int row,
                                           int column) const {
    // Port pose by body pose: δp = δx − arm~ δθ; body wrench by port wrench: the transpose.
    const int count = instances_[network].port_count();
    const Eigen::Map<const RowMajorX> S(port_matrix.data() + 1, 6 * count, 6 * count);
    const auto lever = [&](int p) {
        Block G = Block::Identity();
        G.topRightCorner<3, 3>() = -skew(arms_[slots_[network].port + static_cast<size_t>(p)]);
        return G;
    };
    return lever(row).transpose() * S.block<6, 6>(6 * row, 6 * column) * lever(column);
}

void Networks::hand_out(size_t network, const std::vector<double>& port_stiffness, const StiffnessSink& sink) const {
    const int count = instances_[network].port_count();
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            sink(body_of(network, i), body_of(network, j), seen_from_bodies(network, port_stiffness, i, j));
}

// ---- Phases -------------------------------------------------------------------------------------------------------------

void Networks::linearise(const std::vector<BodyState>& at, double* wrenches, const LinearSink* sink) {
    gather(at, 0);
    arms_ = next_arms_;
    for (size_t n = 0; n < instances_.size(); ++n) {
        const int count = instances_[n].port_count();
        double *stiffness = sink ? make_room(n, stiffness_) : nullptr, *damping = sink ? make_room(n, damping_) : nullptr;
        tell_place(n, [&] {
            instances_[n].linearise(motions_.data() + slots_[n].port, &wrenches_[slots_[n].wrench], stiffness, damping);
            scatter(n, wrenches);
            if (!sink) return;
            check_matrix(n, stiffness_, "stiffness");
            check_matrix(n, damping_, "damping");
        });
        if (!sink) continue;
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j)
                (*sink)(n, body_of(n, i), body_of(n, j), seen_from_bodies(n, stiffness_, i, j),
                        seen_from_bodies(n, damping_, i, j));
    }
}

void Networks::start(const dttmm_step& step, const std::vector<BodyState>& at, const double* accelerations,
                     const double* node_loads) {
    step_size_ = step.size;
    time_ = step.time;
    gather(at, 0);
    arms_ = next_arms_;
    std::vector<double> port_accelerations(6 * ports_.size());
    for (size_t p = 0; p < ports_.size(); ++p) {
        // a_P = a + α × r + ω × (ω × r)
        const auto body = static_cast<size_t>(ports_[p].body);
        const Eigen::Vector3d& w = at[body].angular_velocity;
        const Eigen::Map<const Eigen::Vector3d> a(accelerations + 6 * body), alpha(accelerations + 6 * body + 3);
        vector(&port_accelerations[6 * p]) = a + alpha.cross(arms_[p]) + w.cross(w.cross(arms_[p]));
        vector(&port_accelerations[6 * p + 3]) = alpha;
    }
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_place(n, [&] {
            instances_[n].start(step, motions_.data() + slots_[n].port, port_accelerations.data() + 6 * slots_[n].port,
                                gather_loads(n, node_loads));
        });
}

void Networks::begin_step(const dttmm_step& step, const double* node_loads) {
    time_ = step.time;
    tell_time(time_, [&] {
        for (size_t n = 0; n < instances_.size(); ++n) instances_[n].begin_step(step, gather_loads(n, node_loads));
    });
}

/// Loads on the inner nodes of one network; null if there are none.
const double* Networks::gather_loads(size_t network, const double* node_loads) {
    const Slot& slot = slots_[network];
    if (!slot.is_loaded) [[likely]]
        return nullptr;
    const size_t end = network + 1 < slots_.size() ? slots_[network + 1].inner_node : inner_nodes_.size();
    double* out = loads_.data();
    for (size_t i = slot.inner_node; i < end; ++i) out = std::copy_n(node_loads + 6 * inner_nodes_[i], 6, out);
    return loads_.data();
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches) {
    if (is_implicit_) gather(trial, step_size_);
    rough_ = kNone;
    for (size_t n = 0; n < instances_.size(); ++n) {
        tell_time(time_, [&] {
            if (is_implicit_ && instances_[n].expect(motions_.data() + slots_[n].port)) rough_ = std::min(rough_, n);
            instances_[n].evaluate(motions_.data() + slots_[n].port, &wrenches_[slots_[n].wrench], nullptr);
            scatter(n, wrenches);
        });
    }
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink& stiffness) {
    gather(trial, step_size_);
    rough_ = kNone;
    for (size_t n = 0; n < instances_.size(); ++n) {
        double* port_stiffness = make_room(n, stiffness_);
        tell_time(time_, [&] {
            if (is_implicit_ && instances_[n].expect(motions_.data() + slots_[n].port)) rough_ = std::min(rough_, n);
            instances_[n].evaluate(motions_.data() + slots_[n].port, &wrenches_[slots_[n].wrench], port_stiffness);
            scatter(n, wrenches);
            check_guards(n, port_stiffness, &stiffness_.back(), "stiffness");
        });
        hand_out(n, stiffness_, stiffness);
    }
}

void Networks::commit_step(const std::vector<BodyState>& accepted) {
    gather(accepted, step_size_);
    tell_time(time_ + step_size_, [&] {
        for (size_t n = 0; n < instances_.size(); ++n) instances_[n].commit_step(motions_.data() + slots_[n].port);
    });
    arms_.swap(next_arms_);
}

// ---- Results ------------------------------------------------------------------------------------------------------------

size_t Networks::output_count() const {
    size_t count = 0;
    for (const NetworkInstance& instance : instances_) count += instance.channel_count();
    return count;
}

void Networks::add_mean_wrenches(const std::vector<BodyState>& at, double* wrenches) {
    gather(at, 0);
    arms_.swap(next_arms_);  // those of the start of the step
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_time(time_, [&] {
            instances_[n].mean_wrench(&wrenches_[slots_[n].wrench]);
            scatter(n, wrenches);
        });
    arms_.swap(next_arms_);
}

void Networks::stand_at(const std::vector<BodyState>& at, double* wrenches) {
    gather(at, 0);
    arms_.swap(next_arms_);
    for (size_t n = 0; n < instances_.size(); ++n)
        tell_time(time_, [&] {
            instances_[n].stand(motions_.data() + slots_[n].port, &wrenches_[slots_[n].wrench]);
            scatter(n, wrenches);
        });
    arms_.swap(next_arms_);
}

void Networks::outputs(double* values) const {
    double* own = outputs_.data() + 1;
    for (size_t n = 0; n < instances_.size(); ++n) {
        const NetworkInstance& instance = instances_[n];
        const double before = own[-1];  // a guard, or the last value of the network before
        double* end = own + instance.channel_count();
        set_guard(own - 1);
        set_guard(end);
        tell_time(time_, [&] {
            instance.outputs(own);
            check_guards(n, own, end, "output");
        });
        own[-1] = before;
        for (uint32_t c = 0; c < instance.channel_count(); ++c, ++own) {
            if (std::isfinite(*own)) [[likely]]
                continue;
            const dttmm_channel& channel = instance.channel(c);
            throw Error(ExitCode::plugin_failure, fmt::format("{} \"{}\" at t = {:.9g} s: its plugin says {} is {}",
                                                              channel.of == DTTMM_OF_NODE ? "node" : "element",
                                                              instance.owner_of(channel), time_, channel.name, *own));
        }
    }
    std::copy(outputs_.begin() + 1, outputs_.end() - 1, values);
    refuse_changed_arithmetic();
}

}  // namespace dttmm::host
