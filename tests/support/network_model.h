// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstring>
#include <deque>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "element/registry.h"

namespace dttmm::test {

using namespace plugin;

/// A network described by names and keys, as a model file does it, and kept alive for the plugin.
class NetworkModel {
public:
    explicit NetworkModel(uint32_t scheme = DTTMM_SCHEME_CENTRED, double beta = 0.25, double gamma = 0.5)
        : scheme_(scheme), beta_(beta), gamma_(gamma) {
        nodes_.reserve(kMostNodes);  // references to them stay good
        bodies_.reserve(kMostNodes);
    }

    /// A node on a body has that body at `arm` from it, in its own axes, and with its axes.
    dttmm_node& node(const std::string& name, uint32_t kind, const Eigen::Vector3d& position,
                     const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                     const Eigen::Vector3d& arm = Eigen::Vector3d::Zero()) {
        names_.push_back(name);
        dttmm_node node{names_.back().c_str(), kind, static_cast<uint32_t>(bodies_.size()), {}, {}, 0, 0, {}, {}};
        if (kind == DTTMM_NODE_ON_BODY) {
            dttmm_body body{names_.back().c_str(), {}, {}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
            Eigen::Map<Eigen::Vector3d>{body.position} = position - rotation * arm;
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{body.rotation} = rotation;
            bodies_.push_back(body);
        }
        Eigen::Map<Eigen::Vector3d>{node.position} = position;
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{node.rotation} = rotation;
        if (nodes_.size() == kMostNodes) throw std::length_error("more nodes than a NetworkModel has");
        index_[name] = static_cast<uint32_t>(nodes_.size());
        nodes_.push_back(node);
        return nodes_.back();
    }

    /// Holds directions of the world, x y z rx ry rz by bit.
    void fix(const std::string& name, uint32_t directions) { nodes_[index_.at(name)].fixed = directions; }

    using Values = std::map<std::string, std::vector<double>>;
    void element(const std::string& name, const std::string& type, const std::vector<std::string>& ends,
                 const Values& values) {
        names_.push_back(name);
        const auto types = element_types();
        uint32_t t = 0;
        while (t < types.size() && types[t].name != type) ++t;
        if (t == types.size()) throw std::invalid_argument(type);
        std::vector<double> numbers;
        size_t used = 0;
        for (uint32_t p = 0; p < types[t].parameter_count; ++p) {
            const dttmm_parameter& parameter = types[t].parameters[p];
            const auto given = values.find(parameter.name);
            if (given == values.end()) {
                numbers.insert(numbers.end(), parameter.count, parameter.default_value);
                continue;
            }
            ++used;
            const bool spreads = given->second.size() == 1;
            for (uint32_t i = 0; i < parameter.count; ++i) numbers.push_back(given->second.at(spreads ? 0 : i));
        }
        if (used != values.size()) throw std::invalid_argument("a key of " + name + " that " + type + " does not have");
        numbers_.push_back(numbers);
        std::vector<uint32_t> indices;
        for (const std::string& end : ends) indices.push_back(index_.at(end));
        ends_.push_back(indices);
        elements_.push_back(
            {names_.back().c_str(), t, static_cast<uint32_t>(ends.size()), ends_.back().data(), numbers_.back().data()});
    }

    /// A force per length on an element, axes: DTTMM_AXES_...
    void line_load(const std::string& element, uint32_t axes) {
        uint32_t e = 0;
        while (e < elements_.size() && elements_[e].name != element) ++e;
        line_loads_.push_back({e, axes});
    }

    void set_gravity(const Eigen::Vector3d& gravity) { gravity_ = gravity; }

    dttmm_network description() const {
        return {static_cast<uint32_t>(bodies_.size()),
                bodies_.data(),
                static_cast<uint32_t>(nodes_.size()),
                nodes_.data(),
                static_cast<uint32_t>(elements_.size()),
                elements_.data(),
                scheme_,
                beta_,
                gamma_,
                {gravity_.x(), gravity_.y(), gravity_.z()},
                static_cast<uint32_t>(line_loads_.size()),
                line_loads_.data(),
                0,
                nullptr,
                nullptr,
                0};
    }

    /// Turns and moves everything but the values, nodes that have no axes of their own included.
    void move(const Eigen::Matrix3d& turn, const Eigen::Vector3d& way) {
        using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        for (dttmm_node& node : nodes_) {
            Eigen::Map<Eigen::Vector3d> position(node.position), v(node.velocity), w(node.angular_velocity);
            position = (turn * position + way).eval();
            v = (turn * v).eval();
            w = (turn * w).eval();
            Eigen::Map<RowMajor3> rotation(node.rotation);
            rotation = (turn * rotation).eval();
        }
        for (dttmm_body& body : bodies_) {
            Eigen::Map<Eigen::Vector3d> position(body.position);
            position = (turn * position + way).eval();
            Eigen::Map<RowMajor3> rotation(body.rotation);
            rotation = (turn * rotation).eval();
        }
        gravity_ = (turn * gravity_).eval();
    }

private:
    static constexpr size_t kMostNodes = 4096;
    uint32_t scheme_;
    double beta_, gamma_;
    Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
    std::deque<std::string> names_;
    std::map<std::string, uint32_t> index_;
    std::vector<dttmm_body> bodies_;
    std::vector<dttmm_node> nodes_;
    std::deque<std::vector<double>> numbers_;
    std::deque<std::vector<uint32_t>> ends_;
    std::vector<dttmm_element> elements_;
    std::vector<dttmm_line_load> line_loads_;
};

/// The steel tube of the bond-space paper, 50/30 mm.
inline NetworkModel::Values tube(int segments, double damping = 0) {
    return {{"segments", {static_cast<double>(segments)}},
            {"section.tube", {0.05, 0.03}},
            {"material.E", {204e9}},
            {"material.poisson", {0.26}},
            {"material.density", {7800}},
            {"material.stiffness_damping", {damping}}};
}

}  // namespace dttmm::test
