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

/// Splits the elements of a model into networks, each a list of indices into Model::elements, ascending: elements that share
/// a node belong to one. Bodies and the ground do not connect: what happens on one side of them is not felt on the other
/// within a step but through the host.
std::vector<std::vector<size_t>> split_into_networks(const Model& model);

/// One network of a model as a plugin is told of it. An end on the ground is a node of its own, where the element's other
/// end is at the start, with its axes. The `from` end has the axes that the element is given. Nodes stand in the order in
/// which the elements name them.
class NetworkDescription {
public:
    /// `elements`: indices into Model::elements. Throws Error(model_invalid) with the place in the model file when they
    /// come from different plugins.
    NetworkDescription(const Model& model, const Plugins& plugins, const std::vector<size_t>& elements);

    const PluginLibrary& plugin() const { return *plugin_; }
    /// Valid as long as the model and this object.
    dttmm_network network() const;

    /// A place on a body, and its axes in those of the body.
    struct Port {
        Attachment at;
        Eigen::Matrix3d rotation;
    };
    /// In the order of the ports; each place once, and once more for every element with axes of its own there.
    const std::vector<Port>& ports() const { return ports_; }
    /// Index of the node at a place among those of the network; none if it has no node there.
    std::optional<size_t> node_at(const Attachment& place) const;
    /// Indices into Model::nodes in the order of the inner nodes.
    const std::vector<int>& inner_nodes() const { return inner_nodes_; }

private:
    void add_element(const Element& element);
    uint32_t find_or_add_node(const Attachment& end, const Attachment& other, const std::optional<Eigen::Matrix3d>& axes);
    uint32_t add_port(const Attachment& end, const Eigen::Matrix3d& axes);
    uint32_t add_node(const std::string& name, uint32_t kind, const Eigen::Vector3d& position,
                      const Eigen::Matrix3d& rotation);

    const Model& model_;
    const PluginLibrary* plugin_ = nullptr;
    std::vector<dttmm_node> nodes_;
    std::vector<std::string> node_names_;
    std::map<Attachment, uint32_t> nodes_at_;  ///< by place; the ground has one per element
    std::vector<std::vector<uint32_t>> ends_;  ///< of every element
    std::vector<dttmm_element> elements_;
    std::vector<Port> ports_;
    std::vector<int> inner_nodes_;
};

/// Where a place on a body or a node is in the world at the start: its origin and its axes.
struct Frame {
    Eigen::Vector3d position;
    Eigen::Matrix3d rotation;
};
Frame frame_at_start(const Model& model, const Attachment& at);

}  // namespace dttmm::host
