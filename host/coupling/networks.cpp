// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/networks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cfenv>
#include <cmath>
#include <cstring>

#include "model/error.h"

namespace dttmm {

namespace {

/// Follows each network's wrenches in memory; a plugin that writes past its array changes it. A quiet NaN with a pattern.
constexpr uint64_t kGuardPattern = 0x7ffadadadadadadaULL;

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<Eigen::Vector3d> vector(double* v) { return Eigen::Map<Eigen::Vector3d>(v); }

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

dttmm_node make_node(const char* name, uint32_t kind, const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation) {
    dttmm_node node{name, kind, {}, {}, 0, 0, {}, {}};
    vector(node.position) = position;
    Eigen::Map<RowMajor3>{node.rotation} = rotation;
    return node;
}

uint32_t scheme_of(const SimulationSettings& simulation) {
    if (simulation.coupling == Coupling::implicit) return DTTMM_SCHEME_CENTRED;
    switch (simulation.scheme) {
        case ExplicitScheme::bdf1:
            return DTTMM_SCHEME_BDF1;
        case ExplicitScheme::bdf2:
            return DTTMM_SCHEME_BDF2;
        case ExplicitScheme::houbolt:
            return DTTMM_SCHEME_HOUBOLT;
        case ExplicitScheme::park:
            return DTTMM_SCHEME_PARK;
        default:
            return DTTMM_SCHEME_FOX_EULER;
    }
}

struct Newmark {
    double beta, gamma;
};

/// The centred scheme with the spectral radius ρ at infinite frequency. There w₊ r² + w₀ r + w₋ = 0; a double root takes
/// w₀² = 4 w₊ w₋, which is β = (γ + 1/2)²/4, and is r = 1 − 2/(γ + 1/2): −ρ for γ = (3 − ρ)/2(1 + ρ).
Newmark scheme_with_radius(double rho) {
    const double gamma = (3 - rho) / (2 * (1 + rho));
    return {0.25 * (gamma + 0.5) * (gamma + 0.5), gamma};
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Networks::Networks(const Model& model, const Plugins& plugins) {
    for (const Body& body : model.bodies) body_names_.push_back(body.name);
    for (const Element& element : model.elements) add_network(model, plugins, element);

    // Elements meet only at bodies, so each is a network of its own.
    is_implicit_ = model.simulation.coupling == Coupling::implicit;
    if (!instances_.empty()) {
        refuse_mixed_weights();
        instances_.front().load_weights(weights_);
        if (!(std::abs(weights_[0] + weights_[1] + weights_[2] - 1) < 1e-12))
            throw Error(ExitCode::plugin_failure,
                        fmt::format("element \"{}\": its plugin weights loads by {}, {} and {}, which do not add up to one",
                                    instances_.front().element_name(0), weights_[0], weights_[1], weights_[2]));
        is_implicit_ = false;
        for (const NetworkInstance& instance : instances_) is_implicit_ = is_implicit_ || instance.is_implicit();
    }
    motions_.resize(ports_.size());
    arms_.resize(ports_.size());
    next_arms_.resize(ports_.size());
    wrenches_.resize(6 * ports_.size() + instances_.size());
    for (size_t n = 0; n < instances_.size(); ++n)
        std::memcpy(&wrenches_[slots_[n].wrench + 6 * static_cast<size_t>(instances_[n].port_count())], &kGuardPattern,
                    sizeof(double));
}

Networks::Port Networks::port_at(const Model& model, const Attachment& at) const {
    const Body& body = model.bodies[static_cast<size_t>(at.body)];
    const Marker marker = at.marker < 0 ? Marker{} : body.markers[static_cast<size_t>(at.marker)];
    return {at.body, marker.position - body.center_of_mass, !marker.rotation.isIdentity(0), marker.rotation};
}

void Networks::add_network(const Model& model, const Plugins& plugins, const Element& element) {
    const auto [plugin, type] = plugins.resolve(element.type);
    const size_t first_port = ports_.size();

    // The ground point is where the other end is at the start, with the world's axes.
    const Attachment& moving = element.from.body >= 0 ? element.from : element.to;
    std::vector<dttmm_node> nodes;
    for (const Attachment& end : {element.from, element.to}) {
        const Port port = port_at(model, end.body >= 0 ? end : moving);
        const Body& body = model.bodies[static_cast<size_t>(port.body)];
        const Eigen::Vector3d position = body.position + body.rotation * (port.arm + body.center_of_mass);
        if (end.body >= 0) {
            ports_.push_back(port);
            nodes.push_back(make_node(body.name.c_str(), DTTMM_NODE_PORT, position, body.rotation * port.rotation));
        } else {
            nodes.push_back(make_node("ground", DTTMM_NODE_GROUND, position, Eigen::Matrix3d::Identity()));
        }
    }
    const uint32_t from_to[] = {0, 1};
    const dttmm_element data{element.name.c_str(), type, 2, from_to, element.values.data()};
    const Newmark newmark = scheme_with_radius(model.simulation.spectral_radius);
    const Eigen::Vector3d& g = model.simulation.gravity;
    const dttmm_network network{
        2, nodes.data(), 1, &data, scheme_of(model.simulation), newmark.beta, newmark.gamma, {g.x(), g.y(), g.z()}};
    try {
        instances_.emplace_back(*plugin, network);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("{}: {}", element.place, error.what()));
    }
    slots_.push_back({first_port, 6 * first_port + slots_.size()});
    for (size_t i = first_port; i < ports_.size(); ++i)
        for (size_t j = first_port; j < i; ++j)
            if (ports_[i].body != ports_[j].body) neighbours_.emplace_back(ports_[i].body, ports_[j].body);
}

void Networks::refuse_mixed_weights() const {
    double first[3], other[3];
    instances_.front().load_weights(first);
    for (const NetworkInstance& instance : instances_) {
        instance.load_weights(other);
        if (std::equal(first, first + 3, other)) continue;
        throw Error(
            ExitCode::plugin_failure,
            fmt::format("elements \"{}\" and \"{}\" weight loads differently over a step: their plugins use different time "
                        "schemes and cannot share a model",
                        instances_.front().element_name(0), instance.element_name(0)));
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
    uint64_t guard;
    std::memcpy(&guard, wrench, sizeof guard);
    if (guard != kGuardPattern) [[unlikely]]
        throw Error(ExitCode::plugin_failure,
                    fmt::format("element \"{}\": its plugin wrote past the end of the wrench array",
                                instances_[network].element_name(0)));
}

void Networks::refuse_wrench(size_t network, size_t port) const {
    const double* wrench = &wrenches_[slots_[network].wrench + 6 * (port - slots_[network].port)];
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "element \"{}\" on body \"{}\" at t = {:.9g} s: force ({:.4g}, {:.4g}, {:.4g}) N, moment ({:.4g}, {:.4g}, "
            "{:.4g}) N m is not finite or beyond the cap of {:.0e}; the run ends before it reaches ODE. Is the step too "
            "long for an explicit coupling, or the plugin at fault?",
            instances_[network].element_name(0), body_names_[static_cast<size_t>(ports_[port].body)], time_, wrench[0],
            wrench[1], wrench[2], wrench[3], wrench[4], wrench[5], World::kLargestWrench));
}

/// Block (row port, column port) of a matrix over the ports, as one over the poses of their bodies.
Networks::Block Networks::seen_from_bodies(size_t network, const std::vector<double>& port_matrix, int row,
                                           int column) const {
    // Port pose by body pose: δp = δx − arm~ δθ; body wrench by port wrench: the transpose.
    const int count = instances_[network].port_count();
    const Eigen::Map<const RowMajorX> S(port_matrix.data(), 6 * count, 6 * count);
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
        const size_t size = sink ? 36 * static_cast<size_t>(count * count) : 0;
        stiffness_.resize(size);
        damping_.resize(size);
        instances_[n].linearise(&motions_[slots_[n].port], &wrenches_[slots_[n].wrench], sink ? stiffness_.data() : nullptr,
                                sink ? damping_.data() : nullptr);
        scatter(n, wrenches);
        if (!sink) continue;
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j)
                (*sink)(n, body_of(n, i), body_of(n, j), seen_from_bodies(n, stiffness_, i, j),
                        seen_from_bodies(n, damping_, i, j));
    }
}

