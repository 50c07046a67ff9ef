// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/network_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "coupling/instant.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

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

std::string name_of(const Model& model, const Attachment& at) {
    const Body& body = model.bodies[as_size(at.body)];
    return at.marker < 0 ? body.name : fmt::format("{}.{}", body.name, body.markers[as_size(at.marker)].name);
}

}  // namespace

std::vector<std::vector<size_t>> split_by_plugin(const Model& model, const Plugins& plugins) {
    std::vector<std::vector<size_t>> groups;
    std::map<const PluginLibrary*, size_t> numbers;
    std::vector<int> first_at(model.nodes.size(), -1);  // element on every node
    for (size_t e = 0; e < model.elements.size(); ++e) {
        const Element& element = model.elements[e];
        const PluginLibrary* plugin = plugins.resolve(element.type).first;
        const auto [number, is_new] = numbers.try_emplace(plugin, groups.size());
        if (is_new) groups.emplace_back();
        groups[number->second].push_back(e);
        for (const Attachment& end : element.ends) {
            if (end.node < 0) continue;
            int& first = first_at[as_size(end.node)];
            if (first < 0) first = as_int(e);
            const Element& other = model.elements[as_size(first)];
            const PluginLibrary* own = plugins.resolve(other.type).first;
            if (own != plugin)
                throw Error(ExitCode::model_invalid,
                            fmt::format("{}: element \"{}\" (plugin {}) hangs together with element \"{}\" (plugin {}) "
                                        "through node \"{}\"; one plugin must solve them both, so put a body between them",
                                        element.place, element.name, plugin->name(), other.name, own->name(),
                                        model.nodes[as_size(end.node)].name));
        }
    }
    return groups;
}

Frame frame_at_start(const Model& model, const Attachment& at) {
    if (at.node >= 0) {
        const Node& node = model.nodes[as_size(at.node)];
        return {node.position, node.rotation};
    }
    const Body& body = model.bodies[as_size(at.body)];
    const Marker marker = at.marker < 0 ? Marker{} : body.markers[as_size(at.marker)];
    return {body.position + body.rotation * marker.position, body.rotation * marker.axes()};
}

NetworkDescription::NetworkDescription(const Model& model, const Plugins& plugins, const std::vector<size_t>& elements)
    : model_(model), plugin_(&plugins.libraries().front()) {
    for (const Body& body : model.bodies) add_body(body);
    for (size_t e : elements) {
        const Element& element = model.elements[e];
        const auto [plugin, type] = plugins.resolve(element.type);
        plugin_ = plugin;
        add_element(element);
        elements_.back().type = type;
    }
    for (size_t e = 0; e < elements_.size(); ++e) elements_[e].ends = ends_[e].data();
    for (size_t n = 0; n < nodes_.size(); ++n) nodes_[n].name = node_names_[n].c_str();
    add_line_loads(elements);
}

void NetworkDescription::add_body(const Body& body) {
    dttmm_body out{body.name.c_str(), {}, {}, body.mass, {}};
    Eigen::Map<Eigen::Vector3d>{out.position} = body.position + body.rotation * body.center_of_mass;
    Eigen::Map<RowMajor3>{out.rotation} = body.rotation;
    Eigen::Map<RowMajor3>{out.inertia} = body.rotation * body.inertia * body.rotation.transpose();
    bodies_.push_back(out);
}

void NetworkDescription::add_element(const Element& element) {
    std::vector<uint32_t> ends;
    for (const Attachment& end : element.ends) {
        const bool is_from = &end == &element.ends.front();
        ends.push_back(find_or_add_node(end, end.is_ground() ? element.ends[is_from ? 1 : 0] : end,
                                        is_from ? element.axes.get() : nullptr));
    }
    elements_.push_back({element.name.c_str(), 0, as_whole<uint32_t>(ends.size()), nullptr, element.values.data()});
    ends_.push_back(std::move(ends));
}

