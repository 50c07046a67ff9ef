// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/network_exchange.h"

#include <Eigen/Geometry>
#include <cmath>

#include "coupling/loads.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Map<Eigen::Vector3d> vector(double* v) { return Eigen::Map<Eigen::Vector3d>(v); }

}  // namespace

NetworkExchange::NetworkExchange(const Model& model) : elements_(model.elements), path_(model.path) {
    for (const Body& body : model.bodies) body_names_.push_back(body.name);
    motions_.resize(model.bodies.size());
    wrenches_.resize(6 * model.bodies.size());
}

void NetworkExchange::add(const Model& model, const NetworkDescription& description, const std::vector<size_t>& elements) {
    Slot& slot = slots_.emplace_back();
    slot.elements = elements;
    slot.first_on_body.assign(model.bodies.size(), -1);
    for (size_t e = 0; e < elements.size(); ++e) {
        const Element& element = model.elements[elements[e]];
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
    loads_.resize(std::max(loads_.size(), 6 * slot.loaded.size()));
}

void NetworkExchange::gather(const std::vector<BodyState>& motion) {
    for (size_t b = 0; b < motions_.size(); ++b) {
        dttmm_motion& out = motions_[b];
        vector(out.position) = motion[b].position;
        Eigen::Map<RowMajor3>{out.rotation} = motion[b].rotation;
        vector(out.velocity) = motion[b].velocity;
        vector(out.angular_velocity) = motion[b].angular_velocity;
    }
}

const double* NetworkExchange::gather_loads(size_t instance, const double* loads) {
    const Slot& slot = slots_[instance];
    if (!slot.is_loaded) [[likely]]
        return nullptr;
    double* out = loads_.data();
    for (size_t at : slot.loaded) out = std::copy_n(loads + 6 * at, 6, out);
    return loads_.data();
}

void NetworkExchange::move_supports(size_t instance, const double* loads) {
    const Slot& slot = slots_[instance];
    if (slot.supported.empty()) [[likely]]
        return;
    for (size_t s = 0; s < slot.supported.size(); ++s)
        std::copy_n(loads + slot.supported[s], kSupportNumbers, supports_[s].displacement);
    instances_[instance].move_supports(supports_.data());
}

namespace {

/// Not a number if one of them is not.
double size_of(const double* wrench) {
    double size = 0;
    for (int i = 0; i < 6; ++i) size += std::abs(wrench[i]);
    return size;
}

NetworkExchange::Large large_one(size_t instance, size_t body, const double* wrench) {
    NetworkExchange::Large large{instance, body, {}};
    std::copy_n(wrench, 6, large.wrench);
    return large;
}

}  // namespace

void NetworkExchange::scatter_trial(size_t instance, double* wrenches) {
    constexpr double kLargestTrial = 1e100;  // squares of it are numbers
    add_wrenches(instance, kLargestTrial, wrenches);
    const double* wrench = wrenches_.data();
    for (size_t b = 0; b < motions_.size() && !large_; ++b, wrench += 6)
        if (size_of(wrench) > World::kLargestWrench) [[unlikely]]
            large_ = large_one(instance, b, wrench);
}

void NetworkExchange::refuse_large() const {
    if (large_) refuse_wrench(*large_);
}

void NetworkExchange::add_wrenches(size_t instance, double most, double* wrenches) const {
    check_guards(instance, wrenches_, "wrench");
    const double* wrench = wrenches_.data();
    for (size_t b = 0; b < motions_.size(); ++b, wrench += 6, wrenches += 6) {
        if (!(size_of(wrench) <= most)) [[unlikely]]
            refuse_wrench(large_one(instance, b, wrench));
        for (int i = 0; i < 6; ++i) wrenches[i] += wrench[i];
    }
}

void NetworkExchange::check_guards(size_t instance, const GuardedArray& array, const char* name) const {
    if (const char* end = array.overrun()) [[unlikely]]
        instances_[instance].blame(fmt::format("it wrote past the {} of the {} array", end, name));
}

double* NetworkExchange::make_room(size_t instance, GuardedArray& matrix) const {
    matrix.resize(kBlock * instances_[instance].blocks().size());
    return matrix.data();
}

void NetworkExchange::check_matrix(size_t instance, const GuardedArray& matrix, const char* name, const char* when) const {
    check_guards(instance, matrix, name);
    for (size_t i = 0; i < matrix.size(); ++i)
        if (!std::isfinite(matrix[i]))
            instances_[instance].blame(fmt::format("it says that its {}{} is {}; it must be finite", name, when, matrix[i]));
}

void NetworkExchange::refuse_wrench(const Large& large) const {
    const auto& [instance, body, wrench] = large;
    const NetworkInstance& blamed = instances_[instance];
    const int known = blamed.culprit(-1), first = slots_[instance].first_on_body[body];
    const auto name = [&](int element) { return blamed.element_name(as_whole<uint32_t>(element)); };
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

}  // namespace dttmm::host