void Networks::start(const dttmm_step& step, const std::vector<BodyState>& at, const double* accelerations) {
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
        instances_[n].start(step, &motions_[slots_[n].port], &port_accelerations[6 * slots_[n].port], nullptr);
}

void Networks::begin_step(const dttmm_step& step) {
    time_ = step.time;
    for (NetworkInstance& instance : instances_) instance.begin_step(step, nullptr);
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches) {
    if (is_implicit_) gather(trial, step_size_);
    for (size_t n = 0; n < instances_.size(); ++n) {
        instances_[n].evaluate(&motions_[slots_[n].port], &wrenches_[slots_[n].wrench], nullptr);
        scatter(n, wrenches);
    }
}

void Networks::evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink& stiffness) {
    gather(trial, step_size_);
    for (size_t n = 0; n < instances_.size(); ++n) {
        const auto size = 6 * static_cast<size_t>(instances_[n].port_count());
        stiffness_.resize(size * size);
        instances_[n].evaluate(&motions_[slots_[n].port], &wrenches_[slots_[n].wrench], stiffness_.data());
        scatter(n, wrenches);
        hand_out(n, stiffness_, stiffness);
    }
}

void Networks::commit_step(const std::vector<BodyState>& accepted) {
    gather(accepted, step_size_);
    for (size_t n = 0; n < instances_.size(); ++n) instances_[n].commit_step(&motions_[slots_[n].port]);
    arms_.swap(next_arms_);
}

// ---- Results ------------------------------------------------------------------------------------------------------------

size_t Networks::output_count() const {
    size_t count = 0;
    for (const NetworkInstance& instance : instances_) count += instance.channel_count();
    return count;
}

void Networks::outputs(double* values) const {
    for (const NetworkInstance& instance : instances_) {
        instance.outputs(values);
        for (uint32_t c = 0; c < instance.channel_count(); ++c, ++values) {
            if (std::isfinite(*values)) [[likely]]
                continue;
            const dttmm_channel& channel = instance.channel(c);
            throw Error(ExitCode::plugin_failure, fmt::format("{} \"{}\" at t = {:.9g} s: its plugin says {} is {}",
                                                              channel.of == DTTMM_OF_NODE ? "node" : "element",
                                                              instance.owner_of(channel), time_, channel.name, *values));
        }
    }
    if (std::fegetround() != FE_TONEAREST)
        throw Error(ExitCode::plugin_failure, "a plugin has changed the rounding mode of the processor");
}

}  // namespace dttmm
