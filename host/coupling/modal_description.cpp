// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/modal_description.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Without elements a machine vibrates at rest only, as a pendulum does.
std::vector<size_t> all_elements(const Model& model, const Plugins& plugins, bool at_rest) {
    const std::vector<std::vector<size_t>> groups = split_by_plugin(model, plugins);
    if (groups.empty() && at_rest) return {};
    if (groups.empty())
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: no element: nothing is elastic, nothing vibrates", model.path));
    if (groups.size() > 1) {
        const Element &first = model.elements[groups[0].front()], &other = model.elements[groups[1].front()];
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: element \"{}\" (plugin {}) and element \"{}\" (plugin {}): one plugin must have all "
                                "elements of a machine to know its small vibrations",
                                other.place, first.name, plugins.resolve(first.type).first->name(), other.name,
                                plugins.resolve(other.type).first->name()));
    }
    return groups.front();
}

/// Directions that a joint does not give, in axes whose x is its axis and whose y is its second one.
std::bitset<6> rigid_of(const Joint& joint) {
    if (joint.drive) return 0b111111;  // its motor holds what it leaves free
    switch (joint.type) {
        case JointType::ball:
            return 0b000111;
        case JointType::hinge:
            return 0b110111;
        case JointType::slider:
            return 0b111110;
        case JointType::universal:
            return 0b100111;
        case JointType::fixed:
            break;
    }
    return 0b111111;
}

/// x along the axis, y along the second one where there is one.
Eigen::Matrix3d axes_of(const Joint& joint) {
    const Eigen::Vector3d x = joint.axis.normalized();
    const Eigen::Vector3d y =
        joint.type == JointType::universal ? Eigen::Vector3d(joint.axis2 - x * x.dot(joint.axis2)) : x.unitOrthogonal();
    Eigen::Matrix3d axes;
    axes << x, y.normalized(), x.cross(y.normalized());
    return axes;
}

}  // namespace

ModalDescription::Search::Search(const Model& model, const Plugins& plugins)
    : networks(model, plugins), loads(model, networks.load_weights()), equilibrium(model, networks, loads) {}

ModalDescription::Rest::Rest(Resting resting)
    : at(std::move(resting)),
      load_stiffness(at.equilibrium->load_stiffness()),
      joint_stiffness(at.equilibrium->joint_stiffness()) {
    for (const BodyState& body : at.state.at) {
        dttmm_motion& motion = bodies.emplace_back();
        Eigen::Map<Eigen::Vector3d>{motion.position} = body.position;
        Eigen::Map<RowMajor3>{motion.rotation} = body.rotation;
    }
    const bool is_elastic = !at.networks->instances().empty();
    told = {is_elastic ? at.networks->instances().front().at_rest() : nullptr, bodies.data(), load_stiffness.data(),
            joint_stiffness.data(), 1};
}

/// Networks tell their results of a step: one in which nothing moves.
void ModalDescription::Rest::find_limits(const Loads& loads, double size) {
    Networks* const networks = at.networks;
    const auto has_limits = [](const NetworkInstance& instance) {
        return std::ranges::find(instance.roles(), DTTMM_ROLE_LIMIT) != instance.roles().end();
    };
    if (std::ranges::none_of(networks->instances(), has_limits)) return;
    const dttmm_step step{0, 0.0, size};
    std::vector<double> wrenches(6 * at.state.at.size()), values(networks->output_count());
    networks->start_at_rest(step, at.state.at, loads.on_networks().data());
    networks->begin_step(step, loads.on_networks().data());
    networks->evaluate(at.state.at, wrenches.data());
    networks->refuse_large_wrenches();
    networks->commit_step(at.state.at);
    if (networks->stand()) networks->stand_at(at.state.at, nullptr, wrenches.data());
    networks->outputs(values.data());
    size_t channel = 0;
    for (const NetworkInstance& instance : networks->instances())
        for (size_t c = 0; c < instance.channel_count(); ++c, ++channel)
            if (instance.roles()[c] == DTTMM_ROLE_LIMIT)
                limits.push_back({instance.channel(c).name(), instance.channel(c).owner(), values[channel]});
}

/// Ideal joints go with their bodies; a stop that pushes holds what the joint leaves free.
void ModalDescription::place_at_rest(const Model& model) {
    const JointSystem joints(model.bodies, model.joints);
    const std::vector<BodyState>& at = rest_->at.state.at;
    for (size_t j = 0; j < model.joints.size(); ++j) {
        const Joint& joint = model.joints[j];
        const auto turned = [&](int body, const Eigen::Vector3d& v) {
            if (body < 0) return v;
            return Eigen::Vector3d(at[as_size(body)].rotation * (model.bodies[as_size(body)].rotation.transpose() * v));
        };
        Joint now = joint;
        now.axis = turned(joint.first, joint.axis);
        now.axis2 = turned(joint.second, joint.axis2);
        dttmm_constraint& out = constraints_[j];
        Eigen::Map<Eigen::Vector3d>{out.position} = joints.joints()[j].anchor(at);
        Eigen::Map<RowMajor3>{out.axes} = axes_of(now);
        if (rest_->at.equilibrium->stops()[j].acts) out.rigid |= joint.type == JointType::hinge ? 0b001000u : 0b000001u;
    }
}

ModalDescription::ModalDescription(const Model& model, const Plugins& plugins, bool at_rest)
    : description_(model, plugins, all_elements(model, plugins, at_rest)),
      network_(description_.network()),
      directions_(as_whole<uint32_t>(model.modes.directions.to_ulong())),
      lumped_beams_(model.modes.are_beams_lumped) {
    describe_joints(model);
    if (!at_rest) return;
    auto search = std::make_unique<Search>(model, plugins);
    const RestState& state = search->equilibrium.find(0);
    rest_ = std::make_unique<Rest>(Resting{&search->networks, &search->equilibrium, state});
    rest_->search = std::move(search);
    rest_->find_limits(rest_->search->loads, model.simulation.step);
    place_at_rest(model);
}

ModalDescription::ModalDescription(const Model& model, const Plugins& plugins, Resting resting)
    : description_(model, plugins, all_elements(model, plugins, true)),
      network_(description_.network()),
      directions_(as_whole<uint32_t>(model.modes.directions.to_ulong())),
      lumped_beams_(model.modes.are_beams_lumped),
      rest_(std::make_unique<Rest>(std::move(resting))) {
    describe_joints(model);
    place_at_rest(model);
}

void ModalDescription::describe_joints(const Model& model) {
    for (const Joint& joint : model.joints) {
        dttmm_constraint out{joint.first, joint.second, {}, {}, as_whole<uint32_t>(rigid_of(joint).to_ulong())};
        Eigen::Map<Eigen::Vector3d>{out.position} = joint.anchor;
        Eigen::Map<RowMajor3>{out.axes} = axes_of(joint);
        constraints_.push_back(out);
    }
}

dttmm_modal_model ModalDescription::model() const {
    return {&network_,     as_whole<uint32_t>(constraints_.size()), constraints_.data(), directions_,
            lumped_beams_, rest_ ? &rest_->told : nullptr};
}

}  // namespace dttmm::host
