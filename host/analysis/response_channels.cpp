// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_channels.h"

#include <algorithm>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};

/// The largest distance of a place from the first one, or √(trace J/m) of a body [m]; 1 if all are zero.
double size_of(const Model& model, const ModalMachine& machine) {
    double size = 0;
    for (const ModalPlace& place : machine.places())
        size = std::max(size, (place.position - machine.places()[0].position).norm());
    for (const Body& body : model.bodies)
        if (body.mass > 0) size = std::max(size, std::sqrt(body.inertia.trace() / body.mass));
    return size > 0 ? size : 1;
}

}  // namespace

ResponseChannels::ResponseChannels(const Model& model, const ModalMachine& machine)
    : machine_(machine), size_(size_of(model, machine)) {
    channels_.emplace_back("frequency", "Hz");  // as time is the first of a run
    sources_.push_back({});
    for (size_t e = 0; e < model.elements.size(); ++e) {
        const std::string& name = model.elements[e].name;
        if (model.elements[e].ends.size() != 2) continue;
        if (machine.is_axial(e)) {
            channels_.push_back(Channel(Channel::Of::element, name, "force", "", "N"));
            sources_.push_back({Of::element_force, e, 0});
            channels_.push_back(Channel(Channel::Of::element, name, "length", "", "m"));
            sources_.push_back({Of::element_deflection, e, 0});
            continue;
        }
        add(Channel::Of::element, name, "force", "N", {Of::element_force, e, 0});
        add(Channel::Of::element, name, "moment", "N*m", {Of::element_force, e, 3});
        add(Channel::Of::element, name, "deflection", "m", {Of::element_deflection, e, 0});
        add(Channel::Of::element, name, "rotation", "rad", {Of::element_deflection, e, 3}, false);
    }
    add_joints(model);
    add_places(model);
}

void ResponseChannels::add(Channel::Of of, const std::string& owner, const char* quantity, const char* unit,
                           const Source& first, bool by_default) {
    for (int axis = 0; axis < 3; ++axis) {
        channels_.push_back(Channel(of, owner, quantity, kAxes[axis], unit, by_default));
        sources_.push_back({first.of, first.index, first.direction + axis, first.derivative});
    }
}

void ResponseChannels::add_joints(const Model& model) {
    for (size_t j = 0; j < model.joints.size(); ++j) {
        const Joint& joint = model.joints[j];
        add(Channel::Of::joint, joint.name, "force", "N", {Of::joint, j, 0});
        add(Channel::Of::joint, joint.name, "moment", "N*m", {Of::joint, j, 3});
        if (joint.type == JointType::hinge) {
            channels_.push_back(Channel(Channel::Of::joint, joint.name, "angle", "", "rad"));
            sources_.push_back({Of::joint_angle, j, 0});
        } else if (joint.type == JointType::slider) {
            channels_.push_back(Channel(Channel::Of::joint, joint.name, "travel", "", "m"));
            sources_.push_back({Of::joint_travel, j, 0});
        }
    }
}

void ResponseChannels::add_places(const Model& model) {
    for (size_t p = 0; p < machine_.places().size(); ++p) {
        const ModalPlace& place = machine_.places()[p];
        const bool is_node = place.node >= 0, is_body = !is_node && place.name == model.bodies[as_size(place.body)].name;
        const Channel::Of of = is_node ? Channel::Of::node : is_body ? Channel::Of::body : Channel::Of::marker;
        add(of, place.name, "position", "m", {Of::place, p, 0, 0}, is_node || is_body);
        add(of, place.name, "velocity", "m/s", {Of::place, p, 0, 1}, is_node || is_body);
        add(of, place.name, "acceleration", "m/s^2", {Of::place, p, 0, 2});
        if (!is_node && !is_body) continue;
        add(of, place.name, "rotation", "rad", {Of::place, p, 3, 0});
        add(of, place.name, "angular_velocity", "rad/s", {Of::place, p, 3, 1});
        add(of, place.name, "angular_acceleration", "rad/s^2", {Of::place, p, 3, 2}, false);
    }
}

bool ResponseChannels::has_forces(const std::vector<int>& channels) const {
    return std::ranges::any_of(channels, [&](int c) {
        const Of of = sources_[as_size(c)].of;
        return c > 0 && (of == Of::element_force || of == Of::element_deflection || of == Of::joint);
    });
}

std::complex<double> ResponseChannels::value(int channel, const ModalInstance::Response& response, double omega) const {
    const Source& source = sources_[as_size(channel)];
    const Eigen::Index d = source.direction;
    switch (source.of) {
        case Of::element_force:
            return response.forces[source.index](d);
        case Of::element_deflection:
            return response.deflections[source.index](d);
        case Of::joint:
            return machine_.joint_wrench(source.index, response)(d);
        case Of::joint_angle:
            return machine_.joint_motion(source.index, response)(3);
        case Of::joint_travel:
            return machine_.joint_motion(source.index, response)(0);
        case Of::place:
            break;
    }
    const std::complex<double> motion = machine_.motion(machine_.places()[source.index], response)(d);
    const std::complex<double> rate(0, omega);
    return source.derivative == 0 ? motion : source.derivative == 1 ? rate * motion : rate * rate * motion;
}

AdaptivePoints::Kind ResponseChannels::kind(int channel) const {
    const Source& source = sources_[as_size(channel)];
    const bool turns = source.of == Of::joint_angle || source.direction > 2;
    if (source.of == Of::element_force || source.of == Of::joint) return {3, turns ? 1 / size_ : 1};
    return {as_size(source.derivative), turns ? size_ : 1};
}

std::array<double, ResponseChannels::kKinds> ResponseChannels::largest(const ModalInstance::Response& response,
                                                                       double omega) const {
    std::array<double, kKinds> largest{};
    for (const ModalPlace& place : machine_.places()) {
        const ModalInstance::Complex6 motion = machine_.motion(place, response);
        largest[0] = std::max({largest[0], motion.head<3>().norm(), size_ * motion.tail<3>().norm()});
    }
    largest[1] = omega * largest[0];
    largest[2] = omega * largest[1];
    for (const ModalInstance::Complex6& force : response.forces)
        largest[3] = std::max({largest[3], force.head<3>().norm(), force.tail<3>().norm() / size_});
    return largest;
}

}  // namespace dttmm::host