void NetworkDescription::add_line_loads(const std::vector<size_t>& elements) {
    for (size_t i = 0; i < model_.loads.size(); ++i) {
        const Load& load = model_.loads[i];
        const auto found = load.is_per_length() ? std::ranges::find(elements, as_size(load.element)) : elements.end();
        if (found == elements.end()) continue;
        line_loads_.push_back({as_whole<uint32_t>(found - elements.begin()),
                               static_cast<uint32_t>(load.turns ? DTTMM_AXES_ELEMENT : DTTMM_AXES_WORLD)});
        line_load_indices_.push_back(i);
    }
}

uint32_t NetworkDescription::find_or_add_node(const Attachment& end, const Attachment& other, const Eigen::Matrix3d* axes) {
    if (end.is_ground()) {
        const Frame frame = frame_at_start(model_, other);
        return add_node("ground", DTTMM_NODE_GROUND, frame.position, axes ? *axes : frame.rotation);
    }
    if (end.body >= 0 && axes) return add_node_on_body(end, *axes);
    const auto [found, is_new] = nodes_at_.try_emplace(end, as_whole<uint32_t>(nodes_.size()));
    if (!is_new) return found->second;
    const Frame frame = frame_at_start(model_, end);
    if (end.body >= 0) return add_node_on_body(end, frame.rotation);
    inner_nodes_.push_back(end.node);
    const Node& node = model_.nodes[as_size(end.node)];
    const uint32_t index = add_node(node.name, DTTMM_NODE_INNER, frame.position, frame.rotation);
    dttmm_node& inner = nodes_[index];
    inner.fixed = as_whole<uint32_t>(node.fixed.to_ulong());
    inner.moves = node.moves;
    if (node.is_support()) {
        supports_.push_back(index);
        supported_nodes_.push_back(end.node);
    }
    Eigen::Map<Eigen::Vector3d>{inner.velocity} = node.velocity;
    Eigen::Map<Eigen::Vector3d>{inner.angular_velocity} = node.angular_velocity;
    return index;
}

/// axes: of the node, in the world at the start.
uint32_t NetworkDescription::add_node_on_body(const Attachment& end, const Eigen::Matrix3d& axes) {
    const uint32_t index = add_node(name_of(model_, end), DTTMM_NODE_ON_BODY, frame_at_start(model_, end).position, axes);
    nodes_[index].body = as_whole<uint32_t>(end.body);
    return index;
}

uint32_t NetworkDescription::add_node(const std::string& name, uint32_t kind, const Eigen::Vector3d& position,
                                      const Eigen::Matrix3d& rotation) {
    dttmm_node node{nullptr, kind, 0, {}, {}, 0, 0, {}, {}};
    Eigen::Map<Eigen::Vector3d>{node.position} = position;
    Eigen::Map<RowMajor3>{node.rotation} = rotation;
    nodes_.push_back(node);
    node_names_.push_back(name);
    return as_whole<uint32_t>(nodes_.size() - 1);
}

std::optional<size_t> NetworkDescription::node_at(const Attachment& place) const {
    const auto found = nodes_at_.find(place);
    if (found == nodes_at_.end()) return std::nullopt;
    return found->second;
}

dttmm_network NetworkDescription::network() const {
    const Newmark newmark = scheme_with_radius(model_.simulation.spectral_radius);
    dttmm_network network{};
    network.body_count = as_whole<uint32_t>(bodies_.size());
    network.bodies = bodies_.data();
    network.node_count = as_whole<uint32_t>(nodes_.size());
    network.nodes = nodes_.data();
    network.element_count = as_whole<uint32_t>(elements_.size());
    network.elements = elements_.data();
    network.scheme = scheme_of(model_.simulation);
    network.beta = newmark.beta;
    network.gamma = newmark.gamma;
    Eigen::Map<Eigen::Vector3d>{network.gravity} = model_.simulation.gravity;
    network.line_load_count = as_whole<uint32_t>(line_loads_.size());
    network.line_loads = line_loads_.data();
    network.support_count = as_whole<uint32_t>(supports_.size());
    network.supports = supports_.data();
    network.mean_velocities = has_mean_velocities(model_);
    return network;
}

}  // namespace dttmm::host
