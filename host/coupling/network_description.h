// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "loader/plugins.h"
#include "model/model.h"

namespace dttmm::host {

/// The elements of each plugin, as indices into Model::elements, ascending. Throws Error(model_invalid) with the place in
/// the model file where a node joins elements of two plugins: one must solve for its motion.
std::vector<std::vector<size_t>> split_by_plugin(const Model& model, const Plugins& plugins);

/// The bodies of a model and elements of one plugin as its description in the C interface. An end on the ground is a node of
/// its own, where the element's other end is at the start, with its axes. The `from` end has the axes that the element is
/// given. Nodes stand in the order in which the elements name them.
class NetworkDescription {
public:
    /// `elements`: indices into Model::elements, of one plugin; without any the plugin is the built-in one.
    NetworkDescription(const Model& model, const Plugins& plugins, const std::vector<size_t>& elements);

    const PluginLibrary& plugin() const { return *plugin_; }
    /// Valid as long as the model and this object.
    dttmm_network network() const;

    /// Index of the node at a place among those of the network; none if it has no node there.
    std::optional<size_t> node_at(const Attachment& place) const;
    /// Indices into Model::nodes in the order of the inner nodes.
    const std::vector<int>& inner_nodes() const { return inner_nodes_; }
    /// Indices into Model::nodes of those that supports move, in the order of the network's.
    const std::vector<int>& supported_nodes() const { return supported_nodes_; }
    /// Indices into Model::loads of the forces per length on these elements, in the order of the network's.
    const std::vector<size_t>& line_loads() const { return line_load_indices_; }

private:
    void add_element(const Element& element);
    void add_line_loads(const std::vector<size_t>& elements);
    uint32_t find_or_add_node(const Attachment& end, const Attachment& other, const Eigen::Matrix3d* axes);
    void add_body(const Body& body);
    uint32_t add_node_on_body(const Attachment& end, const Eigen::Matrix3d& axes);
    uint32_t add_node(const std::string& name, uint32_t kind, const Eigen::Vector3d& position,
                      const Eigen::Matrix3d& rotation);

    const Model& model_;
    const PluginLibrary* plugin_ = nullptr;
    std::vector<dttmm_body> bodies_;
    std::vector<dttmm_node> nodes_;
    std::vector<std::string> node_names_;
    std::map<Attachment, uint32_t> nodes_at_;  ///< by place; the ground has one per element
    std::vector<std::vector<uint32_t>> ends_;  ///< of every element
    std::vector<dttmm_element> elements_;
    std::vector<int> inner_nodes_, supported_nodes_;
    std::vector<uint32_t> supports_;  ///< indices of the latter among the nodes of the network
    std::vector<dttmm_line_load> line_loads_;
    std::vector<size_t> line_load_indices_;
};

/// Where a place on a body or a node is in the world at the start: its origin and its axes.
struct Frame {
    Eigen::Vector3d position;
    Eigen::Matrix3d rotation;
};
Frame frame_at_start(const Model& model, const Attachment& at);

}  // namespace dttmm::host
