// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modal_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "model/error.h"
#include "model/index.h"
#include "model/read_modes.h"

namespace dttmm::host {

namespace {

/// Puts the place in the model file before what a plugin says: of the element it blames, or the file alone.
template <class Action>
auto tell_place(const Model& model, Action&& action) {
    try {
        return action();
    } catch (const NetworkError& error) {
        const std::string& place = error.element() < 0 ? model.path : model.elements[as_size(error.element())].place;
        throw Error(error.code(), fmt::format("{}: {}", place, error.what()));
    }
}

}  // namespace

const std::vector<std::string>& direction_names() { return kDirections; }

ModalMachine::ModalMachine(const Model& model, const Plugins& plugins)
    : ModalMachine(model, ModalDescription(model, plugins)) {}

ModalMachine::ModalMachine(const Model& model, const Model& resting, const Plugins& plugins)
    : ModalMachine(model, ModalDescription(resting, plugins, true)) {}

ModalMachine::ModalMachine(const Model& model, ModalDescription description)
    : model_(model),
      description_(std::move(description)),
      instance_(tell_place(model, [&] { return ModalInstance(description_.plugin(), description_.model()); })) {
    joint_turning_.resize(model.joints.size());
    for (size_t b = 0; b < model.bodies.size(); ++b) {
        Body body = model.bodies[b];
        if (rest()) {
            body.rotation = rest()->at[b].rotation;
            body.position = rest()->at[b].position - body.rotation * body.center_of_mass;
        }
        places_.push_back({body.name, as_int(b), -1, body.position});
        for (const Marker& marker : body.markers)
            places_.push_back({fmt::format("{}.{}", body.name, marker.name), as_int(b), -1,
                               body.position + body.rotation * marker.position});
    }
    for (size_t n = 0; n < model.nodes.size(); ++n)
        if (const auto index = description_.network().node_at({-1, -1, as_int(n)}))
            places_.push_back({model.nodes[n].name, -1, as_int(*index), model.nodes[n].position,
                               as_whole<unsigned>(model.nodes[n].fixed.to_ulong())});
}

std::vector<ModalInstance::Mode> ModalMachine::find_modes(uint32_t count, double below) {
    return tell_place(model_, [&] {
        const uint32_t found = instance_.find_modes(count, below);
        std::vector<ModalInstance::Mode> modes;
        for (uint32_t m = 0; m < found; ++m) modes.push_back(instance_.mode(m));
        return modes;
    });
}

uint32_t ModalMachine::count_growing() {
    return tell_place(model_, [&] { return instance_.count_growing(0); });
}

std::optional<uint32_t> ModalMachine::count_free() {
    return tell_place(model_, [&] { return instance_.count_free(); });
}

/// Of a place on a body by the motion of its centre of mass, in the directions that the model leaves.
Eigen::Matrix<double, 6, 6> ModalMachine::by_body(const ModalPlace& place) const {
    const Body& body = model_.bodies[as_size(place.body)];
    const Eigen::Vector3d centre = rest() ? rest()->at[as_size(place.body)].position
                                          : Eigen::Vector3d(body.position + body.rotation * body.center_of_mass);
    const Eigen::Vector3d arm = place.position - centre;
    Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Identity();
    for (int d = 0; d < 3; ++d) by.block<3, 1>(0, 3 + d) = Eigen::Vector3d::Unit(d).cross(arm);
    for (int d = 0; d < 6; ++d)
        if (!model_.modes.directions[as_size(d)]) by.row(d).setZero();
    return by;
}

ModalMachine::Vector6 ModalMachine::motion(const ModalPlace& place, const ModalInstance::Mode& mode) const {
    if (place.body >= 0) return by_body(place) * mode.bodies[as_size(place.body)];
    return mode.nodes[as_size(place.node)];
}

std::vector<ModalMachine::Vector6> ModalMachine::along(uint32_t mode, uint32_t element, uint32_t count, double& length) {
    return tell_place(model_, [&] { return instance_.along(mode, element, count, length); });
}

void ModalMachine::damp(double highest) {
    // Of a mode at this many times ω, damping is 2 ζ/10 of what its stiffness is at ω, and that 1/100 of its inertia
    constexpr double kModesAbove = 10;
    const DampingSettings& damping = model_.damping;
    if (highest == 0 || (damping.mass_rate == 0 && damping.ratios.empty())) return;
    tell_place(model_, [&] {
        instance_.set_damping(damping.mass_rate, damping.ratios, damping.is_of_all ? kModesAbove * highest : 0);
        return 0;
    });
}

std::vector<ModalInstance::Damped> ModalMachine::find_damped(double below, int32_t& is_proved) {
    return tell_place(model_, [&] { return instance_.find_damped(below, is_proved); });
}

ModalMachine::Complex6 ModalMachine::motion(const ModalPlace& place, const ModalInstance::Damped& mode) const {
    if (place.body < 0) return mode.nodes[as_size(place.node)];
    return by_body(place).cast<std::complex<double>>() * mode.bodies[as_size(place.body)];
}

dttmm_harmonic ModalMachine::load_at(const ModalPlace& place, const Complex6& wrench) {
    dttmm_harmonic load{place.body, place.node, {place.position.x(), place.position.y(), place.position.z()}, {}, 0};
    for (size_t d = 0; d < 6; ++d) {
        load.wrench[2 * d] = wrench(as_row(d)).real();
        load.wrench[2 * d + 1] = wrench(as_row(d)).imag();
    }
    return load;
}

dttmm_harmonic ModalMachine::motion_at(const ModalPlace& node, const Complex6& motion) {
    dttmm_harmonic support = load_at(node, motion);
    support.is_motion = 1;
    return support;
}

std::vector<ModalInstance::Response> ModalMachine::respond(double frequency, const std::vector<ModalInstance::Loads>& cases,
                                                           bool with_forces) {
    return tell_place(model_, [&] { return instance_.respond(frequency, cases, with_forces); });
}

ModalMachine::Complex6 ModalMachine::motion_of_body(int body, const Eigen::Vector3d& point,
                                                    const ModalInstance::Response& response) const {
    if (body < 0) return Complex6::Zero();
    return by_body({"", body, -1, point}).cast<std::complex<double>>() * response.bodies[as_size(body)];
}

ModalMachine::Complex6 ModalMachine::joint_wrench(size_t joint, const ModalInstance::Response& response) const {
    const int first = model_.joints[joint].first;
    const Eigen::Matrix3d axes = first < 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : axes_of_body(as_size(first));
    const Complex6& wrench = response.constraints[joint];
    Complex6 own;
    own << axes.transpose().cast<std::complex<double>>() * wrench.head<3>(),
        axes.transpose().cast<std::complex<double>>() * wrench.tail<3>();
    Eigen::Matrix<std::complex<double>, 12, 1> bodies;
    for (const int side : {0, 1}) {
        const int body = side == 0 ? first : model_.joints[joint].second;
        bodies.segment<6>(6 * side) = body < 0 ? Complex6(Complex6::Zero()) : response.bodies[as_size(body)];
    }
    std::optional<Eigen::Matrix<double, 6, 12>>& turning = joint_turning_[joint];
    if (!turning) turning = description_.joint_turning(joint);
    return own + *turning * bodies;
}

ModalMachine::Complex6 ModalMachine::joint_motion(size_t joint, const ModalInstance::Response& response) const {
    const dttmm_constraint& at = description_.model().constraints[joint];
    const Eigen::Vector3d point(at.position);
    const Eigen::Matrix3cd axes =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(at.axes).cast<std::complex<double>>();
    const Complex6 way = motion_of_body(at.second, point, response) - motion_of_body(at.first, point, response);
    Complex6 own;
    own << axes.transpose() * way.head<3>(), axes.transpose() * way.tail<3>();
    return own;
}

std::vector<double> ModalMachine::frequencies_below(double frequency) {
    return tell_place(model_, [&] {
        std::vector<double> frequencies;
        const uint32_t found = instance_.find_modes(0, frequency);
        for (uint32_t m = 0; m < found; ++m) frequencies.push_back(instance_.mode(m).numbers.frequency);
        return frequencies;
    });
}

ModalMachine::Complex6 ModalMachine::motion(const ModalPlace& place, const ModalInstance::Response& response) const {
    if (place.body < 0) return response.nodes[as_size(place.node)];
    return by_body(place).cast<std::complex<double>>() * response.bodies[as_size(place.body)];
}

std::string ModalMachine::why_still(const ModalPlace& in, int in_direction, const ModalPlace& out, int out_direction) const {
    if (in.is_held(in_direction) || out.is_held(out_direction))
        return fmt::format("{} is fixed in that direction", in.is_held(in_direction) ? in.name : out.name);
    // Bodies, then nodes, each pointing to another that it is joined with, or to itself
    std::vector<size_t> root(model_.bodies.size() + model_.nodes.size());
    std::iota(root.begin(), root.end(), size_t{0});
    const auto find_root = [&](size_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    const auto index = [&](int body, int node) { return body >= 0 ? as_size(body) : model_.bodies.size() + as_size(node); };
    for (const Element& element : model_.elements) {
        const Attachment* first = nullptr;
        for (const Attachment& end : element.ends) {
            if (end.is_ground()) continue;
            if (first) root[find_root(index(end.body, end.node))] = find_root(index(first->body, first->node));
            first = &end;
        }
    }
    for (const Joint& joint : model_.joints)
        if (joint.first >= 0 && joint.second >= 0) root[find_root(as_size(joint.first))] = find_root(as_size(joint.second));
    const auto place_root = [&](const ModalPlace& place) {
        if (place.body >= 0) return find_root(as_size(place.body));
        const auto node = std::ranges::find(model_.nodes, place.name, &Node::name);
        return find_root(model_.bodies.size() + as_size(node - model_.nodes.begin()));
    };
    return place_root(in) == place_root(out)
               ? "they are joined, but the symmetry of the machine keeps these directions apart"
               : "no element or joint leads from one to the other";
}

const ModalPlace* ModalMachine::find(const std::string& name) const {
    const auto found = std::ranges::find(places_, name, &ModalPlace::name);
    return found == places_.end() ? nullptr : &*found;
}

}  // namespace dttmm::host
